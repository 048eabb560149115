"""body.link_inertia told from links that were refitted along, when they are off by more than stated inertias are."""

from __future__ import annotations

import numpy as np

from mjfriction.diagnose.alike import MOST_CONFIDENT, Standing, standing
from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LEAST_NOTED, LinkScale
from mjfriction.diagnose.field import Field
from mjfriction.diagnose.links_off import links_far_off
from mjfriction.diagnose.model import Chosen, Model, build_model
from mjfriction.diagnose.nuisance import PER_LINK
from mjfriction.diagnose.outcome import Finding
from mjfriction.diagnose.untold import Untold, shows
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.proof import gain_at
from mjfriction.record.log import Floats

SURELY = 0.05  # of a link's stated mass and inertia, that the whole interval of its change must be off by


def link_finding(model: Model, half: Floats, untold: Untold, field: Field, seed: int) -> Finding | None:
    """Return the links' inertias as a finding when some are off by more than a stated inertia ever is.

    ``half`` are the half-widths of the nuisances' 95 % intervals.
    """
    gap, nuisance = model.gap, model.nuisance
    changes = model.link_changes[:, 0]
    named = [choice for choice in model.chosen if choice.cause.name == LinkScale.name]
    if not changes.size or any(choice.key not in untold.keys for choice in named):
        return None  # a link was named on its own; the others' few percent are refitted along
    widths = half[nuisance.of_links].reshape(-1, PER_LINK)[:, 0]
    noted = (np.abs(changes) > LEAST_NOTED) & (np.abs(changes) - widths > SURELY)
    if not np.any(noted) or not links_far_off(model):
        return None
    without = model.without_links()
    if not shows(gap, without.heldout_residual(), model.heldout_residual(), gap.examined, untold.left, untold.bare):
        return None
    before, heldout = without.heldout_residual(oscillations=True), model.heldout_residual(oscillations=True)
    gains = {joint: gain_at(gap, before, heldout, joint, seed) for joint in gap.examined}
    joint = max(gains, key=lambda place: gains[place].reduction)
    most = nuisance.links[int(np.argmax(np.abs(changes) * noted))].name
    stands = _link_standing(model, most, field)
    scales = [
        Fitted(
            f"link_scale.{link.name}",
            "mass and inertia of the link that the joint moves, relative to what is stated",
            "1",
            1.0 + float(change),
            1.0 + float(change - width),
            1.0 + float(change + width),
        )
        for link, change, width, own in zip(nuisance.links, changes, widths, noted, strict=True)
        if own
    ]
    return Finding(
        cause=LinkScale.name,
        joint=None,
        confidence=stands.confidence,
        alternatives=stands.alternatives,
        parameters=tuple(scales),
        gain=gains[joint],
        evidence="masses and inertias of the links do not fit the efforts of all joints at once as they are stated",
        covariate=LinkScale.covariate,
        picture=LinkScale.picture,
        shown_at=gap.robot.joints[joint],
    )


def _link_standing(model: Model, link: str, field: Field) -> Standing:
    # The link that is most off against whatever else could stand for it: on a lone sliding axis, a payload or a rotor.
    if link not in model.gap.robot.joints:
        return Standing((), MOST_CONFIDENT)
    scaled = Chosen(LinkScale(), Site(model.gap.robot.joints.index(link)))
    alone = build_model(model.gap, model.nuisance.without_links(), (*model.chosen, scaled))
    return standing(alone, scaled, field)
