"""The parameters of the simulated cell: type, default, unit, bound, meaning."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from common.geometry import Array
from remote_site.assist.families import MarkerFamily
from remote_site.assist.placement import transform_of

SIMULATED = "simulated"
BLOCK, GRIP, GRIPPER_BODY = "block", "grip", "gripper_body"
FINGERS = "finger_left", "finger_right"
NAMES = frozenset({BLOCK, GRIP, GRIPPER_BODY, *FINGERS})  # of bodies and joints, which no arm's may have

Point = tuple[float, float, float]
Positive = Annotated[float, Meta(gt=0)]
PerJoint = tuple[Annotated[float, Meta(ge=0)], ...]


class ArmConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a URDF does not state about the arm; one value per joint."""

    armature_kg_m2: Annotated[PerJoint, Meta(description="inertia of motor and gear, felt at the joint")] = (
        0.4,
    ) * 3 + (0.05,) * 3
    coulomb_n_m: Annotated[
        PerJoint, Meta(description="dry friction; the wrist's motors are too weak for the arm's")
    ] = (1.5,) * 3 + (0.5, 0.5, 0.2)
    viscous_n_m_s: Annotated[PerJoint, Meta(description="friction per rad/s")] = (1.4,) * 3 + (0.5, 0.5, 0.2)


class GripperConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The two-finger gripper; its fingers close along the y axis of the frame that carries it."""

    frame: Annotated[str, Meta(description="URDF link that carries it, z along the fingers; empty: the tool's")] = ""
    max_opening_m: Annotated[Positive, Meta(description="widest opening between the fingers, m")] = 0.065
    force_limit_n: Annotated[Positive, Meta(description="largest grip force, N")] = 25.0
    speed_m_s: Annotated[Positive, Meta(description="speed of the opening, m/s")] = 0.15
    body_length_m: Annotated[Positive, Meta(description="flange to the root of the fingers, m")] = 0.1087
    finger_length_m: Annotated[Positive, Meta(description="length of the fingers, m")] = 0.0254
    body_mass_kg: Annotated[Positive, Meta(description="mass of the body, kg")] = 0.5
    finger_mass_kg: Annotated[Positive, Meta(description="mass of each finger, kg")] = 0.05
    friction: Annotated[Positive, Meta(description="friction of the finger pads")] = 1.0


class ServoConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The simulated robot controller; its limits are the robot's own, wider than those of the guard."""

    bandwidth_hz: Annotated[float, Meta(gt=0, le=30, description="of the joint position servo")] = 15.0
    follow_hz: Annotated[float, Meta(gt=0, le=30, description="bandwidth after a jump of the setpoints")] = 8.0
    extrapolation_ms: Annotated[float, Meta(ge=0, le=50, description="longest extrapolation of a setpoint")] = 20.0
    watchdog_ms: Annotated[float, Meta(ge=10, le=1000, description="silence after which the arm is stopped")] = 100.0
    max_velocity_rad_s: Annotated[Positive, Meta(description="of every joint")] = 2.98
    max_acceleration_rad_s2: Annotated[PerJoint, Meta(description="of every joint")] = (12.5,) * 3 + (25.0,) * 3
    stop_acceleration_rad_s2: Annotated[Positive, Meta(description="of the watchdog's stop")] = 10.0
    stop_jerk_rad_s3: Annotated[Positive, Meta(description="of the watchdog's stop")] = 1000.0
    following_error_rad: Annotated[Positive, Meta(description="an arm that lags further is blocked: it holds")] = 0.1
    activation_tolerance_rad: Annotated[Positive, Meta(description="from the arm to where it is activated")] = 0.02


class BlockConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The foam block of thesis section 5.3 and its start position, in the base frame."""

    size_m: Annotated[Point, Meta(description="depth (x), thickness (y), height (z)")] = (0.100, 0.050, 0.200)
    mass_kg: Annotated[float, Meta(gt=0, le=2.0, description="plastic foam; the arm carries 2 kg at most")] = 0.12
    friction: Annotated[Positive, Meta(description="on table and fingers")] = 0.7
    centre_xy_m: Annotated[tuple[float, float], Meta(description="centre on the table")] = (0.544, 0.0)
    yaw_deg: Annotated[float, Meta(ge=-180, le=180, description="turned about the vertical")] = 0.0


class SceneConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Floor, table and target paper, in the base frame."""

    floor_z_m: Annotated[float, Meta(lt=0, description="the base stands on a pedestal this high")] = -0.45
    pedestal_side_m: Annotated[Positive, Meta(description="side of the square pedestal")] = 0.30
    table_z_m: Annotated[float, Meta(description="top of the table")] = 0.558
    table_centre_xy_m: tuple[float, float] = (0.72, -0.05)
    table_size_xy_m: tuple[Positive, Positive] = (0.60, 1.00)
    target_corner_xy_m: Annotated[
        tuple[float, float], Meta(description="where the block's corner (+x, -y) belongs; the paper extends to -x, +y")
    ] = (0.594, -0.225)
    target_side_m: Annotated[Positive, Meta(description="side of the square target paper")] = 0.0765


class MarkerConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A printed marker in the views; its frame has x to its right, y up and z towards who looks at it."""

    family: MarkerFamily = MarkerFamily.ARUCO_4X4_50
    marker: Annotated[int, Meta(ge=0, description="its number in the family")]
    size_mm: Annotated[float, Meta(ge=10, le=500, description="side of the black square, mm")]
    on: Annotated[
        Literal["block", "base"], Meta(description="moves with the block, or is fixed in the base's frame")
    ] = "base"
    xyz_mm: Annotated[Point, Meta(description="its middle from the block's middle, or in the base's frame, mm")]
    rpy_deg: Annotated[Point, Meta(description="its axes: turned about that frame's x, then y, then z, deg")]

    def __post_init__(self) -> None:
        if self.marker >= self.family.size:
            raise ValueError(f"{self.family} has markers 0 to {self.family.size - 1}, not {self.marker}")

    @property
    def size_m(self) -> float:
        """The side of the black square, m."""
        return 1e-3 * self.size_mm

    @property
    def parent_T_marker(self) -> Array:
        """The marker's pose (4 x 4) in the block's or the base's frame."""
        return transform_of(self.xyz_mm, self.rpy_deg)


class ViewConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A camera of the cell; in the tool frame it rides on the end-effector, its up being the tool's -x."""

    name: str
    frame: Literal["base", "tool"] = "base"
    position_m: Point
    looks_at_m: Point
    fovy_deg: Annotated[float, Meta(gt=5, lt=150, description="vertical field of view")] = 45.0


VIEWS = (
    ViewConfig(name="front_high", position_m=(1.85, 0.50, 1.50), looks_at_m=(0.45, 0.08, 0.63), fovy_deg=34),
    ViewConfig(name="front_low", position_m=(1.85, -0.40, 0.72), looks_at_m=(0.45, 0.08, 0.67), fovy_deg=32),
    ViewConfig(name="side", position_m=(0.45, -1.70, 0.90), looks_at_m=(0.40, 0.05, 0.62), fovy_deg=34),
    ViewConfig(name="gripper", frame="tool", position_m=(-0.15, 0, 0.06), looks_at_m=(0.0, 0, 0.165), fovy_deg=58),
)


class CellConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The simulated cell; its four cameras are placed as in thesis section 4.1.3."""

    step_ms: Annotated[float, Meta(ge=0.5, le=2.0, description="physics and control period, ms")] = 2.0
    arm: ArmConfig = ArmConfig()
    gripper: GripperConfig = GripperConfig()
    servo: ServoConfig = ServoConfig()
    block: BlockConfig = BlockConfig()
    scene: SceneConfig = SceneConfig()
    views: tuple[ViewConfig, ...] = VIEWS
    printed_markers: Annotated[tuple[MarkerConfig, ...], Meta(max_length=16)] = ()
