"""What cannot carry friction is refused by name, and the process lives."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import mujoco
import mujoco.rollout
import numpy as np
import pytest

from mjfriction.errors import SimulationError
from mjfriction.laws.friction import friction
from mjfriction.sim import layout
from mjfriction.sim.attach import attach, rewrite
from mjfriction.sim.callback import compiled_callback, friction_active, install, remove
from mjfriction.sim.reading import ensure_sound, read_friction, torques
from tests.sim.models import ROTOR, TWO_ARMS, arm_laws, lugre, spec


def test_joints_that_cannot_carry_a_law() -> None:
    for laws, message in (
        ({"rotr": lugre()}, "joint 'rotr' is not in the model"),
        ({"free": lugre()}, "joint 'free' is a free joint"),
        ({"hang": lugre()}, "joint 'hang' is a ball joint"),
        ({}, "no joint was given"),
    ):
        with pytest.raises(SimulationError, match=message):
            attach(spec(TWO_ARMS), laws)
    with pytest.raises(SimulationError, match="did you mean 'rotor'"):
        attach(spec(ROTOR), {"rotr": lugre()})


def test_what_is_no_spec_or_no_law_is_refused() -> None:
    model = spec(ROTOR).compile()
    for made in (model, "rotor.xml"):
        with pytest.raises(SimulationError, match=r"attached to an MjSpec, not to \w+; read the model's file"):
            attach(made, {"rotor": lugre()})  # type: ignore[arg-type]
    for own in ("lugre", None, {"coulomb": 1.0}, [lugre(), 2.0]):
        with pytest.raises(SimulationError, match=r"joint 'rotor': .* is no friction law; give one"):
            attach(spec(ROTOR), {"rotor": own})  # type: ignore[dict-item]
    with pytest.raises(SimulationError, match="from an MjModel, not from MjData"):
        read_friction(mujoco.MjData(model))  # type: ignore[arg-type]


def test_rk4_and_disabled_actuation_are_refused() -> None:
    made = spec(ROTOR)
    made.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with pytest.raises(SimulationError, match="RK4"):
        attach(made, {"rotor": lugre()})
    made = spec(ROTOR)
    made.option.disableflags = mujoco.mjtDisableBit.mjDSBL_ACTUATION
    with pytest.raises(SimulationError, match="actuation is disabled"):
        attach(made, {"rotor": lugre()})


def test_rk4_set_later_adds_no_friction_and_is_said() -> None:
    model = attach(spec(ROTOR), {"rotor": lugre()})
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    data.ctrl[0] = 3.0
    with friction_active():
        for _ in range(5):
            mujoco.mj_step(model, data)
    with pytest.raises(SimulationError, match="RK4"):
        ensure_sound(model, data)


def test_steps_without_friction_are_said() -> None:
    model = attach(spec(ROTOR), {"rotor": lugre()})
    data = mujoco.MjData(model)
    ensure_sound(model, data)
    with friction_active():
        for _ in range(3):
            mujoco.mj_step(model, data)
            ensure_sound(model, data)
        mujoco.mj_forward(model, data)
    ensure_sound(model, data)
    for _ in range(3):
        mujoco.mj_step(model, data)
    with pytest.raises(SimulationError, match="made without friction; step inside"):
        ensure_sound(model, data)
    with friction_active():
        mujoco.mj_step(model, data)
    ensure_sound(model, data)
    model.opt.disableflags = mujoco.mjtDisableBit.mjDSBL_ACTUATION
    with pytest.raises(SimulationError, match="actuation is disabled"):
        ensure_sound(model, data)
    mujoco.mj_resetData(model, data)
    model.opt.disableflags = 0
    ensure_sound(model, data)


def test_a_model_without_room_is_refused() -> None:
    plain = spec(ROTOR).compile()
    with pytest.raises(SimulationError, match="compiled without room"):
        rewrite(plain, {"rotor": lugre()})
    with pytest.raises(SimulationError, match="compiled without room"):
        read_friction(plain)
    model = attach(spec(ROTOR), {"rotor": lugre()})
    with pytest.raises(SimulationError, match="room for"):
        rewrite(
            model, {"rotor": friction("maxwell_slip", {"viscous": 0.0, "stiffness": [1e3] * 3, "level": [1.0] * 3})}
        )
    other = spec(ROTOR)
    attach(other, {"rotor": lugre()})
    assert other.nuserdata in (-1, 0)  # the user's spec is as it was
    assert not list(other.numerics)


def test_the_spec_may_have_user_data_of_its_own() -> None:
    made = spec(ROTOR)
    made.nuserdata = 5
    model = attach(made, {"rotor": lugre()})
    data = mujoco.MjData(model)
    data.userdata[:5] = range(5)
    data.ctrl[0] = 3.0
    with friction_active():
        for _ in range(20):
            mujoco.mj_step(model, data)
    assert data.userdata[:5].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert torques(model, data)["rotor"] == pytest.approx(3.0, rel=0.2)


def test_attaching_twice_is_refused() -> None:
    made = spec(ROTOR)
    made.add_numeric(name="mjfriction", data=[1.0], size=1)
    with pytest.raises(SimulationError, match="already carries friction"):
        attach(made, {"rotor": lugre()})


def test_a_python_callback_is_refused_and_left_in_place() -> None:
    def mine(model, data) -> None:
        pass

    mujoco.set_mjcb_control(mine)
    try:
        with pytest.raises(SimulationError, match="Python control callback"), friction_active():
            pass
        assert mujoco.get_mjcb_control() is mine
    finally:
        mujoco.set_mjcb_control(None)


def test_a_native_callback_is_called_first_and_is_back_afterwards() -> None:
    calls = []

    @ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
    def native(model: int, data: int) -> None:
        calls.append(data)

    model = attach(spec(ROTOR), {"rotor": lugre()})
    data = mujoco.MjData(model)
    data.ctrl[0] = 3.0
    mujoco.set_mjcb_control(native)
    try:
        with friction_active():
            with friction_active():
                mujoco.mj_step(model, data)
            mujoco.mj_step(model, data)
        assert mujoco.get_mjcb_control() is native
        assert calls == [data._address] * 2
        assert data.qvel[0] < 0.1  # without friction it would be 0.6
    finally:
        mujoco.set_mjcb_control(None)


def test_another_callback_on_top_is_named() -> None:
    install()
    mujoco.set_mjcb_control(lambda model, data: None)
    with pytest.raises(SimulationError, match="another control callback"):
        remove()
    mujoco.set_mjcb_control(compiled_callback())
    remove()
    assert mujoco.get_mjcb_control() is None
    with pytest.raises(SimulationError, match="nothing to remove"):
        remove()


def test_a_callback_installed_for_good_outlives_a_with_block() -> None:
    assert install()
    try:
        with friction_active():
            assert not install()
        assert mujoco.get_mjcb_control() is compiled_callback()
    finally:
        remove()


def turned(steps: int) -> Iterator[float]:
    """The velocities of a rotor that is driven within a block of its own."""
    model = attach(spec(ROTOR), {"rotor": lugre()})
    data = mujoco.MjData(model)
    data.ctrl[0] = 3.0
    with friction_active():
        for _ in range(steps):
            mujoco.mj_step(model, data)
            yield float(data.qvel[0])


def test_blocks_that_overlap_keep_the_friction_until_the_last_of_them_ends() -> None:
    alone = list(turned(20))
    short, long = turned(3), turned(20)
    beside = [next(long) for _ in zip(range(2), short, strict=False)]
    assert list(short)[-1:] == alone[2:3]
    assert beside + list(long) == alone
    assert mujoco.get_mjcb_control() is None


def test_blocks_of_several_threads_do_not_end_each_other() -> None:
    lengths = [1, 4000] * 4
    alone = [list(turned(steps)) for steps in lengths]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda steps: list(turned(steps)), lengths)) == alone
    assert mujoco.get_mjcb_control() is None


def test_a_callback_installed_for_good_within_a_block_outlives_it() -> None:
    with friction_active():
        assert not install()
    try:
        assert mujoco.get_mjcb_control() is compiled_callback()
    finally:
        remove()
    assert mujoco.get_mjcb_control() is None


def test_a_callback_that_was_removed_and_put_back_within_a_block_ends_with_it() -> None:
    with friction_active():
        remove()
        assert mujoco.get_mjcb_control() is None
        assert install()
    assert mujoco.get_mjcb_control() is None


def test_a_nan_is_an_error_naming_the_joint() -> None:
    model = attach(spec(TWO_ARMS), arm_laws())
    data = mujoco.MjData(model)
    with friction_active():
        mujoco.mj_step(model, data)
        ensure_sound(model, data)
        data.qfrc_applied[model.joint("b1").dofadr[0]] = np.nan
        mujoco.mj_step(model, data)
    with pytest.raises(
        SimulationError, match="joint 'b1'(: its friction| or one that moves with it: its acceleration)"
    ):
        ensure_sound(model, data)
    data = mujoco.MjData(model)
    with friction_active():
        data.qvel[model.joint("a3").dofadr[0]] = np.inf
        mujoco.mj_step(model, data)
    with pytest.raises(SimulationError, match="joint 'a3' or one that moves with it: its velocity was NaN"):
        ensure_sound(model, data)


def test_a_nan_among_the_controls_is_an_error_naming_the_actuator() -> None:
    model = attach(spec(ROTOR), {"rotor": lugre()})
    data = mujoco.MjData(model)
    data.ctrl[0] = np.nan
    with friction_active():
        mujoco.mj_step(model, data)
    with pytest.raises(SimulationError, match="actuator 'motor': its control was NaN or infinite"):
        ensure_sound(model, data)


def test_a_layout_that_is_not_understood_is_refused(monkeypatch) -> None:
    structs = [b"\x00" * 64] * 2
    with pytest.raises(SimulationError, match="field qpos is not where the bindings say"):
        layout._place(structs, [b"\x01" * 8] * 2, "qpos")
    assert len(layout._memory(0, 4096)) == 0  # memory that is not ours is an empty answer


def test_a_joint_without_friction_has_no_state() -> None:
    reader = read_friction(attach(spec(TWO_ARMS), arm_laws()))
    assert reader.joints == ("wrist", "a1", "a2", "a4", "b1")
    assert reader.state("a4").stop - reader.state("a4").start == 6
    with pytest.raises(SimulationError, match="joint 'a3' carries no friction"):
        reader.state("a3")


def test_a_saved_model_carries_its_friction_into_another_process(tmp_path) -> None:
    model = attach(spec(ROTOR), {"rotor": lugre()})
    mujoco.mj_saveModel(model, str(tmp_path / "rotor.mjb"), None)
    code = (
        "import mujoco, mjfriction as mjf;"
        f"m = mujoco.MjModel.from_binary_path({str(tmp_path / 'rotor.mjb')!r}); d = mujoco.MjData(m); d.ctrl[0] = 3.0\n"
        "with mjf.friction_active():\n    mujoco.mj_step(m, d, nstep=50)\n"
        "print(repr(float(d.qpos[0])))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    data = mujoco.MjData(model)
    data.ctrl[0] = 3.0
    with friction_active():
        mujoco.mj_step(model, data, nstep=50)
    assert float(out.stdout) == data.qpos[0]


def test_a_block_without_its_user_data_is_not_acted_on() -> None:
    made = spec(ROTOR)
    block = attach(spec(ROTOR), {"rotor": lugre()}).numeric_data
    made.add_numeric(name="from_elsewhere", data=block, size=block.size)
    model = made.compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 1.0
    with friction_active():
        mujoco.mj_step(model, data)
    assert data.qvel[0] == pytest.approx(0.1)  # as without friction, and a warning
    assert data.warning[mujoco.mjtWarning.mjWARN_BADCTRL].number == 1


def test_laws_for_other_joints_do_not_fit() -> None:
    model = attach(spec(TWO_ARMS), {"a1": lugre()})
    with pytest.raises(SimulationError, match="or stand on others"):
        rewrite(model, {"a2": lugre()})
    with pytest.raises(SimulationError, match="list of friction laws is empty"):
        attach(spec(TWO_ARMS), {"a1": []})


def test_a_rollout_begins_with_relaxed_bristles() -> None:
    model = attach(spec(ROTOR), {"rotor": lugre()})
    data = mujoco.MjData(model)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    initial = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, initial, kind)
    with friction_active():
        states, _ = mujoco.rollout.rollout(model, data, np.tile(initial, (3, 1)), np.full((3, 50, 1), 5.0))
    assert states[0].tolist() == states[1].tolist() == states[2].tolist()


def test_a_rollout_may_begin_with_the_bristles_of_its_data() -> None:
    model, pull, half = attach(spec(ROTOR), {"rotor": lugre()}), np.full((1, 20, 1), 5.0), 10
    whole, kind = mujoco.mjtState.mjSTATE_INTEGRATION, mujoco.mjtState.mjSTATE_FULLPHYSICS

    def after(data: mujoco.MjData, steps: int) -> np.ndarray:
        initial = np.empty(mujoco.mj_stateSize(model, kind))
        mujoco.mj_getState(model, data, initial, kind)
        with friction_active():
            return mujoco.rollout.rollout(model, data, initial, pull[:, :steps])[0][0, -1]

    at_once, first = mujoco.MjData(model), mujoco.MjData(model)
    reached, between = after(at_once, 2 * half), after(first, half)
    state = np.empty(mujoco.mj_stateSize(model, whole))
    mujoco.mj_getState(model, first, state, whole)
    bent, relaxed = mujoco.MjData(model), mujoco.MjData(model)
    mujoco.mj_setState(model, bent, state, whole)
    mujoco.mj_setState(model, relaxed, between, kind)
    assert after(bent, half).tolist() == reached.tolist()
    assert not np.allclose(after(relaxed, half), reached, rtol=1e-6)
