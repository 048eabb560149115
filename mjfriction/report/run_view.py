"""The recording of a simulated run: the machine in motion, its drives, its friction and what its bristles do."""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from mjfriction.plant.machine import Run
from mjfriction.report.rerun_view import CLOCK, NAMESPACE, send, thinned_to_see
from mjfriction.report.scene_view import scene_along, scene_view, send_scene
from mjfriction.robot.robot import Robot
from mjfriction.sim.scene import Scene


def write_run(robot: Robot, run: Run, path: Path) -> None:
    """Write a recording of a run that was kept whole: the robot in 3D and, a tab a joint, torque, friction, states."""
    course = hashlib.sha256(run.played.torque.tobytes()).hexdigest()
    identity = uuid.uuid5(NAMESPACE, f"run of {robot.name} {course}")
    stream = rr.RecordingStream("mjfriction", recording_id=identity, send_properties=False)
    when, scene = scene_along(robot, run.time, run.played.link_position)
    stream.save(path, default_blueprint=_blueprint(robot.joints, run, scene))
    send_scene(stream, when, scene, CLOCK)
    thin = thinned_to_see(run.time)
    for i, name in enumerate(robot.joints):
        send(stream, f"{name}/drive", run.time[thin], run.played.torque[thin, i])
        send(stream, f"{name}/friction", run.time[thin], run.played.friction[thin, i])
        send(stream, f"{name}/compensation", run.time[thin], run.estimates[thin, i])
        send(stream, f"{name}/position", run.time[thin], run.played.position[thin, i])
        send(stream, f"{name}/velocity", run.time[thin], run.played.velocity[thin, i])
        for k, course in enumerate(run.played.states.get(name, np.empty((0, 0)))[thin].T):
            send(stream, f"{name}/state/{k + 1}", run.time[thin], course)
    for name, cylinder in run.cylinders.items():
        send(stream, f"{name}/pressure/head", run.time[thin], cylinder.p1[thin])
        send(stream, f"{name}/pressure/rod", run.time[thin], cylinder.p2[thin])
        send(stream, f"{name}/voltage", run.time[thin], cylinder.volts[thin])
    stream.flush()
    stream.disconnect()


def _blueprint(joints: Sequence[str], run: Run, scene: Scene) -> rrb.Blueprint:
    tabs = []
    for name in joints:
        views = [
            rrb.TimeSeriesView(
                origin=f"/{name}",
                contents=[f"/{name}/drive", f"/{name}/friction", f"/{name}/compensation"],
                name="drive, friction and its compensation",
            ),
            rrb.TimeSeriesView(origin=f"/{name}", contents=[f"/{name}/velocity"], name="velocity"),
        ]
        if run.played.states.get(name, np.empty((0, 0))).size:
            views.append(rrb.TimeSeriesView(origin=f"/{name}/state", name="states of friction"))
        if name in run.cylinders:
            views.append(rrb.TimeSeriesView(origin=f"/{name}/pressure", name="pressures"))
        tabs.append(rrb.Vertical(*views, name=name))
    return rrb.Blueprint(rrb.Horizontal(scene_view(scene), rrb.Tabs(*tabs), column_shares=[1, 1]), collapse_panels=True)
