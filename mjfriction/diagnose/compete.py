"""Causes compete for the residual: forward by what they explain on motion not fitted, then back."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize
from scipy.stats import t as student

from mjfriction.body.inverse import inverse_dynamics
from mjfriction.diagnose.causes.cause import Cause, Site
from mjfriction.diagnose.hum import unheard_tones
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.diagnose.nuisance import Nuisance, make_nuisance
from mjfriction.diagnose.refusal import refused
from mjfriction.diagnose.tangent import straightened
from mjfriction.diagnose.trial import Trial, try_out
from mjfriction.identify.gap import Gap
from mjfriction.identify.regression import UNSEEN, Columns
from mjfriction.progress import Tell, silently
from mjfriction.record.log import Floats
from mjfriction.robot.effort import without_offsets
from mjfriction.robot.robot import Robot

# These two were loosened (from 0.01 and 0.03) with the EMPS log in hand, whose offset stands at their edge; no other
# data speaks for their values yet.
KIN_CHANCE = 0.05  # at which a cause's other half is taken along: that of its 95 % interval leaving out zero
LEAST_KIN = 0.02  # of its partner's effort that a cause's other half must reach
LEAST_KIN_EFFECT = 0.002  # and of the joint's effort
MOST_CAUSES = 12
SHORT_LIST = 8
NEAR_BEST = 0.9  # of the best candidate's merit, from which on two are compared on the real balance
NO_DIFFERENCE = 1.0  # of merit: the data are then but 1.6 times as likely under one as under the other
SCREENED_ROWS = 1000  # enough to rank shapes by
HEARD = 0.02  # periods of the band, by which a delay must have moved for columns to be drawn anew
WEIGHED = 0.1  # of a joint's load, by which it must have changed for columns to be drawn anew
HEARINGS = 3


@dataclass(frozen=True)
class Entrant:
    """A cause on a joint, with every shape of its starting grid; ``times`` is how many of it the joint may have."""

    cause: Cause
    joint: int
    sites: tuple[Site, ...]
    times: int

    @property
    def key(self) -> tuple[str, int]:
        """The cause's name and its joint."""
        return self.cause.name, self.joint

    @property
    def kind(self) -> tuple[type[Cause], int]:
        """What is refused when it is refused: this way to draw the cause, at this joint."""
        return type(self.cause), self.joint


Field = tuple[Entrant, ...]


def make_field(gap: Gap, causes: tuple[Cause, ...]) -> Field:
    """Return every cause at every joint it may sit on."""
    entrants = []
    for cause in causes:
        sites = cause.sites(gap)
        for joint in dict.fromkeys(site.joint for site in sites):
            own = tuple(site for site in sites if site.joint == joint)
            entrants.append(Entrant(cause, joint, own, cause.times))
    return tuple(entrants)


def size(field: Field) -> int:
    """Return how many candidates a field holds, every shape counted: how often chance may strike."""
    return sum(len(entrant.sites) for entrant in field)


SEARCHED, FURTHER = 0.8, 0.7  # of a diagnosis, that is search; of what is left of it, that each cause found leaves


def compete(gap: Gap, nuisance: Nuisance, field: Field, tell: Tell = silently) -> tuple[Model, Field]:
    """Choose the causes that the log shows, strongest first; return them with what of the field was not refused.

    Forward: of the candidates whose strengths are beyond chance (Wald's test with block-clustered covariance, at a
    level divided by the number of candidates) and that take away a share of the error on motion not fitted, the one
    that takes most is chosen, until none is left.  Backward: causes that the later ones have made needless are dropped.
    Proof: where a steady tone is heard that none of them makes, all compete anew beside it; what
    :func:`~mjfriction.diagnose.refusal.refused` names is refused, and the others compete anew without it.
    """
    asked, count = field, size(field)
    while True:
        model = _as_known(_pruned(_forward(gap, nuisance, asked, count, tell), count))
        tones = unheard_tones(model)
        if tones:
            nuisance = make_nuisance(gap, (*nuisance.tones, *tones))
            continue
        no_causes = refused(model)
        if not no_causes:
            return straightened(_with_kin(_fulfilled(model), field)), asked
        asked = _narrowed(asked, no_causes)


def _narrowed(field: Field, no_causes: list[Chosen]) -> Field:
    # What is refused, and all that come after it of its kind, are asked for no more.
    out = []
    for entrant in field:
        orders = [one.site.order for one in no_causes if (type(one.cause), one.site.joint) == entrant.kind]
        if min(orders, default=entrant.times) > 0:
            out.append(replace(entrant, times=min([*orders, entrant.times])))
    return tuple(out)


def _forward(gap: Gap, nuisance: Nuisance, field: Field, count: int, tell: Tell) -> Model:
    model = build_model(gap, nuisance, ())
    while len(model.chosen) < MOST_CAUSES:
        tell(f"searching for causes, {len(model.chosen)} so far", SEARCHED * (1.0 - FURTHER ** (1 + len(model.chosen))))
        passing = _passing(model, field, count)
        if not passing:
            break
        best = _best(field, fairly(model, passing))
        model = straightened(reshaped(build_model(model.gap, model.nuisance, (*model.chosen, best.chosen))))
        model = _as_known(model)
    return model


def _best(field: Field, trials: list[Trial]) -> Trial:
    # The one of the largest merit, or the first in the field of those that come as near to it as makes no difference.
    causes = [type(entrant.cause) for entrant in field]
    most = max(trial.merit for trial in trials)
    return min(
        (trial for trial in trials if trial.merit > most - NO_DIFFERENCE),
        key=lambda trial: causes.index(type(trial.chosen.cause)),
    )


def _as_known(model: Model) -> Model:
    # Where drives are found to report late, all causes are looked for as late as they are reported; where the body is
    # found to be another, or elsewhere, with the loads of that.
    for _ in range(HEARINGS):
        gap, nuisance, late, robot = model.gap, model.nuisance, _delays(model), _weighed(model)
        if np.max(np.abs(late - gap.late)) * gap.chain.band >= HEARD:
            gap = gap.heard_later(late)
            nuisance = make_nuisance(gap, nuisance.tones)
        if _load_changes(gap, robot):
            gap = gap.beside(robot)
        if gap is model.gap:
            break
        model = straightened(reshaped(build_model(gap, nuisance, model.chosen)))
    return model


def _weighed(model: Model) -> Robot:
    # The stated robot with the body that was found, where it was found to be.
    robot = model.gap.robot
    for choice, place in zip(model.chosen, model.places, strict=True):
        strengths = model.strengths[place]
        if choice.cause.of_body and choice.cause.admissible(model.gap, choice.site, strengths):
            robot = choice.cause.extend(robot, choice.site, strengths)
    return robot


def _load_changes(gap: Gap, robot: Robot) -> bool:
    # Whether another body's loads are far from those that are known.
    some = slice(None, None, max(1, gap.motion.time.size // SCREENED_ROWS))
    thin, loads = gap.motion.part(some), []
    for one, body in ((robot, robot.body()), (gap.known.robot, gap.known.body)):
        at = without_offsets(one, thin)
        loads.append(inverse_dynamics(body, at.position, at.velocity, at.acceleration))
    moved, size = (np.sqrt(np.mean(np.square(values), axis=0)) for values in (loads[0] - loads[1], loads[1]))
    return bool(np.any(moved > WEIGHED * size))


def _delays(model: Model) -> Floats:
    # By how much the drives report later than is stated, as far as was found, (joints,).
    stated = robot = model.gap.robot
    for choice, place in zip(model.chosen, model.places, strict=True):
        if choice.cause.of_sensor:
            robot = choice.cause.extend(robot, choice.site, model.strengths[place])
    pairs = zip(robot.table.joint, stated.table.joint, strict=True)
    return np.array([found.effort_sensor.delay - own.effort_sensor.delay for found, own in pairs])


def _passing(model: Model, field: Field, count: int) -> list[Trial]:
    # The best of a short list that pass; where none does, of the next: what no cause fits at one joint may have a dozen
    # candidates there rank before what is plain at another.
    ranked = _ranked(model, field)
    for first in range(0, len(ranked), SHORT_LIST):
        passing = [trial for trial in _all_tried(model, ranked[first : first + SHORT_LIST]) if trial.passes(count)]
        if passing:
            return passing
    return []


def fairly(model: Model, trials: list[Trial]) -> list[Trial]:
    """Return trials of which those near the best are tried on the real balance, where any of these is curved.

    A payload drawn in a straight line from none can lose against a shifted link that bends less.
    """
    best = max((trial.merit for trial in trials), default=0.0)
    close = [trial for trial in trials if trial.merit > NEAR_BEST * best]
    if len(close) < 2:
        return trials
    return [_bent(model, trial) if trial.merit > NEAR_BEST * best else trial for trial in trials]


def _bent(model: Model, trial: Trial) -> Trial:
    if not trial.chosen.cause.curved:
        return trial
    # What the curved causes chosen before have come to is left as it was: only the newcomer bends.
    fitted = straightened(build_model(model.gap, model.nuisance, (*model.chosen, trial.chosen)), trial.chosen)
    return try_out(model, fitted.chosen[-1]) or trial


def contenders(model: Model, field: Field) -> list[Trial]:
    """Screen every candidate not in the model yet, and return the trials of a short list, each at its best shape."""
    return _all_tried(model, _ranked(model, field)[:SHORT_LIST])


def _all_tried(model: Model, choices: list[Chosen]) -> list[Trial]:
    trials = [_tried(model, choice) for choice in choices]
    return [trial for trial in trials if trial is not None]


def _ranked(model: Model, field: Field) -> list[Chosen]:
    # Candidates by what they gain on a part of the rows, of which those that gain nothing are left out.
    every = max(1, model.gap.blocks.row.size // SCREENED_ROWS)
    best = []
    for entrant in field:
        order = _present(model, entrant)
        if order >= entrant.times:
            continue
        columns = _screening(model.gap, entrant, every)
        strengths, gains = model.system.screen(columns, every)
        for i in np.argsort(-gains):
            if entrant.cause.admissible(model.gap, entrant.sites[i], strengths[i]):
                gain = float(gains[i]) - _price(model.gap, _shown(columns, int(i)) + len(entrant.sites[i].shape))
                best.append((gain, Chosen(entrant.cause, replace(entrant.sites[i], order=order))))
                break
    return [choice for gain, choice in sorted(best, key=lambda entry: -entry[0]) if gain > 0.0]


def _present(model: Model, entrant: Entrant) -> int:
    return sum((choice.cause.name, choice.site.joint) == entrant.key for choice in model.chosen)


def _tried(model: Model, choice: Chosen) -> Trial | None:
    best = _best_shape(model, choice)
    if not choice.cause.own_shape(model.gap, best.site):
        return None
    # The shape that fits best may be one that nature does not allow; the grid's may be.
    trial = try_out(model, best) or try_out(model, choice)
    if trial is not None and choice.cause.of_sensor and model.chosen:
        return _bent(model, trial)
    return trial


def _screening(gap: Gap, entrant: Entrant, every: int) -> Columns:
    key = f"screening {type(entrant.cause).__name__} {entrant.joint}"
    if key not in gap.kept:
        gap.kept[key] = dict(entrant.cause.screening(gap, entrant.sites, every))
    return gap.kept[key]


def _shown(columns: Columns, site: int) -> int:
    # How many of a candidate's strengths the motion shows at all.
    size = sum(np.mean(np.square(values[:, site]), axis=0) for values in columns.values())
    return int(np.count_nonzero(size > UNSEEN**2 * np.max(size)))


def _price(gap: Gap, freedoms: int) -> float:
    # Every freedom, the searched shape included, costs what it gains on noise alone.
    return freedoms * float(np.log(gap.blocks.row.size))


def _best_shape(model: Model, choice: Chosen) -> Chosen:
    def lost(site: Site) -> float:
        columns = choice.cause.columns(model.gap, site)
        strengths, gains = model.system.screen({joint: values[:, None, :] for joint, values in columns.items()})
        return -float(gains[0]) if choice.cause.admissible(model.gap, site, strengths[0]) else 0.0

    around = choice.cause.around_sites(model.gap, choice.site)
    if around:
        return Chosen(choice.cause, min([choice.site, *around], key=lost))
    bounds = choice.cause.shape_bounds(model.gap, choice.site)
    if not bounds:
        return choice

    def loss(logarithm: Floats) -> float:
        return lost(choice.site.shaped(tuple(float(value) for value in np.exp(logarithm))))

    start = np.log(np.clip(choice.site.shape, *np.array(bounds).T))
    limits = [(float(np.log(low)), float(np.log(high))) for low, high in bounds]
    steps = np.log1p(np.divide(choice.cause.shape_steps(model.gap, choice.site), choice.site.shape))
    simplex = np.vstack([start, start + np.diag(steps)])
    options = {"maxfev": 60, "xatol": 1e-2 * float(np.min(steps)), "initial_simplex": simplex}
    found = minimize(loss, start, method="Nelder-Mead", bounds=limits, options=options)
    shape = tuple(float(value) for value in np.exp(found.x))
    return Chosen(choice.cause, choice.site.shaped(shape)) if found.fun < loss(start) else choice


def reshaped(model: Model, joint: int | None = None) -> Model:
    """Return the model with the shapes of its causes (of one joint's, if given) searched anew, each in turn.

    A new cause, or a level held, moves the best shapes of the others.
    """
    for i, choice in enumerate(model.chosen):
        if (choice.site.shape or choice.site.around) and not choice.tangent and joint in (None, choice.site.joint):
            better = _best_shape(model.without(choice), choice)
            model = build_model(model.gap, model.nuisance, (*model.chosen[:i], better, *model.chosen[i + 1 :]))
    return model


def _pruned(model: Model, count: int) -> Model:
    while model.chosen:
        trials = [(choice, try_out(model.without(choice), choice)) for choice in model.chosen]
        needless = [(trial.gain if trial else -np.inf, choice) for choice, trial in trials if not _stays(trial, count)]
        if not needless:
            return model
        model = reshaped(model.without(min(needless, key=lambda entry: entry[0])[1]))
    return model


def _stays(trial: Trial | None, count: int) -> bool:
    return trial is not None and trial.passes(count)


def _fulfilled(model: Model) -> Model:
    # What is found may be found with one strength more: one question asked beforehand, as that for its other half.
    for choice in model.chosen:
        if choice.cause.fuller is None:
            continue
        blocks, without = model.gap.blocks, model.without(choice)
        whole = Chosen(choice.cause.fuller(), choice.site)
        plain, full = without.with_candidate(choice), without.with_candidate(whole)
        strengths = full.strengths(np.ones(blocks.count, dtype=bool))
        deviation = float(np.sqrt(full.covariance(strengths, blocks.group)[-1, -1]))
        sure = abs(strengths[-1]) > student.ppf(1.0 - 0.5 * KIN_CHANCE, blocks.groups - 1) * deviation
        errors = [float(np.sum(normal.heldout_errors(blocks.folds))) for normal in (plain, full)]
        count = len(whole.cause.quantities(model.gap, whole.site))
        if sure and errors[1] < errors[0] and whole.cause.admissible(model.gap, whole.site, strengths[-count:]):
            model = build_model(model.gap, model.nuisance, (*without.chosen, whole))
    return model


def _with_kin(model: Model, field: Field) -> Model:
    # A found cause names its other half, if it has one.  That is one question asked beforehand, not the best of many
    # answers, so that it stands at the plain level; and it is measured against its partner, not against the effort.
    for choice in model.chosen:
        for entrant in field:
            if entrant.cause.name not in choice.cause.kin or entrant.joint != choice.site.joint:
                continue
            if _present(model, entrant):
                continue
            other = Chosen(entrant.cause, entrant.sites[0])
            trial = try_out(model, other, repeating=True)
            own = try_out(model.without(choice), choice)
            if not trial or not own or trial.chance > KIN_CHANCE:
                continue
            if trial.effect > max(LEAST_KIN * own.effect, LEAST_KIN_EFFECT):
                model = build_model(model.gap, model.nuisance, (*model.chosen, other))
    return model
