"""The picture of an identified law: friction against speed."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go

from mjfriction.identify.map_fit import on_side
from mjfriction.identify.outcome import Identification, JointLaw
from mjfriction.laws.ambient import ambient
from mjfriction.report.figures import AFTER, BEFORE, INK, MEASURED, styled, thinned

POINTS = 401


def friction_against_speed(identification: Identification, law: JointLaw) -> go.Figure:
    """Return a figure of a joint's friction against velocity, measured, stated and identified.

    The measured points are what the balance of efforts leaves for friction, on clear rows.  Forward and backward passes
    are added where the log has them.
    """
    gap = identification.gap
    joint = gap.robot.joints.index(law.joint)
    problem = law.fit.problem
    clear = np.flatnonzero(gap.clear[:, joint])
    kept = clear[thinned(clear.size)]
    velocity = gap.at_rows("velocity")[:, joint]
    figure = go.Figure()
    marker = {"size": 3, "color": MEASURED, "opacity": 0.5}
    figure.add_scatter(x=velocity[kept], y=problem.target[kept], mode="markers", marker=marker, name="measured")
    top = float(np.max(np.abs(velocity)))
    side = np.linspace(top / POINTS, top, POINTS // 2) ** 2 / top
    speeds = np.concatenate([-side[::-1], side])
    table, ratio = gap.robot.table.joint[joint], gap.robot.table.joint[joint].actuator.gear_ratio
    load = float(np.sqrt(np.mean(np.square(gap.effort.load[:, joint]))))
    around = ambient(speeds.size, load=np.full(speeds.size, load))
    for name, colour, terms in (("stated", BEFORE, table.friction or ()), ("identified", AFTER, (law.fit.term,))):
        curve = sum((term.friction(ratio).steady(speeds, around) for term in terms), start=np.zeros(speeds.size))
        figure.add_scatter(x=speeds, y=curve, mode="lines", line={"color": colour, "width": 2.5}, name=name)
    if law.passes is not None:
        speed, friction, _ = on_side(law.passes, "joint", ratio)
        for sign, shown in ((1.0, True), (-1.0, False)):
            figure.add_scatter(
                x=sign * speed,
                y=sign * friction,
                error_y={"array": law.passes.spread, "color": INK},
                mode="markers",
                marker={"color": INK, "size": 8, "symbol": "diamond"},
                name="passes forward and backward",
                showlegend=shown,
            )
    sliding = gap.body.sliding[joint]
    figure.update_xaxes(title_text=f"velocity of the joint, {'m/s' if sliding else 'rad/s'}")
    figure.update_yaxes(title_text=f"friction at the joint, {'N' if sliding else 'N·m'}")
    return styled(figure, 380)
