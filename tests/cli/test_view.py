"""``mjfriction view``: what it asks of the viewer."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import typer

from mjfriction.cli.view import view


@pytest.mark.parametrize(("serve", "words"), [(False, []), (True, ["--serve-web"])])
def test_a_folder_of_results_is_opened_or_served(
    serve: bool, words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "recording.rrd").touch()
    asked: list[list[str]] = []
    monkeypatch.setattr(subprocess, "call", lambda command: asked.append(command) or 0)
    with pytest.raises(typer.Exit):
        view(tmp_path, serve=serve)
    (command,) = asked
    assert command[2:] == ["rerun", *words, str(tmp_path / "recording.rrd")]


def test_the_viewer_knows_the_words_it_is_asked_with() -> None:
    told = subprocess.run([sys.executable, "-m", "rerun", "--help"], capture_output=True, text=True, check=True)
    assert "--serve-web" in told.stdout
