"""A hand that goes round and a remote site whose states come late, told to a page in step."""

import math
import time
from collections import deque
from itertools import count

from msgspec.structs import replace

from common.clock import NS_PER_MS
from common.geometry import Array
from common.messages.hand import HandArm
from common.messages.robot import Pose, RobotState
from lab.measure.page import scene
from remote_site.teleop.config import MappingConfig
from tests.local_site.console.followed_remote import Remote, sample

RADIUS_M = 0.12
SESSIONS = count(100)  # each hand is another local site's: the page forgets the one before
STEP_RAD = 0.35
LAG = 2  # samples that the measured arm is behind its target
AGE_NS = 20 * NS_PER_MS
LATE_NS = 200 * NS_PER_MS


class LateRemote:
    """Give its `hand` and `state` to a page: the state answers the sample made `behind` samples before the newest.

    While `still` the hand stays where it is, and so do the states: the page may be as slow as it likes. `measured` and
    `sent` are where it has to show the tool (4 x 4).
    """

    def __init__(self, behind: int) -> None:
        self._remote = Remote(MappingConfig())
        self.still, self._session = False, next(SESSIONS)
        self._seq = self._steps = 0
        self._states: deque[RobotState] = deque(maxlen=behind + 1)
        self._targets: deque[Array] = deque(maxlen=LAG + 1)
        self.measured = self.sent = scene.MODEL.forward(scene.CONFIG.robot.start)

    def hand(self) -> HandArm:
        """The next sample, exposed just now."""
        self._seq, self._steps = self._seq + 1, self._steps + (not self.still)
        angle = STEP_RAD * self._steps
        moved = (RADIUS_M * math.sin(angle), 0.0, RADIUS_M * (math.cos(angle) - 1.0))
        made = replace(sample(self._seq, moved, None), session=self._session, capture_ns=time.monotonic_ns() - AGE_NS)
        self.sent = self._remote.follow(made)
        if self.still:
            return made
        self._targets.append(self.sent)
        reached = Pose.from_transform(self._targets[0])
        self._states.append(self._remote.state(t_ns=0, base_T_tool=reached))
        return made

    def state(self) -> RobotState:
        """The state that comes by now."""
        while not self._states:
            self.hand()
        state = replace(self._states[0], t_ns=time.monotonic_ns() - LATE_NS)  # however slow the machine
        if state.lease is not None:
            state = replace(state, lease=replace(state.lease, session=self._session))
        self.measured = state.base_T_tool.transform()
        return state
