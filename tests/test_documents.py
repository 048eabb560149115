"""What the documents say of limits and counts is what the code holds."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from pathlib import Path

from mjfriction.control.observe import OBSERVERS
from mjfriction.diagnose.causes import carried_payload, offset, torque_constant
from mjfriction.diagnose.causes.along_stroke import FINEST
from mjfriction.diagnose.causes.backlash import PLAYS, PROMISES
from mjfriction.diagnose.causes.carried_drive import RATIOS as CARRIED
from mjfriction.diagnose.causes.carried_drive import TRIED, WHOLE
from mjfriction.diagnose.causes.catalog import STRUCTURAL
from mjfriction.diagnose.causes.coupling import RATIOS
from mjfriction.diagnose.causes.delay import USUALLY_EARLY, USUALLY_LATE
from mjfriction.diagnose.causes.elasticity import (
    RESONANCE_BAND,
    RESONANCES,
    STIFFER,
    USUALLY_GIVES,
    USUALLY_GIVES_ALONG,
    USUALLY_SWINGS,
)
from mjfriction.diagnose.causes.friction_at_place import FLANK, PASSES
from mjfriction.diagnose.causes.friction_edge import SHARPEST
from mjfriction.diagnose.causes.friction_edge import WIDEST as LEVEL_FROM
from mjfriction.diagnose.causes.friction_spot import NARROWEST, WIDEST
from mjfriction.diagnose.causes.hung_payload import FAR_OUT
from mjfriction.diagnose.causes.landed_play import FLOWN
from mjfriction.diagnose.causes.links import LEAST_ALONE, LEAST_MOMENTS, LEAST_MOVED, LEAST_MOVED_ALONE, LEAST_NOTED
from mjfriction.diagnose.causes.load import LEAST_ROTOR
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.presliding import LEAST_PART, LONGEST_OF_ELEMENTS, SLIPS
from mjfriction.diagnose.causes.rotor_inertia import USUALLY_OFF as ROTOR_OFF
from mjfriction.diagnose.causes.spring import BentSpring
from mjfriction.diagnose.causes.springy_play import FEWER_PLAYS, FLANKS
from mjfriction.diagnose.causes.steepening_viscous import POWERS
from mjfriction.diagnose.causes.stribeck import EXPONENTS, FALLEN, GONE_BY, UNFINISHED
from mjfriction.diagnose.causes.torque_constant import USUALLY_OFF as CONSTANT_OFF
from mjfriction.diagnose.causes.varying import ALIKE, EDGE, FASTER, MOST_CHANGE, Step
from mjfriction.diagnose.causes.waves import Cogging, PositionFriction
from mjfriction.diagnose.faults import mend, misplaced
from mjfriction.diagnose.faults.audit import AS_KNOWN
from mjfriction.diagnose.faults.look import NO_WORSE
from mjfriction.diagnose.faults.misplaced import EXPLAINED
from mjfriction.diagnose.faults.which_log import LOUDER
from mjfriction.diagnose.fit import nearness, small_errors
from mjfriction.diagnose.fit.as_little import AS_GOOD
from mjfriction.diagnose.fit.exact import EXACT, FEWEST_OTHERS, MOST_JOINTS
from mjfriction.diagnose.fit.nuisance import FARTHEST, LET_GO
from mjfriction.diagnose.fit.refitted import CONSTANT, FEWEST_JOINTS, LINK_SCALE, LINK_SHIFT, OUT_OF_CHANCE, ROTOR, ZERO
from mjfriction.diagnose.fit.trial import (
    BRIEFLY,
    EVENEST,
    FALSE_ALARM,
    LEAST_EFFECT,
    MOST,
    MOST_OF_FEW,
    OF_FEW,
    QUIETLY,
    STANDS_OUT,
    UNEVEN,
    WAVIEST,
)
from mjfriction.diagnose.search.compete import KEPT, MOST_CAUSES, MOST_STEPS
from mjfriction.diagnose.search.courses import NEARLY, OF_REMOVED
from mjfriction.diagnose.search.exchange import MOST_EXCHANGED
from mjfriction.diagnose.search.free_links import BAR, FEWEST_GAINING, LEAST_GAINED, MANY, STRAINED
from mjfriction.diagnose.search.kin import FULLER_CHANCE, KIN_CHANCE, LEAST_KIN_EFFECT
from mjfriction.diagnose.search.oscillations import INSTEAD, LEAST_TOLD, NEAR, QUIETER, RESONANT
from mjfriction.diagnose.search.refusal import APART as UNDONE
from mjfriction.diagnose.search.refusal import AT_TURNS, ON_THE_WAY, SHAKEN, SOON
from mjfriction.diagnose.search.richer import PAYS
from mjfriction.diagnose.search.short_list import NEAR_BEST, PROMISED
from mjfriction.diagnose.search.stroke_curve import HARMONIC, HARMONIC_TWO, HIGHEST
from mjfriction.diagnose.search.unevenness import TOLD_BY
from mjfriction.diagnose.settle import as_plain, hidden_curve
from mjfriction.diagnose.settle.held_links import NEARLY_ALL, NEARLY_EXACT
from mjfriction.diagnose.settle.levels_kept import LEAST_OFF, NEARER
from mjfriction.diagnose.settle.one_factor import CLEAN
from mjfriction.diagnose.settle.one_factor import LEAST_OFF as LEAST_FACTOR
from mjfriction.diagnose.settle.stated import FADED, LEFT, NEARER_LINKS, OUTLYING
from mjfriction.diagnose.tell import findings, free_run, what_gives
from mjfriction.diagnose.tell.alike import AT_THE_BAR, EVEN, MOST_CONFIDENT, ROOM
from mjfriction.diagnose.tell.contacts import NO_CONTACT, RIGID
from mjfriction.diagnose.tell.findings import FAINTEST, ONE_OF_MANY
from mjfriction.diagnose.tell.link_finding import ALWAYS_NOTED, AS_STATED, SURELY
from mjfriction.diagnose.tell.untold import BRISTLE_MISFIT, DROWNED, LEAST_SEEN, MISFIT, SURELY_SEEN
from mjfriction.diagnose.tell.verdict import FEWEST_SHOWN, LEAST_FRICTION, LEAST_SHOWN, MANY_AT_A_JOINT, MUCH_COLOURED
from mjfriction.identify import bursts, choose, conclude, excerpt, landings, measure, row_noise, turning
from mjfriction.identify.blocks import MOST_GROUPS
from mjfriction.identify.colour import AROUND, COLOURED, EVEN_BELOW, FEWEST_ALIKE, MOST_ALIKE
from mjfriction.identify.doubt import WITHIN, YIELDING
from mjfriction.identify.measure import ENOUGH_CLEAR, ENOUGH_PER_PERIOD, FEWEST_CLEAR
from mjfriction.identify.stroke_waves import STEPS_PER_LOBE
from mjfriction.identify.swing import FASTEST, SLOWEST
from mjfriction.laws.catalog import LAWS
from mjfriction.record import glitches, jumps
from mjfriction.record.clipped import FEWEST_STOPS
from mjfriction.record.clock_bursts import FEWEST_AT_ONCE
from mjfriction.record.clock_order import FARTHEST as FARTHEST_STAMP
from mjfriction.record.clock_rate import OFF
from mjfriction.record.jumps import NO_STEP
from mjfriction.record.motion import DAWDLING, HELD, HELD_BESIDE_ANOTHER_KIND, RINGING, USUALLY
from mjfriction.report.result import UNEVEN as UNEVEN_CLOCK
from mjfriction.reproduce.catalog import DOCUMENTS
from mjfriction.robot.edges import APART as EDGES_APART
from mjfriction.robot.robot import bundled_robots
from mjfriction.robot.rubbing import UNSETTLED
from mjfriction.robot.spots import APART
from mjfriction.robot.transmission import BEGINNING

ROOT = Path(__file__).parents[1]
NUMBERS = {9: "Nine"}


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_readme_counts_laws_and_robots() -> None:
    readme = text("README.md")
    assert f"any of {len(LAWS)} friction laws" in readme
    assert f"{NUMBERS[len(bundled_robots())]} robots are included" in readme


def test_every_bundled_robot_has_its_place_on_the_page() -> None:
    page = text("docs/robots.md")
    for name in bundled_robots():
        assert f"## {name}" in page


def test_every_cause_that_competes_is_in_the_readmes_table() -> None:
    rows = [line.split("|")[1] for line in text("README.md").splitlines() if line.startswith("| `")]
    listed = {name for row in rows for name in re.findall(r"`([a-z_.]+)`", row)}
    for cause in STRUCTURAL:
        assert cause.name in listed


def test_every_observer_and_every_experiment_is_told_of() -> None:
    told = text("docs/compensation.md")
    for name in OBSERVERS:
        assert f"`{name}`" in told
    assert "|".join(DOCUMENTS) in told


def test_how_it_decides_tells_the_share_that_it_uses() -> None:
    assert f"comes within {'a tenth' if NEAR_BEST == 0.9 else NEAR_BEST} of" in " ".join(
        text("docs/how_it_decides.md").split()
    )


def test_every_page_that_is_named_is_there() -> None:
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]:
        for named in re.findall(r"`(docs/[\w./]+)`", page.read_text(encoding="utf-8")):
            assert (ROOT / named).exists(), f"{page.name} names {named}"
        for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / picture).is_file(), f"{page.name} shows {picture}"


def test_how_it_decides_tells_what_rows_and_waves_count() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"a wave has to be {STANDS_OUT:g} times as large as the waves that half of the joints" in told
    assert f"Waves above {100 * WAVIEST:g} % of friction do not raise this bar" in told
    assert f"until that matters by less than {100 * UNSETTLED:g} % of its level" in told
    assert (FEWEST_CLEAR, ENOUGH_CLEAR, WITHIN) == (0.2, 50, 0.9), "in words"
    assert (MOST, MOST_OF_FEW) == (0.95, 0.995), "in words: one row in twenty, in two hundred"
    assert (carried_payload.PARTS, carried_payload.EDGE) == (12, 0.25), "in words: a twelfth, a quarter of it"


def test_how_it_decides_tells_how_much_of_a_long_log_is_searched() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"more than {excerpt.ENOUGH:g} s of motion, a part of every block is searched, {excerpt.ENOUGH:g} s" in told


def test_how_it_decides_tells_the_limits_of_delays_and_travels() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"late by less than {1e3 * USUALLY_LATE:g} ms, which the filter of any drive takes" in told
    assert f"or early by less than {1e3 * USUALLY_EARLY:g} ms, which a filter of its positions takes" in told
    assert (YIELDING, UNDONE) == (1e-3, 0.5), "the page says a thousandth, and half of a delay"


def test_how_it_decides_tells_which_plays_and_swings_are_tried() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"So {len(PLAYS)} plays are tried, from {1e6 * PLAYS[-1]:.0f} µrad to {PLAYS[0]:g} rad" in told
    assert (PLAYS[1] / PLAYS[0], PROMISES[0], PROMISED) == (0.9, 0.1, 3.0), (
        "the page says a tenth, a tenth, three times"
    )
    assert f"If it lies between {RESONANCES[0]:.1f} and {RESONANCES[-1]:.0f} Hz" in told
    assert f"what its drive passes on to it in the first {BEGINNING:g} s" in told


def test_how_it_decides_tells_which_blows_and_bursts_count() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"at least {bursts.FEWEST_BURSTS} bursts of few rows" in told
    assert f"if it is {bursts.FAR_OUT:g} times as large as the sensor's noise" in told
    assert (bursts.BURST_SHARE, what_gives.HALVED, bursts.EDGE) == (0.5, 0.5, 2), "the page says half, and two rows"
    assert f"{what_gives.LOUD:g} times as large as without, and {what_gives.ABOVE_NOISE:g} times the sensor's" in told
    assert f"leaves more than {what_gives.ABOVE_NOISE:g} times the sensor's noise (or" in told
    assert row_noise.LEAST_NOISE == 1e-3, "a thousandth, and three"
    assert (len(FEWER_PLAYS), len(FLANKS)) == (10, 19), "the page says ten and nineteen"
    assert f"from {FLANKS[0]:g} to {FLANKS[-1]:.0f} Hz, and then refined" in told
    assert f"that has at least {landings.FEWEST} of its own and no play" in told


def test_how_it_decides_tells_the_limits_that_it_uses() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"makes less than {100 * LEAST_EFFECT:g} % of the effort (one of the whole arm: at the joint where" in told
    assert f"At no joint does it remove {100 * LEAST_SEEN:g} % of the mean square" in told
    uneven = [100 * cause.least_of_friction for cause in (Offset, PositionFriction, Step)]
    assert f"of {100 * UNEVEN:g} % of friction and more at two joints or more" in told
    assert "| any | {:g} % | | | waves of the friction level | {:g} % |".format(*uneven) in told
    assert f"| a course over time | {uneven[2]:g} % |" in told
    assert EVENEST == 0.25, "the page says a quarter"
    assert f"at a level of {100 * FALSE_ALARM:g} % that is shared out" in told
    assert (KEPT, MOST_EXCHANGED, MOST_CAUSES, MOST_STEPS, ENOUGH_PER_PERIOD) == (10, 8, 12, 40, 4.0), "in words"
    assert f"for a while, by {100 * OFF:g} % at least" in told
    assert f"none is more than {FARTHEST_STAMP:g} steps off" in told
    assert f"Of more than {MOST_GROUPS}, several that follow one another are one cluster" in told
    assert (LOUDER, free_run.SECONDS) == (4.0, 0.25), "the page says four times, a quarter of a second"
    assert f"an uneven machine leaves at least {100 * UNEVEN / math.sqrt(2.0):.1f} % of its friction beyond its" in told
    assert f"of what was explained, {100 * LEAST_FRICTION:g} % of the joint's friction" in told
    for value, off in (("inertia of each rotor", ROTOR), ("torque constant of each drive", CONSTANT)):
        assert f"| {value} | {100 * off:g} % | {100 * FARTHEST * off:g} % |" in told
    assert (UNFINISHED, STEPS_PER_LOBE, ONE_OF_MANY, AROUND) == (2.0, 2, 0.25, 2.0), "in words"
    assert f"refused within {100 * (NEAR - 1.0):.0f} % of the frequencies at which a link swings" in told
    assert f"leaves the noise flat below {EVEN_BELOW:g} Hz at least" in told
    assert (EXACT, MOST_JOINTS, FEWEST_JOINTS) == (0.01, 0.75, 3), "the page says a percent, a quarter, three or more"
    assert f"It must remove {100 * MISFIT:g} % of the mean square that other causes remove" in told
    assert f"{100 * SURELY_SEEN:g} % of what is left is enough" in told
    assert f"it must also remove {100 * BRISTLE_MISFIT:g} % of what that cause removes" in told
    assert f"Steps that spread by less than {100 * UNEVEN_CLOCK:g} % are evened out and are no fault" in told
    assert FEWEST_AT_ONCE == 3, "the page says three"
    assert (ON_THE_WAY, FADED, LEFT) == (0.5, 0.1, 0.1), "the page says half, a tenth, and a tenth of the rows"
    assert (HARMONIC_TWO, HARMONIC, HIGHEST) == (0.005, 0.01, 8), "the page says 0.5 %, 1 %, and eight times"
    assert (DROWNED, ROOM, COLOURED) == (3.0, 0.5, 0.5), "the page says three times, half of the effect, half of it"
    assert STIFFER == (1.4, 1.9, 2.8)
    assert "under the largest load is 1.4, 1.9 and 2.8 times" in told
    assert (RESONANCE_BAND, SLIPS) == (0.8, (0.25, 0.75, 2.0)), "the page says four fifths; a quarter, …"
    assert f"all but {100 * NO_STEP:g} % of what stands out" in told
    assert (NEARLY_ALL, QUIETER) == (0.99, 0.5), "the page says all but a percent, and less than half"
    assert (INSTEAD, RESONANT) == (0.75, 0.75), "the page says a quarter less"
    assert f"a lightly damped resonance ({SLOWEST:g} to {FASTEST:g} Hz)" in told
    assert f"more than {100 * LEAST_TOLD:g} % of the joint's effort" in told
    assert f"| scale of each link | {100 * LINK_SCALE:g} % | {100 * FARTHEST * LINK_SCALE:g} % |" in told
    assert f"along each axis | {1e3 * LINK_SHIFT:g} mm | {1e3 * FARTHEST * LINK_SHIFT:g} mm |" in told
    assert f"({100 * RINGING:g} % of the fastest speed" in told
    assert f"at least {100 * LEAST_KIN_EFFECT:g} % of the joint's effort" in told
    assert f"first or last {100 * EDGE:g} %" in told
    assert (GONE_BY, LEAST_PART, OUTLYING) == (0.8, 0.1, 3.0), "the page says four fifths, a tenth and three times"
    assert f"with a usual deviation of {100 * LET_GO:g} %, in place of every named link" in told
    assert FARTHEST * 2.0 == STRAINED * 3.0, "the page says two thirds"
    assert (BAR, FEWEST_GAINING, MANY, LEAST_GAINED) == (2.0, 2, 2, 0.1), "the page says two, two, two and a tenth"
    assert (MOST_CONFIDENT, AT_THE_BAR, TOLD_BY) == (0.9, 0.5, 2), "the page says 0.9, half, all but one"
    assert MUCH_COLOURED == 0.3, "the page says three tenths"
    assert (Cogging.times, PositionFriction.times) == (3, 2), "the page says three waves of cogging and two of friction"


def test_how_it_decides_tells_what_an_error_that_none_explains_says_of_what_was_found() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"at most {EVEN:g} where something is left unexplained" in told
    assert (MANY_AT_A_JOINT, FEWEST_JOINTS) == (3, 3), "the page says three causes and three joints"


def test_how_it_decides_tells_which_exponents_are_usual_and_what_suffices_for_play() -> None:
    assert BRIEFLY == 0.5, "the page says half"
    assert f"those from {min(EXPONENTS):g} to {max(EXPONENTS):g} are tried" in text("docs/how_it_decides.md")


def test_how_it_decides_tells_how_long_the_travel_of_elements_may_be() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"The travel may be {100 * LONGEST_OF_ELEMENTS:g} % of the stroke then" in told
    assert SLIPS[-1] * LONGEST_OF_ELEMENTS < 1.0, "the last element slips within the stroke"


def test_how_it_decides_tells_how_often_an_effort_stands_at_a_limit() -> None:
    assert "stands still at its extreme only, twice or more" in text("docs/how_it_decides.md")
    assert FEWEST_STOPS == 2, "the page says twice"


def test_how_it_decides_tells_how_noise_is_known_by_its_colour() -> None:
    assert (FEWEST_ALIKE, MOST_ALIKE) == (3, 3.0), "the page says three others, and three times the sensor's noise"


def test_how_it_decides_tells_what_stands_for_links() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"friction is right to {100 * NEARLY_EXACT:g} % at three quarters" in told
    assert FEWEST_OTHERS + 1 == 3, "the page says three others"
    assert f"if the load leaves as little, within {100 * (AS_GOOD - 1.0):.0f} %" in told
    assert math.isclose(Offset.least_of_friction, 5.0 * ZERO), "the page says a fifth as a rule"
    assert OUT_OF_CHANCE == 5.0, "and up to that"


def test_how_it_decides_tells_what_ratios_a_shared_drive_may_have() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert "({:g} to {:g}) beside which both joints' levels are as stated".format(*RATIOS) in told
    assert f"comes out more than {100 * LEAST_OFF:g} % off, and a further drive leaves as little" in told
    assert NEARER == 0.5, "the page says half"


def test_how_it_decides_tells_how_wide_a_worn_place_is() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"a bump with a standard deviation of {100 * NARROWEST:g} to {100 * WIDEST:g} % of the stroke" in told
    assert f"a standard deviation of {100 * SHARPEST:g} to {100 * LEVEL_FROM:g} % of the stroke" in told
    assert PASSES == 4, "the page says four times"


def test_how_it_decides_tells_how_much_more_a_curve_may_leave() -> None:
    assert (NEARLY, OF_REMOVED) == (1.25, 1.0 / 50.0)
    told = " ".join(text("docs/how_it_decides.md").split())
    assert "at most a quarter more, which must be less than a fiftieth (in mean square) of what it removes" in told


def test_the_robot_file_tells_when_a_spot_comes_back() -> None:
    told = " ".join(text("docs/robot_file.md").replace("\n# ", " ").split())
    assert f"a series that comes back every {APART:g} widths" in told
    assert f"a series whose edges are {EDGES_APART / 2:g} widths apart" in told


def test_how_it_decides_tells_what_is_too_faint() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"Below a confidence of {100 * FAINTEST:g} %, a cause is not reported at all" in told
    assert (
        f"without which the error is at most {100 * (AS_GOOD - 1.0):.0f} % larger at every joint does not stay" in told
    )
    assert f"is refused; so is one by more than {MOST_CHANGE:g} times the stated friction" in told
    assert f"three quarters of the joint's motion are slower than {ALIKE:g} of its usual speed" in told
    assert FASTER == 0.75, "the page says three quarters"


def test_how_it_decides_tells_how_joints_creep() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"It is chosen where it gains at least {PAYS:g} more than one that is not damped" in told
    assert SHAKEN == 3, "the page says three joints or more"
    assert f"At least {AT_TURNS:g} of what play gains must come within {SOON:g} s of that" in told
    assert FLANK == 2.0, "the page says two widths"
    assert f"where the one effort is less than {OF_FEW:g} of the other" in told
    assert f"but {100 * FALLEN:g} % of it must have faded there" in told
    slowest, fastest = turning.SPEEDS[[0, -1]]
    assert f"within {100 * slowest:g} to {100 * fastest:g} % of their fastest speed" in told
    assert (turning.FEWEST_JOINTS, turning.ALL_BUT, turning.SHARE, turning.TURNED) == (3, 0.5, 0.25, 3.0), "in words"
    assert f"within {100 * turning.MOST_OFF:.0f} % of the level, and friction may turn within" in told
    assert f"may turn within {100 * turning.FARTHER[-1]:.0f} % of the fastest speed" in told


def test_the_pages_tell_which_joints_and_traces_are_left_out() -> None:
    decides, records = (" ".join(text(f"docs/{page}.md").split()) for page in ("how_it_decides", "recording"))
    held = f"travels less than {100 * HELD:g} % as far as the joint of its kind"
    assert f"by less than {100 * DAWDLING:g} % of both" in decides
    assert measure.MOST_SPOILT == 0.9, "the page says nine tenths"
    assert f"leaves less than {turning.ALONE:g} of the error left by friction that builds up" in decides
    assert f"that stands out by {jumps.PLAIN:g} standard deviations" in decides
    assert f"At least {jumps.FEWEST_ALIKE} jumps of one size" in decides
    assert f"at least {landings.FEWEST} blows of its own" in decides
    assert (landings.AGREE, landings.MOSTLY, FLOWN) == (0.2, 0.5, (0.5, 2.0)), "a fifth, half, half and twice"
    assert jumps.DEGREE == 5, "the page says fifth"
    assert f"takes more than {100 * LEAST_ROTOR:g} % of what its links do" in decides
    assert held in decides
    assert f"and {100 * USUALLY:g} % of the time it is slower than {100 * HELD:g} % of the fastest one" in decides
    assert f"1 m counting as 1 rad, and the limit is {100 * HELD_BESIDE_ANOTHER_KIND:g} %" in decides
    assert f"held throughout (less than {100 * HELD:g} % of the travel of others of its kind) is not" in records
    identification = " ".join(text("docs/identification.md").split())
    assert f"must be at least {100 * choose.LEAST_EFFECT:g} % of the joint's friction" in identification
    assert f"by {100 * choose.LEAST_GAIN:g} % of the squared error" in identification
    assert "more than a tenth of what is left" in identification
    assert "more than half of it is no noise, and that is more than half a percent" in identification
    assert (conclude.STRUCTURED, COLOURED, conclude.LEAST_EFFORT) == (0.1, 0.5, 0.005), "as the page says"


def test_how_it_decides_tells_what_stands_out_of_a_models_small_errors() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"beyond {small_errors.NOISY:g} times its sensor's noise" in told
    assert f"must remove {100 * small_errors.STANDS_OUT:g} % of the mean square that they leave together" in told
    assert f"less than {100 * small_errors.USUAL:g} % of the effort makes" in told


def test_how_it_decides_tells_how_much_more_a_spring_must_remove() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"no larger than {100 * small_errors.USUAL:g} % of the effort and less than a tenth, in" in told
    assert as_plain.PART == 0.1, "in words"
    assert f"must remove {BentSpring.least_cleared:g} times the mean square that is left at its joint" in told


def test_how_it_decides_tells_what_is_known_no_better_and_what_is_one_of_several() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"| by {100 * torque_constant.LEAST_OFF:g} % if the rest of the robot is stated exactly" in told
    assert f"larger than {100 * offset.ONE_WAY:g} % of the stated Coulomb level" in told
    stiff = f"swings at less than {USUALLY_SWINGS:g} Hz on it, or it gives by more than {1e3 * USUALLY_GIVES:g} mrad"
    assert f"{stiff} ({1e3 * USUALLY_GIVES_ALONG:g} mm)" in told
    assert f"its confidence is below {100 * findings.ONE_OF_SEVERAL:g} %" in told
    assert f"its confidence is below {100 * findings.HARDLY_LARGER:g} % all the same" in told
    assert findings.SEVERAL_JOINTS == 4, "in words"
    assert f"of drives and links would grow by {nearness.STRAINED:g}, the equivalent of one value at eight" in told
    assert f"no joint has more than {small_errors.NOISY:g} times its sensor's noise left; gears" in told
    enough = f"{100 * QUIETLY * LEAST_EFFECT:g} %"
    assert f"no more than {small_errors.NOISY:g} times its sensor's noise is left at every joint, {enough} is" in told
    assert (
        f"a fifth of it, {enough}, where no more than {small_errors.NOISY:g} times the sensor's noise is left" in told
    )
    assert f"the load is placed {FAR_OUT:g} m from the flange" in told
    assert f"friction is off by more than {100 * hidden_curve.SUSPECT:g} %, but not by enough" in told
    assert hidden_curve.HALVED == 0.5, "in words"


def test_how_it_decides_tells_at_what_level_other_halves_are_asked_for() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"at the plain {100 * KIN_CHANCE:g} % level" in told
    assert f"In the same way, at {100 * FULLER_CHANCE:g} %, a drive" in told


def test_how_it_decides_tells_when_columns_are_out_of_place_and_when_a_log_is_mended() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert "a quarter of the variance of a joint's effort is left unexplained, and less than a third of that" in told
    assert f"two joints that leave {100 * misplaced.NOTICED:g} % unexplained keep a fifth of that each" in told
    assert (misplaced.POOR, misplaced.MENDED, misplaced.MENDED_BOTH) == (0.25, 0.3, 0.2), "as the page says"
    assert f"explained worse by {100 * NO_WORSE:g} % of its effort's variance" in told
    assert f"by {100 * glitches.TOUCHED:g} % of its height" in told
    assert NO_CONTACT == 3.0, "the page says three quarters"
    assert f"none may have more than {small_errors.NOISY:g} times its sensor's noise left: where other" in told
    assert RIGID == 0.3, "the page says less than a third"
    assert (FEWEST_SHOWN, LEAST_SHOWN, EXPLAINED) == (3, 0.1, 0.01), "the page says three, a tenth and a hundredth"
    assert (WHOLE, CARRIED) == (1.2, (0.06, 1.5)), "the page says a fifth more, between 0.06 and 1.5"
    assert (len(TRIED), min(TRIED), max(TRIED)) == (4, 0.12, 1.0), "the page says four, from an eighth to one"
    assert (mend.MOST_ROUNDS, AS_KNOWN) == (3, 1.25), "three times, within a quarter"
    assert (mend.ANOTHER_SIZE, mend.NEAR) == (1.25, 0.1), "a quarter larger and smaller, within a tenth"


def test_the_pages_build_without_a_warning(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "mkdocs", "build", "--site-dir", str(tmp_path / "site")]
    done = subprocess.run(words, cwd=ROOT, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    listed = {path.stem for path in (tmp_path / "site").glob("*.html")}
    assert {page.stem for page in (ROOT / "docs").glob("*.md")} <= listed
    assert "pages exist in the docs directory" not in done.stderr, "a page is missing in mkdocs.yml"


def test_how_it_decides_tells_how_far_links_are_off() -> None:
    told = " ".join(text("docs/how_it_decides.md").split())
    assert f"more than {100 * LEAST_NOTED:g} % (or three times" in told
    assert f"up to {100 * ALWAYS_NOTED:g} %), and by more than {100 * SURELY:g} %" in told
    assert FEWEST_JOINTS == 3, "the page says three joints"
    assert f"off by more than {100 * SURELY:g} % with its whole interval, and the whole interval of every level" in told
    assert f"and damping must lie within {100 * AS_STATED:g} % of what is stated" in told
    assert f"| torque constant | it is off by {100 * CONSTANT_OFF:g} % |" in told
    assert f"the bounds of {100 * CONSTANT_OFF:g} % and {100 * ROTOR_OFF:g} % hold" in told
    assert f"drives as stated, is off by more than {100 * LEAST_FACTOR:g} %, and neither" in told
    assert f"What is left must be less than {CLEAN:g} times the sensor's noise" in told
    assert f"{FINEST} half waves over the stroke" in told
    assert f"by {PAYS:g} of merit, or leaves as little (within {100 * (AS_GOOD - 1.0):g} %)" in told
    assert f"a power of speed between {POWERS[0]:g} and {POWERS[1]:g}" in told
    assert f"lies more than {100 * LEAST_MOVED:g} cm off" in told
    assert NEARER_LINKS == (0.1, 0.2, 0.4), "the page says a tenth, a fifth or two fifths"
    assert f"off by a factor, by more than {100 * LEAST_MOMENTS:g} %" in told
    alone = f"{100 * LEAST_ALONE:g} %"
    assert f"one link that is {alone} off; - a payload that makes the last link {alone} heavier" in told
    assert f"or moves its centre by {1e3 * LEAST_MOVED_ALONE:g} mm" in told
