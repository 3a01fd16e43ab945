"""The local site's parameters: type, default, unit, bound and meaning of each."""

from typing import Annotated

import msgspec
from msgspec import Meta, field

from common.cameras.sources import Source
from common.link.channels import check_cell_name
from common.link.config import LinkSecurity
from common.process.config import MetricsConfig
from local_site.acquisition.pairing import PairingConfig
from local_site.authority.operator_name import host_operator
from local_site.preview.config import PreviewConfig
from local_site.samples.smoothing import SmoothingConfig
from local_site.simulation.config import SimulationConfig
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.drift import DriftConfig

SIMULATED = "simulated"


class LocalLinksConfig(LinkSecurity, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the remote site is, and where this site is heard on its own host."""

    remote: Annotated[str, Meta(min_length=1, description="the remote site's control endpoint")] = "tcp/127.0.0.1:7447"
    listen: Annotated[str, Meta(min_length=1, description="endpoint for programs of this host")] = "tcp/127.0.0.1:7457"


class OperatorConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The two to four cameras before the operator, and their calibration."""

    left: Annotated[Source, Meta(description="'simulated', device, URL, file or folder")] = SIMULATED
    right: Annotated[Source, Meta(description="'simulated', device, URL, file or folder")] = SIMULATED
    also: Annotated[
        tuple[Source, ...], Meta(max_length=2, description="a third and a fourth camera, in the rig's order")
    ] = ()
    alone: Annotated[
        bool, Meta(description='left is the only camera, for tracking.method = "monocular"; right does not count')
    ] = False
    rig: Annotated[str, Meta(description="rig file from 'farhand calibrate'; simulated cameras bring their own")] = ""
    fps: Annotated[float, Meta(gt=0, le=240, description="frames per second asked of the cameras")] = 30.0
    latency_ms: Annotated[float, Meta(ge=0, le=1000, description="exposure to arrival of a live camera")] = 30.0

    def __post_init__(self) -> None:
        if not self.alone and (self.left == SIMULATED) != (self.right == SIMULATED):
            raise ValueError("left and right must both be simulated, or neither")
        if self.is_simulated and (self.also or self.alone):
            raise ValueError("also and alone are for real cameras; the simulated operator brings its own")
        if self.alone and self.also:
            raise ValueError("alone leaves no room for also")
        if not self.is_simulated and not self.rig:
            raise ValueError("rig is missing; make one with: farhand calibrate points CSV --out rig.json")

    @property
    def is_simulated(self) -> bool:
        """Whether the operator is a simulated one."""
        return self.left == SIMULATED

    @property
    def sources(self) -> tuple[Source, ...]:
        """All cameras, in the rig's order."""
        return (self.left,) if self.alone else (self.left, self.right, *self.also)


class AuthorityConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How this operator comes by the right to operate the cell."""

    operator: Annotated[str, Meta(description="name shown to others at the cell; empty: this host's name")] = ""
    automatic: Annotated[
        bool, Meta(description="ask for the lease whenever nobody holds it; otherwise: farhand lease take")
    ] = True

    def __post_init__(self) -> None:
        check_cell_name(self.name, "operator")

    @property
    def name(self) -> str:
        """The operator's name."""
        return self.operator or host_operator()


class GestureConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When an open hand counts."""

    hold_ms: Annotated[float, Meta(ge=0, le=1000, description="how long a change of the hand must last, ms")] = 120.0


class LocalConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything the local site can be told."""

    cell: Annotated[str, Meta(description="name of the cell to operate; both sites must agree on it")] = "cell"
    links: LocalLinksConfig = field(default_factory=LocalLinksConfig)
    operator: OperatorConfig = field(default_factory=OperatorConfig)
    capture: PairingConfig = field(default_factory=PairingConfig)
    tracking: TrackingConfig = field(default_factory=TrackingConfig)
    smoothing: SmoothingConfig = field(default_factory=SmoothingConfig)
    gesture: GestureConfig = field(default_factory=GestureConfig)
    authority: AuthorityConfig = field(default_factory=AuthorityConfig)
    drift: DriftConfig = field(default_factory=DriftConfig)
    preview: PreviewConfig = field(default_factory=PreviewConfig)
    simulation: SimulationConfig = field(default_factory=SimulationConfig)
    metrics: MetricsConfig = field(default_factory=MetricsConfig)

    def __post_init__(self) -> None:
        check_cell_name(self.cell)
        one = self.operator.alone or (self.operator.is_simulated and self.simulation.textured)
        if one and self.tracking.method != "monocular":
            raise ValueError('one camera alone needs tracking.method = "monocular"')
