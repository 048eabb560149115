"""Whether links are farther off than stated inertias usually are, when all ten parameters of each may be."""

from __future__ import annotations

import numpy as np

from mjfriction.body.inertia import PER_LINK, symmetric
from mjfriction.diagnose.causes.links import LEAST_MOVED, LEAST_NOTED, LinkCentre, LinkScale
from mjfriction.diagnose.exact import stated_exactly
from mjfriction.diagnose.model import Model, cause_block
from mjfriction.diagnose.nearness import nearness_of
from mjfriction.identify.link_inertias import link_inertias
from mjfriction.identify.regression import Columns, System
from mjfriction.record.log import Floats

USUALLY, EXACTLY = 0.03, 0.01  # by which a link is off in each of its ten numbers, where the rest is or is not too
FAR = 4.0  # times that, over all of a link's ten numbers, from which on it is off by more: three are what is usual


def links_far_off(model: Model) -> bool:
    """Return whether any link has to be off by more than usual, its mass or its centre by as much as is ever a finding,
    or in proportion where other links are nearer to what is stated, unless these or all else are stated exactly.

    Mass, centre and moments of every link are let go at once, held near what is stated, in the place of what the model
    says of links: errors of a few percent everywhere add up to what a single link would have to be a quarter off for.
    """
    gap, rows = model.gap, model.system.rows
    held = not model.nuisance.links  # beside what is named, they do as well as they are stated
    usually = EXACTLY if held or stated_exactly(model) else max(EXACTLY, USUALLY * min(1.0, nearness_of(model).spread))
    links = link_inertias(gap, usually)
    if links is None:
        return False
    others = [choice for choice in model.chosen if not isinstance(choice.cause, LinkScale | LinkCentre)]
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
    # Let go at once, all bear a part of it, the more the nearer they are held.
    part = usually / USUALLY
    shift = np.linalg.norm(first / mass[:, None] - stated[:, :3, 3] / stated[:, 3, 3, None], axis=1)
    heavier, moved = np.abs(mass / stated[:, 3, 3] - 1.0) > part * LEAST_NOTED, shift > part * LEAST_MOVED
    far = np.linalg.norm(changes, axis=(1, 2)) > FAR * usually
    return bool(np.any(far & (heavier | moved | (usually == EXACTLY))))
