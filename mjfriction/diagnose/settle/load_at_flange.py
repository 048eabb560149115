"""A payload is a part of the last link: of the two, the payload is what somebody forgot to state."""

from __future__ import annotations

import numpy as np

from mjfriction.body.regressor import tip_link
from mjfriction.diagnose.causes.hung_payload import FAR_OUT, HungPayload
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.causes.payload import Payload, torques_about
from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nearness import STRAINED, relief
from mjfriction.identify.gap import Gap
from mjfriction.record.log import Floats


def of_last_link(gap: Gap, joint: int) -> bool:
    """Return whether the link that a joint moves is the last one, of which a payload at the flange is a part."""
    return gap.robot.joints[joint] == gap.body.link_holding(tip_link(gap.body))


def as_load(model: Model, *, exact: bool) -> Model:
    """Return the model with a payload at the flange in the place of a last link that is off.

    The payload must leave as little at every joint, and must not take links and drives farther from what is stated than
    its four numbers are worth. That one link of six is off would be chance; holding a load is what arms are made for.
    Where the rest is not stated ``exact``ly, the payload must be more than other links and drives could make up for.
    """
    gap = model.gap
    last = [one for one in model.chosen if one.cause.name == LinkScale.name and of_last_link(gap, one.site.joint)]
    if not last or any(choice.cause.name == Payload.name for choice in model.chosen):
        return model
    rest = tuple(choice for choice in model.chosen if choice not in last)
    for site in Payload().sites(gap):
        laden = _physical(build_model(gap, model.nuisance, (*rest, Chosen(Payload(), site))))
        load, strengths = laden.fitted_causes[-1]
        near = relief(model, laden) < len(load.cause.quantities(gap, load.site)) * float(np.log(gap.blocks.count))
        if near and load.cause.admissible(gap, load.site, strengths) and leaves_as_little(laden, model):
            usual = load.cause.usual(gap, load.site, strengths)
            if exact or (not usual and relief(laden, build_model(gap, model.nuisance, rest)) > STRAINED):
                return laden
    return model


def _physical(laden: Model) -> Model:
    # A model whose last cause is a payload, with one farther out in its place if that has too little mass for its first
    # moment: where the motion hardly shows the mass, any will do.
    gap, (load, strengths) = laden.gap, laden.fitted_causes[-1]
    if load.cause.admissible(gap, load.site, strengths) or gap.robot.table.payload is not None:
        return laden
    if not np.any(strengths[1:]):
        return laden  # no motion shows its first moment
    rest, centre = laden.without(load), _far_out(strengths[1:])
    # Its moments of inertia there, which a load near the last link does not have, change what is felt of the first
    # moment.
    torques = torques_about(gap, centre) @ np.vstack([centre / np.dot(centre, centre), np.eye(3)])
    felt = {joint: gap.reported(joint, torques[:, joint]) for joint in gap.examined}
    centre = _far_out(rest.system.extended(felt, np.zeros(3)).fitted[-3:])
    return rest.with_also(Chosen(HungPayload(), load.site.shaped(tuple(centre.tolist()))))


def _far_out(moment: Floats) -> Floats:
    # The centre of a payload with a first moment, as far out as it may be, (3,) each.
    return np.asarray(FAR_OUT / float(np.linalg.norm(moment)) * moment)
