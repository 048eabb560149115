"""The experiments that identification asks for, as trajectories of the whole arm."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from mjfriction.body.gravity_pose import gravity_pose
from mjfriction.body.inertia import factors, parameters_per_number, pseudo_inertias
from mjfriction.body.inverse import inverse_dynamics
from mjfriction.body.model import Body
from mjfriction.body.regressor import weighed_links
from mjfriction.errors import RobotError
from mjfriction.identify.background import USUAL_OFFSET
from mjfriction.plant.motions import KNOTS, excitation, forward_backward, move
from mjfriction.plant.trajectory import Trajectory
from mjfriction.progress import Tell, counting, silently
from mjfriction.record.log import EFFORT, POSITION, Floats
from mjfriction.record.motion import Motion, estimate_motion
from mjfriction.record.readers.table import log_from_table
from mjfriction.robot.effort import predict_effort
from mjfriction.robot.robot import Robot

REACH = 0.4  # share of a joint's range that a motion may use on either side of the middle
WIDEST = 1.2  # rad or m, the largest such reach, where limits are wide
# rad/s or m/s, the highest speed that is planned where none is asked for, even if the model's limit is higher
UNSTATED_SPEED = 1.5
SLOWEST_SHARE = 0.005  # speed of the slowest pass, as a share of the fastest
LONGEST_PASS = 8.0  # s; slower passes cover only a part of the stroke
TOP_SHARE = 0.8  # share of a joint's top speed that passes use
CUTOFF = 20.0  # Hz, for the derivatives of planned motions
REST = 125  # samples of rest between two joints' passes
PACES = (0.15, 1.0)  # shares of the top speeds at which trial motions of all joints run
# Number of trials of each kind, s of a trial of all joints at once, s of the slowest to and fro of one joint alone.
TRIALS, TRIAL_SECONDS, LONGEST_TO_AND_FRO = 4, 40.0, 20.0
ENOUGH_SAMPLES = 1500
USUAL_SPEEDS, USUAL_SECONDS = 12, 60.0
DRAWS = 8  # random excitations, of which the best is taken
USUAL_SPREAD = 0.2  # how far off links usually are: a mass by 20 %


@dataclass(frozen=True)
class Plan:
    """A trajectory, and sentences that tell a person what it does."""

    trajectory: Trajectory
    words: tuple[str, ...]


def room(body: Body) -> tuple[Floats, Floats]:
    """Return the middle of every joint's range and how far a motion may go to either side, (joints,) each.

    A turning joint without stated limits counts as one with a range of half a turn either way.  Raises
    :class:`~mjfriction.errors.RobotError` for a sliding joint without limits.
    """
    low, high = _range(body)
    return 0.5 * (low + high), np.minimum(REACH * (high - low), WIDEST)


def unbounded(body: Body) -> tuple[str, ...]:
    """Return the sliding joints for which the model states no range: no motion of theirs is safe to plan."""
    ends = zip(body.joints, body.sliding, body.lower, body.upper, strict=True)
    return tuple(joint for joint, slides, low, high in ends if slides and not np.isfinite(high - low))


def _range(body: Body) -> tuple[Floats, Floats]:
    if names := unbounded(body):
        raise RobotError(
            f"joint '{names[0]}' slides, and its model file states no range: a plan could move it anywhere; state its "
            "limits there (limit lower, upper of a URDF; range of an MJCF)"
        )
    low = np.where(np.isfinite(body.lower), body.lower, -np.pi)
    return low, np.where(np.isfinite(body.upper), body.upper, np.pi)


def plan_passes(
    robot: Robot,
    joints: Sequence[str],
    *,
    count: int = USUAL_SPEEDS,
    speeds: Mapping[str, Floats] | None = None,
    slowest: float | None = None,
    fastest: float | None = None,
    stroke: float | None = None,
    seed: int = 0,
    tell: Tell = silently,
) -> Plan:
    """Plan passes forward and backward of one joint after another, each where gravity loads it least.

    Each joint gets ``count`` speeds, spaced logarithmically from the ``slowest`` (by default a two-hundredth of the
    fastest) to the ``fastest`` (by default 0.8 of the joint's top speed, which counts as 1.5 at most).  Instead
    ``speeds`` may give a joint's speeds (rad/s or m/s at the joint, rising), even beyond its top speed.  Passes go over
    the ``stroke`` (rad or m; by default four fifths of the joint's range, 2.4 at most), slow ones over a part of it.
    ``tell`` is called for each joint.

    Raises :class:`RobotError` for a joint that the robot does not have, for fewer than three speeds, or for speeds or a
    stroke that a joint cannot reach.
    """
    body = robot.body()
    if count < 3:
        raise RobotError(f"{count} speeds are too few for a friction map; at least 3 are needed")
    parts: list[Floats] = []
    words = []
    begin = counting(tell, len(joints))
    for name in joints:
        begin(f"freeing {name} of gravity")
        index = robot.joints.index(robot.joint(name).name)
        freed = gravity_pose(body, index, seed=seed)
        way_at_most = _stroke(body, index, float(freed.pose[index]), stroke)
        paces = _paces(body, index, count, slowest, fastest)
        top = float(paces[-1])
        if speeds is not None and name in speeds:
            paces, top = speeds[name], float(speeds[name][-1])
        start = freed.pose.copy()
        own = []
        for speed in paces.tolist():
            way = min(way_at_most, speed * LONGEST_PASS)
            middle = float(freed.pose[index])
            # At top speed, three quarters of the way remain for the phase of constant speed.
            acceleration = 4.0 * max(top * top / way_at_most, speed * speed / way)
            passes = forward_backward(name, middle - 0.5 * way, way, [speed], acceleration)
            own.append(passes.position[:, 0])
        for course in own:
            pose = np.tile(start, (course.size, 1))
            pose[:, index] = course
            parts.append(pose)
        listed = f"{paces[0]:.3g} to {paces[-1]:.3g} {'m/s' if body.sliding[index] else 'rad/s'}"
        words.append(f"{name}: {paces.size} speeds from {listed}; {freed.kind.value}")
    return Plan(joined(robot.joints, parts, body), tuple(words))


def _stroke(body: Body, index: int, middle: float, asked: float | None) -> float:
    # How far a joint's passes go around the position where gravity loads it least.
    if asked is None:
        return 2.0 * float(room(body)[1][index])
    low, high = (float(limits[index]) for limits in _range(body))
    most = 2.0 * min(high - middle, middle - low)
    if not 0.0 < asked <= most:
        unit = "m" if body.sliding[index] else "rad"
        raise RobotError(
            f"joint '{body.joints[index]}' cannot pass over {asked:.4g} {unit} about {middle:.3g} {unit}, where "
            f"gravity loads it least; up to {most:.4g} {unit} are within its limits"
        )
    return asked


def _paces(body: Body, index: int, count: int, slowest: float | None, fastest: float | None) -> Floats:
    # The speeds of a joint's passes, spaced logarithmically.
    limit = float(body.top_speed[index])
    top = TOP_SHARE * min(limit, UNSTATED_SPEED) if fastest is None else fastest
    low = SLOWEST_SHARE * top if slowest is None else slowest
    if not 0.0 < low < top <= limit:
        unit = "m/s" if body.sliding[index] else "rad/s"
        known = f" and not above its limit of {limit:.4g} {unit}" if np.isfinite(limit) else ""
        raise RobotError(
            f"joint '{body.joints[index]}' cannot pass at {low:.4g} to {top:.4g} {unit}: speeds must rise from above 0"
            f"{known}"
        )
    return np.geomspace(low, top, count)


def plan_excitation(robot: Robot, seconds: float = USUAL_SECONDS, *, seed: int = 0, tell: Tell = silently) -> Plan:
    """Plan a motion of all joints at once, within limits, that separates links from friction.

    Of several random sums of sines, the one is taken whose regressor of links and friction, in usual sizes, has the
    largest median singular value.  ``tell`` is called for each draw.
    """
    body = robot.body()
    middle, reach = room(body)
    top = np.minimum(body.top_speed, UNSTATED_SPEED)
    best: tuple[float, Trajectory] | None = None
    begin = counting(tell, DRAWS)
    for draw in range(DRAWS):
        begin("drawing motions")
        trajectory = excitation(robot.joints, middle, reach, top, seconds, seed=seed * DRAWS + draw)
        told = least_told(body, motion_along(robot, trajectory))
        if best is None or told > best[0]:
            best = told, trajectory
    assert best is not None, "there is always a draw"
    return Plan(
        best[1], (f"all joints for {seconds:.0f} s, the best of {DRAWS} draws for telling links from friction",)
    )


def plan_separation(robots: tuple[Robot, Robot], *, seed: int = 0, tell: Tell = silently) -> Plan:
    """Plan the motion on which two robots' predicted efforts differ most, out of a few dozen within limits.

    ``tell`` is called with the joint whose motions are tried.

    Raises :class:`RobotError` where the robots do not have the same joints, or predict the same efforts on all motions.
    """
    one, other = robots
    if one.joints != other.joints:
        raise RobotError(f"'{one.name}' and '{other.name}' have not the same joints; compare models of one robot")
    body = one.body()
    top = np.minimum(body.top_speed, UNSTATED_SPEED)
    best: tuple[float, int, Trajectory] | None = None
    begin = counting(tell, len(one.joints))
    for joint in range(len(one.joints)):
        begin(f"trying motions of {one.joints[joint]}")
        for trajectory in candidate_motions(one.joints, body, top, joint, all_joints=joint == 0, seed=seed):
            size = difference(robots, motion_along(one, trajectory))
            worst = int(np.argmax(size))
            if best is None or size[worst] > best[0]:
                best = float(size[worst]), worst, trajectory
    assert best is not None, "a robot has joints"
    apart, worst, trajectory = best
    if apart <= 0.0:
        raise RobotError(f"'{one.name}' and '{other.name}' predict the same efforts on every motion that was tried")
    unit = "N" if body.sliding[worst] else "N·m"
    return Plan(trajectory, (f"the two differ by {apart:.3g} {unit} (RMS) at {one.joints[worst]}",))


def candidate_motions(
    names: tuple[str, ...],
    body: Body,
    top: Floats,
    joint: int,
    *,
    all_joints: bool = True,
    side: float = 0.0,
    seed: int = 0,
) -> list[Trajectory]:
    """Return motions within the joints' limits: random ones of all joints at two paces, and one joint to and fro.

    With ``side`` −1 or 1, ``joint`` moves about a place as far from the middle of its range as possible, but no more
    than a quarter of a turn away: a load may point the other way there.
    """
    middle, reach = room(body)
    middle[joint] += side * _room_aside(body, joint, float(reach[joint]))
    out = []
    if all_joints:
        out = [
            excitation(names, middle, reach, np.maximum(top * pace, 1e-3), TRIAL_SECONDS, seed=TRIALS * seed + draw)
            for pace in PACES
            for draw in range(TRIALS)
        ]
    # A pass to and fro takes four reaches divided by its speed; a slower one would take too long.
    slowest = 4.0 * reach[joint] / LONGEST_TO_AND_FRO
    fastest = max(min(top[joint], 4.0 * reach[joint]), 1.01 * slowest)
    speeds = np.geomspace(slowest, fastest, TRIALS).tolist()
    alone = forward_backward(names[joint], middle[joint] - reach[joint], 2.0 * reach[joint], speeds, 4.0 * fastest)
    still = np.tile(middle, (alone.time.size, 1))
    still[:, joint] = alone.position[:, 0]
    return [*out, Trajectory(names, alone.time, still)]


def _room_aside(body: Body, joint: int, reach: float) -> float:
    low, high = _range(body)
    widest = np.inf if body.sliding[joint] else 0.5 * np.pi
    return float(np.clip(0.5 * (high[joint] - low[joint]) - reach, 0.0, widest))


def motion_along(robot: Robot, trajectory: Trajectory) -> Motion:
    """Return the motion of a trajectory, as estimated from a log that followed it exactly."""
    columns = {"time": trajectory.time}
    for i, name in enumerate(trajectory.joints):
        columns[f"{POSITION}.{name}"] = trajectory.position[:, i]
        columns[f"{EFFORT}.{name}"] = np.zeros(trajectory.time.size)
    return estimate_motion(log_from_table(pa.table(columns), "plan"), robot.joints, CUTOFF)


def difference(robots: Sequence[Robot], motion: Motion) -> Floats:
    """Return the RMS difference of two robots' reported efforts along a motion, (joints,)."""
    one, other = (predict_effort(robot, robot.body(), motion).reported for robot in robots)
    return np.asarray(np.sqrt(np.mean(np.square(one - other), axis=0)))


def least_told(body: Body, motion: Motion) -> float:
    """Return the median singular value of a motion's regressor of links and friction, in sizes they usually are off."""
    thin = slice(None, None, max(1, motion.time.size // ENOUGH_SAMPLES))
    course = (motion.position[thin], motion.velocity[thin], motion.acceleration[thin])
    weight = USUAL_SPREAD * parameters_per_number(factors(pseudo_inertias(body.model)))
    links = weighed_links(body, *course, weight)
    size = np.sqrt(np.mean(np.square(inverse_dynamics(body, *course)), axis=0))
    blocks = []
    for joint in range(len(body.joints)):
        velocity = motion.velocity[thin, joint]
        own = np.zeros((velocity.size, 2 * len(body.joints)))
        own[:, 2 * joint : 2 * joint + 2] = USUAL_OFFSET * size[joint] * np.column_stack([np.sign(velocity), velocity])
        rows = np.hstack([links[:, joint].reshape(velocity.size, -1), own])
        blocks.append(rows / max(float(size[joint]), 1e-12))
    values = np.linalg.svd(np.vstack(blocks), compute_uv=False)
    # Combinations that no motion shows are the same for all draws, so the least of the larger half of the values
    # decides.
    return float(values[values.size // 2])


def joined(joints: tuple[str, ...], parts: list[Floats], body: Body) -> Trajectory:
    """Join parts (n, joints) at 250 Hz; between two, all joints move from where one ends to where the next begins."""
    top = 0.3 * np.minimum(body.top_speed, UNSTATED_SPEED)
    out = [parts[0]]
    for before, after in itertools.pairwise(parts):
        if not np.allclose(before[-1], after[0], atol=1e-9):
            out += [move(before[-1], after[0], top, top), np.tile(after[0], (REST, 1))]
        out.append(after)
    position = np.concatenate(out)
    return Trajectory(joints, np.arange(position.shape[0]) / KNOTS, position)
