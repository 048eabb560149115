"""Write the page of the bundled robots, docs/robots.md, and draw them: docs/images/robots.png.

Run headless: MUJOCO_GL=egl python -m scripts.robot_pages
"""

from __future__ import annotations

import itertools
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

ROOT = Path(__file__).resolve().parent.parent
PAGE, PICTURE = ROOT / "docs/robots.md", ROOT / "docs/images/robots.png"
PAGE_TEXT = """# The robots that come along

Written by `python -m scripts.robot_pages`. Every command takes them by name, as in `--robot machine_table`.

![the robots](images/robots.png)

| robot | joints | moving mass | friction stated |
|---|---|---:|---|
{table}

`mjfriction plan --robot R --protocol P --out T` writes motions for any of them: `forward_backward`, `excitation`,
`sine`, `sawtooth`, `loops` (two inner hysteresis loops a period), `pick_and_place`, and for the cylinder `voltages`.
`mjfriction simulate --robot R --trajectory T --out LOG --recording R.rrd` runs them and shows them.

{sections}"""
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


def row(name: str) -> str:
    """Return a robot's line of the table."""
    robot = read_robot(name)
    body = robot.body()
    laws = sorted({term.law for joint in robot.with_stated_friction(body).table.joint for term in joint.friction or ()})
    kinds = {True: "sliding", False: "turning"}
    joints = f"{len(robot.joints)} {kinds[body.sliding[0]]}"
    mass = float(robot_spec(robot).compile().body_mass.sum())
    return f"| `{name}` | {joints} | {mass:.4g} kg | {', '.join(f'`{law}`' for law in laws)} |"


def section(name: str, path: Path) -> str:
    """Return the section of a robot: the comment at the head of its file, which explains its numbers."""
    lines = itertools.takewhile(lambda line: line.startswith("#"), path.read_text(encoding="utf-8").splitlines())
    return f"## {name}\n\n" + "\n".join(line.removeprefix("#").strip() for line in lines) + "\n"


def main() -> None:
    names = list(bundled_robots())
    page = PAGE_TEXT.format(
        table="\n".join(row(name) for name in names),
        sections="\n".join(section(name, path) for name, path in bundled_robots().items()),
    )
    PAGE.write_text(page, encoding="utf-8")
    figure, axes = plt.subplots(3, 3, figsize=(9.0, 9.4), layout="constrained")
    for axis, name in zip(axes.flat, names, strict=False):
        axis.imshow(render(name))
        axis.set_title(name, fontsize=11)
    for axis in axes.flat:
        axis.axis("off")
    figure.savefig(PICTURE, dpi=90)


if __name__ == "__main__":
    main()
