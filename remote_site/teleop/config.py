"""The parameters of the mapping from hand to tool."""

from typing import Annotated, Literal, Protocol

import msgspec
from msgspec import Meta, field
from msgspec.structs import replace

from common.messages.hand import HandPoint
from remote_site.assist.config import AssistConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.motion.config import ControlConfig
from remote_site.safety.config import SafetyConfig
from remote_site.session.config import EngagementConfig

Row3 = tuple[float, float, float]
Factor = Annotated[float, Meta(gt=0, le=5)]


class LocksConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Motions that the arm does not copy: along the base's axes, and about the tool's axes as at engagement."""

    x: Annotated[bool, Meta(description="no motion along the base's x")] = False
    y: Annotated[bool, Meta(description="no motion along the base's y")] = False
    z: Annotated[bool, Meta(description="no motion along the base's z")] = False
    roll: Annotated[bool, Meta(description="no rotation about the tool axis (tool z)")] = False
    pitch: Annotated[bool, Meta(description="no rotation about the tool's y")] = False
    yaw: Annotated[bool, Meta(description="no rotation about the tool's x")] = False


class MappingConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the hand's motion becomes the tool's."""

    command: Annotated[
        Literal["relative", "incremental"],
        Meta(
            description="relative: the tool's origin plus the hand's motion since its own; incremental: the tool's "
            "position plus the hand's motion since the last sample, as in the ROBONAUT report, which drifts"
        ),
    ] = "relative"
    point: Annotated[
        HandPoint, Meta(description="what the tool copies; only the tracker of one camera measures the palm")
    ] = HandPoint.WRIST
    scale: Annotated[float, Meta(gt=0, le=5, description="tool motion per hand motion")] = 1.0
    scale_range: Annotated[
        tuple[Factor, Factor],
        Meta(description="least and most tool motion per hand motion, whatever scale the operator sets"),
    ] = (0.05, 5.0)
    base_R_operator: Annotated[
        tuple[Row3, Row3, Row3],
        Meta(description="rotation from the operator frame to the robot's base frame, row by row"),
    ] = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    locks: LocksConfig = field(default_factory=LocksConfig)

    def __post_init__(self) -> None:
        least, most = self.scale_range
        if not least <= self.scale <= most:
            raise ValueError(f"scale {self.scale:g} must be within scale_range, {least:g} to {most:g}")


class PipelineConfig(Protocol):
    """The tables of the configuration that the pipeline needs."""

    @property
    def robot(self) -> RobotConfig: ...
    @property
    def mapping(self) -> MappingConfig: ...
    @property
    def safety(self) -> SafetyConfig: ...
    @property
    def control(self) -> ControlConfig: ...
    @property
    def engagement(self) -> EngagementConfig: ...
    @property
    def assist(self) -> AssistConfig: ...


def prediction(config: PipelineConfig) -> ControlConfig:
    """The control parameters with `predict_ms` as it applies to this mapping.

    An incremental target moves with the arm: predicted beyond its sample it would run away.
    """
    incremental = config.mapping.command == "incremental"
    return replace(config.control, predict_ms=0.0) if incremental else config.control
