"""What a cause contains goes when it comes."""

from __future__ import annotations

from mjfriction.diagnose.causes.cause import Site
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.spring import Spring
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.fit.model import Chosen, without_contained


def test_a_spring_has_the_offset_of_its_own_joint_and_no_other() -> None:
    own, elsewhere, curve = Chosen(Offset(), Site(2)), Chosen(Offset(), Site(3)), Chosen(Stribeck(), Site(2))
    assert without_contained((own, elsewhere, curve), Chosen(Spring(), Site(2))) == (elsewhere, curve)
    assert without_contained((own, elsewhere, curve), Chosen(Stribeck(), Site(2))) == (own, elsewhere, curve)
