"""The remote site's parameters, table by table; each package describes its own."""

from typing import Annotated, Self

import msgspec
from msgspec import Meta, field

from common.link.channels import check_cell_name
from common.process.config import MetricsConfig
from common.recording.config import RecordConfig
from remote_site.assist.config import AssistConfig
from remote_site.drivers.config import DriverConfig, GripConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.link_config import RemoteLinksConfig
from remote_site.motion.config import ControlConfig
from remote_site.safety.config import SafetyConfig
from remote_site.session.config import ACCEPTANCE, EngagementConfig, EngagementMode, LeaseConfig
from remote_site.simulation.config import SIMULATED, CellConfig
from remote_site.teleop.config import MappingConfig
from remote_site.video.config import VideoConfig


class RemoteConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The whole configuration of the remote site."""

    cell: Annotated[str, Meta(description="name of this cell; both sites must agree on it")] = "cell"
    links: RemoteLinksConfig = field(default_factory=RemoteLinksConfig)
    robot: RobotConfig = field(default_factory=RobotConfig)
    mapping: MappingConfig = field(default_factory=MappingConfig)
    safety: SafetyConfig = field(default_factory=SafetyConfig)
    control: ControlConfig = field(default_factory=ControlConfig)
    engagement: EngagementConfig = field(default_factory=EngagementConfig)
    lease: LeaseConfig = field(default_factory=LeaseConfig)
    driver: DriverConfig = field(default_factory=DriverConfig)
    grip: GripConfig = field(default_factory=GripConfig)
    video: VideoConfig = field(default_factory=VideoConfig)
    assist: AssistConfig = field(default_factory=AssistConfig)
    simulation: CellConfig = field(default_factory=CellConfig)
    metrics: MetricsConfig = field(default_factory=MetricsConfig)
    record: RecordConfig = field(default_factory=RecordConfig)

    def __post_init__(self) -> None:
        check_cell_name(self.cell)
        engagement, driver = self.engagement, self.driver
        automatic = engagement.mode is EngagementMode.AUTOMATIC
        if automatic and not (driver.moves_nothing_real or engagement.automatic_accepted == ACCEPTANCE):
            raise ValueError(
                f"engagement.mode = 'automatic' lets the driver {driver.name!r} move a real robot as soon as a hand is "
                f"seen: use 'on_request', or accept it with engagement.automatic_accepted = {ACCEPTANCE!r}"
            )

        self._check_assist()

    def _check_assist(self) -> None:
        """ValueError when no marker could ever be seen well enough."""
        cameras = self.video.cameras
        calibrated = [
            c for c in cameras if c.projection is not None or (c.source == SIMULATED and self.video.calibrated)
        ]
        if self.assist.targets and len(calibrated) < 2 and not any(camera.on_tool for camera in calibrated):
            raise ValueError(
                "assist.targets need two calibrated views, or one on the tool: give cameras their projection in "
                "[[video.cameras]], or for simulated views set video.calibrated = true"
            )

    def engaging(self, mode: EngagementMode) -> Self:
        """The same configuration with another mode of engagement."""
        return msgspec.structs.replace(self, engagement=msgspec.structs.replace(self.engagement, mode=mode))

    @property
    def cell_is_simulated(self) -> bool:
        """Return whether the robot is the simulated cell's."""
        return self.driver.name == SIMULATED

    @property
    def views_are_simulated(self) -> bool:
        """Return whether a camera shows the simulated cell."""
        return any(camera.source == SIMULATED for camera in self.video.cameras)
