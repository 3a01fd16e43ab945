"""The parameters of the arm: its URDF, tool and tightened limits, its inverse kinematics, and singular postures."""

import math
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np
from msgspec import Meta, field

from common.config.loading import beside
from common.geometry import Array, transform

MODELS = Path(__file__).parents[1] / "models"
UNSTATED_JERK_RAD_S3 = 100.0  # of an arm whose file states none
OWN: Literal["own"] = "own"
Row3 = tuple[float, float, float]


def is_built_in(model: str) -> bool:
    """Return whether a model that Farhand brings has this name."""
    return Path(model).name == model and (MODELS / model / f"{model}.urdf").exists()


class BranchConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which of the closed form's eight IK configurations (branches) is taken; `keep` stays in the one the arm is in."""

    shoulder: Annotated[Literal["keep", "front", "back"], Meta(description="the wrist before or behind joint 1")] = (
        "keep"
    )
    elbow: Annotated[Literal["keep", "forward", "backward"], Meta(description="side to which the elbow bends")] = "keep"
    wrist: Annotated[Literal["keep", "forward", "backward"], Meta(description="side to which joint 5 bends")] = "keep"


class SingularityConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What happens near singular postures, by the condition number of the Jacobian."""

    radius_m: Annotated[float, Meta(gt=0, le=2, description="distance that a turn of 1 rad counts as, m")] = 0.3
    damp_condition: Annotated[float, Meta(ge=5, le=1e4, description="beyond it, lost directions are damped")] = 60.0
    slow_condition: Annotated[float, Meta(ge=5, le=1e4, description="beyond it, motion into the singularity slows")] = (
        100.0
    )
    slowest: Annotated[float, Meta(gt=0, le=1, description="fraction of the speed left in the singular posture")] = 0.3


class SolverConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The general solver: one step of differential inverse kinematics per tick."""

    gain_s: Annotated[float, Meta(gt=0, le=200, description="how fast an error of the tool decays, 1/s")] = 60.0
    posture_gain_s: Annotated[
        float, Meta(ge=0, le=20, description="how fast the null space returns to the start posture, 1/s")
    ] = 0.5
    swivel_gain_s: Annotated[
        float, Meta(ge=0, le=50, description="how fast the elbow of a seven-axis arm follows the operator's, 1/s")
    ] = 6.0
    swivel_speed_rad_s: Annotated[float, Meta(gt=0, le=5, description="maximum speed of that elbow, rad/s")] = 1.5
    swivel_joints: Annotated[
        tuple[str, str, str] | None,
        Meta(description="joints in shoulder, elbow and wrist of seven axes; by default the second, fourth and sixth"),
    ] = None
    swivel_about: Annotated[
        Literal["forward", "arm"],
        Meta(
            description="axis about which the operator's elbow angle is measured: the base's x, along which the arm "
            "reaches, or, for a robot of the operator's shape, the line from its own shoulder to its wrist"
        ),
    ] = "forward"
    lead_rad: Annotated[float, Meta(gt=0, le=2, description="maximum lead of the target over a joint, rad")] = 0.3


class CapsuleConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A capsule around a part of the arm or its tool, in the frame of its link."""

    link: Annotated[str, Meta(description="URDF link or frame that carries it; empty: robot.tool_frame")] = ""
    start_m: Annotated[Row3, Meta(description="one end of its axis, m")]
    end_m: Annotated[Row3, Meta(description="the other end of its axis, m")]
    radius_m: Annotated[float, Meta(gt=0, le=1, description="radius, m")]

    def __post_init__(self) -> None:
        if not all(math.isfinite(v) for v in (*self.start_m, *self.end_m)):
            raise ValueError(f"a capsule of {self.link or 'the tool frame'} has an end that is not finite")


GRIPPER = (
    CapsuleConfig(start_m=(0.0, 0.0, 0.0), end_m=(0.0, 0.0, 0.05), radius_m=0.035),
    CapsuleConfig(start_m=(0.0, -0.03, 0.08), end_m=(0.0, 0.03, 0.08), radius_m=0.035),
    CapsuleConfig(start_m=(0.0, 0.0, 0.11), end_m=(0.0, 0.0, 0.122), radius_m=0.015),
)


class RobotConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The arm, its tool, and limits that can only tighten the robot's own."""

    model: Annotated[
        str,
        Meta(
            min_length=1,
            description="a built-in model by name, or the path of a URDF as seen from this file's folder",
            extra=beside(unless=is_built_in),
        ),
    ] = "a465"
    tool_frame: Annotated[str, Meta(min_length=1, description="URDF frame that carries the tool")] = "tool0"
    tool_offset_m: Annotated[
        float, Meta(ge=0, le=1, description="tool centre point beyond the tool frame along its z, m")
    ] = 0.1341
    kinematics: Annotated[
        Literal["auto", "closed", "general"],
        Meta(description="closed form, general solver, or the closed form if it fits the URDF"),
    ] = "auto"
    stance: BranchConfig = field(default_factory=BranchConfig)
    start_deg: Annotated[
        tuple[float, ...], Meta(min_length=1, max_length=16, description="posture at the start, joint by joint, deg")
    ] = (0.0, 0.0, -45.0, 0.0, -45.0, 0.0)
    position_deg: Annotated[
        dict[str, tuple[float, float]], Meta(description="tighter lower and upper limit by joint name, deg")
    ] = field(default_factory=dict)
    position_margin_deg: Annotated[
        float, Meta(ge=0, le=20, description="distance kept from every joint limit, deg")
    ] = 1.0
    speed: Annotated[
        float, Meta(gt=0, le=1, description="fraction of every joint's own maximum speed, and of nothing else")
    ] = 1.0
    acceleration_rad_s2: Annotated[
        tuple[Annotated[float, Meta(gt=0, le=25)], ...],
        Meta(min_length=1, max_length=16, description="acceleration joint by joint, or one for all, rad/s²"),
    ] = (10.0, 10.0, 10.0, 20.0, 20.0, 20.0)
    jerk_rad_s3: Annotated[
        Annotated[float, Meta(gt=0)] | Literal["own"],
        Meta(description="every joint's jerk, rad/s³; \"own\": as the arm's file states it, 100 where it does not"),
    ] = OWN
    limits_factor: Annotated[
        float,
        Meta(
            ge=0.01,
            le=1,
            description="multiplies every joint's limits of speed, acceleration and jerk, after the keys above: "
            "a stop takes as long, and its way shrinks in proportion",
        ),
    ] = 1.0
    payload_kg: Annotated[
        Annotated[float, Meta(gt=0, le=1000)] | None,
        Meta(description="what the makers of arm and gripper allow beyond the tool, kg; shown, never measured"),
    ] = None
    capsules: Annotated[
        tuple[CapsuleConfig, ...], Meta(description="what must not touch anything, besides the URDF's collision shapes")
    ] = GRIPPER

    @property
    def urdf(self) -> Path:
        """The model's file."""
        return MODELS / self.model / f"{self.model}.urdf" if is_built_in(self.model) else Path(self.model)

    @property
    def tool_T_tcp(self) -> Array:
        """The tool centre point in the tool frame."""
        return transform(np.eye(3), np.array([0.0, 0.0, self.tool_offset_m]))

    @property
    def start(self) -> Array:
        """The start posture in rad."""
        start: Array = np.radians(np.array(self.start_deg))
        return start
