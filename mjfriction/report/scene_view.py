"""A robot in three dimensions, in a Rerun recording."""

from __future__ import annotations

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from mjfriction.record.log import Floats
from mjfriction.report.entity import place_of
from mjfriction.robot.robot import Robot
from mjfriction.robot.simulation import robot_spec
from mjfriction.sim.scene import Scene, Shape, draw

ROOT = "robot"
FRAMES = 30.0  # pictures per second; more would not be visible


def scene_along(robot: Robot, time: Floats, position: Floats) -> tuple[Floats, Scene]:
    """Return the instants (s) and the scene of a robot drawn along its motion, ``time`` (n,), ``position`` (n, joints).

    Raises :class:`~mjfriction.errors.SimulationError` where MuJoCo cannot read the model.
    """
    when = np.arange(time[0], time[-1] + 0.5 / FRAMES, 1.0 / FRAMES)
    course = np.column_stack([np.interp(when, time, column) for column in position.T])
    return when, draw(robot_spec(robot), robot.model_path, robot.joints, course)


def send_scene(stream: rr.RecordingStream, time: Floats, scene: Scene, clock: str) -> None:
    """Write a scene to a recording: its shapes once, and the pose of every body at each instant of ``time`` (n,)."""
    stream.log(ROOT, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    shown = {shape.body for shape in scene.shapes}
    for i, body in enumerate(scene.bodies):
        if body not in shown:
            continue
        entity = f"{ROOT}/{place_of(body)}"
        for number, shape in enumerate(shape for shape in scene.shapes if shape.body == body):
            stream.log(f"{entity}/{number}", _drawn(shape), static=True)
        stream.send_columns(
            entity,
            indexes=[rr.TimeColumn(clock, duration=time)],
            columns=rr.Transform3D.columns(
                translation=scene.position[:, i],
                quaternion=np.roll(scene.quaternion[:, i], -1, axis=1),  # Rerun's w comes last
            ),
        )


def scene_view(scene: Scene) -> rrb.Spatial3DView:
    """Return the view of a scene, from far enough to see all of it."""
    reach = max((max(shape.size) + float(np.linalg.norm(shape.position)) for shape in scene.shapes), default=0.1)
    low, high = (bound(scene.position, axis=(0, 1)) for bound in (np.min, np.max))
    middle, size = 0.5 * (low + high), float(np.linalg.norm(high - low)) + 2.0 * min(reach, 1.0)
    eye = rrb.EyeControls3D(position=middle + size * np.array([0.55, -0.7, 0.3]), look_target=middle)
    return rrb.Spatial3DView(origin=f"/{ROOT}", name="machine", eye_controls=eye)


def _drawn(shape: Shape) -> rr.AsComponents:
    a, b, c = shape.size
    turned = rr.Quaternion(xyzw=np.roll(shape.quaternion, -1))
    place = [shape.position]
    colour = [tuple(round(255 * value) for value in shape.colour)]
    if shape.kind == "mesh":
        rotation = _rotation(shape.quaternion)
        assert shape.vertices is not None
        vertices = shape.vertices @ rotation.T + np.array(shape.position)
        return rr.Mesh3D(
            vertex_positions=vertices,
            triangle_indices=shape.faces,
            vertex_normals=_normals(vertices, shape.faces),
            albedo_factor=colour[0],
        )
    if shape.kind == "box":
        return rr.Boxes3D(
            half_sizes=[shape.size], centers=place, quaternions=[turned], colors=colour, fill_mode="solid"
        )
    if shape.kind == "cylinder":
        return rr.Cylinders3D(
            radii=[a], lengths=[2.0 * b], centers=place, quaternions=[turned], colors=colour, fill_mode="solid"
        )
    if shape.kind == "capsule":
        # Rerun's capsule starts at its origin and extends along z; MuJoCo's is centred at its origin.
        start = np.array(shape.position) - _rotation(shape.quaternion)[:, 2] * b
        return rr.Capsules3D(
            radii=[a], lengths=[2.0 * b], translations=[start], quaternions=[turned], colors=colour, fill_mode="solid"
        )
    half = (a, a, a) if shape.kind == "sphere" else (a, b, c)
    return rr.Ellipsoids3D(half_sizes=[half], centers=place, quaternions=[turned], colors=colour, fill_mode="solid")


def _rotation(quaternion: tuple[float, float, float, float]) -> Floats:
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _normals(vertices: Floats, faces: np.ndarray | None) -> Floats:
    assert faces is not None
    corner = vertices[faces]
    facing = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    out = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(out, faces[:, k], facing)
    return np.asarray(out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300))
