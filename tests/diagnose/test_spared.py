"""What a cause spares joints that it does not touch counts for it: without it others bend to stand in its place."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.fit.model import Chosen, Model, build_model
from mjfriction.diagnose.fit.nuisance import make_nuisance
from mjfriction.diagnose.settle.stated import Settled
from mjfriction.diagnose.tell import untold
from mjfriction.identify.measure import measure_gap
from mjfriction.identify.structure import Structure
from mjfriction.record.log import Floats
from mjfriction.record.readers import read_log
from mjfriction.robot.files import read_robot
from tests.hidden.machine import Machine, write_case

ELBOW, PAN = 2, 0


@dataclass(frozen=True)
class Without:
    left: Floats

    def heldout_residual(self) -> Floats:
        return self.left


@pytest.fixture
def with_an_offset(tmp_path: Path) -> tuple[Model, Chosen]:
    log, robot = write_case(tmp_path, Machine(hidden={ELBOW: lambda i: 1.5 + 0.0 * i.q}), seed=5, seconds=25.0)
    gap = measure_gap(read_log(log), read_robot(robot), highest=60.0)
    offset = Chosen(Offset(), Site(ELBOW))
    return build_model(gap, make_nuisance(gap), (offset,)), offset


@pytest.mark.parametrize(("at", "told"), [(None, False), (PAN, True)])
def test_an_error_it_keeps_from_another_joint_is_worth_a_finding(
    at: int | None, told: bool, with_an_offset: tuple[Model, Chosen], monkeypatch: pytest.MonkeyPatch
) -> None:
    model, offset = with_an_offset
    left = model.heldout_residual()

    def standing_in(_model: Model, _choice: Chosen) -> Without:
        # Something that takes the offset's place at its own joint, and costs another joint as much as there is.
        bent = left.copy()
        if at is not None:
            bent[:, at] *= 2.0
        return Without(bent)

    monkeypatch.setattr(untold, "without_cause", standing_in)
    monkeypatch.setattr(untold, "relief", lambda *_: 0.0)
    found = untold.find_untold(Settled(model, ()), (), (), left)
    assert (offset.key not in found.keys) is told


@pytest.mark.parametrize(
    ("unexplained", "deviations", "told"),
    [(ELBOW, 9.0, False), (PAN, 9.0, True), (PAN, 7.0, False)],
)
def test_that_drives_and_links_would_be_strained_without_it_says_little_and_nothing_where_much_is_unexplained(
    unexplained: int,
    deviations: float,
    told: bool,
    with_an_offset: tuple[Model, Chosen],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model, offset = with_an_offset
    left = model.heldout_residual()
    monkeypatch.setattr(untold, "without_cause", lambda *_: Without(left))
    monkeypatch.setattr(untold, "relief", lambda *_: deviations**2)
    remaining = (Structure(model.gap.robot.joints[unexplained], "time", 0.9),)
    found = untold.find_untold(Settled(model, ()), remaining, (), left)
    assert (offset.key not in found.keys) is told
