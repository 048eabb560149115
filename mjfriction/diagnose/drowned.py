"""Causes that go under in what no cause explains."""

from __future__ import annotations

from mjfriction.diagnose.causes.catalog import STATED_LEVELS
from mjfriction.diagnose.model import Chosen, Key, Model, build_model
from mjfriction.diagnose.stated import Settled
from mjfriction.diagnose.trial import asked_for
from mjfriction.identify.structure import Structure

DROWNED = 0.5  # of the mean square that is left unexplained at a joint, which a cause must explain there


def find_drowned(settled: Settled, remaining: tuple[Structure, ...]) -> frozenset[Key]:
    """Return the causes that explain less of a joint than what is ``remaining`` unexplained there.

    A course that no cause is can be told in part by many: a hum looks a little like a late effort, a load that swings
    like a spring.  They stay refitted, since they help on motion not fitted, but are no findings.  Causes of the whole
    arm answer for all joints, and the other half of a cause was asked for by name: these stay what they are.
    """
    model = settled.model
    left = {model.gap.robot.joints.index(entry.joint): entry.share for entry in remaining}
    return frozenset(
        choice.key
        for choice in (*model.chosen, *settled.levels)
        if not choice.cause.whole_arm
        and not asked_for(model, choice)
        and choice.site.joint in left
        and _explained(model, choice) < DROWNED * left[choice.site.joint]
    )


def _explained(model: Model, choice: Chosen) -> float:
    # What a cause takes off the mean square at its joint on motion not fitted, relative to what the model leaves.
    gap, joint = model.gap, choice.site.joint
    if choice.cause is STATED_LEVELS:
        without = build_model(gap, model.nuisance.without_level(joint), model.chosen)
    else:
        without = model.without(choice)
    before, after = (gap.rms(one.heldout_residual()[:, joint], joint) ** 2 for one in (without, model))
    return (before - after) / max(after, 1e-300)
