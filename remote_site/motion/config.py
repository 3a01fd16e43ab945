"""The parameters of the control loop and of target prediction."""

from typing import Annotated

import msgspec
from msgspec import Meta, field

from remote_site.kinematics.config import SingularityConfig, SolverConfig


class ControlConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The control loop and how it follows the hand."""

    rate_hz: Annotated[float, Meta(ge=50, le=1000, description="ticks per second, Hz")] = 250.0
    leash_m: Annotated[float, Meta(gt=0, le=1, description="how far the target may run ahead of the tool, m")] = 0.2
    leash_deg: Annotated[float, Meta(gt=0, le=180, description="how far it may turn ahead of the tool, deg")] = 60.0
    position_gain: Annotated[
        float, Meta(gt=0, le=1, description="fraction of a sample's deviation that moves the target estimate, at rest")
    ] = 0.6
    velocity_gain: Annotated[
        float,
        Meta(ge=0, le=1, description="fraction of a sample's deviation that changes its velocity estimate, at rest"),
    ] = 0.2
    glide_rad_s: Annotated[
        float,
        Meta(ge=1, le=200, description="how fast the target converges to a new estimate, at rest: bandwidth, rad/s"),
    ] = 20.0
    moving_position_gain: Annotated[
        float, Meta(gt=0, le=1, description="position_gain once samples deviate to one side: the hand moves")
    ] = 0.9
    moving_velocity_gain: Annotated[
        float, Meta(ge=0, le=1, description="velocity_gain once samples deviate to one side")
    ] = 0.6
    moving_acceleration_gain: Annotated[
        float, Meta(ge=0, le=1, description="fraction of a sample's deviation that changes the acceleration estimate")
    ] = 0.3
    moving_glide_rad_s: Annotated[
        float, Meta(ge=1, le=200, description="glide_rad_s once samples deviate to one side, rad/s")
    ] = 50.0
    predict_ms: Annotated[
        float,
        Meta(
            ge=0,
            le=200,
            description="how long a target is extrapolated after its sample has arrived, ms; 0: never; "
            "proportionally longer while samples older than 100 ms are obeyed",
        ),
    ] = 60.0
    solver: SolverConfig = field(default_factory=SolverConfig)
    singularity: SingularityConfig = field(default_factory=SingularityConfig)
