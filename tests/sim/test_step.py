"""What the friction step must hold in MuJoCo: sticking, repeating, batches, integrators, mixed trees."""

from __future__ import annotations

import copy

import mujoco
import mujoco.batch
import mujoco.rollout
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjfriction.laws.ambient import ambient
from mjfriction.laws.catalog import LAWS
from mjfriction.laws.friction import friction
from mjfriction.sim import block as at
from mjfriction.sim.attach import attach, candidate_blocks, rewrite
from mjfriction.sim.callback import friction_active, install, remove
from mjfriction.sim.forces import AFFINE, BIAS_SIZE, EULER, NO_DAMPER, NO_EULER_DAMPING
from mjfriction.sim.reading import ensure_sound, read_friction, torques, write_candidates
from mjfriction.sim.step import BAD_FORCE, RUNGE_KUTTA
from scripts.sim_accuracy import six_axis_case
from tests.contract.draws import named
from tests.sim.models import LUGRE, PENDULUM, ROTOR, TWO_ARMS, arm_laws, controls, lugre, spec

INTEGRATORS = ["mjINT_EULER", "mjINT_IMPLICIT", "mjINT_IMPLICITFAST", "mjINT_DISCRETE"]
FULL = mujoco.mjtState.mjSTATE_INTEGRATION
pytestmark = pytest.mark.usefixtures("active")


@pytest.fixture
def active():
    with friction_active():
        yield


def full_state(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    state = np.empty(mujoco.mj_stateSize(model, FULL))
    mujoco.mj_getState(model, data, state, FULL)
    return state


def arms(integrator: str = "mjINT_EULER") -> mujoco.MjModel:
    made = spec(TWO_ARMS)
    made.option.integrator = getattr(mujoco.mjtIntegrator, integrator)
    return attach(made, arm_laws())


def run(model: mujoco.MjModel, steps: int, data: mujoco.MjData | None = None, start: int = 0) -> mujoco.MjData:
    data = mujoco.MjData(model) if data is None else data
    ctrl = controls(model, start + steps)
    for k in range(start, start + steps):
        data.ctrl[:] = ctrl[k]
        mujoco.mj_step(model, data)
    return data


def test_the_constants_are_mujocos() -> None:
    assert mujoco.mjtIntegrator.mjINT_EULER == EULER
    assert mujoco.mjtWarning.mjWARN_BADCTRL == BAD_FORCE
    assert mujoco.mjtIntegrator.mjINT_RK4 == RUNGE_KUTTA
    assert mujoco.mjtBias.mjBIAS_AFFINE == AFFINE
    assert mujoco.mjtDisableBit.mjDSBL_EULERDAMP == NO_EULER_DAMPING
    assert mujoco.mjtDisableBit.mjDSBL_DAMPER == NO_DAMPER
    assert mujoco.mjNBIAS == BIAS_SIZE


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("name", [law.name for law in LAWS.values() if law.name not in {"lugre_smooth", "arctan"}])
def test_it_sticks_under_half_its_level(name: str, integrator: str) -> None:
    """h²σ₀/J = 400, half the Coulomb level: after two seconds the rotor does not move any more."""
    law = LAWS[name]
    values = named(law, 1)
    if "coulomb" in values and "static" in values:
        values["coulomb"] = 0.8 * values["static"]
    values |= {"level": 5.0} if name == "static_kinetic" else {}
    own = friction(name, values)
    level = float(own.steady(np.array([1e-9]), ambient(1))[0])
    made = spec(ROTOR)
    stiffness = float(values.get("bristle_stiffness", 1e4)) if "stiffness" not in values else sum(values["stiffness"])
    made.joint("rotor").armature = 1e-6 * stiffness / 400.0
    made.option.integrator = getattr(mujoco.mjtIntegrator, integrator)
    model = attach(made, {"rotor": own})
    data = mujoco.MjData(model)
    data.qvel[0] = 0.5
    data.ctrl[0] = 0.5 * level
    for _ in range(2000):
        mujoco.mj_step(model, data)
    assert abs(data.qvel[0]) < 1e-9
    ensure_sound(model, data)


def test_without_friction_it_does_not_stick() -> None:
    model = spec(ROTOR).compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 0.5
    for _ in range(100):
        mujoco.mj_step(model, data)
    assert data.qvel[0] == pytest.approx(5.0)


def test_a_stuck_joint_stays_for_a_minute() -> None:
    model = attach(spec(ROTOR), {"rotor": lugre()})
    data = mujoco.MjData(model)
    data.ctrl[0] = 3.0
    for _ in range(2000):
        mujoco.mj_step(model, data)
    at = data.qpos[0]
    for _ in range(60_000):
        mujoco.mj_step(model, data)
    assert abs(data.qpos[0] - at) / 60.0 < 1e-9


def rotor(integrator: str, level: float = 5.0) -> mujoco.MjModel:
    made = spec(ROTOR)
    made.option.integrator = getattr(mujoco.mjtIntegrator, integrator)
    return attach(made, {"rotor": friction("coulomb", {"coulomb": level})})


@pytest.mark.parametrize("refresh", [False, True], ids=["step", "forward"])
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_velocity_that_is_set_is_no_force(integrator: str, *, refresh: bool) -> None:
    """A joint stopped by hand stays, and one that is nudged slows down and is not thrown back."""
    model = rotor(integrator)
    data = mujoco.MjData(model)
    for before, after in ((20.0, 0.0), (0.0, 1e-3), (-20.0, 5.0)):
        data.qvel[0] = before
        for _ in range(5):
            mujoco.mj_step(model, data)
        data.qvel[0] = after
        if refresh:
            mujoco.mj_forward(model, data)
        mujoco.mj_step(model, data)
        lost = 5.0 / 0.01 * 1e-3
        assert data.qvel[0] == pytest.approx(max(after - lost, 0.0), abs=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_twin_whose_velocity_is_set_at_every_tick_carries_its_load(integrator: str) -> None:
    model, rng, borne = rotor(integrator), np.random.default_rng(0), []
    data = mujoco.MjData(model)
    data.ctrl[0] = 2.5
    for _ in range(500):
        data.qvel[0] = 1e-3 * rng.normal()
        mujoco.mj_step(model, data)
        borne.append(torques(model, data)["rotor"])
    assert np.mean(borne) == pytest.approx(2.5, abs=0.01)
    assert np.std(borne) < 0.02  # N·m, of which 0.01 stop 1 mrad/s within the step


@pytest.mark.parametrize(
    ("option", "joint", "more", "foreseen"),
    [
        ("", 'damping="1"', '<actuator><position joint="j" kp="9" kv="1"/></actuator>', True),
        ('density="9"', "", "", False),
        ("", 'damping="1 2 0"', "", False),
        ("", "", '<tendon><fixed damping="1"><joint joint="j" coef="1"/></fixed></tendon>', False),
        ("", "", '<actuator><position joint="j" kp="9" kv="1" forcerange="-99 99"/></actuator>', False),
    ],
)
def test_where_more_than_constraints_is_not_foreseen_a_difference_is_made_up_for(
    option: str, joint: str, more: str, *, foreseen: bool
) -> None:
    """The joint arrives off what was predicted at every step, and what lacked is in the next step's balance."""
    text = f"""<mujoco><option timestep="0.002" integrator="implicitfast" gravity="0 0 0" {option}/><worldbody>
      <body><joint name="j" {joint}/><geom type="capsule" size=".05" fromto="0 0 0 .5 0 0"/></body></worldbody>{more}
      </mujoco>"""
    model = attach(mujoco.MjSpec.from_string(text), {"j": friction("coulomb", {"coulomb": 0.1})}, keep_native=True)
    data = mujoco.MjData(model)
    data.qvel[0] = 3.0
    for _ in range(3):
        mujoco.mj_step(model, data)
    header = model.numeric("mjfriction").data
    unknown = data.userdata[int(header[at.H_BASE]) + at.U_SCALARS + 2]
    assert header[at.H_FORESEEN] == foreseen
    assert bool(unknown == 0.0) is foreseen


def test_a_velocity_that_is_set_is_no_load() -> None:
    """Friction that reads the load takes the acceleration that the joint had, not the jump to the new velocity."""
    values = {"coulomb": 0.5, "viscous": 0.0, "load": 0.2}
    model = attach(spec(PENDULUM), {"swing": friction("load_dependent", values)})
    reader = read_friction(model)

    def load(jump: float) -> float:
        data = mujoco.MjData(model)
        data.qpos[0] = 1.0
        for _ in range(20):
            mujoco.mj_step(model, data)
        data.qvel[0] += jump
        mujoco.mj_step(model, data)
        return float(data.userdata[reader.load][0])

    assert 0.1 < abs(load(0.0)) < 1.0
    assert load(0.5) == pytest.approx(load(0.0), rel=1e-3)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_forward_twice_changes_nothing(integrator: str) -> None:
    model = arms(integrator)
    data = run(model, 200)
    mujoco.mj_forward(model, data)
    state, force, acceleration = full_state(model, data), data.qfrc_passive.copy(), data.qacc.copy()
    warm = data.qacc_warmstart.copy()
    for _ in range(3):
        data.qacc_warmstart[:] = warm
        mujoco.mj_forward(model, data)
        assert data.qfrc_passive.tolist() == force.tolist()
        assert data.qacc.tolist() == acceleration.tolist()
    mujoco.mj_forwardSkip(model, data, mujoco.mjtStage.mjSTAGE_VEL, 1)
    np.testing.assert_allclose(data.qfrc_passive, force, rtol=1e-12, atol=1e-12)
    data.qacc_warmstart[:] = warm
    np.testing.assert_allclose(full_state(model, data), state, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_restored_state_repeats_to_the_bit(integrator: str) -> None:
    model = arms(integrator)
    data = run(model, 150)
    state = full_state(model, data)
    once = full_state(model, run(model, 150, data, 150))
    other = mujoco.MjData(model)
    mujoco.mj_setState(model, other, state, FULL)
    again = full_state(model, run(model, 150, other, 150))
    assert once.tolist() == again.tolist()


def test_reset_clears_the_states_and_copies_carry_them() -> None:
    model = arms()
    data = run(model, 100)
    twin = copy.copy(data)
    assert twin.userdata.tolist() == data.userdata.tolist()
    mujoco.mj_resetData(model, data)
    assert not np.any(data.userdata)
    assert full_state(model, run(model, 100, data)).tolist() == full_state(model, run(model, 100)).tolist()


@pytest.mark.parametrize("threads", [1, 2])
def test_a_batch_is_the_serial_loop_to_the_bit(threads: int) -> None:
    model, steps = arms(), 120
    rng = np.random.default_rng(0)
    start = rng.normal(0.0, 0.3, (5, model.nv))
    batch = mujoco.batch.Batch(model, 5, nthread=threads)
    batch.qvel[:] = start
    ctrl = np.tile(controls(model, steps), (5, 1, 1))
    out = batch.rollout(steps, control=ctrl, record=("qpos", "qvel", "userdata"))
    for k in range(5):
        data = mujoco.MjData(model)
        data.qvel[:] = start[k]
        run(model, steps, data)
        assert out["qpos"][k, -1].tolist() == data.qpos.tolist()
        assert out["userdata"][k, -1].tolist() == data.userdata.tolist()


def test_rollout_runs_with_friction() -> None:
    model, steps = arms(), 80
    data = mujoco.MjData(model)
    initial = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, initial, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    states, _ = mujoco.rollout.rollout(model, data, initial, controls(model, steps)[None])
    serial = run(model, steps)
    assert states[0, -1, 1 : 1 + model.nq].tolist() == serial.qpos.tolist()


def test_a_thousand_parameter_sets_in_one_batch_are_a_thousand_runs() -> None:
    rng = np.random.default_rng(1)
    model, steps, count = attach(spec(TWO_ARMS), arm_laws()), 30, 1000
    sets = []
    for _ in range(count):
        laws = arm_laws()
        coulomb = float(rng.uniform(1.0, 8.0))
        laws["a1"] = lugre(coulomb=coulomb, static=coulomb * float(rng.uniform(1.0, 1.6)))
        sets.append(laws)
    batch = mujoco.batch.Batch(model, count, nthread=2)
    write_candidates(batch.expand("numeric_data"), model, candidate_blocks(model, sets))
    ctrl = controls(model, steps)
    out = batch.rollout(steps, control=np.tile(ctrl, (count, 1, 1)))["qpos"]
    for k in range(count):
        rewrite(model, sets[k])
        assert run(model, steps).qpos.tolist() == out[k, -1].tolist()


def test_joints_may_stand_in_any_order() -> None:
    laws = arm_laws()
    turned = dict(reversed(laws.items()))
    one, other = run(attach(spec(TWO_ARMS), laws), 100), run(attach(spec(TWO_ARMS), turned), 100)
    assert one.qpos.tolist() == other.qpos.tolist()


def test_six_joints_are_stepped_as_any_number_is() -> None:
    """Six joints have machine code of their own; a weight that swings apart from them sends them through the other."""
    case = six_axis_case()
    laws = {name: friction("lugre", law) for name, law in case.laws.items()}
    beside = case.spec.copy()
    weight = beside.worldbody.add_body(name="weight", pos=[5.0, 0.0, 0.0])
    weight.add_geom(size=[0.1, 0.0, 0.0], contype=0, conaffinity=0)
    weight.add_joint(name="weight", type=mujoco.mjtJoint.mjJNT_SLIDE)
    ends = []
    for model in (attach(case.spec, laws), attach(beside, laws)):
        data = mujoco.MjData(model)
        for k in range(300):
            data.ctrl[:] = 10.0 * np.sin(10e-3 * k + np.arange(6))
            mujoco.mj_step(model, data)
        assert np.min(np.abs(data.qpos[:6])) > 1e-9
        assert np.max(np.abs(data.qvel[:6])) > 1.0
        ends.append(np.concatenate([data.qpos[:6], data.qvel[:6], list(torques(model, data).values())]))
    assert ends[1] == pytest.approx(ends[0], rel=1e-12)


def test_two_models_with_different_laws_share_the_callback() -> None:
    first, second = (
        attach(spec(ROTOR), {"rotor": lugre()}),
        attach(spec(ROTOR), {"rotor": friction("coulomb", {"coulomb": 1.0})}),
    )
    plain = spec(ROTOR).compile()
    together = [mujoco.MjData(m) for m in (first, second, plain)]
    for data in together:
        data.ctrl[0] = 9.0
    for _ in range(50):
        for model, data in zip((first, second, plain), together, strict=True):
            mujoco.mj_step(model, data)
    for model, data in zip((first, second, plain), together, strict=True):
        alone = mujoco.MjData(model)
        alone.ctrl[0] = 9.0
        for _ in range(50):
            mujoco.mj_step(model, alone)
        assert alone.qpos.tolist() == data.qpos.tolist()


def test_a_model_without_friction_is_untouched() -> None:
    model = spec(TWO_ARMS).compile()
    inside = full_state(model, run(model, 100))
    remove()
    try:
        assert full_state(model, run(model, 100)).tolist() == inside.tolist()
    finally:
        install()


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_joints_land_where_they_were_predicted(integrator: str) -> None:
    """Without constraints MuJoCo's own integrator ends on the velocity that the friction step solved for."""
    made = spec(TWO_ARMS)
    made.option.integrator = getattr(mujoco.mjtIntegrator, integrator)
    for joint in ("a1", "b1"):
        made.joint(joint).damping[0] = 0.7
    model = attach(made, arm_laws(), keep_native=True)
    data = run(model, 300)
    header = model.numeric("mjfriction").data
    base, n = (int(header[i]) for i in (at.H_BASE, at.H_TOUCHED))
    assert n == 4 + 2 + 4  # the hanging arm's four dofs, two and four of the arms
    start = int(header[at.H_DOF_LIST])
    dofs = header[start : start + n].astype(int)
    assert len(set(dofs.tolist())) == n
    predicted = data.userdata[base + at.U_SCALARS + n : base + at.U_SCALARS + 2 * n]
    # Euler is predicted to rounding; the implicit integrators add the derivative of Coriolis forces, which is not.
    tolerance = 1e-9 if integrator == "mjINT_EULER" else 2e-3
    assert np.max(np.abs(predicted - data.qvel[dofs])) < tolerance * max(1.0, float(np.max(np.abs(data.qvel[dofs]))))


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
@settings(max_examples=8)
@given(seed=st.integers(0, 10**6), angle=st.floats(0.3, 3.0))
def test_a_free_pendulum_never_gains_energy(law, seed: int, angle: float) -> None:
    """No more than the same steps gain without friction, semi-implicit Euler's own breathing."""
    made = spec(PENDULUM)
    made.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    made.option.timestep = 5e-4
    values = dict(named(law, seed))
    for name in ("coulomb", "static", "static_rested", "level", "viscous", "stribeck_fall"):
        if isinstance(values.get(name), float):
            values[name] *= 0.05  # a pendulum of 0.5 kg: let it swing before it sticks
    for name in ("level_extending", "level_retracting"):
        if name in values:
            values[name] *= 1e-3
    if "asymmetry" in values:  # a difference of the directions opposes motion only beside as much damping in both
        values["asymmetry"] = min(values["asymmetry"], values["viscous"])

    def energies(model: mujoco.MjModel) -> np.ndarray:
        data = mujoco.MjData(model)
        data.qpos[0] = angle
        mujoco.mj_forward(model, data)
        out = [sum(data.energy)]
        for _ in range(1500):
            mujoco.mj_step(model, data)
            out.append(sum(data.energy))
        return np.array(out)

    free = energies(made.compile())
    rubbed = energies(attach(made, {"swing": friction(law.name, values)}))
    breathing = free.max() - free[0]
    assert np.max(rubbed) <= rubbed[0] + breathing + 1e-9
    assert rubbed[-1] <= rubbed[0] + breathing + 1e-9


def test_the_torque_is_the_law_at_the_velocity_reached() -> None:
    model = attach(spec(ROTOR), {"rotor": lugre()})
    data = mujoco.MjData(model)
    law, p = LAWS["lugre"], LAWS["lugre"].pack(LUGRE)
    reader = read_friction(model)
    z_next = np.zeros(1)
    for k in range(400):
        data.ctrl[0] = 12.0 * np.sin(0.02 * k)
        around = ambient(1, sliding=float(data.qvel[0]))[0]  # the falling level lags by the step
        mujoco.mj_step(model, data)
        z = data.userdata[reader.state("rotor")].copy()
        torque, _ = law.advance(float(data.qvel[0]), around, z, 1e-3, p, z_next)
        assert torques(model, data)["rotor"] == pytest.approx(torque, rel=1e-5, abs=1e-7)
    assert data.userdata[reader.rounds][0] > 0


@pytest.mark.parametrize("epsilon", [1e-8, 1e-6, 1e-4])
def test_the_derivative_by_the_control_holds_in_steady_motion(epsilon: float) -> None:
    """Where nothing changes from step to step, the guess is the end of the step but for what the control changes."""
    viscous, inertia, step = 2.0, 0.01, 1e-3
    model = attach(spec(ROTOR), {"rotor": friction("coulomb_viscous", {"coulomb": 1.0, "viscous": viscous})})
    data = mujoco.MjData(model)
    data.ctrl[0] = 3.0
    for _ in range(3000):
        mujoco.mj_step(model, data)
    assert data.qvel[0] == pytest.approx((3.0 - 1.0) / viscous, rel=1e-9)
    b = np.zeros((2, 1))
    mujoco.mjd_transitionFD(model, data, epsilon, True, None, b, None, None)
    assert b[1, 0] == pytest.approx(step / (inertia + step * viscous), rel=1e-4)


def test_transition_derivatives_agree_with_steps_by_hand() -> None:
    model = arms()
    data = run(model, 200)
    mujoco.mj_forward(model, data)
    state = full_state(model, data)
    size, eps = 2 * model.nv, 1e-6
    a, b = np.zeros((size, size)), np.zeros((size, model.nu))
    mujoco.mjd_transitionFD(model, data, eps, False, a, b, None, None)
    assert np.all(np.isfinite(a))

    def stepped(change) -> np.ndarray:
        twin = mujoco.MjData(model)
        mujoco.mj_setState(model, twin, state, FULL)
        change(twin)
        mujoco.mj_step(model, twin)
        return twin.qvel.copy()

    base = stepped(lambda d: None)
    for i in range(model.nu):

        def push(d, i=i):
            d.ctrl[i] += eps

        np.testing.assert_allclose(b[model.nv :, i], (stepped(push) - base) / eps, atol=2e-4)
    for j in range(6, model.nv):

        def shove(d, j=j):
            d.qvel[j] += eps

        np.testing.assert_allclose(a[model.nv :, model.nv + j], (stepped(shove) - base) / eps, atol=5e-3)
