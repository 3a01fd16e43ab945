"""What LeRobot is told of a Farhand cell: where it is, how it is protected, and what an action consists of."""

from dataclasses import dataclass, field

from lerobot.teleoperators.config import TeleoperatorConfig

JOINTS, TOOL = "joints", "tool"


@TeleoperatorConfig.register_subclass("farhand")
@dataclass(kw_only=True)
class FarhandTeleopConfig(TeleoperatorConfig):
    """A cell `cell` whose remote site, or a router, is at `remote`.

    `ca`, `certificate` and `key` are PEM files, all three for tls/ and quic/ endpoints; a viewer's suffice.
    `action` is "joints" (rad; `joints` names them, in the cell's order) or "tool" (m, and a quaternion x, y, z, w, in
    the frame of the arm's base). The gripper is between `gripper_closed` and `gripper_open`. A state older than
    `max_age_ms` is refused.
    """

    cell: str = "cell"
    remote: str = "tcp/127.0.0.1:7447"
    ca: str = ""
    certificate: str = ""
    key: str = ""
    action: str = JOINTS
    joints: list[str] = field(default_factory=list)
    gripper: bool = True
    gripper_closed: float = 0.0
    gripper_open: float = 1.0
    max_age_ms: float = 200.0
    connect_timeout_s: float = 10.0

    def __post_init__(self) -> None:
        if self.action not in (JOINTS, TOOL):
            raise ValueError(f"action is {self.action!r}: write {JOINTS!r} or {TOOL!r}")
        if self.action == JOINTS and not self.joints:
            raise ValueError("joints is empty: name the cell's joints in their order, as its page or its URDF does")
        if len({bool(self.ca), bool(self.certificate), bool(self.key)}) != 1:
            raise ValueError("ca, certificate and key belong together: give all three, or none")
        if not self.ca and not self.remote.startswith("tcp/"):
            raise ValueError(f"{self.remote} needs certificates: give ca, certificate and key")
