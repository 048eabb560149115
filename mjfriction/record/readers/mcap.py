"""ROS 2 bags in MCAP: the joint states in them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from mjfriction.errors import LogError
from mjfriction.record.log import EFFORT, POSITION, VELOCITY

JOINT_STATE = "sensor_msgs/msg/JointState"
FIELDS = (POSITION, VELOCITY, EFFORT)
Stamped = tuple[float, Any]


def read_table(path: Path) -> pa.Table:
    """Read every ``sensor_msgs/JointState`` of an .mcap file, or of the .mcap files of a bag's folder.

    Time is the messages' own stamp (the log's, where they have none), from the first on.  Joints may come in any order,
    and in messages or topics of their own: all are brought to the instants of those that come most often, in between by
    straight lines.  Raises :class:`LogError` for a file that cannot be parsed, and one without joint states.
    """
    files = sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    if not files:
        raise LogError(f"{path}: there is no .mcap file in the folder")
    groups: dict[tuple[str, tuple[str, ...]], list[Stamped]] = defaultdict(list)
    topics: set[str] = set()
    for file in files:
        for topic, kind, stamp, message in _messages(file):
            topics.add(f"{topic} ({kind})")
            if message is not None:
                groups[topic, tuple(message.name)].append((stamp, message))
    if not groups:
        listed = ", ".join(sorted(topics)) or "nothing"
        raise LogError(f"{path}: there are no joint states ({JOINT_STATE}) in it. Found: {listed}")
    main = max(groups, key=lambda key: len(groups[key]))
    clock = np.array([stamp for stamp, _ in groups[main]])
    columns: dict[str, np.ndarray] = {}
    for key in sorted(groups, key=lambda key: -len(groups[key])):
        for name, (stamps, values) in _courses(key[1], groups[key]).items():
            # A joint that several topics tell of is taken from the one that tells most often.
            if name not in columns:
                columns[name] = (
                    values if key == main and values.size == clock.size else np.interp(clock, stamps, values)
                )
    return pa.table({"time": clock - clock[0], **columns})


def _messages(file: Path) -> Iterator[tuple[str, str, float, Any]]:
    try:
        with file.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            for schema, channel, message in reader.iter_messages():
                kind = schema.name if schema is not None else channel.message_encoding
                if kind != JOINT_STATE or schema is None:
                    yield channel.topic, kind, 0.0, None
                    continue
                decode = DecoderFactory().decoder_for(channel.message_encoding, schema)
                if decode is None:
                    raise LogError(
                        f"{file}: joint states encoded as '{channel.message_encoding}'; ROS 2's 'cdr' is read"
                    )
                state = decode(message.data)
                own = state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec
                yield channel.topic, kind, own or 1e-9 * message.log_time, state
    except (McapError, OSError, ValueError) as error:
        raise LogError(f"{file}: not a readable MCAP file: {str(error).splitlines()[0]}") from None


def _courses(names: tuple[str, ...], messages: list[Stamped]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    out = {}
    for field in FIELDS:
        told = [(stamp, getattr(message, field)) for stamp, message in messages]
        told = [(stamp, values) for stamp, values in told if len(values) == len(names)]
        if told:
            stamps = np.array([stamp for stamp, _ in told])
            values = np.array([values for _, values in told], dtype=np.float64)
            for i, name in enumerate(names):
                if np.all(np.isfinite(values[:, i])):  # drivers fill what they do not measure with NaN
                    out[f"{field}.{name}"] = stamps, values[:, i]
    return out
