"""Load friction and a wrong torque constant at one joint: a gear that loses more when driving than when driven.

μ·|τ|·sgn v + ε·τ is friction with coefficient μ + ε where the drive works against the load and μ − ε where the load
drives.  A torque constant also scales the joint's own friction, so levels held as stated show which of the two it is.
Where they do not, one cause is preferred to two.
"""

from __future__ import annotations

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.load import DriveLoad, Load
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.trial import try_out


def geared(model: Model) -> Model:
    """Return the model with geared load friction, which differs with the direction of power, in place of load friction
    and a torque constant at one joint, where that leaves as little.

    It must do so with the joint's levels held as stated, and with them free.
    """
    for load in model.chosen:
        at = (TorqueConstant.name, load.site.joint, 0)
        for factor in (choice for choice in model.chosen if choice.key == at):
            if isinstance(load.cause, Load | DriveLoad):
                one = Chosen(load.cause.geared(), Site(load.site.joint))
                model = _in_place_of(model, (load, factor), one) or model
    return model


def _in_place_of(model: Model, both: tuple[Chosen, Chosen], one: Chosen) -> Model | None:
    gap, joint = model.gap, one.site.joint
    rest = tuple(choice for choice in model.chosen if choice not in both)
    if try_out(build_model(gap, model.nuisance, rest), one) is None:
        return None
    held = model.nuisance.without_level(joint)
    instead, apart = (build_model(gap, held, chosen) for chosen in ((*rest, one), model.chosen))
    free = build_model(gap, model.nuisance, instead.chosen)
    return free if leaves_as_little(instead, apart, [joint]) and leaves_as_little(free, model) else None
