"""The house: imports run down its floors, and heavy libraries stay in their rooms."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import mjfriction

PACKAGE = Path(mjfriction.__file__).parent
FLOOR = {
    "errors": 0,
    "parameter": 0,
    "progress": 0,
    "laws": 1,
    "record": 2,
    "body": 2,
    "sim": 2,
    "robot": 3,
    "plant": 3,
    "control": 3,
    "identify": 4,
    "reproduce": 5,
    "diagnose": 5,
    "benchmark": 6,
    "report": 6,
    "cli": 7,
}
# The rooms of the diagnosis, from the ground up.
DIAGNOSE = ["faults", "causes", "fit", "search", "settle", "tell", "diagnosis"]
ONLY_IN = {
    "pinocchio": {"body"},
    "mujoco": {"sim"},
    "rerun": {"report"},
    "plotly": {"report"},
    "numba": {"laws", "sim", "control"},
    "llvmlite": {"laws", "sim"},
}


def imports() -> list[tuple[Path, str]]:
    found = []
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found += [(path, alias.name) for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                found.append((path, node.module or ""))
    return found


def room(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def test_imports_go_down_only() -> None:
    wrong = []
    for path, name in imports():
        parts = name.split(".")
        if parts[0] != "mjfriction" or len(parts) < 2 or room(path) in ("__init__", "__main__"):
            continue
        here, there = room(path), parts[1]
        sideways = here != there and FLOOR[here] == FLOOR[there] in (2,)
        if FLOOR[there] > FLOOR[here] or sideways:
            wrong.append(f"{path.relative_to(PACKAGE)} imports {name}")
    assert not wrong


def test_the_rooms_of_the_diagnosis_have_floors_too() -> None:
    wrong, diagnose = [], PACKAGE / "diagnose"
    for path, name in imports():
        parts = name.split(".")
        if (
            path.is_relative_to(diagnose)
            and parts[:2] == ["mjfriction", "diagnose"]
            and path != diagnose / "__init__.py"
        ):
            here = path.relative_to(diagnose).parts[0].removesuffix(".py")
            if DIAGNOSE.index(parts[2]) > DIAGNOSE.index(here):
                wrong.append(f"{path.relative_to(PACKAGE)} imports {name}")
    assert not wrong


def test_the_benchmark_and_the_diagnosis_know_nothing_of_each_other() -> None:
    judges, judged = {"benchmark"}, {"diagnose", "identify"}
    seen = {(room(path), name.split(".")[1]) for path, name in imports() if name.startswith("mjfriction.")}
    assert {pair for pair in seen if pair[0] in judged and pair[1] in judges} == set()
    assert {pair for pair in seen if pair[0] in judges and pair[1] in judged} == set()


def test_heavy_libraries_stay_in_their_rooms() -> None:
    wrong = [
        f"{path.relative_to(PACKAGE)} imports {name}"
        for path, name in imports()
        if name.split(".")[0] in ONLY_IN and room(path) not in ONLY_IN[name.split(".")[0]]
    ]
    assert not wrong


@pytest.mark.parametrize("statement", ["import mjfriction", "import mjfriction.cli.main"])
def test_import_loads_nothing_heavy(statement: str) -> None:
    heavy = ["mujoco", "pinocchio", "rerun", "numba", "numpy", "scipy", "plotly", "pydantic", "pyarrow"]
    code = f"{statement}; import sys; print([name for name in {heavy} if name in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_everything_promised_is_there() -> None:
    for name in mjfriction.__all__:
        assert getattr(mjfriction, name).__doc__
    assert set(mjfriction.__all__) <= set(dir(mjfriction))
    with pytest.raises(AttributeError, match="no attribute 'diagnos'"):
        _ = mjfriction.diagnos  # type: ignore[attr-defined]
