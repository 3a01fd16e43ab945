"""The remote site's parameters: type, default, unit, bound and meaning of each."""

import math
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np
from msgspec import Meta, field

from common.channels import check_cell_name
from common.geometry import Array, transform
from common.link_config import LinkSecurity
from common.metrics.config import MetricsConfig
from remote_site.kinematics.config import SingularityConfig, SolverConfig, StanceConfig
from remote_site.safety.config import CapsuleConfig, CertaintyConfig, CollisionConfig
from remote_site.simulation.config import CellConfig
from remote_site.video.config import SIMULATED, VideoConfig

EMULATED = "c500c"
MODELS = Path(__file__).parent / "models"

Row3 = tuple[float, float, float]
HandPoint = Literal["wrist", "palm"]


GRIPPER = (
    CapsuleConfig(start_m=(0.0, 0.0, 0.0), end_m=(0.0, 0.0, 0.05), radius_m=0.035),
    CapsuleConfig(start_m=(0.0, -0.03, 0.08), end_m=(0.0, 0.03, 0.08), radius_m=0.035),
    CapsuleConfig(start_m=(0.0, 0.0, 0.11), end_m=(0.0, 0.0, 0.122), radius_m=0.015),
)


class RobotConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The arm, its tool, and limits that can only tighten the robot's own."""

    model: Annotated[str, Meta(min_length=1, description="a built-in model by name, or the path of a URDF")] = "a465"
    tool_frame: Annotated[str, Meta(min_length=1, description="URDF frame that carries the tool")] = "tool0"
    tool_offset_m: Annotated[
        float, Meta(ge=0, le=1, description="tool centre point beyond the tool frame along its z, m")
    ] = 0.1341
    kinematics: Annotated[
        Literal["auto", "closed", "general"],
        Meta(description="closed form, general solver, or the closed form if it fits the URDF"),
    ] = "auto"
    stance: StanceConfig = field(default_factory=StanceConfig)
    start_deg: Annotated[
        tuple[float, ...], Meta(min_length=1, max_length=16, description="posture at the start, joint by joint, deg")
    ] = (0.0, 0.0, -45.0, 0.0, -45.0, 0.0)
    position_deg: Annotated[
        dict[str, tuple[float, float]], Meta(description="tighter lower and upper limit by joint name, deg")
    ] = field(default_factory=dict)
    position_margin_deg: Annotated[
        float, Meta(ge=0, le=20, description="distance kept from every joint limit, deg")
    ] = 1.0
    speed: Annotated[float, Meta(gt=0, le=1, description="share of every joint's own maximum speed")] = 1.0
    acceleration_rad_s2: Annotated[
        tuple[Annotated[float, Meta(gt=0, le=25)], ...],
        Meta(min_length=1, max_length=16, description="acceleration joint by joint, or one for all, rad/s²"),
    ] = (10.0, 10.0, 10.0, 20.0, 20.0, 20.0)
    jerk_rad_s3: Annotated[float, Meta(gt=0, le=5000, description="every joint's jerk, rad/s³")] = 1000.0
    capsules: Annotated[
        tuple[CapsuleConfig, ...], Meta(description="what must not touch anything, besides the URDF's collision shapes")
    ] = GRIPPER

    @property
    def urdf(self) -> Path:
        """The model's file."""
        housed = MODELS / self.model / f"{self.model}.urdf"
        return housed if housed.exists() else Path(self.model)

    @property
    def tool_T_tcp(self) -> Array:
        """The tool centre point in the tool frame."""
        return transform(np.eye(3), np.array([0.0, 0.0, self.tool_offset_m]))

    @property
    def start(self) -> Array:
        """The start posture in rad."""
        start: Array = np.radians(np.array(self.start_deg))
        return start


class LocksConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Motions that the arm does not copy: along the base's axes, and about the tool's axes as at engagement."""

    x: Annotated[bool, Meta(description="no motion along the base's x")] = False
    y: Annotated[bool, Meta(description="no motion along the base's y")] = False
    z: Annotated[bool, Meta(description="no motion along the base's z")] = False
    roll: Annotated[bool, Meta(description="no rotation about the tool axis (tool z)")] = False
    pitch: Annotated[bool, Meta(description="no rotation about the tool's y")] = False
    yaw: Annotated[bool, Meta(description="no rotation about the tool's x")] = False


class MappingConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the hand's motion becomes the tool's."""

    command: Annotated[
        Literal["relative", "incremental"],
        Meta(
            description="relative: the tool's origin and the hand's way since its own; incremental: where the tool is "
            "and the hand's way since the last sample, as in the ROBONAUT report, which drifts"
        ),
    ] = "relative"
    point: Annotated[
        HandPoint, Meta(description="what the tool copies; the palm is told by the tracker of one camera alone")
    ] = "wrist"
    scale: Annotated[float, Meta(gt=0, le=5, description="tool motion per hand motion")] = 1.0
    base_R_operator: Annotated[
        tuple[Row3, Row3, Row3],
        Meta(description="rotation from the operator frame to the robot's base frame, row by row"),
    ] = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    locks: LocksConfig = field(default_factory=LocksConfig)


class SafetyConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When a hand sample is too old or too wild, and where the tool may be."""

    t_soft_ms: Annotated[float, Meta(ge=50, le=400, description="an older hand sample stops the arm, ms")] = 100.0
    t_latch_ms: Annotated[
        float, Meta(ge=100, le=2000, description="an older hand sample ends the engagement, ms; above t_soft_ms")
    ] = 500.0
    hand_speed_m_s: Annotated[float, Meta(gt=0, le=20, description="a faster wrist is a jump, m/s")] = 3.0
    hand_noise_m: Annotated[float, Meta(ge=0, le=0.2, description="added to the jump limit for noise, m")] = 0.03
    hand_turn_deg_s: Annotated[
        float, Meta(gt=0, le=2000, description="a hand that turns faster turns the tool no more, deg/s")
    ] = 120.0
    turn_settle_ms: Annotated[
        float, Meta(ge=0, le=2000, description="calm before the hand's orientation turns the tool again, ms")
    ] = 200.0
    collision: CollisionConfig = field(default_factory=CollisionConfig)
    certainty: CertaintyConfig = field(default_factory=CertaintyConfig)
    jumps_to_latch: Annotated[int, Meta(ge=1, le=100, description="jumps in a row that end the engagement")] = 3
    workspace_min_m: Annotated[Row3, Meta(description="lower corner of the tool's box in the base frame, m")] = (
        0.15,
        -0.55,
        0.25,
    )
    workspace_max_m: Annotated[Row3, Meta(description="upper corner of the tool's box in the base frame, m")] = (
        0.80,
        0.55,
        1.25,
    )

    def __post_init__(self) -> None:
        if self.t_latch_ms <= self.t_soft_ms:
            raise ValueError(f"t_latch_ms {self.t_latch_ms} must be above t_soft_ms {self.t_soft_ms}")
        corners = zip(self.workspace_min_m, self.workspace_max_m, strict=True)
        if not all(math.isfinite(low) and math.isfinite(high) and low < high for low, high in corners):
            raise ValueError("workspace_min_m must be below workspace_max_m on every axis")


class ControlConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The control loop and how it follows the hand."""

    rate_hz: Annotated[float, Meta(ge=50, le=1000, description="ticks per second, Hz")] = 250.0
    leash_m: Annotated[float, Meta(gt=0, le=1, description="how far the target may run ahead of the tool, m")] = 0.2
    leash_deg: Annotated[float, Meta(gt=0, le=180, description="how far it may turn ahead of the tool, deg")] = 60.0
    position_gain: Annotated[
        float, Meta(gt=0, le=1, description="share of a sample's deviation that moves the target estimate, at rest")
    ] = 0.6
    velocity_gain: Annotated[
        float, Meta(ge=0, le=1, description="share of a sample's deviation that changes its speed estimate, at rest")
    ] = 0.2
    glide_rad_s: Annotated[
        float, Meta(ge=1, le=200, description="how fast the target glides onto a new course, at rest: bandwidth, rad/s")
    ] = 20.0
    moving_position_gain: Annotated[
        float, Meta(gt=0, le=1, description="position_gain once samples deviate to one side: the hand moves")
    ] = 0.9
    moving_velocity_gain: Annotated[
        float, Meta(ge=0, le=1, description="velocity_gain once samples deviate to one side")
    ] = 0.6
    moving_glide_rad_s: Annotated[
        float, Meta(ge=1, le=200, description="glide_rad_s once samples deviate to one side, rad/s")
    ] = 50.0
    predict_ms: Annotated[
        float,
        Meta(
            ge=0,
            le=200,
            description="how long a target is carried on after its sample has come, ms; 0: never; in proportion longer "
            "where t_soft_ms is above 100",
        ),
    ] = 60.0
    solver: SolverConfig = field(default_factory=SolverConfig)
    singularity: SingularityConfig = field(default_factory=SingularityConfig)


class EngagementMode(StrEnum):
    """What makes the arm follow once all is ready."""

    AUTOMATIC = "automatic"
    ON_REQUEST = "on_request"
    HOLD_TO_RUN = "hold_to_run"
    PEDAL = "pedal"


class EngagementConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What must be so before the arm follows the hand."""

    mode: Annotated[
        EngagementMode,
        Meta(
            description="automatic: by itself, once per start of the remote site; on_request: by 'farhand engage'; "
            "hold_to_run or pedal: while the operator holds it down"
        ),
    ] = EngagementMode.AUTOMATIC
    frames: Annotated[int, Meta(ge=1, le=1000, description="good hand samples in a row before engaging")] = 30
    resume_frames: Annotated[int, Meta(ge=1, le=100, description="good samples in a row that end a hold")] = 3


class LeaseConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The right to operate this cell."""

    seconds: Annotated[
        float, Meta(ge=1, le=60, description="how long it lasts; the local site renews it five times as often, s")
    ] = 5.0


class DriverConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which robot is driven."""

    name: Annotated[str, Meta(min_length=1, description="kinematic, simulated, c500c, or an installed driver")] = (
        SIMULATED
    )
    emulate: Annotated[bool, Meta(description="c500c: against an emulated controller instead of a serial line")] = False
    options: Annotated[
        dict[str, str | int | float | bool], Meta(description="what the driver itself can be told, by its own keys")
    ] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.emulate and self.name != EMULATED:
            raise ValueError(f"driver.emulate is for the driver {EMULATED}; {self.name} has no emulator")

    command_timeout_ms: Annotated[
        float,
        Meta(
            ge=8,
            le=1000,
            description="without a command for so long, the robot has to be activated anew, ms; its stop begins after "
            "three missed ticks",
        ),
    ] = 500.0


class GripConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the gripper closes, and when it has done so."""

    force_n: Annotated[
        float, Meta(gt=0, le=200, description="largest grip force, N; the gripper's own may be less")
    ] = 25.0
    closed_mm: Annotated[float, Meta(ge=0, le=50, description="narrower, it is closed; wider, it holds an object")] = (
        3.0
    )
    open_mm: Annotated[float, Meta(gt=0, le=500, description="wider, it is open, mm")] = 45.0
    timeout_ms: Annotated[float, Meta(ge=200, le=10000, description="longest time to open or close, ms")] = 2000.0


class LinksConfig(LinkSecurity, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the remote site listens."""

    control: Annotated[str, Meta(min_length=1, description="endpoint of hand, state and requests")] = (
        "tcp/127.0.0.1:7447"
    )
    video: Annotated[str, Meta(min_length=1, description="endpoint of the camera streams")] = "tcp/127.0.0.1:7448"
    router: Annotated[
        str, Meta(description="a router's endpoint, for a site that cannot be reached: then nothing listens here")
    ] = ""

    @property
    def heard_at(self) -> str:
        """Where others find hand, state and requests of this site."""
        return self.router or self.control

    @property
    def places(self) -> tuple[str, ...]:
        """Every endpoint that this site uses."""
        return self.listened or (self.router,)

    @property
    def listened(self) -> tuple[str, ...]:
        """Where this site listens."""
        return () if self.router else (self.control, self.video)


class RemoteConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything the remote site can be told."""

    cell: Annotated[str, Meta(description="name of this cell; both sites must agree on it")] = "cell"
    links: LinksConfig = field(default_factory=LinksConfig)
    robot: RobotConfig = field(default_factory=RobotConfig)
    mapping: MappingConfig = field(default_factory=MappingConfig)
    safety: SafetyConfig = field(default_factory=SafetyConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    engagement: EngagementConfig = field(default_factory=EngagementConfig)
    lease: LeaseConfig = field(default_factory=LeaseConfig)
    driver: DriverConfig = field(default_factory=DriverConfig)
    grip: GripConfig = field(default_factory=GripConfig)
    video: VideoConfig = field(default_factory=VideoConfig)
    simulation: CellConfig = field(default_factory=CellConfig)
    metrics: MetricsConfig = field(default_factory=MetricsConfig)

    def __post_init__(self) -> None:
        check_cell_name(self.cell)

    @property
    def cell_is_simulated(self) -> bool:
        """Whether the robot is the simulated cell's."""
        return self.driver.name == SIMULATED

    @property
    def views_are_simulated(self) -> bool:
        """Whether a camera shows the simulated cell."""
        return any(camera.source == SIMULATED for camera in self.video.cameras)
