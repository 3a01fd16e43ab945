"""The parameters of the simulated operator: body, cameras, picture and motion."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from local_site.simulation.room.config import RoomConfig

Vector3 = tuple[float, float, float]
MotionName = Literal[
    "hold", "figure_of_eight", "rotate_x", "rotate_y", "rotate_z", "pick_and_place", "reach_and_adjust", "toggles"
]
PostureName = Literal["u", "fist", "pointing", "flat"]
MarkersWorn = Literal["round_the_tips", "beside_the_tips"]


class BodyConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The size of the arm; the defaults are an average adult's, girths are measured round the limb."""

    upper_arm_length: Annotated[float, Meta(gt=0.1, le=0.6, description="shoulder to elbow centre, m")] = 0.33
    forearm_length: Annotated[float, Meta(gt=0.1, le=0.6, description="elbow to wrist centre, m")] = 0.28
    hand_scale: Annotated[float, Meta(gt=0.5, le=1.5, description="1 is 0.19 m from wrist to middle finger tip")] = 1.0
    upper_arm_girth: Annotated[float, Meta(gt=0.1, le=0.6, description="at the biceps, m")] = 0.29
    elbow_girth: Annotated[float, Meta(gt=0.1, le=0.6, description="at the elbow, m")] = 0.245
    forearm_girth: Annotated[float, Meta(gt=0.1, le=0.6, description="at the belly of the forearm, m")] = 0.265
    wrist_girth: Annotated[float, Meta(gt=0.05, le=0.4, description="at the wrist, m")] = 0.165
    belly_offset: Annotated[
        float, Meta(ge=0, le=0.03, description="how far the muscle bellies lie before the line between the joints, m")
    ] = 0.011
    bare_fraction: Annotated[
        float, Meta(gt=0.2, le=0.9, description="part of the upper arm, from the elbow up, that no sleeve covers")
    ] = 0.65


class StereoConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Two equal cameras that look at the centre of the volume from the left and from the right."""

    width_px: Annotated[int, Meta(ge=64, le=4096)] = 640
    height_px: Annotated[int, Meta(ge=64, le=4096)] = 480
    focal_px: Annotated[float, Meta(gt=10, description="focal length, px")] = 800.0
    distance_m: Annotated[float, Meta(gt=0.5, le=10, description="from the centre of the volume")] = 1.5
    half_angle_deg: Annotated[float, Meta(gt=0, lt=80, description="each camera's turn off the middle")] = 25.0
    elevation_deg: Annotated[float, Meta(ge=0, lt=80, description="height above the volume's centre, as an angle")] = (
        15.0
    )
    centre: Vector3 = (0.5, 0.45, 0.5)
    k1: Annotated[float, Meta(ge=-0.4, le=0.4, description="radial distortion, x (1 + k1 r²)")] = 0.0


class PictureConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What lens and sensor do to the picture."""

    blur_sigma_px: Annotated[float, Meta(ge=0, le=5, description="defocus, 0 is sharp")] = 0.8
    noise_sigma: Annotated[float, Meta(ge=0, le=50, description="sensor noise, grey levels")] = 2.0
    shutter_ms: Annotated[float, Meta(ge=0, le=100, description="motion blur over this exposure, 0 is none")] = 0.0


class MotionConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the operator does, and from where."""

    name: MotionName = "pick_and_place"
    begins: Annotated[
        Literal["at_once", "when_engaged"],
        Meta(description="with the cameras, or once the arm is engaged, as an operator waits for it"),
    ] = "when_engaged"
    still_s: Annotated[float, Meta(ge=0, le=60, description="stillness from the beginning to the first motion")] = 2.0
    tremor_mm: Annotated[float, Meta(ge=0, le=10, description="amplitude of the tremor of the wrist")] = 0.0
    shoulder: Annotated[Vector3, Meta(description="shoulder joint in the operator frame, m")] = (0.88, 0.29, 0.46)
    wrist: Annotated[Vector3, Meta(description="wrist at the start in the operator frame, m")] = (0.50, 0.45, 0.69)
    swivel_deg: Annotated[
        float, Meta(ge=-180, le=180, description="elbow about the line shoulder to wrist, 0 is hanging down")
    ] = 16.0
    posture: Annotated[
        PostureName, Meta(description="the closed hand: index and thumb as a U, a fist, a pointing index, or flat")
    ] = "u"
    roll_deg: Annotated[
        float,
        Meta(
            ge=-180, le=180, description="hand about its own length, 0 is thumb ahead, 90 the palm towards the cameras"
        ),
    ] = 0.0


class SimulationConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The simulated operator and the cameras that film the arm."""

    body: BodyConfig = BodyConfig()
    stereo: StereoConfig = StereoConfig()
    picture: PictureConfig = PictureConfig()
    motion: MotionConfig = MotionConfig()
    room: RoomConfig = RoomConfig()
    markers: Annotated[
        bool, Meta(description="a dark glove with bright markers on wrist, index and thumb instead of a bare arm")
    ] = False
    markers_worn: Annotated[
        MarkersWorn,
        Meta(
            description="round_the_tips: caps about the last joints of index and thumb, seen from all sides; "
            "beside_the_tips: on the radial side of the index and the back of the thumb, as in the thesis's figure 5.4"
        ),
    ] = "round_the_tips"
    textured: Annotated[
        bool,
        Meta(
            description="a textured arm before one camera, which swings as in HAZEL-S of the ROBONAUT report; body, "
            "stereo, picture and the motion's name are ignored then"
        ),
    ] = False
    seed: Annotated[int, Meta(ge=0, lt=2**32)] = 1
    fps: Annotated[float, Meta(gt=0, le=240)] = 30.0
    phase_offset_ms: Annotated[
        float,
        Meta(ge=0, lt=100, description="how much later than the left camera the right one exposes, 0 is synchronous"),
    ] = 0.0

    def __post_init__(self) -> None:
        if self.room.scene == "dark" and self.room != RoomConfig():
            raise ValueError('only an office shows colours and disturbances: set room.scene = "office"')
        if self.room.scene != "dark" and (self.markers or self.textured):
            raise ValueError('markers and textured are filmed in the dark: take them off or set room.scene = "dark"')
