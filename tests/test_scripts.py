"""The scripts that users begin from do what they print."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from scripts import many_models, own_robot, report_to_controller


@pytest.fixture
def printed(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    def run(script, *words: str) -> str:
        monkeypatch.setattr("sys.argv", [script.__name__, *words])
        script.main()
        return capsys.readouterr().out

    return run


def test_own_robot(printed, tmp_path: Path) -> None:
    said = printed(own_robot, str(tmp_path / "own"), "--seconds", "20")
    assert "The model of 'z1' lacks friction.load at joint3;" in said
    (value,) = re.findall(r"load = ([\d.]+)", said)
    assert float(value) == pytest.approx(0.1, rel=0.05)
    assert {"report.html", "robot.toml"} <= {path.name for path in (tmp_path / "own/result").iterdir()}


@pytest.mark.deep
def test_many_models(printed) -> None:
    said = printed(many_models, "--count", "24")
    stated, identified, low, high = (float(x) for x in re.findall(r"(0\.\d{4})\b", said.split("rad:")[1]))
    assert low < identified < high
    assert abs(high - low) < 0.1 * identified
    assert stated != identified


@pytest.mark.deep
def test_report_to_controller(printed) -> None:
    said = printed(report_to_controller, "--seconds", "20")
    strays = {name: (float(a), float(b)) for name, a, b in re.findall(r"(\w+_joint) +([\d.]+) +([\d.]+)", said)}
    before, after = strays["elbow_joint"]
    assert after < 0.1 * before
    assert max(after for _, after in strays.values()) < 0.1 * max(before for before, _ in strays.values())
