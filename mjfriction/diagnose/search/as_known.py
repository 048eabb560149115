"""Feed findings back: search for other causes with the drive delays and body loads found so far."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from mjfriction.diagnose.fit.model import Model, build_model
from mjfriction.diagnose.fit.shapes import reshaped
from mjfriction.diagnose.fit.tangent import straightened
from mjfriction.identify.gap import Gap
from mjfriction.identify.measure import heard_later
from mjfriction.record.log import Floats
from mjfriction.robot.effort import without_offsets
from mjfriction.robot.links_torque import links_torque
from mjfriction.robot.robot import Robot

HEARD = 0.02  # a delay must move by this many periods of the band before columns are rebuilt
WEIGHED = 0.1  # a joint's load must change by this fraction (RMS) before columns are rebuilt
WEIGHED_SAMPLES = 1000  # enough samples to tell how much loads differ
HEARINGS = 3  # most rounds of rebuilding columns and refitting


def as_known(model: Model) -> Model:
    """Return the model on a gap that includes the delays and loads found so far.

    Where drives are found to report late, all causes are searched for with that delay. Where the body is found to
    differ, or to be placed otherwise, causes are searched for with the loads of that body.
    """
    for _ in range(HEARINGS):
        gap, nuisance, late, robot = model.gap, model.nuisance, _delays(model), _weighed(model)
        anew: Collection[int] | None = np.flatnonzero(late != gap.late).tolist()
        if np.max(np.abs(late - gap.late)) * gap.chain.band >= HEARD:
            gap = heard_later(gap, late)
            nuisance = nuisance.along(gap, nuisance.sources)
        if _load_changes(gap, robot):
            gap, anew = gap.beside(robot), None
        if gap is model.gap:
            break
        model = straightened(reshaped(build_model(gap, nuisance, model.chosen), anew))
    return model


def _weighed(model: Model) -> Robot:
    # The stated robot with the body, and its placement, as found so far.
    robot, inertias = model.gap.robot, model.nuisance.inertias
    if inertias is not None:
        robot = inertias.applied(robot, model.strengths[model.nuisance.of_inertias])
    for choice, fitted in model.fitted_causes:
        if choice.cause.of_body and choice.cause.admissible(model.gap, choice.site, fitted):
            robot = choice.cause.extend(robot, choice.site, fitted)
    return robot


def _load_changes(gap: Gap, robot: Robot) -> bool:
    # Whether a robot's loads differ much from those that the gap is built with.
    some = slice(None, None, max(1, gap.motion.time.size // WEIGHED_SAMPLES))
    thin, loads = gap.motion.part(some), []
    for one, body in ((robot, robot.body()), (gap.known.robot, gap.known.body)):
        loads.append(links_torque(one, body, without_offsets(one, thin)))
    moved, size = (np.sqrt(np.mean(np.square(values), axis=0)) for values in (loads[0] - loads[1], loads[1]))
    return bool(np.any(moved > WEIGHED * size))


def _delays(model: Model) -> Floats:
    # By how much (s) the drives report later than stated, as found so far, (joints,).
    stated = robot = model.gap.robot
    for choice, fitted in model.fitted_causes:
        if choice.cause.of_sensor:
            robot = choice.cause.extend(robot, choice.site, fitted)
    pairs = zip(robot.table.joint, stated.table.joint, strict=True)
    return np.array([found.effort_sensor.delay - own.effort_sensor.delay for found, own in pairs])
