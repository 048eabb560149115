"""The same log, however it is kept: NumPy, MATLAB, HDF5, ROS 2 bags, LeRobot datasets, foreign column names."""

from __future__ import annotations

import functools
import io
import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from mcap_ros2.writer import Writer
from scipy.io import savemat

from mjfriction.errors import LogError
from mjfriction.record.mapping import Mapping, Source, guess_mapping, read_mapping
from mjfriction.record.readers import READERS, read_log, read_table

JOINTS = ("shoulder", "elbow")
JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


@functools.cache
def columns() -> dict[str, np.ndarray]:
    time = np.arange(400) / 200.0
    out = {"time": time}
    for i, joint in enumerate(JOINTS):
        out[f"position.{joint}"] = 0.5 * np.sin((2.0 + i) * time)
        out[f"effort.{joint}"] = 3.0 * np.cos((2.0 + i) * time) + i
    return out


def matrix(quantity: str) -> np.ndarray:
    return np.column_stack([columns()[f"{quantity}.{joint}"] for joint in JOINTS])


def npz(path: Path) -> Path:
    np.savez(path / "log.npz", **columns())
    return path / "log.npz"


def npz_of_matrices(path: Path) -> Path:
    named = {"position": matrix("position"), "effort": matrix("effort").T, "joint_names": np.array(JOINTS)}
    np.savez(path / "log.npz", time=columns()["time"], **named)
    return path / "log.npz"


def mat(path: Path) -> Path:
    savemat(path / "log.mat", {name.replace(".", "_"): values for name, values in columns().items()})
    return path / "log.mat"


def mat_of_a_struct(path: Path) -> Path:
    log = {"time": columns()["time"], "position": matrix("position"), "effort": matrix("effort")}
    savemat(path / "log.mat", {"log": {**log, "joint_names": np.array(JOINTS, dtype=object)}})
    return path / "log.mat"


def hdf5(path: Path) -> Path:
    with h5py.File(path / "log.h5", "w") as file:
        for name, values in columns().items():
            file["run/" + name.replace(".", "/")] = values
    return path / "log.h5"


def mat_of_hdf5(path: Path) -> Path:
    with h5py.File(path / "log.mat", "w", userblock_size=512) as file:
        for name, values in columns().items():
            file[name.replace(".", "_")] = values[None, :]
    return path / "log.mat"


def write_bag(
    path: Path, told: Sequence[tuple[str, Sequence[str], Sequence[int]]], bare: dict[str, float] | None = None
) -> Path:
    """A bag of joint states: (topic, joints, rows) each a series of messages.

    Topics that are ``bare`` have no efforts, and positions that are so much higher.
    """
    stream = io.BytesIO()
    writer = Writer(stream)
    schema = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
    messages = sorted((row, topic, joints) for topic, joints, rows in told for row in rows)
    for row, topic, joints in messages:
        stamp = columns()["time"][row] + 100.0
        whole = int(stamp)
        message = {
            "header": {"stamp": {"sec": whole, "nanosec": round(1e9 * (stamp - whole))}, "frame_id": ""},
            "name": list(joints),
            "position": [columns()[f"position.{joint}"][row] + (bare or {}).get(topic, 0.0) for joint in joints],
            "velocity": [],
            "effort": [] if topic in (bare or {}) else [columns()[f"effort.{joint}"][row] for joint in joints],
        }
        writer.write_message(topic, schema, message, log_time=int(1e9 * stamp), publish_time=int(1e9 * stamp))
    writer.finish()
    path.write_bytes(stream.getvalue())
    return path


def bag(path: Path) -> Path:
    return write_bag(path / "bag.mcap", [("/joint_states", ("elbow", "shoulder"), range(400))])


def bag_in_a_folder(path: Path) -> Path:
    (path / "bag").mkdir()
    write_bag(path / "bag" / "bag_0.mcap", [("/joint_states", JOINTS, range(200))])
    write_bag(path / "bag" / "bag_1.mcap", [("/joint_states", JOINTS, range(200, 400))])
    return path / "bag"


@pytest.mark.parametrize("write", [npz, npz_of_matrices, mat, mat_of_a_struct, hdf5, mat_of_hdf5, bag, bag_in_a_folder])
def test_a_log_is_the_same_however_it_is_kept(write: Callable[[Path], Path], tmp_path: Path) -> None:
    log = read_log(write(tmp_path))
    assert set(log.joints) == set(JOINTS)
    np.testing.assert_allclose(log.time, columns()["time"], atol=1e-6)
    for name in list(columns())[1:]:
        np.testing.assert_allclose(log.columns[name], columns()[name], atol=1e-9)


def test_joints_in_topics_of_their_own_are_brought_together(tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    slow = range(0, 400, 2)
    log = read_log(write_bag(path, [("/arm", ("shoulder",), range(400)), ("/gripper", ("elbow",), slow)]))
    # The gripper's last message is the last but one of the arm's: from there on nothing is known of it.
    assert log.time.size == 399
    np.testing.assert_allclose(log.columns["position.shoulder"], columns()["position.shoulder"][:399], atol=1e-9)
    np.testing.assert_allclose(log.columns["position.elbow"], columns()["position.elbow"][:399], atol=1e-4)


@pytest.mark.parametrize(("topic", "has_effort"), [("/aaa/joint_commands", True), ("/aaa", False)])
def test_of_two_topics_the_one_that_measures_is_read(topic: str, has_effort: bool, tmp_path: Path) -> None:
    told = [(topic, JOINTS, range(400)), ("/joint_states", JOINTS, range(0, 400, 2))]
    bare = {} if has_effort else {topic: 0.3}
    log = read_log(write_bag(tmp_path / "bag.mcap", told, bare))
    assert log.time.size == 200
    np.testing.assert_allclose(log.columns["position.elbow"], columns()["position.elbow"][::2], atol=1e-9)


def test_what_was_commanded_is_no_measurement_where_nothing_else_has_it(tmp_path: Path) -> None:
    told = [("/arm/des", JOINTS, range(400)), ("/joint_states", JOINTS, range(400))]
    log = read_log(write_bag(tmp_path / "bag.mcap", told, {"/joint_states": 0.0}))
    assert set(log.columns) == {f"position.{joint}" for joint in JOINTS}


def test_a_message_of_something_else_does_not_cut_a_log_short(tmp_path: Path) -> None:
    told = [("/joint_states", ("shoulder",), range(400)), ("/gripper", ("elbow",), [7])]
    log = read_log(write_bag(tmp_path / "bag.mcap", told))
    assert log.joints == ("shoulder",)
    assert log.time.size == 400


def test_joints_may_change_their_order_and_files_theirs(tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    for k in range(12):  # named so that their alphabet is not their order
        rows = range(k * 33, (k + 1) * 33)
        turned = JOINTS[::-1] if k % 2 else JOINTS
        write_bag(tmp_path / "bag" / f"bag_{k}.mcap", [("/joint_states", turned, rows)])
    log = read_log(tmp_path / "bag")
    assert log.time.size == 396
    np.testing.assert_allclose(log.columns["position.elbow"], columns()["position.elbow"][:396], atol=1e-9)


@pytest.mark.parametrize("kind", ["npz", "h5"])
def test_one_joint_alone_in_a_matrix(kind: str, tmp_path: Path) -> None:
    arrays = {"time": columns()["time"], "position": matrix("position")[:, :1], "effort": matrix("effort")[:, :1]}
    path = tmp_path / f"log.{kind}"
    if kind == "npz":
        np.savez(path, **arrays, joint_names=np.array("slide"))
    else:
        with h5py.File(path, "w") as file:
            for name, values in arrays.items():
                file[name] = values.astype(">f8")  # as another machine may have written it
            file["joint_names"] = "slide"
    log = read_log(path)
    assert log.joints == ("slide",)
    np.testing.assert_allclose(log.columns["effort.slide"], columns()["effort.shoulder"])


def test_two_arms_in_one_file_are_not_mixed(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["time"] = columns()["time"]
        for side in ("left", "right"):
            file[f"{side}/position"] = matrix("position")
    with pytest.raises(LogError, match="two datasets are called 'position'"):
        read_log(tmp_path / "log.h5")


def test_a_gap_in_a_bag_stays_a_gap(tmp_path: Path) -> None:
    rows = [*range(150), *range(250, 400)]
    log = read_log(write_bag(tmp_path / "bag.mcap", [("/joint_states", JOINTS, rows)]))
    assert log.time.size == 300
    assert np.max(np.diff(log.time)) == pytest.approx(0.505, abs=1e-6)


def test_a_bag_without_joint_states_says_what_it_has(tmp_path: Path) -> None:
    stream = io.BytesIO()
    writer = Writer(stream)
    schema = writer.register_msgdef("std_msgs/msg/Empty", "uint8 structure_needs_at_least_one_member\n")
    writer.write_message("/nothing", schema, {"structure_needs_at_least_one_member": 0})
    writer.finish()
    (tmp_path / "bag.mcap").write_bytes(stream.getvalue())
    with pytest.raises(LogError, match=r"no joint states .* Found: /nothing \(std_msgs/msg/Empty\)"):
        read_log(tmp_path / "bag.mcap")


def test_a_lerobot_dataset_comes_in_episodes_with_its_own_names(tmp_path: Path) -> None:
    folder = tmp_path / "data" / "chunk-000"
    folder.mkdir(parents=True)
    (tmp_path / "meta").mkdir()
    info = {"features": {"observation.state": {"names": ["shoulder.pos", "elbow.pos"]}}}
    (tmp_path / "meta" / "info.json").write_text(json.dumps(info))
    time = np.concatenate([columns()["time"][:200]] * 2)
    table = pa.table(
        {
            "timestamp": time.astype(np.float32),
            "episode_index": np.repeat([0, 1], 200),
            "observation.state": pa.array(list(matrix("position")), type=pa.list_(pa.float64())),
            "observation.effort": pa.array(list(matrix("effort")), type=pa.list_(pa.float64())),
            "action": pa.array(list(matrix("position")), type=pa.list_(pa.float64())),
        }
    )
    pyarrow.parquet.write_table(table, folder / "file-000.parquet")
    log = read_log(folder / "file-000.parquet")
    assert log.joints == JOINTS
    assert log.segment.tolist() == [0] * 200 + [1] * 200
    np.testing.assert_allclose(log.columns["effort.elbow"], columns()["effort.elbow"])


@pytest.mark.parametrize("suffix", sorted(READERS))
def test_what_cannot_be_read_is_one_line(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"log{suffix}"
    path.write_bytes(b"\x00\x01this is no log\n\xff\xfe")
    with pytest.raises(LogError) as caught:
        read_log(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_pickles_are_not_opened(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", time=columns()["time"], position=np.array([{"a": 1}], dtype=object))
    with pytest.raises(LogError, match="not a readable NumPy archive"):
        read_log(tmp_path / "log.npz")


def test_matrices_need_a_name_for_every_column(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", time=columns()["time"], position=matrix("position"), joints=np.array(["one"]))
    with pytest.raises(LogError, match="'position' has 2 columns for 1 joints"):
        read_log(tmp_path / "log.npz")


FOREIGN = [
    ("t", "q0", "q1", "tau0", "tau1", "q_ref0"),
    ("Time (ms)", "actual_q_1", "actual_q_2", "actual_effort_1", "actual_effort_2", "target_q_1"),
    ("timestamp", "shoulder_pos_deg", "elbow_pos_deg", "shoulder_torque", "elbow_torque", "cmd_shoulder_pos"),
    ("time_ns", "jointPos1", "jointPos2", "motorTorque1", "motorTorque2", "desiredPos1"),
    ("t", "q1_mrad", "q2_mrad", "tau_q1", "tau_q2", "q1_cmd"),
]
SCALE = {"ms": 1e3, "ns": 1e9, "deg": 180.0 / np.pi, "mrad": 1e3}


def foreign(names: tuple[str, ...]) -> dict[str, np.ndarray]:
    out = {}
    for name, values in zip(names, columns().values(), strict=False):
        unit = next((scale for word, scale in SCALE.items() if f"_{word}" in name or f"({word})" in name), 1.0)
        out[name] = unit * values
    return out | {names[-1]: np.zeros(400)}


def ordered(names: tuple[str, ...]) -> tuple[str, ...]:
    # columns() goes joint by joint; the foreign lists quantity by quantity.
    return (names[0], names[1], names[3], names[2], names[4], names[5])


@pytest.mark.parametrize("names", FOREIGN)
def test_foreign_names_are_guessed_with_their_units(names: tuple[str, ...], tmp_path: Path) -> None:
    table = pa.table(foreign(ordered(names)))
    guess = guess_mapping(table.schema.names, JOINTS)
    assert set(guess.sources) == set(columns())
    assert names[-1] not in {source.column for source in guess.sources.values()}
    told = guess.applied(table, "log")
    for name, values in columns().items():
        np.testing.assert_allclose(told[name].to_numpy(), values, rtol=1e-9, atol=1e-12)
    (tmp_path / "map.toml").write_text(guess.text())
    assert read_mapping(tmp_path / "map.toml") == guess


def test_units_go_with_their_quantity() -> None:
    names = [
        "time",
        "current_1 (mA)",
        "temp_1_degC",
        "temperature_2 [deg C]",
        "vel_q1",
        "q1",
        "torque_1_Nmm",
        "pos_a",
        "tau_a",
    ]
    guess = guess_mapping(names, ("shoulder", "elbow", "a")).sources
    assert guess["current.shoulder"].scale == 1e-3
    assert guess["temperature.shoulder"].scale == guess["temperature.elbow"].scale == 1.0
    assert (guess["velocity.shoulder"].column, guess["position.shoulder"].column) == ("vel_q1", "q1")
    assert guess["effort.shoulder"].scale == 1e-3
    assert (guess["position.a"].column, guess["effort.a"].column) == ("pos_a", "tau_a")


def test_every_quantity_counts_joints_its_own_way() -> None:
    names = ["t", "actual_q_0 [deg]", "actual_q_1 [deg]", "Torque J1 (Nm)", "Torque J2 (Nm)"]
    guess = guess_mapping(names, JOINTS).sources
    assert guess["position.shoulder"].column == "actual_q_0 [deg]"
    assert guess["effort.shoulder"].column == "Torque J1 (Nm)"
    assert guess["effort.elbow"].column == "Torque J2 (Nm)"


def test_matrices_by_other_names_can_be_guessed(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", t=columns()["time"], q=matrix("position"), tau=matrix("effort"))
    table = read_table(tmp_path / "log.npz")
    log = read_log(tmp_path / "log.npz", guess_mapping(table.schema.names, JOINTS))
    np.testing.assert_allclose(log.columns["effort.elbow"], columns()["effort.elbow"])


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
def test_text_of_spreadsheets_is_read_whatever_its_encoding(encoding: str, tmp_path: Path) -> None:
    rows = "\n".join(f"{0.01 * k:.2f};{0.1 * k:.2f};{0.2 * k:.2f};21" for k in range(200))
    path = tmp_path / "log.csv"
    path.write_bytes(
        f"time;position.a;effort.a;Öl [°C]\n{rows}\n".replace(".", ",").replace(",a;", ".a;").encode(encoding)
    )
    log = read_log(path)
    np.testing.assert_allclose(log.columns["effort.a"], 0.2 * np.arange(200), atol=1e-9)
    assert "Öl [°C]" in log.columns


@pytest.mark.parametrize("raw", [b"\xff\xfeabc", b"time;position.a\n\x81\x8d;\x00\n"])
def test_what_is_no_text_is_said_in_a_line(raw: bytes, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_bytes(raw)
    with pytest.raises(LogError, match="log.csv: "):
        read_log(tmp_path / "log.csv")


def test_a_comma_in_a_name_does_not_make_decimals_commas(tmp_path: Path) -> None:
    rows = "\n".join(f"{0.01 * k:.2f};{0.1 * k:.2f};{0.2 * k:.2f};left, then right" for k in range(200))
    path = tmp_path / "log.csv"
    path.write_text(f"time;position.a;effort.a;note (where, how)\n{rows}\n")
    np.testing.assert_allclose(read_log(path).columns["effort.a"], 0.2 * np.arange(200), atol=1e-9)


@pytest.mark.parametrize(("mark", "point"), [(";", "."), (";", ","), ("\t", ".")])
def test_tables_parted_otherwise(mark: str, point: str, tmp_path: Path) -> None:
    rows = [mark.join(columns())]
    table = zip(*columns().values(), strict=True)
    rows += [mark.join(f"{value:.9f}".replace(".", point) for value in row) for row in table]
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    log = read_log(tmp_path / "log.csv")
    np.testing.assert_allclose(log.columns["position.elbow"], columns()["position.elbow"], atol=1e-8)


def test_nanoseconds_since_1970_are_read() -> None:
    stamps = 1_760_000_000_000_000_123 + 5_000_000 * np.arange(3)
    told = guess_mapping(["timestamp_ns"], ()).applied(pa.table({"timestamp_ns": stamps}), "log")
    np.testing.assert_allclose(np.diff(told["time"].to_numpy()), 0.005, atol=1e-6)


def test_a_mapping_scales_and_shifts(tmp_path: Path) -> None:
    text = 'time = "t"\n"position.elbow" = { column = "q", scale = 2.0, offset = 1.0 }\n'
    (tmp_path / "map.toml").write_text(text)
    told = read_mapping(tmp_path / "map.toml").applied(pa.table({"t": [0, 1], "q": [3, 4], "x": [0, 0]}), "log")
    assert told.to_pydict() == {"time": [0, 1], "position.elbow": [7.0, 9.0]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time = ", "not valid TOML"),
        ("time = 3", "'time': a column's name is allowed"),
        ('"position.elbow" = { colunm = "q" }', "'position.elbow': a column's name is allowed"),
        ('"angle.elbow" = "q"', "'angle.elbow' is no column of a log; allowed are time, segment and position"),
    ],
)
def test_wrong_mappings_are_one_line(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(LogError, match=message) as caught:
        read_mapping(tmp_path / "map.toml")
    assert "\n" not in str(caught.value)


def test_a_mapping_of_columns_that_are_not_there() -> None:
    mapping = Mapping({"time": Source(column="timestmp")})
    with pytest.raises(LogError, match="no column 'timestmp' for 'time'; did you mean 'timestamp'"):
        mapping.applied(pa.table({"timestamp": [0.0]}), "log")


def test_no_reader_is_loaded_before_it_is_asked_for() -> None:
    code = "import mjfriction.record.readers, sys; print([n for n in ('h5py', 'mcap', 'scipy.io') if n in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
