"""Test whether links are farther off than stated inertias usually are, with all ten parameters of each refitted."""

from __future__ import annotations

import numpy as np

from mjfriction.body.inertia import PER_LINK, symmetric
from mjfriction.diagnose.causes.links import (
    LEAST_MOMENTS,
    LEAST_MOVED,
    LEAST_NOTED,
    LinkCentre,
    LinkMoments,
    LinkScale,
)
from mjfriction.diagnose.fit.exact import stated_exactly
from mjfriction.diagnose.fit.model import Model, cause_block
from mjfriction.diagnose.fit.nearness import nearness_of
from mjfriction.identify.link_inertias import link_inertias
from mjfriction.identify.regression import Columns, System
from mjfriction.record.log import Floats

# Prior spread of each of a link's ten relative numbers, where the rest is off too, and where it is exact.
USUALLY, EXACTLY = 0.03, 0.01
FAR = 4.0  # times that spread, as the norm over a link's ten numbers: more is farther off than usual (three is usual)


def links_far_off(model: Model) -> bool:
    """Return whether any link has to be off by more than usual.

    Its mass, its centre of mass or its moments about that must also be off by as much as is ever a finding. That
    threshold is lower in proportion where links are nearer to what is stated, and it is dropped where links are held as
    stated or all else is stated exactly.

    All ten parameters of every link are refitted at once, with a prior around what is stated, in the place of what the
    model says of links: errors of a few percent everywhere add up to what a single link would have to be a quarter off
    for.
    """
    gap, rows = model.gap, model.system.rows
    held = not model.nuisance.links  # beside the named causes, links as stated do as well
    usually = EXACTLY if held or stated_exactly(model) else max(EXACTLY, USUALLY * min(1.0, nearness_of(model).spread))
    links = link_inertias(gap, usually)
    if links is None:
        return False
    others = [choice for choice in model.chosen if not isinstance(choice.cause, LinkScale | LinkCentre | LinkMoments)]
    nuisance = model.nuisance.without_links()
    blocks: list[tuple[Columns, Floats]] = [(nuisance.columns, nuisance.precision)] if nuisance.count else []
    blocks += [cause_block(gap, choice) for choice in others]
    columns, precisions = zip((links.columns, links.precision), *blocks, strict=True)
    system = System(rows, list(columns), list(precisions))
    strengths = system.normal.fitted[: links.precision.size]
    changes = np.array([symmetric(own) for own in strengths.reshape(-1, PER_LINK)])
    turned = np.swapaxes(links.factor, 1, 2)
    stated, fitted = (links.factor @ own @ turned for own in (links.stated, links.stated + changes))
    mass, first = fitted[:, 3, 3], fitted[:, :3, 3]
    # With all links refitted at once, each takes a part of the error, the more the tighter the prior.
    part = usually / USUALLY
    shift = np.linalg.norm(first / mass[:, None] - stated[:, :3, 3] / stated[:, 3, 3, None], axis=1)
    heavier, moved = np.abs(mass / stated[:, 3, 3] - 1.0) > part * LEAST_NOTED, shift > part * LEAST_MOVED
    sizes = [
        np.trace(own[:, :3, :3], axis1=1, axis2=2) - np.sum(np.square(own[:, :3, 3]), axis=1) / own[:, 3, 3]
        for own in (stated, fitted)
    ]
    spread = np.abs(sizes[1] / sizes[0] - 1.0) > part * LEAST_MOMENTS
    far = np.linalg.norm(changes, axis=(1, 2)) > FAR * usually
    return bool(np.any(far & (heavier | moved | spread | (usually == EXACTLY))))
