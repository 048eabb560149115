"""Numbers that are read and kept: a clock that counts since 1970 loses none of its seconds."""

from __future__ import annotations

import json

from mjfriction.report.digits import digits, kept, percentage
from mjfriction.report.result import ParameterEntry

MOMENT = 1700000024.25


def test_a_moment_is_told_to_the_millisecond_and_all_else_in_four_digits() -> None:
    assert digits(MOMENT, "s") == "1700000024.250"
    assert digits(24.2512, "s") == "24.25"
    assert digits(1234567.0, "N/m") == "1.235e+06"
    assert (kept(MOMENT), kept(0.123456789), kept(1234567.8)) == (MOMENT, 0.1234568, 1234568.0)


def test_next_to_nothing_has_no_sign() -> None:
    assert [percentage(share) for share in (-0.004, 0.004, -0.016, 0.784)] == ["0", "0", "-2", "78"]


def test_a_step_on_such_a_clock_is_kept_in_the_report() -> None:
    entry = ParameterEntry(name="time", value=MOMENT, ci95=(MOMENT - 0.5, MOMENT + 0.5), unit="s", meaning="moment")
    told = json.loads(entry.model_dump_json())
    assert (told["value"], told["ci95"]) == (MOMENT, [MOMENT - 0.5, MOMENT + 0.5])
