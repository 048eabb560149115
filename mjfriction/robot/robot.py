"""A robot as every command uses it: the table of its file, and the folder that its model path starts from."""

from __future__ import annotations

import os
import sysconfig
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

import numpy as np

from mjfriction.body.inertia import RigidLink
from mjfriction.body.model import Body, Load, load_body
from mjfriction.errors import RobotError, suggestion
from mjfriction.laws.coulomb_viscous import COULOMB_VISCOUS
from mjfriction.robot.friction_tables import FrictionTerm
from mjfriction.robot.plain_model import check_tree, in_plain_words
from mjfriction.robot.schema import Joint, RobotTable

EXAMPLE_ROBOT_DATA = "package://example-robot-data/"


@dataclass(frozen=True, repr=False)
class Robot:
    """A robot: ``table`` holds the keys of its file, ``folder`` is the base of a relative model path."""

    table: RobotTable
    folder: Path

    def __repr__(self) -> str:
        """The name and the joints."""
        return f"<Robot '{self.name}': {', '.join(self.joints)}>"

    @property
    def name(self) -> str:
        """The robot's name."""
        return self.table.name

    @property
    def joints(self) -> tuple[str, ...]:
        """The names of its joints, in the order of the file."""
        return tuple(joint.name for joint in self.table.joint)

    def joint(self, name: str) -> Joint:
        """Return a joint's table; :class:`RobotError` suggests the nearest joint if there is none of that name."""
        for joint in self.table.joint:
            if joint.name == name:
                return joint
        raise RobotError(
            f"robot '{self.name}' has no joint '{name}'{suggestion(name, self.joints)} Its joints are "
            f"{', '.join(self.joints)}"
        )

    def with_joint(self, changed: Joint) -> Robot:
        """Return the robot with the joint's table of the same name replaced."""
        joints = tuple(changed if joint.name == changed.name else joint for joint in self.table.joint)
        return Robot(self.table.model_copy(update={"joint": joints}), self.folder)

    @property
    def model_path(self) -> Path:
        """The path of the model file that the robot file's ``model`` key names."""
        return resolve_model(self.table.model, self.folder)

    def body(self) -> Body:
        """Read the rigid bodies: the model with this robot's gravity, payload, link changes, rotors and top speeds."""
        payload = self.table.payload
        try:
            check_tree(self.model_path, self.joints)
            body = load_body(
                self.model_path,
                self.joints,
                gravity=self.table.gravity,
                payload=Load(payload.mass, payload.com, payload.parent) if payload else None,
                link_inertia={
                    name: RigidLink(own.mass, own.com, own.inertia) for name, own in self.table.link_inertia.items()
                },
                link_scale=self.table.link_scale,
                link_shift=self.table.link_shift,
                rotor_inertia=[joint.actuator.reflected_inertia for joint in self.table.joint],
                text=in_plain_words(self.model_path),
            )
        except RobotError as error:
            raise RobotError(f"robot '{self.name}': {error}") from error
        stated = [joint.top_speed for joint in self.table.joint]
        top = [own or float(model) for own, model in zip(stated, body.top_speed, strict=True)]
        return replace(body, top_speed=np.array(top))

    def with_stated_friction(self, body: Body) -> Robot:
        """Return the robot with the model file's damping and dry friction as a law on each joint that states none.

        Raises :class:`RobotError` where that damping has terms of higher order.
        """
        robot = self
        for i, joint in enumerate(self.table.joint):
            if joint.friction is None:
                if body.bent_damping[i]:
                    raise RobotError(
                        f"robot '{self.name}': the model's damping of joint '{joint.name}' is no multiple of its "
                        "speed; state it in the robot file as a friction law, such as quadratic_viscous"
                    )
                levels = {"coulomb": float(body.dry_friction[i]), "viscous": float(body.damping[i])}
                term = FrictionTerm(law=COULOMB_VISCOUS.name, parameters=levels)
                robot = robot.with_joint(joint.model_copy(update={"friction": (term,)}))
        return robot


def resolve_model(model: str, folder: Path) -> Path:
    """Return the path that a ``model`` key names.

    Relative paths start from the robot file's folder; ``package://example-robot-data/…`` is looked up in the installed
    example-robot-data.  Raises :class:`RobotError` for any other package, or if that one is not installed.
    """
    if not model.startswith("package://"):
        return Path(os.path.normpath(folder / model))
    if not model.startswith(EXAMPLE_ROBOT_DATA):
        raise RobotError(f"model '{model}': the one package that can be named is {EXAMPLE_ROBOT_DATA}…")
    share = _example_robots()
    if not share.is_dir():
        raise RobotError(f"model '{model}': example-robot-data is not installed; pip install example-robot-data")
    return share / model.removeprefix(EXAMPLE_ROBOT_DATA)


def packaged_model(path: Path) -> str | None:
    """Return the ``package://…`` name of a model file in the installed example-robot-data, None for any other file."""
    share = _example_robots().resolve()
    return (
        EXAMPLE_ROBOT_DATA + path.resolve().relative_to(share).as_posix() if share in path.resolve().parents else None
    )


def _example_robots() -> Path:
    return Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"


def bundled_robots() -> dict[str, Path]:
    """Return the robot files that come with the package, by name."""
    package = Path(str(files("mjfriction")))
    shipped = package / "bundled" / "robots"  # in a wheel; a source checkout keeps them at its top level
    root = shipped if shipped.is_dir() else package.parent / "robots"
    return {
        folder.name: folder / "robot.toml" for folder in sorted(root.iterdir()) if (folder / "robot.toml").is_file()
    }
