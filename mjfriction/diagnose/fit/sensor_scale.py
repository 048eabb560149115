"""What a new scale of a joint's effort sensor means for what was fitted beside it."""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.fit.model import Chosen, Model
from mjfriction.diagnose.fit.refitted import Drive
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats


def sensor_factors(model: Model, strengths: Floats) -> Floats:
    """Return by what factor each fitted strength is larger than the value that the robot file has to state.

    The fit adds every effect at the sensor's output.  Where a joint's sensor gets a new scale 1 + ε, effects before the
    sensor come out 1 + ε times as large there; the robot file states them before it.  What changes the links' loads is
    felt by several joints, whose sensors' scales act on the loads as they are found, so its strengths are not larger.
    """
    nuisance = model.nuisance
    scale = np.ones(len(model.gap.robot.joints))
    drives = list(zip(nuisance.drives, strengths[nuisance.of_drives].tolist(), strict=True))
    constants = [(drive.site.joint, change) for drive, change in drives if drive.cause.name == TorqueConstant.name]
    constants += [
        (choice.site.joint, float(strengths[place][0]))
        for choice, place in zip(model.chosen, model.places, strict=True)
        if choice.cause.name == TorqueConstant.name
    ]
    for joint, change in constants:
        scale[joint] *= 1.0 + change
    out = np.ones(strengths.size)
    for level in nuisance.levels:
        out[nuisance.of_level(level.site.joint)] = scale[level.site.joint]
    for k, (drive, _) in enumerate(drives, start=nuisance.of_drives.start):
        out[k] = _scaled(model.gap, drive, scale)[0]
    for choice, place in zip(model.chosen, model.places, strict=True):
        if not choice.cause.of_body:
            out[place] = _scaled(model.gap, choice, scale)
    return out


def _scaled(gap: Gap, one: Drive | Chosen, scale: Floats) -> list[float]:
    # The factor of each strength of a drive or a cause.
    quantities = one.cause.quantities(gap, one.site)
    return [float(scale[one.site.joint]) if quantity.before_sensor else 1.0 for quantity in quantities]
