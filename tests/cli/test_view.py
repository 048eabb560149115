"""``mjfriction view``: what it asks of the viewer, and of whom."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

import mjfriction.cli.view as module
from mjfriction.cli.view import SCREENS, view
from mjfriction.errors import InputError


class ReplacedError(Exception):
    """Stands for the process that would have become another."""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    commands: list[list[str]] = []

    def become(_: str, words: list[str]) -> None:
        commands.append(words)
        raise ReplacedError

    monkeypatch.setattr(os, "execv", become)
    return commands


def test_a_folder_of_results_is_opened(asked: list[list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SCREENS[0], ":0")
    (tmp_path / "recording.rrd").touch()
    with pytest.raises(ReplacedError):
        view(tmp_path)
    program, recording = asked[0]
    assert Path(program).name == "rerun", "the program itself: a child of a module would outlive what started it"
    assert recording == str(tmp_path / "recording.rrd")


def test_one_that_is_served_says_where(
    asked: list[list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "recording.rrd").touch()
    with pytest.raises(ReplacedError):
        view(tmp_path, serve=True)
    assert "--serve-web" in asked[0]
    _, here, elsewhere = capsys.readouterr().out.splitlines()
    # A browser on another machine has to find both servers by this machine's name, which this one may not know.
    assert elsewhere.count(socket.gethostname()) == 2
    assert here.count("localhost") == 2


def test_what_is_served_already_stays(
    asked: list[list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "recording.rrd").touch()
    with socket.socket() as taken:
        taken.bind(("", 0))
        taken.listen()
        port = taken.getsockname()[1]
        monkeypatch.setattr(module, "PORTS", ((port, 9876), (0, 0)))
        with pytest.raises(ReplacedError):
            view(tmp_path, serve=True)
        assert str(port) not in capsys.readouterr().out
        assert str(port) not in asked[0]
        monkeypatch.setattr(module, "PORTS", ((port, 9876),))
        with pytest.raises(InputError, match=f"ports {port}, 9876 are taken"):
            view(tmp_path, serve=True)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="screens are asked of differently elsewhere")
def test_without_a_screen_the_way_out_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in SCREENS:
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "recording.rrd").touch()
    with pytest.raises(InputError, match="--serve"):
        view(tmp_path)


def test_a_log_is_no_recording(tmp_path: Path) -> None:
    (tmp_path / "run.parquet").touch()
    with pytest.raises(InputError, match="ends in .rrd"):
        view(tmp_path / "run.parquet")


def test_the_viewer_knows_the_words_it_is_asked_with() -> None:
    told = subprocess.run([sys.executable, "-m", "rerun", "--help"], capture_output=True, text=True, check=True)
    for word in ("--serve-web", "--web-viewer-port", "--port"):
        assert word in told.stdout
