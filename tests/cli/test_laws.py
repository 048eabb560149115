"""``mjfriction laws``, and the picture it draws."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mjfriction.laws.catalog import LAWS
from mjfriction.laws.portrait import portrait, typical_values
from mjfriction.report.canvas import line_plot
from scripts.law_pages import chooser, section
from tests.cli.here import mjfriction_here

ROOT = Path(__file__).resolve().parents[2]


def test_every_law_has_a_line_within_eighty_columns() -> None:
    done = mjfriction_here("laws")
    assert done.returncode == 0
    for law in LAWS.values():
        assert re.search(rf"^{law.name} ", done.stdout, re.MULTILINE)
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_one_law_is_shown_with_its_picture_and_page(tmp_path: Path) -> None:
    page = tmp_path / "gms.html"
    done = mjfriction_here("laws", "gms", "--out", page)
    assert done.returncode == 0
    for parameter in (*LAWS["gms"].parameters, *LAWS["gms"].elements):
        assert parameter.name in done.stdout
    assert any("\u2801" <= sign <= "\u28ff" for sign in done.stdout)
    assert "Breakaway from rest" in page.read_text("utf-8")
    assert [path.name for path in tmp_path.iterdir()] == ["gms.html"]


def test_wrong_words_are_one_line() -> None:
    for words, message in (
        (("laws", "lugr"), "did you mean 'lugre'"),
        (("laws", "--out", "x.html"), "name it"),
        (("laws", "lugre", "--out", "/nowhere/x.html"), "there is no folder /nowhere"),
    ):
        done = mjfriction_here(*words)
        assert done.returncode == 2
        assert message in done.stderr
        assert done.stderr.count("\n") == 1


def test_a_second_process_compiles_nothing() -> None:
    code = (
        "import numpy as np; from mjfriction.laws.catalog import LAWS; from mjfriction.laws.ambient import ambient;"
        "law = LAWS['lugre']; from mjfriction.laws.portrait import typical_values as t;"
        "law.advance(0.1, ambient(1)[0], np.zeros(1), 1e-3, law.pack(t(law)), np.zeros(1));"
        "print(sum(law.advance.stats.cache_misses.values()))"
    )
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(2)]
    assert runs[1].stdout.strip() == "0"


def test_a_line_is_drawn_where_it_is() -> None:
    rising = line_plot(np.array([0.0, 1.0]), np.array([0.0, 1.0]), width=4, height=2, title="t", across="x", up="y")
    lines = rising.splitlines()
    assert lines[0] == "t (y)"
    assert lines[1].startswith("1 │\u2800\u2800")
    assert lines[2] == "0 │⡠⠊"
    assert lines[3].endswith("1")


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
def test_typical_values_are_allowed_and_every_portrait_is_finite(law) -> None:
    law.pack(typical_values(law, 7))
    drawn = portrait(law)
    for curves in (drawn.steady, drawn.presliding, drawn.lag, drawn.breakaway):
        assert curves
        for curve in curves:
            assert np.all(np.isfinite(curve.torque))


def test_the_page_of_laws_is_the_one_the_laws_write() -> None:
    page = (ROOT / "docs/laws.md").read_text("utf-8")
    assert chooser() in page
    for law in LAWS.values():
        assert section(law).strip() in page
        assert (ROOT / f"docs/images/laws/{law.name}.png").is_file()
