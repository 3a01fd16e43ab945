"""Where the operator says that the joints are: the console's clicks reach the tracker that needs them."""

from typing import Protocol

import structlog

from common.requests import JointsRequest, Reply
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.tracker import Tracker


class Clicks(Protocol):
    """Requests that wait to be answered."""

    def poll(self, now_ns: int, handle: "Handle") -> None: ...


class Handle(Protocol):
    """What answers one of them."""

    def __call__(self, request: JointsRequest) -> Reply: ...


class JointClicks:
    """Lets the tracker of one camera begin anew where the joints were clicked; no other tracker needs to be told."""

    def __init__(self, clicks: Clicks, tracker: Tracker) -> None:
        self._clicks, self._tracker = clicks, tracker

    def poll(self, now_ns: int) -> None:
        """Answer one request, if one waits; never blocks."""
        self._clicks.poll(now_ns, self.begin)

    def begin(self, request: JointsRequest) -> Reply:
        """Done where the tracker begins with the next picture; whether it finds the arm there, its status tells."""
        if not isinstance(self._tracker, MonocularTracker):
            return Reply(
                id=request.id,
                done=False,
                code="no_joints",
                reason="this tracker finds the arm by itself, without clicks",
            )
        self._tracker.start_at(request.shoulder_px, request.elbow_px, request.wrist_px)
        structlog.get_logger().info("joints", shoulder=request.shoulder_px, elbow=request.elbow_px)
        return Reply(id=request.id, done=True, code="ok", reason="tracking begins where the joints were clicked")
