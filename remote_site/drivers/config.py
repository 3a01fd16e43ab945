"""The parameters of driver and gripper."""

from collections.abc import Mapping
from typing import Annotated

import msgspec
from msgspec import Meta, field

from remote_site.kinematics.config import MODELS
from remote_site.simulation.config import SIMULATED

C500C, FRANKA, KINEMATIC = "c500c", "franka", "kinematic"
# What can be emulated, each with the option that says where the real one is.
ADDRESS_OPTIONS: Mapping[str, str] = {C500C: "port", FRANKA: "host"}
# The remote site's file of the only arm that a driver moves.
DRIVER_FILES = {FRANKA: MODELS / "fr3" / "fr3.toml"}


class DriverConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which robot is driven."""

    name: Annotated[
        str, Meta(min_length=1, description="kinematic, simulated, c500c, franka, or an installed driver")
    ] = SIMULATED
    emulate: Annotated[
        bool,
        Meta(description="c500c, franka: against an emulated robot, also where the address of a real one is given"),
    ] = False
    options: Annotated[
        dict[str, str | int | float | bool], Meta(description="the driver's own options, by its own keys")
    ] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.emulate and self.name not in ADDRESS_OPTIONS:
            can = ", ".join(ADDRESS_OPTIONS)
            raise ValueError(f"driver.emulate is for the drivers {can}; {self.name} has no emulator")

    @property
    def moves_nothing_real(self) -> bool:
        """Return whether the robot is simulated, kinematic or emulated."""
        return self.emulate or self.name in (SIMULATED, KINEMATIC)

    command_timeout_ms: Annotated[
        float,
        Meta(
            ge=8,
            le=1000,
            description="time without a command after which the robot has to be activated again, ms; it stops after "
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
