"""What is found is known from then on: other causes are looked for as late as drives report, with the body's loads."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from mjfriction.diagnose.model import Model, build_model
from mjfriction.diagnose.shapes import reshaped
from mjfriction.diagnose.tangent import straightened
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats
from mjfriction.robot.effort import without_offsets
from mjfriction.robot.links_torque import links_torque
from mjfriction.robot.robot import Robot

HEARD = 0.02  # periods of the band, by which a delay must have moved for columns to be drawn anew
WEIGHED = 0.1  # of a joint's load, by which it must have changed for columns to be drawn anew
WEIGHED_SAMPLES = 1000  # enough to tell how far loads are apart
HEARINGS = 3


def as_known(model: Model) -> Model:
    """Return the model on a gap that knows what it found.

    Where drives are found to report late, all causes are looked for as late as they are reported; where the body is
    found to be another, or elsewhere, with the loads of that.
    """
    for _ in range(HEARINGS):
        gap, nuisance, late, robot = model.gap, model.nuisance, _delays(model), _weighed(model)
        anew: Collection[int] | None = np.flatnonzero(late != gap.late).tolist()
        if np.max(np.abs(late - gap.late)) * gap.chain.band >= HEARD:
            gap = gap.heard_later(late)
            nuisance = nuisance.along(gap, nuisance.sources)
        if _load_changes(gap, robot):
            gap, anew = gap.beside(robot), None
        if gap is model.gap:
            break
        model = straightened(reshaped(build_model(gap, nuisance, model.chosen), anew))
    return model


def _weighed(model: Model) -> Robot:
    # The stated robot with the body that was found, where it was found to be.
    robot, inertias = model.gap.robot, model.nuisance.inertias
    if inertias is not None:
        robot = inertias.applied(robot, model.strengths[model.nuisance.of_inertias])
    for choice, place in zip(model.chosen, model.places, strict=True):
        strengths = model.strengths[place]
        if choice.cause.of_body and choice.cause.admissible(model.gap, choice.site, strengths):
            robot = choice.cause.extend(robot, choice.site, strengths)
    return robot


def _load_changes(gap: Gap, robot: Robot) -> bool:
    # Whether another body's loads are far from those that are known.
    some = slice(None, None, max(1, gap.motion.time.size // WEIGHED_SAMPLES))
    thin, loads = gap.motion.part(some), []
    for one, body in ((robot, robot.body()), (gap.known.robot, gap.known.body)):
        loads.append(links_torque(one, body, without_offsets(one, thin)))
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
