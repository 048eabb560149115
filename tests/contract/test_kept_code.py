"""Compiled code that was kept goes once a source has changed that another file's function was made from."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

import mjfriction
from mjfriction.laws.kept_code import KERNELS, let_go_of_stale_code


@pytest.fixture
def package(tmp_path: Path) -> Path:
    for room in KERNELS:
        (tmp_path / room / "__pycache__").mkdir(parents=True)
        (tmp_path / room / "kernel.py").write_text("one = 1\n")
    let_go_of_stale_code(tmp_path)
    for room in KERNELS:
        for kind in ("nbi", "nbc", "pyc"):
            (tmp_path / room / "__pycache__" / f"kernel.{kind}").write_text("code")
    return tmp_path


def kept(package: Path) -> int:
    return len(list(package.rglob("*.nb[ci]")))


def test_code_stays_while_the_sources_are_what_they_were(package: Path) -> None:
    let_go_of_stale_code(package)
    assert kept(package) == 2 * len(KERNELS)


@pytest.mark.parametrize("room", KERNELS)
def test_code_of_all_goes_once_a_source_has_changed(package: Path, room: str) -> None:
    file = package / room / "kernel.py"
    file.write_text("one = 2\n")
    os.utime(file, ns=(1, 1))  # as old as may be: another is another
    let_go_of_stale_code(package)
    assert kept(package) == 0
    assert len(list(package.rglob("*.pyc"))) == len(KERNELS)


def test_code_of_all_goes_once_a_source_was_added(package: Path) -> None:
    (package / KERNELS[0] / "another.py").write_text("two = 2\n")
    let_go_of_stale_code(package)
    assert kept(package) == 0


def test_a_package_that_may_not_be_written_to_is_left_alone(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError

    (package / KERNELS[0] / "another.py").write_text("two = 2\n")
    monkeypatch.setattr(Path, "unlink", refuse)
    let_go_of_stale_code(package)
    assert kept(package) == 2 * len(KERNELS)


def test_every_file_with_compiled_functions_stands_in_one_of_the_rooms() -> None:
    package = Path(mjfriction.__file__).parent
    rooms = {
        file.relative_to(package).parts[0]
        for file in package.rglob("*.py")
        if re.search(r"^(import|from) numba|law import .*\b(kernel|routine)\b", file.read_text("utf-8"), re.MULTILINE)
    }
    assert rooms == set(KERNELS)
