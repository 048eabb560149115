"""Several logs of one machine joined to one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mjfriction.errors import LogError
from mjfriction.record.clock_restarts import PAUSE
from mjfriction.record.log import JOINED, Log
from mjfriction.record.resample import read_clock

APART = 1.25  # highest ratio of the time steps of two logs that count as sampled at one rate


def merge_logs(logs: Sequence[Log]) -> Log:
    """Join logs of the same joints, each with segments of its own; columns that not all logs have are left out.

    The clock runs on: every log begins a pause after the end of the one before, so that changes between logs show over
    time.

    Raises :class:`LogError` when the logs have different joints or different sampling rates.
    """
    first = logs[0]
    if len(logs) == 1:
        return first
    for log in logs[1:]:
        if set(log.joints) != set(first.joints):
            raise LogError(
                f"{log.source}: has joints {', '.join(log.joints)}, but {first.source} has {', '.join(first.joints)}; "
                "diagnose logs of one robot together"
            )
    steps = [read_clock(log).step for log in logs]
    slow, fast = int(np.argmax(steps)), int(np.argmin(steps))
    if steps[slow] > APART * steps[fast]:
        raise LogError(
            f"{logs[slow].source}: has a row every {1e3 * steps[slow]:.3g} ms, but {logs[fast].source} every "
            f"{1e3 * steps[fast]:.3g} ms; resample the faster one, or take them one by one"
        )
    shared = [name for name in first.columns if all(name in log.columns for log in logs)]
    segments, times, offset, start = [], [], 0, float(first.time[0])
    for log in logs:
        times.append(log.time - log.time[0] + start)
        start = float(times[-1][-1]) + PAUSE
        numbered = np.cumsum(np.append(0, np.diff(log.segment) != 0))
        segments.append(numbered + offset)
        offset = int(segments[-1][-1]) + 1
    return Log(
        source=JOINED.join(log.source for log in logs),
        time=np.concatenate(times),
        segment=np.concatenate(segments),
        joints=first.joints,
        columns={name: np.concatenate([log.columns[name] for log in logs]) for name in shared},
        faults=tuple(replace(fault, where=f"{log.source}: {fault.where}") for log in logs for fault in log.faults),
        unusable={
            name: np.concatenate([log.unusable.get(name, np.zeros(log.time.size, dtype=bool)) for log in logs])
            for name in shared
            if any(name in log.unusable for log in logs)
        },
        joined=tuple((log.name, float(own[0])) for log, own in zip(logs, times, strict=True)),
    )
