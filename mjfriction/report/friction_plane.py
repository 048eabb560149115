"""Friction against velocity in a Rerun recording: point clouds of a whole log, and the point at each instant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from mjfriction.record.log import Floats
from mjfriction.report.entity import place_of

MOST_POINTS = 4000
TALL = 0.6  # height over width; Rerun scales both axes equally, so that both quantities are divided by their maxima


def send_plane(
    stream: rr.RecordingStream,
    entity: str,
    clock: str,
    time: Floats,
    velocity: Floats,
    friction: Mapping[str, Floats],
    colours: Sequence[tuple[int, int, int]],
    units: tuple[str, str],
) -> None:
    """Write a plot of friction over velocity to a recording.

    ``velocity`` (rows,) and each named series of ``friction`` (rows,) become a point cloud and, at each ``time``
    (rows,), one large point, in the series' colour.  ``units`` are those of velocity and friction.
    """
    top = float(np.max(np.abs(velocity), initial=1e-12))
    most = max(float(np.max(np.abs(course), initial=1e-12)) for course in friction.values())
    _axes(stream, entity, f"{top:.3g} {units[0]}", f"{most:.3g} {units[1]}")
    kept = slice(None, None, max(1, -(-velocity.size // MOST_POINTS)))
    for (name, course), colour in zip(friction.items(), colours, strict=True):
        # In Rerun's 2D views, y points down.
        place = np.column_stack([velocity / top, -TALL * course / most]).astype(np.float32)
        cloud = rr.Points2D(place[kept], radii=0.006, colors=[colour])
        stream.log(f"{entity}/{place_of(name)}", cloud, static=True)
        stream.log(
            f"{entity}/now/{place_of(name)}",
            rr.Points2D.from_fields(radii=0.02, colors=[colour]),
            static=True,
        )
        stream.send_columns(
            f"{entity}/now/{place_of(name)}",
            indexes=[rr.TimeColumn(clock, duration=time)],
            columns=rr.Points2D.columns(positions=place),
        )


def plane_view(entity: str) -> rrb.Spatial2DView:
    """Return the view of such a plot."""
    frame = rrb.VisualBounds2D(x_range=[-1.15, 1.15], y_range=[-1.15 * TALL, 1.15 * TALL])
    return rrb.Spatial2DView(origin=entity, name="friction over velocity", visual_bounds=frame)


def _axes(stream: rr.RecordingStream, entity: str, right: str, up: str) -> None:
    lines = [[(-1.05, 0.0), (1.05, 0.0)], [(0.0, 1.05 * TALL), (0.0, -1.05 * TALL)]]
    stream.log(f"{entity}/axes", rr.LineStrips2D(lines, radii=0.0015, colors=[(138, 141, 145)]), static=True)
    ends = rr.Points2D([(1.0, 0.0), (0.0, -TALL)], labels=[right, up], radii=0.006, colors=[(138, 141, 145)])
    stream.log(f"{entity}/ends", ends, static=True)
