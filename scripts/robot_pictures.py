"""Draw every bundled robot: docs/images/robots.png.

Run headless: MUJOCO_GL=egl python -m scripts.robot_pictures
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import mujoco
import numpy as np

from mjfriction.laws.law import Floats
from mjfriction.robot.files import read_robot
from mjfriction.robot.robot import bundled_robots
from mjfriction.robot.simulation import robot_spec
from mjfriction.sim.scene import spec_with_shapes

mpl.use("Agg")
import matplotlib.pyplot as plt

PICTURE = Path(__file__).resolve().parent.parent / "docs/images/robots.png"
POSES = {
    "comau_ns12": [0.3, 0.2, 0.1, 0.0, 0.6, 0.0],
    "comau_nj60": [0.3, 0.3, 0.0, 0.0, 0.5, 0.0],
    "ur5": [0.3, -1.2, 1.4, -0.6, 1.2, 0.0],
    "ur10": [0.3, -1.2, 1.4, -0.6, 1.2, 0.0],
    "z1": [0.3, 1.2, -1.2, 0.2, 0.3, 0.0],
}


def render(name: str, height: int = 420, width: int = 420) -> Floats:
    """Return a picture of a robot, (height, width, 3)."""
    robot = read_robot(name)
    spec = spec_with_shapes(robot_spec(robot), robot.model_path)
    spec.worldbody.add_light(pos=[1.5, -2.0, 4.0], dir=[-0.3, 0.45, -0.85], diffuse=[0.45, 0.45, 0.45])
    spec.add_texture(
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=[1.0, 1.0, 1.0],
        rgb2=[1.0, 1.0, 1.0],
        width=8,
        height=48,
    )
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5.0, 5.0, 0.1], rgba=[0.94, 0.94, 0.95, 1.0], group=1
    )
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    model = spec.compile()
    data = mujoco.MjData(model)
    for joint, place in zip(robot.joints, POSES.get(name, [0.0] * len(robot.joints)), strict=True):
        data.qpos[model.jnt_qposadr[model.joint(joint).id]] = place
    mujoco.mj_forward(model, data)
    seen = [i for i in range(model.ngeom) if model.geom_type[i] != mujoco.mjtGeom.mjGEOM_PLANE]
    low = np.min([data.geom_xpos[i] - model.geom_rbound[i] for i in seen], axis=0)
    high = np.max([data.geom_xpos[i] + model.geom_rbound[i] for i in seen], axis=0)
    camera = mujoco.MjvCamera()
    camera.lookat, camera.azimuth, camera.elevation = 0.5 * (low + high), 125.0, -18.0
    camera.distance = 1.25 * float(np.linalg.norm(high - low))
    option = mujoco.MjvOption()
    option.geomgroup[:] = 1
    with mujoco.Renderer(model, height, width) as renderer:
        renderer.update_scene(data, camera, option)
        return np.asarray(renderer.render())


def main() -> None:
    names = list(bundled_robots())
    figure, axes = plt.subplots(3, 3, figsize=(9.0, 9.4), layout="constrained")
    for axis, name in zip(axes.flat, names, strict=False):
        axis.imshow(render(name))
        axis.set_title(name, fontsize=11)
    for axis in axes.flat:
        axis.axis("off")
    figure.savefig(PICTURE, dpi=90)


if __name__ == "__main__":
    main()
