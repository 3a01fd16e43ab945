"""The local site's parameters, composed of those of its rooms."""

from typing import Annotated

import msgspec
from msgspec import Meta, field

from common.link.channels import check_cell_name
from common.link.config import LinkSecurity
from common.link.roles import Identity, Role
from common.process.config import MetricsConfig
from common.recording.config import OperatorRecordConfig
from local_site.acquisition.pairing import PairingConfig
from local_site.acquisition.rig_cameras import OperatorConfig
from local_site.authority.config import AuthorityConfig
from local_site.preview.preview import PreviewConfig
from local_site.samples.hand_sample import GestureConfig
from local_site.samples.smoothing import SmoothingConfig
from local_site.simulation.config import SimulationConfig
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.drift import DriftConfig
from local_site.tracking.registry import tracker_kind


class LocalLinksConfig(LinkSecurity, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the remote site is, and where this site listens on its own host."""

    remote: Annotated[str, Meta(min_length=1, description="the remote site's control endpoint")] = "tcp/127.0.0.1:7447"
    listen: Annotated[str, Meta(min_length=1, description="endpoint for programs of this host")] = "tcp/127.0.0.1:7457"


class LocalConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Every setting of the local site."""

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
    record: OperatorRecordConfig = field(default_factory=OperatorRecordConfig)

    def __post_init__(self) -> None:
        check_cell_name(self.cell)
        one = self.operator.alone or (self.operator.is_simulated and self.simulation.textured)
        if one and tracker_kind(self.tracking.method).scene != "textured":
            key = "operator.alone" if self.operator.alone else "simulation.textured"
            raise ValueError(f'{key} = true: one camera alone needs tracking.method = "monocular"')

    @property
    def bearer(self) -> Identity:
        """Whose certificate this site shows."""
        return Identity(Role.OPERATOR, self.cell, self.authority.name)
