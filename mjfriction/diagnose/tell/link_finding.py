"""The body.link_inertia finding, made from refitted links that are off by more than stated inertias are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.links import LEAST_NOTED, LinkScale
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.fit.base_changes import base_changes
from mjfriction.diagnose.fit.exact import OUTLYING, levels_off, surely_exact
from mjfriction.diagnose.fit.intervals import HalfWidths
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.refitted import FEWEST_JOINTS, PER_LINK
from mjfriction.diagnose.search.field import Field
from mjfriction.diagnose.settle.load_at_flange import of_last_link
from mjfriction.diagnose.tell.alike import EVEN, MOST_CONFIDENT, Standing, standing
from mjfriction.diagnose.tell.links_off import links_far_off
from mjfriction.diagnose.tell.outcome import Finding
from mjfriction.diagnose.tell.untold import Untold, shows
from mjfriction.identify.fitted import Fitted
from mjfriction.identify.proof import gain_at

SURELY = 0.05  # of a link's stated mass and inertia: the whole interval of its change must be beyond this
ALWAYS_NOTED = 0.09  # of a link's mass: a larger change is a finding however far off friction is
AS_STATED = 0.02  # relative to what is stated: friction must surely be that near for a link to be told of few joints
MOST_LISTED = 12  # most combinations of inertias that a finding lists


def link_finding(model: Model, widths: HalfWidths, untold: Untold, field: Field, seed: int) -> Finding | None:
    """Return the links' inertias as a finding where some are off by more than a stated inertia ever is, else None."""
    gap = model.gap
    named = [choice for choice in model.chosen if choice.cause.name == LinkScale.name]
    if any(choice.key not in untold.keys for choice in named):
        return None  # a link is a finding of its own; the few percent of the others are refitted along
    off = _let_go(model, widths) if model.nuisance.inertias else _scaled(model, widths, field)
    if off is None or not links_far_off(model):
        return None
    without = model.without_links()
    if not shows(gap, without.heldout_residual(), model.heldout_residual(), untold.left, untold.bare, {}):
        return None
    before, heldout = without.heldout_residual(oscillations=True), model.heldout_residual(oscillations=True)
    gains = {joint: gain_at(gap, before, heldout, joint, seed) for joint in gap.examined}
    joint = max(gains, key=lambda place: gains[place].reduction)
    return Finding(
        cause=LinkScale.name,
        joint=None,
        confidence=off.standing.confidence,
        alternatives=off.standing.alternatives,
        parameters=off.parameters,
        gain=gains[joint],
        evidence=off.evidence,
        covariate=LinkScale.covariate,
        picture=LinkScale.picture,
        shown_at=gap.robot.joints[joint],
        without=heldout[:, joint] + model.made_by([model.nuisance.of_links, model.nuisance.of_inertias])[:, joint],
    )


@dataclass(frozen=True)
class _Off:
    parameters: tuple[Fitted, ...]
    standing: Standing
    evidence: str


def _scaled(model: Model, widths: HalfWidths, field: Field) -> _Off | None:
    # The links whose scale is off, with the standing of the one that is most off; None where there is none, or where
    # too few joints tell a link from a torque constant, which may be off by as much and looks the same there, unless
    # friction is surely as stated.
    few = len(model.gap.examined) < FEWEST_JOINTS
    if few and not surely_exact(model, AS_STATED):
        return None
    nuisance, changes = model.nuisance, model.link_changes[:, 0]
    half = widths.nuisance[nuisance.of_links].reshape(-1, PER_LINK)[:, 0]
    least = SURELY if few else min(max(LEAST_NOTED, OUTLYING * levels_off(model)), ALWAYS_NOTED)
    noted = (np.abs(changes) > least) & (np.abs(changes) - half > SURELY)
    if not np.any(noted):
        return None
    scales = tuple(
        Fitted(
            f"link_scale.{link.name}",
            "mass and inertia of the link that the joint moves, relative to what is stated",
            "1",
            1.0 + float(change),
            1.0 + float(change - width),
            1.0 + float(change + width),
        )
        for link, change, width, own in zip(nuisance.links, changes, half, noted, strict=True)
        if own
    )
    most = nuisance.links[int(np.argmax(np.abs(changes) * noted))].name
    evidence = "masses and inertias of the links do not fit the efforts of all joints at once as they are stated"
    return _Off(scales, _link_standing(model, most, field), evidence)


def _let_go(model: Model, widths: HalfWidths) -> _Off | None:
    # No rivals: whatever few causes could stand in for all links has already lost against freed links.
    changes = base_changes(model, widths)
    if not changes.off:
        return None
    evidence = (
        "the efforts of all joints at once ask for other masses, centres and moments of the links than are stated: "
        f"of {changes.shown} combinations of these that the motion shows, {len(changes.off)} are off"
    )
    most = tuple(fitted for _, fitted in changes.off[:MOST_LISTED])
    return _Off(most, Standing((), MOST_CONFIDENT), evidence)


def _link_standing(model: Model, link: str, field: Field) -> Standing:
    # The link that is most off, compared with whatever else could stand in for it: on a lone sliding axis, a payload or
    # a rotor.
    if link not in model.gap.robot.joints:
        return Standing((), MOST_CONFIDENT)
    scaled = Chosen(LinkScale(), Site(model.gap.robot.joints.index(link)))
    alone = build_model(model.gap, model.nuisance.without_links(), (*model.chosen, scaled))
    stands = standing(alone, scaled, field)
    weighed = any(isinstance(choice.cause, Payload) for choice in model.chosen) or not Payload().sites(model.gap)
    if weighed or not of_last_link(model.gap, scaled.site.joint) or Payload.name in stands.alternatives:
        return stands
    # A payload is a part of the last link, and the other links, which are off too, hide which of the two it is.
    return Standing((*stands.alternatives, Payload.name), min(stands.confidence, EVEN), stands.rival)
