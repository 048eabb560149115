"""A payload is a part of the last link: of the two, the payload is what somebody forgot to state."""

from __future__ import annotations

import numpy as np

from mjfriction.body.regressor import tip_link
from mjfriction.diagnose.causes.links import LinkScale
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.fit.as_little import leaves_as_little
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nearness import STRAINED, relief
from mjfriction.identify.gap import Gap


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
        laden = build_model(gap, model.nuisance, (*rest, Chosen(Payload(), site)))
        strengths = laden.strengths[laden.places[-1]]
        near = relief(model, laden) < strengths.size * float(np.log(gap.blocks.count))
        if near and Payload().admissible(gap, site, strengths) and leaves_as_little(laden, model):
            usual = Payload().usual(gap, site, strengths)
            if exact or (not usual and relief(laden, build_model(gap, model.nuisance, rest)) > STRAINED):
                return laden
    return model
