"""The causes that compete, one instance of each."""

from __future__ import annotations

from mjfriction.diagnose.causes.asymmetry import Asymmetry, AsymmetryWithOffset
from mjfriction.diagnose.causes.backlash import Backlash
from mjfriction.diagnose.causes.carried_drive import DifferenceCarried, SumCarried
from mjfriction.diagnose.causes.carried_payload import CarriedPayload
from mjfriction.diagnose.causes.cause import Cause
from mjfriction.diagnose.causes.coulomb_viscous import CoulombViscous
from mjfriction.diagnose.causes.coupling import DifferenceDrive, SharedEffort, SharedFriction, SharedMotion, SumDrive
from mjfriction.diagnose.causes.crossed_play import CrossedPlay
from mjfriction.diagnose.causes.delay import JointDelay, LogDelay
from mjfriction.diagnose.causes.elasticity import (
    Elasticity,
    HardeningElasticity,
    LinkSideElasticity,
    SensorElasticity,
    SwingingElasticity,
)
from mjfriction.diagnose.causes.encoder_offset import EncoderOffset
from mjfriction.diagnose.causes.friction_spot import FrictionSpot
from mjfriction.diagnose.causes.gravity_direction import GravityDirection
from mjfriction.diagnose.causes.landed_play import LandedPlay
from mjfriction.diagnose.causes.links import LinkCentre, LinkMoments, LinkScale
from mjfriction.diagnose.causes.load import DriveLoad, Load
from mjfriction.diagnose.causes.lugre_presliding import DampedLuGrePresliding, LuGrePresliding
from mjfriction.diagnose.causes.offset import Offset
from mjfriction.diagnose.causes.payload import Payload
from mjfriction.diagnose.causes.payload_for_a_while import PayloadForAWhile
from mjfriction.diagnose.causes.presliding import DampedPresliding, Presliding
from mjfriction.diagnose.causes.pressure import PistonPressure, Pressure
from mjfriction.diagnose.causes.rotor_inertia import RotorInertia
from mjfriction.diagnose.causes.saturating_viscous import SaturatingViscous
from mjfriction.diagnose.causes.spring import BentSpring, Spring
from mjfriction.diagnose.causes.steepening_viscous import SteepeningViscous
from mjfriction.diagnose.causes.stribeck import Stribeck
from mjfriction.diagnose.causes.torque_constant import TorqueConstant
from mjfriction.diagnose.causes.varying import Step, Warming, WarmUpDrift
from mjfriction.diagnose.causes.viscous_nonlinear import ViscousNonlinear
from mjfriction.diagnose.causes.waves import Cogging, PositionFriction

STATED_LEVELS = CoulombViscous()

# The order matters: of causes that fit equally well, the first one is named and the others become its alternatives.
STRUCTURAL: tuple[Cause, ...] = (
    Stribeck(),
    ViscousNonlinear(),
    SaturatingViscous(),
    SteepeningViscous(),
    Asymmetry(),
    AsymmetryWithOffset(),
    Load(),
    DriveLoad(),
    Presliding(),
    DampedPresliding(),
    LuGrePresliding(),
    DampedLuGrePresliding(),
    PositionFriction(),
    FrictionSpot(),
    Warming(),
    WarmUpDrift(),
    Step(),
    Pressure(),
    PistonPressure(),
    Cogging(),
    Offset(),
    RotorInertia(),
    TorqueConstant(),
    SharedFriction(),
    SharedMotion(),
    SharedEffort(),
    SumDrive(),
    DifferenceDrive(),
    SumCarried(),
    DifferenceCarried(),
    Elasticity(),
    LinkSideElasticity(),
    SensorElasticity(),
    SwingingElasticity(),
    HardeningElasticity(),
    EncoderOffset(),
    Backlash(),
    CrossedPlay(),
    LandedPlay(),
    Spring(),
    BentSpring(),
    Payload(),
    PayloadForAWhile(),
    CarriedPayload(),
    LinkScale(),
    LinkCentre(),
    LinkMoments(),
    GravityDirection(),
    JointDelay(),
    LogDelay(),
)
