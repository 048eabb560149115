"""A clock that starts again with each episode: the same diagnosis as of one that runs on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.diagnose.tell.outcome import Diagnosis
from mjfriction.record.clock_restarts import PAUSE
from mjfriction.record.readers.table import log_from_table
from mjfriction.report.result import make_report
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

ELBOW = 2


def test_episodes_that_each_begin_at_zero_are_diagnosed_as_if_the_clock_ran_on(tmp_path: Path) -> None:
    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: lambda at: 8.0 * at.q}), seed=4, seconds=25.0)
    table, stated = pq.read_table(log), read_robot(robot)
    time = table["time"].to_numpy()
    # The second is the shorter one: its rows end before the first's do.
    second = time >= 15.0
    begins = time[second][0]

    def diagnosed(clock: np.ndarray) -> Diagnosis:
        columns = {name: table[name] for name in table.schema.names}
        return diagnose_log(log_from_table(pa.table({**columns, "time": clock, "segment": second * 1}), "log"), stated)

    last = time[~second][-1]
    anew = diagnosed(np.where(second, time - begins, time))
    on = diagnosed(np.where(second, time - begins + last + PAUSE, time))
    assert [finding.cause for finding in anew.findings] == ["body.spring"]
    again, running = make_report(anew), make_report(on)
    assert again.findings == running.findings
    assert again.joints == running.joints
    (problem,) = again.data_problems
    assert (problem.kind, problem.where) == ("data.clock", "segment 1")
    assert not running.data_problems
