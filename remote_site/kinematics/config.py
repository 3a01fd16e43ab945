"""The parameters of inverse kinematics: which solver, which stance, what happens near singular postures."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta


class StanceConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which of the closed form's eight postures is taken; `keep` stays in the one the arm is in."""

    shoulder: Annotated[Literal["keep", "front", "back"], Meta(description="the wrist before or behind joint 1")] = (
        "keep"
    )
    elbow: Annotated[Literal["keep", "forward", "backward"], Meta(description="which way the elbow bends")] = "keep"
    wrist: Annotated[Literal["keep", "forward", "backward"], Meta(description="which way joint 5 bends")] = "keep"


class SingularityConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What happens near singular postures, told by the condition number of the Jacobian."""

    radius_m: Annotated[float, Meta(gt=0, le=2, description="what a turn of 1 rad counts as, beside a way in m")] = 0.3
    damp_condition: Annotated[float, Meta(ge=5, le=1e4, description="beyond, lost directions are damped")] = 60.0
    slow_condition: Annotated[float, Meta(ge=5, le=1e4, description="beyond, going on that way is slowed")] = 100.0
    slowest: Annotated[float, Meta(gt=0, le=1, description="share of the speed left in the singular posture")] = 0.3


class SolverConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The general solver: one step of differential inverse kinematics per tick."""

    gain_s: Annotated[float, Meta(gt=0, le=200, description="how fast an error of the tool is taken back, 1/s")] = 60.0
    posture_gain_s: Annotated[
        float, Meta(ge=0, le=20, description="how fast free joints return to the start posture, 1/s")
    ] = 0.5
    swivel_gain_s: Annotated[
        float, Meta(ge=0, le=50, description="how fast the elbow of seven axes follows the operator's, 1/s")
    ] = 6.0
    swivel_speed_rad_s: Annotated[float, Meta(gt=0, le=5, description="fastest turn of that elbow, rad/s")] = 1.5
    swivel_joints: Annotated[
        tuple[str, str, str] | None,
        Meta(description="joints in shoulder, elbow and wrist of seven axes; without, the second, fourth and sixth"),
    ] = None
    swivel_about: Annotated[
        Literal["forward", "arm"],
        Meta(
            description="the line about which the operator's elbow is seen to turn: the base's x, along which the arm "
            "reaches, or, for a robot of the operator's shape, the line from its own shoulder to its wrist"
        ),
    ] = "forward"
    lead_rad: Annotated[float, Meta(gt=0, le=2, description="how far the target runs ahead of a joint, rad")] = 0.3
