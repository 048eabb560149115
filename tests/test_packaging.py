"""What is shipped: the wheel holds robots, models, demo and schema; the lock names no index."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def test_the_wheel_holds_everything_a_user_needs(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        archive.extractall(tmp_path / "site")
    for name in (
        "bundled/robots/ur5/robot.toml",
        "bundled/models_xml/linear_axis.xml",
        "bundled/demo/log.parquet",
        "bundled/demo/other_motion.parquet",
        "py.typed",
        "report/report.schema.json",
        "report/templates/report.html.j2",
    ):
        assert f"mjfriction/{name}" in names
    code = "from mjfriction.robot.files import read_robot; print(read_robot('linear_axis').body().joints)"
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path / "site"
    )
    assert run.stdout.strip() == "('axis',)"


def test_the_lock_pins_by_hash_and_names_no_index() -> None:
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    assert "://" not in lock
    pinned = re.findall(r"^[a-z0-9._-]+==", lock, flags=re.MULTILINE)
    assert len(pinned) > 30
    assert lock.count("--hash=sha256:") >= len(pinned)
    assert not re.search(r"^-", lock, flags=re.MULTILINE)
