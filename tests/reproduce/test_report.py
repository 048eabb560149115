"""The page of reproduced experiments, and the verb that makes it; the experiments themselves run behind a marker."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from mjfriction.report.reproduced import write_reproduced
from mjfriction.reproduce.catalog import DOCUMENTS, reproduce
from mjfriction.reproduce.outcome import Claim, Line, Picture, Reproduction, Row, Table
from tests.cli.test_cli import mjfriction


def made_up() -> Reproduction:
    x = np.linspace(0.0, 1.0, 5000)
    return Reproduction(
        name="table",
        title="A <title>",
        source="Someone",
        how=("so",),
        tables=(Table("T", ("a", "b"), (Row("r", (1.23456789, None)), Row("s", ("word", 2.0)))),),
        pictures=(Picture("P", "x", "y", (Line("measured", x, x), Line("fitted", x, x, marks=True)), "figure 1"),),
        claims=(Claim("It is so.", True, "1"), Claim("It is otherwise.", False, "2")),
        differs=("because",),
    )


def test_page_and_figures_hold_what_came_out(tmp_path: Path) -> None:
    write_reproduced([made_up()], tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "A &lt;title&gt;" in page
    assert "It holds here" in page
    assert "Not here" in page
    assert 'src="http' not in page
    (own,) = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert own["tables"][0]["rows"][0] == {"name": "r", "cells": [1.235, None]}
    assert [claim["holds"] for claim in own["claims"]] == [True, False]


def test_pictures_are_thinned_to_what_is_seen(tmp_path: Path) -> None:
    write_reproduced([made_up()], tmp_path)
    thinned = (tmp_path / "report.html").stat().st_size
    write_reproduced([replace(made_up(), pictures=())], tmp_path)
    # Two lines of 5000 points, each of two numbers: some 200 kB if all were kept.
    assert thinned - (tmp_path / "report.html").stat().st_size < 120_000


def test_every_document_has_its_experiments() -> None:
    for name in DOCUMENTS:
        module = import_module(f"mjfriction.reproduce.{name}.told")
        assert callable(getattr(module, f"reproduce_{name}"))


def test_a_document_that_there_is_not_is_refused(tmp_path: Path) -> None:
    done = mjfriction("reproduce", "tabel", "--out", str(tmp_path / "out"))
    assert done.returncode == 2
    assert "tabel" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.deep
def test_the_documents_orders_come_out_at_any_number_of_processes(tmp_path: Path) -> None:
    found = reproduce(DOCUMENTS, jobs=2)
    claims = {claim.sentence: claim.holds for one in found for claim in one.claims}
    for sentence in (
        "Of the document's four combinations the one with GMS is the best.",
        "The observer alone loses at ten times the speed.",
        "Feedforward and observer together beat either alone, with every law.",
        "On parsimony model 3 is chosen over model 2.",
        "Friction is larger in retraction than in extension.",
        "Sharp switching makes the control chatter, smooth switching cures it.",
        "Along the near-sinusoidal motion the dynamic law tells the currents of every joint better.",
        "What a payload adds to friction comes out of passes without it and with it.",
        "Where gravity loads a joint, the model's pendulum tells its friction worse than passes both ways.",
        "At every joint the static law fits new passes better than Coulomb and viscous friction.",
    ):
        assert claims[sentence], sentence
    write_reproduced(found, tmp_path)
    told: list[float | None] = []
    alone = reproduce(("hydraulic",), lambda step, done=None: told.append(done), jobs=1)
    np.testing.assert_allclose(told, np.arange(len(told)) / len(told), err_msg="every step is counted")
    assert alone[0].tables == found[1].tables
