"""The joint states of ROS 2 bags in MCAP."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sized
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from mjfriction.errors import LogError
from mjfriction.record.log import EFFORT, POSITION, SET_WORDS, VELOCITY

JOINT_STATE = "sensor_msgs/msg/JointState"
FIELDS = (POSITION, VELOCITY, EFFORT)
LEAST_COVERED = 0.5  # share of the time of the topic that sets the clock that another one must cover to be used
Stamped = tuple[float, Any]
Course = tuple[np.ndarray, np.ndarray]


def read_table(path: Path) -> pa.Table:
    """Read every ``sensor_msgs/JointState`` of an .mcap file, or of the .mcap files of a bag's folder.

    Time is the messages' own stamp (the log's, where they have none), starting at 0.  Joints may come in any order, and
    in separate messages or topics: all are interpolated linearly at the instants of one topic's messages, within the
    time that all of them cover.  That topic is one whose name does not speak of a command or a reference, that has
    positions and efforts, and that has the most messages, in this order; of a joint in several topics, the first so
    ordered is used.  Beside it, commands and references are left out, and topics that cover less than half of its
    time.  Raises :class:`LogError` for a file that cannot be parsed, and for one without joint states.
    """
    files = sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    if not files:
        raise LogError(f"{path}: there is no .mcap file in the folder")
    groups: dict[tuple[str, frozenset[str]], list[Stamped]] = defaultdict(list)
    topics: set[str] = set()
    for file in files:
        for topic, kind, stamp, message in _messages(file):
            topics.add(f"{topic} ({kind})")
            if message is not None:
                groups[topic, frozenset(message.name)].append((stamp, message))
    if not groups:
        listed = ", ".join(sorted(topics)) or "nothing"
        raise LogError(f"{path}: there are no joint states ({JOINT_STATE}) in it. Found: {listed}")
    for told in groups.values():
        told.sort(key=lambda entry: entry[0])  # files and topics come in any order
    told_of = {key: _courses(messages) for key, messages in groups.items()}
    ranks = {key: _rank(key, told_of[key], groups[key]) for key in groups if told_of[key]}
    order = sorted(ranks, key=ranks.__getitem__)
    order = [key for key in order if ranks[key][0] == ranks[order[0]][0]]  # commands beside measurements are not read
    if not order:
        raise LogError(f"{path}: its joint states hold no finite positions")
    clock = np.array([stamp for stamp, _ in groups[order[0]]])
    courses: dict[str, Course] = {}
    for key in order:
        for name, course in told_of[key].items():
            if np.ptp(course[0]) >= LEAST_COVERED * np.ptp(clock):
                courses.setdefault(name, course)
    first, last = max(stamps[0] for stamps, _ in courses.values()), min(stamps[-1] for stamps, _ in courses.values())
    clock = clock[(clock >= first) & (clock <= last)]
    if not clock.size:
        raise LogError(f"{path}: the joints were recorded at different times; a log needs them together")
    columns = {name: np.interp(clock, stamps, values) for name, (stamps, values) in sorted(courses.items())}
    return pa.table({"time": clock - clock[0], **columns})


def _rank(key: tuple[str, frozenset[str]], courses: Mapping[str, Course], messages: Sized) -> tuple[Any, ...]:
    topic, joints = key
    words = re.split(r"[^a-z]+", topic.lower())
    asked = any({word, word.removesuffix("s")} & SET_WORDS for word in words)
    quantities = {name.partition(".")[0] for name in courses}
    return asked, not {POSITION, EFFORT} <= quantities, -len(messages), topic, sorted(joints)


def _messages(file: Path) -> Iterator[tuple[str, str, float, Any]]:
    try:
        with file.open("rb") as stream:
            factory = DecoderFactory()  # caches the parsed schemas
            for schema, channel, message in make_reader(stream).iter_messages():
                kind = schema.name if schema is not None else channel.message_encoding
                if kind != JOINT_STATE or schema is None:
                    yield channel.topic, kind, 0.0, None
                    continue
                decode = factory.decoder_for(channel.message_encoding, schema)
                if decode is None:
                    raise LogError(
                        f"{file}: joint states encoded as '{channel.message_encoding}'; ROS 2's 'cdr' is read"
                    )
                state = decode(message.data)
                own = state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec
                yield channel.topic, kind, own or 1e-9 * message.log_time, state
    except (McapError, OSError, ValueError) as error:
        raise LogError(f"{file}: not a readable MCAP file: {str(error).splitlines()[0]}") from None


def _courses(messages: list[Stamped]) -> dict[str, Course]:
    told: dict[str, tuple[list[float], list[float]]] = defaultdict(lambda: ([], []))
    for stamp, message in messages:
        for field in FIELDS:
            values = getattr(message, field)
            if len(values) == len(message.name):
                for name, value in zip(message.name, values, strict=True):
                    stamps, course = told[f"{field}.{name}"]
                    stamps.append(stamp)
                    course.append(value)
    out = {name: (np.array(stamps), np.array(course)) for name, (stamps, course) in told.items()}
    # Drivers fill quantities that they do not measure with NaN; such columns are dropped.  Single NaNs are errors of
    # the log, and are kept to be reported.
    return {name: course for name, course in out.items() if np.any(np.isfinite(course[1]))}
