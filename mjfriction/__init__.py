"""mjfriction: what a MuJoCo model of a manipulator gets wrong, why, and the model that has it right."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mjfriction.diagnose.diagnosis import diagnose_log
    from mjfriction.diagnose.tell.outcome import Diagnosis, Finding
    from mjfriction.errors import MjfrictionError
    from mjfriction.identify.comparison import Comparison, compare_robots
    from mjfriction.identify.identification import identify_log
    from mjfriction.identify.outcome import Identification
    from mjfriction.laws.friction import Friction, Level, friction
    from mjfriction.plant.machine import simulate
    from mjfriction.plant.trajectory import Trajectory, read_trajectory
    from mjfriction.record.log import Log
    from mjfriction.record.readers import read_log
    from mjfriction.report.finding_figure import finding_figure
    from mjfriction.report.write import save_diagnosis
    from mjfriction.robot.files import read_robot, write_robot
    from mjfriction.robot.predict import predict_log
    from mjfriction.robot.robot import Robot
    from mjfriction.robot.simulation import robot_laws, robot_spec
    from mjfriction.sim.attach import attach
    from mjfriction.sim.callback import friction_active
    from mjfriction.sim.reading import read_friction

_HOMES = {
    "Comparison": "mjfriction.identify.comparison",
    "Diagnosis": "mjfriction.diagnose.tell.outcome",
    "Identification": "mjfriction.identify.outcome",
    "Finding": "mjfriction.diagnose.tell.outcome",
    "Friction": "mjfriction.laws.friction",
    "Level": "mjfriction.laws.friction",
    "Log": "mjfriction.record.log",
    "MjfrictionError": "mjfriction.errors",
    "Robot": "mjfriction.robot.robot",
    "Trajectory": "mjfriction.plant.trajectory",
    "compare_robots": "mjfriction.identify.comparison",
    "identify_log": "mjfriction.identify.identification",
    "attach": "mjfriction.sim.attach",
    "diagnose_log": "mjfriction.diagnose.diagnosis",
    "friction": "mjfriction.laws.friction",
    "friction_active": "mjfriction.sim.callback",
    "predict_log": "mjfriction.robot.predict",
    "read_friction": "mjfriction.sim.reading",
    "read_log": "mjfriction.record.readers",
    "read_robot": "mjfriction.robot.files",
    "read_trajectory": "mjfriction.plant.trajectory",
    "finding_figure": "mjfriction.report.finding_figure",
    "robot_laws": "mjfriction.robot.simulation",
    "robot_spec": "mjfriction.robot.simulation",
    "save_diagnosis": "mjfriction.report.write",
    "simulate": "mjfriction.plant.machine",
    "write_robot": "mjfriction.robot.files",
}

__all__ = [
    "Comparison",
    "Diagnosis",
    "Finding",
    "Friction",
    "Identification",
    "Level",
    "Log",
    "MjfrictionError",
    "Robot",
    "Trajectory",
    "attach",
    "compare_robots",
    "diagnose_log",
    "finding_figure",
    "friction",
    "friction_active",
    "identify_log",
    "predict_log",
    "read_friction",
    "read_log",
    "read_robot",
    "read_trajectory",
    "robot_laws",
    "robot_spec",
    "save_diagnosis",
    "simulate",
    "write_robot",
]


def __getattr__(name: str) -> Any:
    # Loaded on first use, so that importing the package, and asking the command for help, costs nothing.
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'mjfriction' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
