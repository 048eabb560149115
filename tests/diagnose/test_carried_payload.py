"""What an arm takes up or puts down while a log is recorded is a payload, said with the moments."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pytest

from mjfriction.diagnose.causes.carried_payload import CarriedPayload
from mjfriction.diagnose.causes.payload import Payload as Held
from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.fit.model import Chosen, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.search.field import make_field
from mjfriction.diagnose.search.short_list import ranked
from mjfriction.diagnose.tell.outcome import Diagnosis, Verdict
from mjfriction.identify.measure import measure_gap
from mjfriction.plant.machine import simulate
from mjfriction.plant.motions import excitation
from mjfriction.plant.sensors import Recorder
from mjfriction.record.log import Log
from mjfriction.record.merge import merge_logs
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.body_tables import Payload, TakenUp
from mjfriction.robot.files import read_robot
from mjfriction.robot.links_torque import is_held
from mjfriction.robot.robot import Robot
from mjfriction.robot.schema import EffortSensor
from tests.deep import deep

HOME = np.array([0.0, -1.2, 1.4, -0.4, 1.2, 0.0])
CENTRE, FLANGE = (0.02, 0.01, 0.08), "wrist_3_joint"
BEGIN, END = 7.3, 16.1
MOMENT = 0.2  # s, five rows of the fit: within them what is left differs by less than noise makes of it
FILTERED = 0.5  # s, beyond which the filter of efforts carries next to nothing from one moment to another


def arm(mass: float = 0.0, *taken_up: TakenUp) -> Robot:
    robot = read_robot("ur5")
    for joint in robot.table.joint:
        robot = robot.with_joint(joint.model_copy(update={"effort_sensor": EffortSensor(noise=0.3)}))
    payload = Payload(mass=mass, com=CENTRE, parent=FLANGE) if mass else None
    return Robot(robot.table.model_copy(update={"payload": payload, "taken_up": taken_up}), robot.folder)


def load(mass: float, begin: float, end: float | None) -> TakenUp:
    return TakenUp(mass=mass, com=CENTRE, parent=FLANGE, begin=begin, end=end)


def recorded(robot: Robot, seed: int = 5) -> Log:
    count = len(robot.joints)
    course = excitation(robot.joints, HOME, np.full(count, 0.7), np.full(count, 1.0), 25.0, seed=seed)
    return log_from_table(pa.table(simulate(robot, course, recorder=Recorder(125.0), seed=seed)), f"run{seed}.csv")


@functools.cache
def diagnosed(mass: float, stated: float, begin: float, end: float | None) -> Diagnosis:
    return diagnose_log(recorded(arm(stated, load(mass, begin, end))), arm(stated))


@pytest.mark.parametrize(
    ("mass", "stated", "begin", "end"),
    [
        (1.2, 0.0, BEGIN, END),
        deep(1.2, 0.0, BEGIN, None),  # taken up, and held to the end
        deep(1.2, 0.0, 0.0, END),  # put down
        deep(-1.5, 1.5, BEGIN, END),  # what is stated is put down meanwhile
    ],
)
def test_it_is_told_with_its_moments(mass: float, stated: float, begin: float, end: float | None) -> None:
    diagnosis = diagnosed(mass, stated, begin, end)
    assert diagnosis.verdict is Verdict.EXPLAINED
    (finding,) = diagnosis.findings
    assert (finding.cause, finding.joint) == ("body.payload", None)
    (held,) = diagnosis.robot.table.taken_up
    assert held.mass == pytest.approx(mass, rel=0.05)
    assert held.com == pytest.approx(CENTRE, abs=0.02)
    assert held.begin == pytest.approx(begin, abs=MOMENT)
    assert held.end == (None if end is None else pytest.approx(end, abs=MOMENT))


def test_its_error_is_removed_on_motion_not_fitted() -> None:
    (finding,) = diagnosed(1.2, 0.0, BEGIN, END).findings
    assert finding.gain.low > 0.5


@pytest.mark.deep
def test_one_held_throughout_has_no_moments() -> None:
    diagnosis = diagnose_log(recorded(arm(1.2)), arm())
    assert [(finding.cause, len(finding.parameters)) for finding in diagnosis.findings] == [("body.payload", 4)]
    assert diagnosis.robot.table.taken_up == ()


def test_several_logs_have_whiles_of_their_own() -> None:
    gap = measure_gap(merge_logs([recorded(arm(), seed) for seed in (1, 2)]), arm())
    assert CarriedPayload().sites(gap) == []


def test_its_columns_are_those_of_a_mass_that_is_held_from_begin_to_end() -> None:
    gap, cause = measure_gap(recorded(arm()), arm()), CarriedPayload()
    sites = cause.sites(gap)
    screened = cause.screening(gap, sites, 7)
    for k, site in enumerate(sites[::10]):
        span, time = cause.span(site), gap.chain.time
        torques = cause.torques(gap) * is_held(*span, gap.motion.time)[:, None, None]
        apart = np.all([np.abs(time - moment) > FILTERED for moment in span], axis=0)
        for joint, values in cause.columns(gap, site).items():
            np.testing.assert_allclose(values[apart], gap.reported(joint, torques[:, joint])[apart], atol=1e-3)
            np.testing.assert_array_equal(screened[joint][:, 10 * k], values[::7])


def test_it_is_looked_for_although_links_have_taken_its_mean() -> None:
    gap, strengths = measure_gap(recorded(arm()), arm()), np.array([1.2, 0.0, 0.0, 0.1])
    whole = next(iter(Held().sites(gap)))
    site = whole.shaped((BEGIN, END))
    site = replace(site, begin=float(gap.motion.time[0]), end=float(gap.motion.time[-1]))
    carried, throughout = CarriedPayload().columns(gap, site), Held().columns(gap, whole)
    residual = gap.residual.copy()
    for joint, values in carried.items():
        residual[:, joint] += values @ strengths
    left = build_model(replace(gap, residual=residual), make_nuisance(gap), (Chosen(Held(), whole),))
    for joint, values in throughout.items():
        residual[:, joint] -= values @ left.strengths[left.places[0]]
    bare = build_model(replace(gap, residual=residual), make_nuisance(gap), ())
    found = [type(choice.cause) for choice in ranked(bare, make_field(gap, (Held(), CarriedPayload())))]
    assert found == [CarriedPayload]
