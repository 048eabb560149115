"""Small models for the tests: free and ball joints before the hinges, two arms, contacts, tendons, equalities."""

from __future__ import annotations

import mujoco
import numpy as np

from mjfriction.laws.friction import Friction, friction

LUGRE = {
    "coulomb": 6.0,
    "static": 8.0,
    "stribeck_velocity": 0.1,
    "stribeck_exponent": 2.0,
    "bristle_stiffness": 2e4,
    "bristle_damping": 60.0,
    "viscous": 1.0,
}

ROTOR = """
<mujoco>
  <option timestep="0.001" gravity="0 0 0"/>
  <worldbody><body><joint name="rotor" axis="0 0 1" armature="0.01"/><geom size=".01" mass="1e-9"/></body></worldbody>
  <actuator><motor name="motor" joint="rotor"/></actuator>
</mujoco>
"""

PENDULUM = """
<mujoco>
  <option timestep="0.001"/>
  <worldbody><body pos="0 0 1"><joint name="swing" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0 0 -.5" size=".02"/></body></worldbody>
</mujoco>
"""

TWO_ARMS = """
<mujoco>
  <option timestep="0.001"/>
  <default><geom type="capsule" size=".03" density="800" contype="0" conaffinity="0"/></default>
  <worldbody>
    <body name="ball" pos="0 0 2"><freejoint name="free"/><geom type="sphere" size=".1"/></body>
    <body pos="0 0 1"><joint name="hang" type="ball"/><geom fromto="0 0 0 0 0 -.3"/>
      <body pos="0 0 -.3"><joint name="wrist" axis="0 1 0"/><geom fromto="0 0 0 .2 0 0"/></body></body>
    <body pos="1 0 1"><joint name="a1" axis="0 0 1"/><geom fromto="0 0 0 .4 0 0"/>
      <body pos=".4 0 0"><joint name="a2" axis="0 1 0"/><geom fromto="0 0 0 .3 0 0"/>
        <body pos=".3 0 0"><joint name="a3" axis="0 1 0"/><geom fromto="0 0 0 .2 0 0"/>
          <body pos=".2 0 0"><joint name="a4" type="slide" axis="1 0 0"/><geom fromto="0 0 0 .1 0 0"/></body>
    </body></body></body>
    <body pos="2 0 1"><joint name="b1" axis="0 1 0"/><geom fromto="0 0 0 .4 0 0"/>
      <body pos=".4 0 0"><joint name="b2" axis="0 1 0"/><geom fromto="0 0 0 .3 0 0"/></body></body>
  </worldbody>
  <tendon><fixed name="tie"><joint joint="a2" coef="1"/><joint joint="a3" coef="-.5"/></fixed></tendon>
  <actuator>
    <motor joint="a1" gear="5"/><motor joint="a2" gear="5"/><position joint="a3" kp="20" kv="2"/>
    <motor joint="b1"/><motor tendon="tie"/>
  </actuator>
</mujoco>
"""


def spec(text: str) -> mujoco.MjSpec:
    return mujoco.MjSpec.from_string(text)


def lugre(**changed: float) -> Friction:
    return friction("lugre", {**LUGRE, **changed})


def arm_laws() -> dict[str, Friction | list[Friction]]:
    return {
        "wrist": lugre(coulomb=0.3, static=0.4, bristle_stiffness=1e3, bristle_damping=3.0, viscous=0.02),
        "a1": lugre(),
        "a2": [
            friction("load_dependent", {"coulomb": 1.0, "load": 0.1, "viscous": 0.5}),
            lugre(coulomb=1.0, static=1.2),
        ],
        "a4": friction("gms", {
            "coulomb": 2.0, "static": 3.0, "stribeck_velocity": 0.05, "stribeck_exponent": 2.0, "attraction": 200.0,
            "viscous": 2.0, "stiffness": [2e4, 1e4, 5e3], "share": [0.2, 0.3, 0.5],
        }),
        "b1": friction("stribeck", {
            "coulomb": 0.5, "static": 0.8, "stribeck_velocity": 0.05, "stribeck_exponent": 2.0, "viscous": 0.1,
        }),
    }  # fmt: skip


def controls(model: mujoco.MjModel, steps: int) -> np.ndarray:
    t = np.arange(steps)[:, None] * 1e-3
    return np.sin(3.0 * t + np.arange(model.nu)) * np.linspace(1.0, 2.0, model.nu)
