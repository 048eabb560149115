"""What a log must hold, and what is said when it does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
import pytest

from mjfriction.errors import LogError
from mjfriction.record.log import check_joints
from mjfriction.record.merge import merge_logs
from mjfriction.record.readers import read_log


def columns(rows: int = 200) -> dict[str, np.ndarray]:
    time = np.arange(rows) * 0.01
    return {"time": time, "position.a": np.sin(time), "effort.a": np.cos(time)}


def write(folder: Path, table: dict[str, object], name: str = "log.parquet") -> Path:
    path = folder / name
    if path.suffix == ".csv":
        pyarrow.csv.write_csv(pa.table(table), path)
    else:
        pyarrow.parquet.write_table(pa.table(table), path)
    return path


@pytest.mark.parametrize("name", ["log.csv", "log.parquet", "LOG.PARQUET"])
def test_formats_read_alike(tmp_path: Path, name: str) -> None:
    table = columns() | {"note": ["x"] * 200, "temperature.a": np.full(200, 30)}
    path = tmp_path / name
    written = write(tmp_path, table, name.lower())
    written.rename(path)
    log = read_log(path)
    assert log.joints == ("a",)
    np.testing.assert_allclose(log.time, table["time"], rtol=1e-12)
    np.testing.assert_allclose(log.columns["effort.a"], table["effort.a"], rtol=1e-12)
    assert log.columns["temperature.a"].dtype == np.float64
    assert "note" not in log.columns
    assert log.segment.tolist() == [0] * 200


def nan_at_row(row: int) -> dict[str, np.ndarray]:
    table = columns()
    table["position.a"] = table["position.a"].copy()
    table["position.a"][row] = np.nan
    return table


def doubled(row: int) -> dict[str, np.ndarray]:
    table = columns()
    table["time"] = table["time"].copy()
    table["time"][row] = table["time"][row - 1]
    return table


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({k: v[:0] for k, v in columns().items()}, "the table is empty"),
        ({k: v[:2] for k, v in columns().items()}, "2 rows are too few"),
        ({k: v for k, v in columns().items() if k != "time"}, "column 'time' is missing.*Found: position.a, effort.a"),
        ({"tme" if k == "time" else k: v for k, v in columns().items()}, "did you mean 'tme'"),
        ({k: v for k, v in columns().items() if k != "position.a"}, "no 'position.<joint>' column"),
        (doubled(50), "row 51: time 0.49 s is doubled"),
        (columns() | {"time": columns()["time"][::-1]}, "runs backwards"),
        (nan_at_row(7), "row 8, column 'position.a' is nan"),
        (columns() | {"effort.a": ["12 Nm"] * 200}, "column 'effort.a' holds '12 Nm', which is not a number"),
        (columns() | {"segment": np.full(200, 0.5)}, "'segment' must hold whole numbers"),
        (columns() | {"held_mass": np.full(200, -1.0)}, "row 1, column 'held_mass' is -1; a mass is 0 kg or more"),
        (columns() | {"temperature.a": np.full(200, np.nan)}, "row 1, column 'temperature.a' is nan"),
    ],
)
def test_a_wrong_table_is_named(tmp_path: Path, table: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(LogError, match=message) as caught:
        read_log(write(tmp_path, table))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("gripper_width", np.where(np.arange(200) < 5, np.nan, 0.02)),
        ("gripper.open", np.arange(200) < 100),
        ("robot.mode", ["running"] * 200),
        ("position_cmd.a", np.sin(np.arange(200))),
        ("position_raw.a", np.sin(np.arange(200))),
        ("velocity_des.a", np.sin(np.arange(200))),
        ("current_q.a", np.sin(np.arange(200))),
    ],
)
def test_columns_of_which_the_format_does_not_speak_do_no_harm(
    tmp_path: Path, name: str, values: np.ndarray | list[str]
) -> None:
    log = read_log(write(tmp_path, columns() | {name: values}))
    check_joints(log, "robot", ("a",))
    assert (name in log.columns) == (
        isinstance(values, np.ndarray) and values.dtype == float and values[0] == values[0]
    )


def test_a_misspelt_column_that_the_log_lacks_is_named(tmp_path: Path) -> None:
    log = read_log(write(tmp_path, columns() | {"velocty.a": np.cos(np.arange(200))}))
    with pytest.raises(LogError, match=r"column 'velocty.a' is not of the format.*did you mean 'velocity.a'"):
        check_joints(log, "robot", ("a",))


@pytest.mark.parametrize(
    ("head", "row", "message"),
    [
        ("time,position.a,effort.a, effort.a", "{t},0.1,1.0,2.0", "column 'effort.a' is there 2 times"),
        ("time,position.a,effort.a", "{t},0.1,", "column 'effort.a' is empty"),
    ],
)
def test_a_column_that_is_there_twice_or_empty_is_named(head: str, row: str, message: str, tmp_path: Path) -> None:
    rows = [row.format(t=0.01 * k) for k in range(200)]
    (tmp_path / "log.csv").write_text("\n".join([head, *rows]) + "\n")
    with pytest.raises(LogError, match=message):
        read_log(tmp_path / "log.csv")


def test_a_wrong_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no such file"):
        read_log(tmp_path / "absent.csv")
    with pytest.raises(LogError, match="cannot read a '.xlsx' file as a log; allowed are .csv, .parquet"):
        read_log(tmp_path / "log.xlsx")
    broken = tmp_path / "broken.parquet"
    broken.write_bytes(b"not parquet")
    with pytest.raises(LogError, match="not a readable Parquet table"):
        read_log(broken)


def test_time_may_start_again_in_a_new_segment(tmp_path: Path) -> None:
    table = columns()
    table["time"] = np.tile(table["time"][:100], 2)
    table["segment"] = np.repeat([4, 9], 100)
    assert read_log(write(tmp_path, table)).segment.tolist() == [4] * 100 + [9] * 100


@pytest.mark.parametrize(("worth", "unit"), [(1e-3, "milliseconds"), (1e-6, "microseconds"), (1e-9, "nanoseconds")])
def test_a_clock_that_ticks_faster_than_seconds_is_read_as_that(tmp_path: Path, worth: float, unit: str) -> None:
    table = columns()
    plain = read_log(write(tmp_path, table))
    fast = read_log(write(tmp_path, {**table, "time": table["time"] / worth}))
    assert plain.faults == ()
    np.testing.assert_allclose(fast.time, plain.time, rtol=1e-12)
    (fault,) = fast.faults
    assert (fault.kind, fault.where) == ("data.unit", "time")
    assert unit in fault.action
    slow = read_log(write(tmp_path, {**table, "time": 50.0 * table["time"]}))  # 0.5 s: too slow, but no other unit
    assert slow.faults == ()


def test_a_log_of_a_row_every_few_seconds_is_not_read_as_a_fast_one(tmp_path: Path) -> None:
    table = columns()
    seconds = 300.0 * table["time"]  # a row every 3 s
    wide = {**table, "time": seconds, "position.a": np.sin(seconds)}  # in milliseconds some hundred rad/s
    np.testing.assert_allclose(read_log(write(tmp_path, wide)).time, seconds, rtol=1e-12)
    little = {**wide, "position.a": 0.05 * wide["position.a"]}
    assert read_log(write(tmp_path, little)).time[-1] == pytest.approx(1e-3 * seconds[-1], rel=1e-12)


def test_joints_are_held_against_the_robot(tmp_path: Path) -> None:
    log = read_log(write(tmp_path, columns()))
    check_joints(log, "arm", ("a",))
    with pytest.raises(LogError, match="log of another robot: it has joints a, robot 'arm' has left, right"):
        check_joints(log, "arm", ("left", "right"))
    with pytest.raises(LogError, match="'position.b' is missing"):
        check_joints(log, "arm", ("a", "b"))
    two = read_log(write(tmp_path, columns() | {"position.elbw": columns()["time"]}))
    with pytest.raises(LogError, match="'position.elbow' is missing; did you mean 'position.elbw'"):
        check_joints(two, "arm", ("a", "elbow"))
    numbered = read_log(write(tmp_path, {**columns(), "position.joint1": columns()["time"]}))
    with pytest.raises(LogError, match=r"'position.joint2' is missing\. Found"):
        check_joints(numbered, "arm", ("a", "joint2"))
    # A gripper that the robot file leaves out comes along in most logs.
    gripper = {f"{quantity}.gripper": np.cos(np.arange(200)) for quantity in ("position", "velocity", "effort")}
    check_joints(read_log(write(tmp_path, columns() | gripper)), "arm", ("a",))
    silent = read_log(write(tmp_path, {k: v for k, v in columns().items() if k != "effort.a"}))
    with pytest.raises(LogError, match=r"no 'effort.<joint>' or 'current.<joint>' column"):
        check_joints(silent, "arm", ("a",))
    stray = read_log(write(tmp_path, columns() | {"effort.b": columns()["time"]}))
    with pytest.raises(LogError, match="column 'effort.b': robot 'arm' has no joint 'b'"):
        check_joints(stray, "arm", ("a",))


def test_logs_of_one_robot_join_as_segments(tmp_path: Path) -> None:
    one = read_log(write(tmp_path, columns(), "one.parquet"))
    two = read_log(write(tmp_path, columns(150) | {"extra": np.zeros(150)}, "two.csv"))
    both = merge_logs([one, two])
    assert both.segment.tolist() == [0] * 200 + [1] * 150
    assert both.time.size == 350
    assert "extra" not in both.columns
    other = read_log(write(tmp_path, {"time": one.time, "position.b": one.time, "effort.b": one.time}, "o.csv"))
    with pytest.raises(LogError, match="diagnose logs of one robot together"):
        merge_logs([one, other])
    # A log of fewer rows a second would look like nothing but gaps.
    slow = columns() | {"time": 5.0 * columns()["time"]}
    with pytest.raises(LogError, match="slow.csv: has a row every .* ms; resample the faster one"):
        merge_logs([one, read_log(write(tmp_path, slow, "slow.csv"))])
