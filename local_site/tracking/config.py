"""The parameters of each of Farhand's own trackers."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta, field


class SilhouetteConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the silhouette tracker learns a body, and which arm it tracks."""

    initial_pairs: Annotated[
        int, Meta(ge=1, le=1000, description="pairs of images from which body lengths are learned, thesis 3.1")
    ] = 10
    right_arm: Annotated[
        bool, Meta(description="which arm is tracked; it decides on which side of the hand the index finger is")
    ] = True


class LearnedConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the tracker for ordinary rooms learns a body, and which arm it tracks."""

    initial_pairs: Annotated[
        int, Meta(ge=5, le=1000, description="pairs of images from which side and lengths of the arm are learned")
    ] = 10
    right_arm: Annotated[bool, Meta(description="which arm is tracked; a hand of the other side is refused")] = True


class EyeConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the tracker by networks learns a body, and which arm it tracks."""

    initial_pairs: Annotated[
        int, Meta(ge=5, le=1000, description="pairs of images from which side and lengths of the arm are learned")
    ] = 10
    right_arm: Annotated[bool, Meta(description="which arm is tracked; a hand of the other side is refused")] = True


class MarkersConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How bright the markers are, how the tracker learns their distances, and what an open hand is."""

    min_contrast: Annotated[
        int, Meta(ge=5, le=250, description="least brightness of a marker above its surroundings, grey levels")
    ] = 40
    initial_pairs: Annotated[
        int, Meta(ge=1, le=1000, description="instants from which the distances of the markers are learned")
    ] = 10
    open_ratio: Annotated[
        float,
        Meta(
            gt=1,
            le=3,
            description="the hand is open when the distance index to thumb over that of wrist to thumb is this many "
            "times what was learned",
        ),
    ] = 1.12


LengthMm = Annotated[float, Meta(gt=0, le=1000)]
GirthMm = Annotated[float, Meta(ge=60, le=800)]
Pixel = tuple[float, float]
StartBy = Literal["joints", "silhouette"]


class UpperArmConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The upper arm, measured on the operator with a tape."""

    length_mm: Annotated[LengthMm, Meta(description="shoulder joint to elbow joint, mm")] = 300.0
    shoulder_girth_mm: Annotated[GirthMm, Meta(description="girth at the armpit, mm")] = 310.0
    biceps_girth_mm: Annotated[GirthMm, Meta(description="girth at the middle, mm")] = 285.0
    elbow_girth_mm: Annotated[GirthMm, Meta(description="girth just above the elbow, mm")] = 245.0


class ForearmConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The forearm with the hand as its rigid extension."""

    length_mm: Annotated[LengthMm, Meta(description="elbow joint to wrist, mm")] = 255.0
    elbow_girth_mm: Annotated[GirthMm, Meta(description="girth just below the elbow, mm")] = 245.0
    belly_girth_mm: Annotated[GirthMm, Meta(description="girth at a quarter of the length, mm")] = 260.0
    wrist_girth_mm: Annotated[GirthMm, Meta(description="girth at the wrist, mm")] = 170.0
    palm_length_mm: Annotated[LengthMm, Meta(description="wrist to knuckles, mm")] = 95.0
    palm_width_mm: Annotated[LengthMm, Meta(description="across the knuckles, mm")] = 82.0
    palm_thickness_mm: Annotated[LengthMm, Meta(description="palm to back of the hand, mm")] = 30.0
    palm_point_mm: Annotated[LengthMm, Meta(description="wrist to the reported point of the palm, mm")] = 60.0


class StartConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the arm is in the first picture; both links are parallel to it there (section 2.6)."""

    by: Annotated[
        StartBy,
        Meta(
            description="joints: as given here, or clicked on the page; silhouette: found by the tracker itself, for a "
            "bare arm that is clearly brighter than all the rest of the picture"
        ),
    ] = "joints"
    shoulder_px: Annotated[Pixel, Meta(description="shoulder joint, px of the camera's own picture")] = (0.0, 0.0)
    elbow_px: Annotated[Pixel, Meta(description="elbow joint, in the same px")] = (0.0, 0.0)
    wrist_px: Annotated[Pixel, Meta(description="wrist, in the same px")] = (0.0, 0.0)
    palm_turn_deg: Annotated[
        float, Meta(ge=-180, le=180, description="turn of the palm about the forearm, 0: flat before the camera")
    ] = 0.0

    @property
    def is_given(self) -> bool:
        """Return whether the joints are given: they are distinct."""
        return self.elbow_px not in (self.shoulder_px, self.wrist_px)


class NoiseConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The error model of the maximum likelihood estimate (section 2.3)."""

    grey: Annotated[float, Meta(gt=0, le=50, description="camera noise, grey levels")] = 2.0
    position_mm: Annotated[float, Meta(ge=0, le=20, description="error of a surface point along each axis, mm")] = 0.5


class MonocularConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How one camera's arm is tracked."""

    setting: Annotated[
        Literal["live", "accurate"],
        Meta(description="live: 800 points per link, changes below 1e-2; accurate: all points, 1e-5"),
    ] = "live"
    camera: Annotated[int, Meta(ge=0, le=3, description="which of the rig's cameras watches, from 0")] = 0
    upper_arm: UpperArmConfig = field(default_factory=UpperArmConfig)
    forearm: ForearmConfig = field(default_factory=ForearmConfig)
    start: StartConfig = field(default_factory=StartConfig)
    noise: NoiseConfig = field(default_factory=NoiseConfig)
