"""Friction exported to stock MuJoCo: plain MJCF elements, exact where one exists, otherwise the nearest fit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.optimize import least_squares, nnls

from mjfriction.errors import SimulationError
from mjfriction.laws.ambient import ROOM_TEMPERATURE, ambient
from mjfriction.laws.catalog import LAWS
from mjfriction.laws.friction import Friction, Level, friction
from mjfriction.laws.law import Floats
from mjfriction.laws.rules import Values
from mjfriction.sim.spec import leave_room_for_digits

NO_INPUT = 16  # ctrlspec of an actuator that only adds friction; input="none" in MJCF compiles to it
UNFADED = 1e9  # rad/s; bristle damping that fades only beyond this velocity counts as constant
SAMPLES, STEP = 4000, 1e-3  # samples, and s between them, of the motion along which laws are compared
POSES = 100
STIFF_SOLREF, STIFF_SOLIMP = (0.002, 1.0), (0.999, 0.9999, 1e-6, 0.5, 2.0)


@dataclass(frozen=True)
class Native:
    """A joint's friction in stock MuJoCo, all values at the joint.

    ``damping``: a·v + b·v|v| + c·v³.  ``frictionloss``: dry friction.  ``lugre``: stiffness, damping, Coulomb and
    static level, Stribeck velocity of a ``dcmotor``.  ``slip``: stiffness and level of tendons that yield.
    """

    damping: tuple[float, float, float] = (0.0, 0.0, 0.0)
    frictionloss: float = 0.0
    lugre: tuple[float, float, float, float, float] | None = None
    slip: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Probe:
    """A motion along which friction is compared: ``velocity`` (n,) and the joint's surroundings ``around`` (n, 7)."""

    velocity: Floats
    around: Floats


@dataclass(frozen=True)
class Carried:
    """How one joint's friction was exported.

    ``exact`` is true where the element's equations are the law's.  ``error`` is the RMS torque difference along a
    motion through rest with speeds up to ``fastest``, under an oscillating load (as large as gravity's in random poses)
    and ± 10 K.  ``size`` is the RMS torque along that motion.  Both are in ``unit``.
    """

    joint: str
    element: str
    exact: bool
    error: float
    size: float
    unit: str


def export_spec(
    spec: mujoco.MjSpec, laws: Mapping[str, Sequence[Friction]], *, fastest: float = 2.0
) -> tuple[mujoco.MjSpec, list[Carried]]:
    """Return a spec of stock MuJoCo elements only, and how each joint's laws were exported.

    ``fastest`` (rad/s or m/s) bounds the speed of the motion that fits are made for.  The spec uses the integrator
    implicitfast, under which MuJoCo's LuGre element is stable.  Raises :class:`SimulationError` for an unknown joint.
    """
    spec = spec.copy()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    leave_room_for_digits(spec)
    loads, report = gravity_loads(spec), []
    for name, own in laws.items():
        if spec.joint(name) is None:
            raise SimulationError(f"joint '{name}' is not in the model")
        probe = probing_motion(fastest, loads[name])
        native, exact = as_native(list(own), probe, fastest)
        put_on(spec, name, native)
        wanted, got = along(own, probe), native_torque(native, probe)
        error, size = (float(np.sqrt(np.mean(x**2))) for x in (wanted - got, wanted))
        unit = "N" if spec.joint(name).type == mujoco.mjtJoint.mjJNT_SLIDE else "N·m"
        report.append(Carried(name, describe(native), exact, error, size, unit))
    return spec, report


def as_native(own: Sequence[Friction], probe: Probe, fastest: float) -> tuple[Native, bool]:
    """Return the native friction for a joint's laws, and whether its equations are the same."""
    parts = [exact_native(one) for one in own]
    found = [part for part in parts if part is not None]
    if len(found) == len(parts) and sum(part.lugre is not None for part in found) <= 1:
        return merged(found), True
    return fitted_native(own, probe, fastest), False


def exact_native(own: Friction) -> Native | None:
    """Return the native element with the same equations as one law, None where MuJoCo has none."""
    if own.negative is not None or own.level != Level():
        return None
    r = abs(own.gear_ratio)
    p = {name: value for name, value in own.law.unpack(own.values).items() if isinstance(value, float)}
    viscous = r * r * p.get("viscous", 0.0)
    if own.law.name in ("coulomb", "coulomb_viscous"):
        return Native(damping=(viscous, 0.0, 0.0), frictionloss=r * p["coulomb"])
    if own.law.name == "quadratic_viscous" and p["quadratic"] >= 0.0:
        return Native(damping=(viscous, r**3 * p["quadratic"], 0.0), frictionloss=r * p["coulomb"])
    if own.law.name == "lugre" and p["stribeck_exponent"] == 2.0 and p["damping_velocity"] > UNFADED:
        stiffness, damping = r * r * p["bristle_stiffness"], r * r * p["bristle_damping"]
        lugre = (stiffness, damping, r * p["coulomb"], r * p["static"], p["stribeck_velocity"] / r)
        return Native(damping=(viscous, 0.0, 0.0), lugre=lugre)
    if own.law.name == "maxwell_slip":
        arrays = own.law.unpack(own.values)
        springs, levels = np.atleast_1d(arrays["stiffness"]), np.atleast_1d(arrays["level"])
        # A tendon whose springyield is 0 never yields, so elements of level 0 are left out.
        pairs = [(float(k), float(w)) for k, w in zip(springs, levels, strict=True) if w > 0.0]
        slip = tuple((r * r * k, r * w) for k, w in pairs)
        return Native(damping=(viscous, 0.0, 0.0), slip=slip)
    return None


def merged(parts: Sequence[Native]) -> Native:
    """Merge the native parts of one joint into one."""
    damping = np.sum([part.damping for part in parts], axis=0)
    lugre = [part.lugre for part in parts if part.lugre is not None]
    return Native(
        damping=(float(damping[0]), float(damping[1]), float(damping[2])),
        frictionloss=sum(part.frictionloss for part in parts),
        lugre=lugre[0] if lugre else None,
        slip=tuple(one for part in parts for one in part.slip),
    )


def fitted_native(own: Sequence[Friction], probe: Probe, fastest: float) -> Native:
    """Return the fit nearest to the laws' torque along the probe: dry friction, or a LuGre element."""
    wanted = along(own, probe)
    found = [fitted_dry(probe, wanted), fitted_lugre(own, probe, wanted, fastest)]
    return min(found, key=lambda native: float(np.sum((native_torque(native, probe) - wanted) ** 2)))


def fitted_dry(probe: Probe, wanted: Floats) -> Native:
    """Return the nearest dry friction with polynomial damping."""
    motion = probe.velocity
    columns = [np.sign(motion), motion, motion * np.abs(motion), motion**3]
    (level, a, b, c), _ = nnls(np.column_stack(columns), wanted)
    return Native(damping=(float(a), float(b), float(c)), frictionloss=float(level))


def fitted_lugre(own: Sequence[Friction], probe: Probe, wanted: Floats, fastest: float) -> Native:
    """Return the nearest LuGre element with polynomial damping, as stiff at rest as the laws."""
    level = max(float(np.max(np.abs(wanted))), 1e-9)
    # Laws without bristles get a stiffness at which the joint sticks within 1e-4 rad or m.
    stiffness = rest_stiffness(own) or 1e4 * level

    def element(x: Floats) -> Native:
        coulomb, extra, velocity, linear, cubic, damping = np.exp(x)
        bristle = (stiffness, damping, coulomb, coulomb + extra, velocity)
        return Native(damping=(linear, 0.0, cubic), lugre=bristle)

    start = np.log([0.7 * level, 0.1 * level, 0.05 * fastest, 0.1 * level / fastest, 1e-3 * level, 1e-4 * stiffness])
    bounds = (start - 14.0, start + 7.0)
    fit = least_squares(lambda x: (native_torque(element(x), probe) - wanted) / level, start, bounds=bounds)
    return element(fit.x)


def rest_stiffness(own: Sequence[Friction]) -> float:
    """Return the stiffness of the laws at rest, N·m/rad or N/m; 0 for laws without a state."""
    tiny, around = 1e-9, ambient(1)
    with_state = [one for one in own if one.state_count]
    return float(sum(one.follow(np.array([tiny]), around, 1.0)[0][0] for one in with_state)) / tiny


def probing_motion(fastest: float, load: float) -> Probe:
    """Return a motion through rest, slow and fast, under an oscillating load and temperature."""
    t = np.arange(SAMPLES) * STEP
    velocity = fastest * np.sin(2.0 * t) * np.sin(2.0 * np.pi * 0.9 * t) ** 2 + 0.02 * fastest * np.sin(17.0 * t)
    around = ambient(
        SAMPLES,
        load=load * np.sin(3.3 * t),
        position=np.cumsum(velocity) * STEP,
        temperature=ROOM_TEMPERATURE + 10.0 * np.sin(1.1 * t),
    )
    return Probe(velocity, around)


def gravity_loads(spec: mujoco.MjSpec) -> dict[str, float]:
    """Return the largest torque of gravity on every joint over random poses, N·m or N."""
    model = spec.compile()
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    largest = np.zeros(model.nv)
    for _ in range(POSES):
        for i in range(model.njnt):
            if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_HINGE:
                data.qpos[model.jnt_qposadr[i]] = rng.uniform(-np.pi, np.pi)
        mujoco.mj_forward(model, data)
        largest = np.maximum(largest, np.abs(data.qfrc_bias))
    return {model.joint(i).name: float(largest[model.jnt_dofadr[i]]) for i in range(model.njnt)}


def along(own: Sequence[Friction], probe: Probe) -> Floats:
    """Return the sum of the laws' torques along a motion, (n,)."""
    return np.asarray(sum(one.follow(probe.velocity, probe.around, STEP)[0] for one in own))


def native_torque(native: Native, probe: Probe) -> Floats:
    """Return the torque of the native elements' equations along a motion, (n,)."""
    velocity, around = probe.velocity, probe.around
    a, b, c = native.damping
    total = a * velocity + b * velocity * np.abs(velocity) + c * velocity**3
    total += LAWS["coulomb"].along(velocity, around, np.array([native.frictionloss]))
    if native.lugre is not None:
        stiffness, damping, coulomb, static, fall = native.lugre
        values = {"coulomb": coulomb, "static": static, "stribeck_velocity": fall, "stribeck_exponent": 2.0}
        values |= {"bristle_stiffness": stiffness, "bristle_damping": damping, "viscous": 0.0}
        total += friction("lugre", values).follow(velocity, around, STEP)[0]
    if native.slip:
        springs: Values = {
            "viscous": 0.0,
            "stiffness": [k for k, _ in native.slip],
            "level": [w for _, w in native.slip],
        }
        total += friction("maxwell_slip", springs).follow(velocity, around, STEP)[0]
    return np.asarray(total)


def put_on(spec: mujoco.MjSpec, name: str, native: Native) -> None:
    """Put native friction on a joint of a spec, in place of its damping and dry friction."""
    joint = spec.joint(name)
    joint.damping = np.array(native.damping)
    joint.frictionloss = native.frictionloss
    joint.solref_friction, joint.solimp_friction = np.array(STIFF_SOLREF), np.array(STIFF_SOLIMP)
    if native.lugre is not None:
        motor = spec.add_actuator(name=f"{name}_friction", trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        motor.set_to_dcmotor(motorconst=[0.0, 0.0], resistance=1.0, lugre=list(native.lugre), ctrlspec=NO_INPUT)
    for i, (stiffness, level) in enumerate(native.slip):
        tendon = spec.add_tendon(name=f"{name}_slip_{i}")
        tendon.wrap_joint(name, 1.0)
        tendon.stiffness[0] = stiffness
        tendon.springyield = level / stiffness


def describe(native: Native) -> str:
    """Return the names of the elements that carry a joint's friction."""
    parts = []
    if native.lugre is not None:
        parts.append("dcmotor lugre")
    if native.slip:
        parts.append(f"{len(native.slip)} yielding tendons")
    if native.frictionloss > 0.0:
        parts.append("frictionloss")
    if any(native.damping):
        parts.append("damping")
    return " + ".join(parts) or "nothing"
