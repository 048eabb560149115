"""The recording of a simulated run: the machine in motion, its drives, its friction and the friction's states."""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from mjfriction.plant.machine import Run
from mjfriction.report.entity import place_of
from mjfriction.report.rerun_view import CLOCK, NAMESPACE, send, thinned_to_see
from mjfriction.report.scene_view import scene_along, scene_view, send_scene
from mjfriction.robot.robot import Robot
from mjfriction.sim.scene import Scene


def write_run(robot: Robot, run: Run, path: Path) -> None:
    """Write a recording of a run that was kept whole: the robot in 3D and, per joint, torque, friction and states."""
    course = hashlib.sha256(run.played.torque.tobytes()).hexdigest()
    identity = uuid.uuid5(NAMESPACE, f"run of {robot.name} {course}")
    stream = rr.RecordingStream("mjfriction", recording_id=identity, send_properties=False)
    when, scene = scene_along(robot, run.time, run.played.link_position)
    stream.save(path, default_blueprint=_blueprint(robot.joints, run, scene))
    send_scene(stream, when, scene, CLOCK)
    thin = thinned_to_see(run.time)
    for i, name in enumerate(robot.joints):
        place = place_of(name)
        send(stream, f"{place}/drive", run.time[thin], run.played.torque[thin, i])
        send(stream, f"{place}/friction", run.time[thin], run.played.friction[thin, i])
        send(stream, f"{place}/compensation", run.time[thin], run.estimates[thin, i])
        send(stream, f"{place}/position", run.time[thin], run.played.position[thin, i])
        send(stream, f"{place}/velocity", run.time[thin], run.played.velocity[thin, i])
        for k, course in enumerate(run.played.states.get(name, np.empty((0, 0)))[thin].T):
            send(stream, f"{place}/state/{k + 1}", run.time[thin], course)
    for name, cylinder in run.cylinders.items():
        place = place_of(name)
        send(stream, f"{place}/pressure/head", run.time[thin], cylinder.p1[thin])
        send(stream, f"{place}/pressure/rod", run.time[thin], cylinder.p2[thin])
        send(stream, f"{place}/voltage", run.time[thin], cylinder.volts[thin])
    stream.flush()
    stream.disconnect()


def _blueprint(joints: Sequence[str], run: Run, scene: Scene) -> rrb.Blueprint:
    tabs = []
    for name in joints:
        place = place_of(name)
        views = [
            rrb.TimeSeriesView(
                origin=f"/{place}",
                contents=[f"/{place}/drive", f"/{place}/friction", f"/{place}/compensation"],
                name="drive, friction and its compensation",
            ),
            rrb.TimeSeriesView(origin=f"/{place}", contents=[f"/{place}/velocity"], name="velocity"),
        ]
        if run.played.states.get(name, np.empty((0, 0))).size:
            views.append(rrb.TimeSeriesView(origin=f"/{place}/state", name="states of friction"))
        if name in run.cylinders:
            views.append(rrb.TimeSeriesView(origin=f"/{place}/pressure", name="pressures"))
        tabs.append(rrb.Vertical(*views, name=name))
    return rrb.Blueprint(rrb.Horizontal(scene_view(scene), rrb.Tabs(*tabs), column_shares=[1, 1]), collapse_panels=True)
