"""The extended robot: the stated one with everything that was found built in."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from mjfriction.diagnose.causes.cause import Cause, Quantity, Site
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.fit.base_changes import base_changes
from mjfriction.diagnose.fit.intervals import half_widths
from mjfriction.diagnose.fit.model import Key, Model
from mjfriction.diagnose.fit.refitted import PER_LINK
from mjfriction.diagnose.fit.sensor_scale import sensor_factors
from mjfriction.identify.gap import Gap
from mjfriction.laws.coulomb_viscous import COULOMB_VISCOUS
from mjfriction.record.log import Floats
from mjfriction.robot.friction import raised_levels, stated_levels
from mjfriction.robot.links import link_scale, link_shift, scaled_link, shifted_link
from mjfriction.robot.robot import Robot

LEAST_SHIFT = 1e-4  # m, shift of a centre of mass below which it is not listed


@dataclass(frozen=True)
class Adjustment:
    """A stated value that the fit moved: at ``joint``, from ``stated`` to ``fitted`` ± ``half_width`` (95 %)."""

    what: str
    joint: str
    unit: str
    stated: float
    fitted: float
    half_width: float


def extend_robot(model: Model, strengths: Floats | None = None) -> Robot:
    """Build a fitted model into the robot: levels, zeros, drives, links, then the causes in the order they were found.

    ``strengths`` are by default those fitted on all blocks, with links that bodies can have
    (:attr:`~mjfriction.diagnose.fit.model.Model.built`).

    The robot file predicts the same as the fit (:func:`~mjfriction.diagnose.fit.sensor_scale.sensor_factors`).
    """
    robot, nuisance = model.gap.robot, model.nuisance
    strengths = model.built if strengths is None else strengths
    strengths = strengths / sensor_factors(model, strengths)
    for level in nuisance.levels:
        coulomb, viscous = strengths[nuisance.of_level(level.site.joint)].tolist()
        robot = raised_levels(robot, robot.joints[level.site.joint], coulomb, viscous)
    for zero, change in zip(nuisance.zeros, strengths[nuisance.of_zeros], strict=True):
        robot = Offset().extend(robot, zero.site, np.array([change]))
    for drive, change in zip(nuisance.drives, strengths[nuisance.of_drives], strict=True):
        robot = drive.cause.extend(robot, drive.site, np.array([drive.stated * change]))
    for link, (scale, *shift) in zip(nuisance.links, nuisance.link_changes(strengths).tolist(), strict=True):
        robot = shifted_link(scaled_link(robot, link.name, 1.0 + scale), link.name, shift)
    if nuisance.inertias is not None:
        robot = nuisance.inertias.applied(robot, strengths[nuisance.of_inertias])
    for choice, place in zip(model.chosen, model.places, strict=True):
        robot = choice.cause.extend(robot, choice.site, strengths[place])
    return robot


def adjustments(model: Model, untold: Collection[Key]) -> list[Adjustment]:
    """List the stated values that the fit moved, including those of causes that are not findings (``untold``)."""
    gap, widths, factors = model.gap, half_widths(model), sensor_factors(model, model.built)
    strengths, half = model.built / factors, widths.nuisance / factors[: model.nuisance.count]
    out = []
    for level in model.nuisance.levels:
        joint = level.site.joint
        place = model.nuisance.of_level(joint)
        changes, spreads = strengths[place], half[place]
        sliding = gap.body.sliding[joint]
        stated = stated_levels(gap.robot.table.joint[joint])
        for k, name in enumerate(("coulomb", "viscous")):
            unit = COULOMB_VISCOUS.parameter(name).unit_for(sliding=sliding)
            fitted = stated[k] + float(changes[k])
            out.append(Adjustment(name, gap.robot.joints[joint], unit, stated[k], fitted, float(spreads[k])))
    changes, spreads = strengths[model.nuisance.of_zeros], half[model.nuisance.of_zeros]
    for zero, change, spread in zip(model.nuisance.zeros, changes, spreads, strict=True):
        if abs(change) > spread:
            (quantity,) = Offset().quantities(gap, zero.site)
            out.append(_moved(gap, Offset(), zero.site, quantity, float(change), float(spread)))
    changes, spreads = strengths[model.nuisance.of_drives], half[model.nuisance.of_drives]
    for drive, change, spread in zip(model.nuisance.drives, changes, spreads, strict=True):
        (quantity,) = drive.cause.quantities(gap, drive.site)
        out.append(_moved(gap, drive.cause, drive.site, quantity, drive.stated * change, drive.stated * spread))
    of_links = half[model.nuisance.of_links].reshape(-1, PER_LINK)
    for link, change, own in zip(model.nuisance.links, model.link_changes, of_links, strict=True):
        out += _moved_link(gap.robot, link.name, change, own)
    for before, now in base_changes(model, widths).off:
        what, name = now.name.split(".", 1)
        out.append(Adjustment(what, name, now.unit, before, now.value, now.high - now.value))
    for choice, place, width in zip(model.chosen, model.places, widths.causes, strict=True):
        if choice.key not in untold:
            continue
        quantities = choice.cause.quantities(gap, choice.site)
        halves = width[: len(quantities)] / factors[place]
        for quantity, value, own in zip(quantities, strengths[place], halves, strict=True):
            out.append(_moved(gap, choice.cause, choice.site, quantity, float(value), float(own)))
    return out


def _moved(gap: Gap, cause: Cause, site: Site, quantity: Quantity, value: float, half: float) -> Adjustment:
    where = "all joints" if cause.whole_arm else gap.robot.joints[site.joint]
    unit = quantity.parameter.unit_for(sliding=gap.body.sliding[site.joint])
    change, spread = quantity.factor * value, abs(quantity.factor) * half
    return Adjustment(quantity.parameter.name, where, unit, quantity.shift, quantity.shift + change, spread)


def _moved_link(robot: Robot, name: str, change: Floats, half: Floats) -> list[Adjustment]:
    # The link's scale, and the shifts of its centre of mass that are larger than their half-width and than anybody
    # measures one.
    scale = link_scale(robot, name)
    fitted = scale * (1.0 + float(change[0]))
    out = [Adjustment("link_scale", name, "1", scale, fitted, scale * float(half[0]))]
    for k, (axis, stated) in enumerate(zip("xyz", link_shift(robot, name), strict=True), start=1):
        if abs(change[k]) > max(half[k], LEAST_SHIFT):
            moved = stated + float(change[k])
            out.append(Adjustment(f"link_shift_{axis}", name, "m", stated, moved, float(half[k])))
    return out
