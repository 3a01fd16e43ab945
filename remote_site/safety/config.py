"""The parameters of collision avoidance, of the workspace, and of the certainty that a hand sample needs."""

import math
from typing import Annotated, Literal

import msgspec
from msgspec import Meta, field

FULL_SPEED_MS = 100.0  # a longer T_soft slows the arm in proportion
AUTO: Literal["auto"] = "auto"

Row3 = tuple[float, float, float]


class FixtureConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A fixed box in the cell, along the axes of the base frame: table, wall, fixture."""

    name: Annotated[str, Meta(min_length=1, max_length=64, description="its name in refusals")]
    min_m: Annotated[Row3, Meta(description="lower corner in the base frame, m")]
    max_m: Annotated[Row3, Meta(description="upper corner in the base frame, m")]

    def __post_init__(self) -> None:
        corners = zip(self.min_m, self.max_m, strict=True)
        if not all(math.isfinite(low) and math.isfinite(high) and low < high for low, high in corners):
            raise ValueError(f"min_m of {self.name} must be below max_m on every axis")


TABLE = FixtureConfig(name="table", min_m=(0.42, -0.55, -0.45), max_m=(1.02, 0.45, 0.558))
PEDESTAL = FixtureConfig(name="pedestal", min_m=(-0.15, -0.15, -0.45), max_m=(0.15, 0.15, 0.0))


class CollisionConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How near the arm may come to itself and to the fixtures of its cell."""

    margin_m: Annotated[float, Meta(ge=0.001, le=0.2, description="distance that is always kept, m")] = 0.01
    slow_m: Annotated[float, Meta(gt=0, le=0.5, description="nearer, the arm approaches more slowly, m")] = 0.04
    slowest: Annotated[float, Meta(gt=0, le=1, description="fraction of the speed left at the margin")] = 0.1
    fixtures: Annotated[tuple[FixtureConfig, ...], Meta(description="boxes in the cell")] = (TABLE, PEDESTAL)
    ignored_pairs: Annotated[
        tuple[tuple[str, str], ...], Meta(description="links or fixtures that are allowed to touch, by name")
    ] = ()

    def __post_init__(self) -> None:
        if self.slow_m <= self.margin_m:
            raise ValueError(f"slow_m {self.slow_m} must be above margin_m {self.margin_m}")


class CertaintyConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the covariance of a hand sample slows the arm: full speed up to `sure`, none beyond `poor`.

    The point that the tool copies (`mapping.point`) decides about the position: its sigma is the root of the
    covariance's trace, the rms length of the 3D error. Wrist, index and thumb together decide about the orientation:
    their covariances give the standard deviation of the hand's rotation about each of its axes. Thumbs that are seen
    have stayed below 8 deg in all recordings, inferred ones between 7 and 14.
    """

    position_sure_mm: Annotated[
        float, Meta(gt=0, le=200, description="sigma of the point that the tool copies up to which speed is full, mm")
    ] = 10.0
    position_poor_mm: Annotated[
        float, Meta(gt=0, le=500, description="sigma beyond which the arm holds, and no elbow is copied, mm")
    ] = 40.0
    turn_sure_deg: Annotated[
        float, Meta(gt=0, le=60, description="deviation up to which the hand turns the tool freely, deg")
    ] = 8.0
    turn_poor_deg: Annotated[
        float, Meta(gt=0, le=90, description="deviation from which the tool does not turn about that axis, deg")
    ] = 16.0
    slowest: Annotated[float, Meta(gt=0, le=1, description="fraction of the speed left just before the hold")] = 0.2

    def __post_init__(self) -> None:
        for sure, poor, name in (
            (self.position_sure_mm, self.position_poor_mm, "position_{}_mm"),
            (self.turn_sure_deg, self.turn_poor_deg, "turn_{}_deg"),
        ):
            if poor <= sure:
                raise ValueError(f"{name.format('poor')} {poor} must be above {name.format('sure')} {sure}")


class SafetyConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When a hand sample is too old or too wild, and where the tool may be."""

    t_soft_ms: Annotated[
        Annotated[float, Meta(ge=50, le=400)] | Literal["auto"],
        Meta(
            description='an older hand sample stops the arm, ms (50 to 400); "auto": as the link needs, 100 to 400; '
            "above 100 the arm is slower in proportion"
        ),
    ] = AUTO
    t_latch_ms: Annotated[
        float, Meta(ge=100, le=1000, description="an older hand sample ends the engagement, ms; above t_soft_ms")
    ] = 500.0
    longest_hold_ms: Annotated[
        float, Meta(ge=200, le=30000, description="a hold that lasts longer ends the engagement, ms")
    ] = 2000.0
    longest_stop_ms: Annotated[
        float,
        Meta(ge=50, le=2000, description="limits with which a joint may take longer to come to rest are refused, ms"),
    ] = 600.0
    hand_speed_m_s: Annotated[float, Meta(gt=0, le=20, description="a faster wrist is a jump, m/s")] = 3.0
    hand_noise_m: Annotated[float, Meta(ge=0, le=0.2, description="added to the jump limit for noise, m")] = 0.03
    hand_turn_deg_s: Annotated[
        float, Meta(gt=0, le=2000, description="a hand that turns faster turns the tool no more, deg/s")
    ] = 120.0
    inferred_turn_deg_s: Annotated[  # the end of a tool of 0.3 m stays below 250 mm/s, the reduced speed of ISO 10218-1
        float, Meta(gt=0, le=2000, description="a hand with an inferred thumb turns the tool no faster, deg/s")
    ] = 45.0
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
        1.15,
    )

    def __post_init__(self) -> None:
        if not isinstance(self.t_soft_ms, str) and self.t_latch_ms <= self.t_soft_ms:
            raise ValueError(f"t_latch_ms {self.t_latch_ms} must be above t_soft_ms {self.t_soft_ms}")
        corners = zip(self.workspace_min_m, self.workspace_max_m, strict=True)
        if not all(math.isfinite(low) and math.isfinite(high) and low < high for low, high in corners):
            raise ValueError("workspace_min_m must be below workspace_max_m on every axis")
