"""Every Python block of the documentation runs, and the page of the interface is as the docstrings say."""

from __future__ import annotations

import ast
import re
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
import pytest

import mjfriction as mjf
from mjfriction.identify.usual_motions import plan_sawtooth
from mjfriction.plant.trajectory import Trajectory
from scripts.api_page import page

ROOT = Path(__file__).parents[1]
PAGES = sorted(
    str(path.relative_to(ROOT))
    for path in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))
    if "```python" in path.read_text(encoding="utf-8")
)
ARM = """<mujoco><worldbody><body>
<joint name="elbow" axis="0 1 0"/><geom type="capsule" size=".03" fromto="0 0 0 .3 0 0"/>
<body pos=".3 0 0"><joint name="wrist" axis="0 1 0"/><geom type="capsule" size=".02" fromto="0 0 0 .2 0 0"/></body>
</body></worldbody></mujoco>"""


def files_that_pages_speak_of(folder: Path, names: str) -> None:
    """Write the logs, robots and motions that code blocks read, of those only that are named."""
    shutil.copy(ROOT / "mjfriction/bundled/demo/log.parquet", folder / "run1.parquet")
    shutil.copy(ROOT / "robots/ur5/robot.toml", folder / "my_arm.toml")
    (folder / "arm.xml").write_text(ARM)
    joints = mjf.read_robot("comau_ns12" if "comau_ns12" in names else "ur5").joints
    time = np.linspace(0.0, 1.0, 51)
    swing = 0.05 * np.sin(np.pi * time)[:, None] ** 2 * np.ones(len(joints))
    pa.csv.write_csv(Trajectory(joints, time, swing).table(), folder / "motion.csv")
    if "turns.parquet" in names:
        table = mjf.read_robot("machine_table")
        turns = plan_sawtooth(table, ["axis"], amplitude=1e-4).trajectory
        pa.parquet.write_table(pa.table(mjf.simulate(table, turns)), folder / "turns.parquet")


def names_that_blocks_take_for_granted(namespace: dict[str, object]) -> None:
    """Add what a block uses without making it: a log's columns."""
    velocity = np.sin(np.arange(0.0, 2.0, 1e-3))
    namespace.update(position=np.cumsum(velocity) * 1e-3, force=2.5 * np.gradient(velocity, 1e-3))


def assigned(code: str) -> set[str]:
    """Return the names that code binds at its top level."""
    targets = [target for node in ast.parse(code).body if isinstance(node, ast.Assign) for target in node.targets]
    return {name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)}


@pytest.mark.parametrize("name", PAGES)
def test_every_python_block_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / name).read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    files_that_pages_speak_of(tmp_path, "\n".join(blocks))
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, object] = {}
    for block in blocks:
        names_that_blocks_take_for_granted(namespace)
        exec(compile(block, name, "exec"), namespace)
    for folder in re.findall(r'save_diagnosis\(\w+, "(\w+)"\)', "\n".join(blocks)):
        assert (tmp_path / folder / "report.html").is_file()
    assert namespace.keys() >= assigned("\n".join(blocks))


def test_the_page_of_the_interface_is_current() -> None:
    assert (ROOT / "docs/api.md").read_text(encoding="utf-8") == page(), "run python -m scripts.api_page"
