"""The tool's target from accepted hand samples: mapping, workspace box and leash; pure."""

import math

from common.geometry import Array
from common.messages.robot import Engagement, Pose
from remote_site.kinematics.model import ArmModel
from remote_site.motion.config import ControlConfig
from remote_site.motion.jerk_limited import leash
from remote_site.motion.target_tracker import ToolSample
from remote_site.safety.clearance import Workspace
from remote_site.session.samples import Accepted
from remote_site.teleop.config import MappingConfig
from remote_site.teleop.mapping import Steering, make_mapping


class ToolTarget:
    """Where the tool should be: `base_T_tool` (4 x 4), relative to both origins of the `engagement`."""

    def __init__(
        self, mapping: MappingConfig, control: ControlConfig, box: Workspace, model: ArmModel, q: Array
    ) -> None:
        self._mapping = make_mapping(mapping)
        self._leash = control.leash_m, math.radians(control.leash_deg)
        self._workspace = box
        self._model = model
        self.base_T_tool = model.forward(q)
        self.engagement: Engagement | None = None

    def capture(self, sample: Accepted, q: Array, engagements: int) -> None:
        """Take both origins, the hand's from the sample and the tool's at `q` (n,) rad: earlier motion is discarded."""
        base_T_tool = self.base_T_tool = self._model.forward(q)
        self._mapping.steer(Steering.of(sample.sample.intent), sample.position, sample.operator_R_hand, base_T_tool)
        self._mapping.engage(sample.position, sample.operator_R_hand, base_T_tool)
        self.engagement = Engagement(engagements, sample.sample.capture_ns, Pose.from_transform(base_T_tool))

    def aim(self, sample: Accepted, q_measured: Array, now_ns: int) -> ToolSample:
        """The target for the newest sample, inside the workspace box and within the leash from the measured arm."""
        position, operator_R_hand = sample.position, sample.operator_R_hand
        self._mapping.steer(Steering.of(sample.sample.intent), position, operator_R_hand, self.base_T_tool)
        measured = self._model.forward(q_measured)
        self._mapping.read(measured)
        target = self._mapping.target(position, operator_R_hand)
        target[:3, 3] = self._workspace.clamp(target[:3, 3])
        self.base_T_tool, leashed = leash(target, measured, *self._leash)
        elbow = self._mapping.elbow(sample.sample.wrist, sample.sample.elbow)
        return ToolSample(sample.born_ns, now_ns, self.base_T_tool, elbow, leashed)
