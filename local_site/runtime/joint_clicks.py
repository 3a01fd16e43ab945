"""Passes the joints that the operator clicks on the console to the monocular tracker."""

from typing import Protocol

import structlog

from common.messages.requests import JointsRequest, Reply
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.tracker import Tracker, Views


class Clicks(Protocol):
    """Requests that wait to be answered."""

    def poll(self, now_ns: int, handle: "Handle") -> None: ...


class Handle(Protocol):
    """The function that answers one of them."""

    def __call__(self, request: JointsRequest) -> Reply: ...


class JointClicks:
    """Restarts the monocular tracker at the clicked joints; other trackers need no joints."""

    def __init__(self, clicks: Clicks, tracker: Tracker) -> None:
        self._clicks, self._tracker = clicks, tracker
        self._views: Views | None = None

    def poll(self, views: Views | None, now_ns: int) -> None:
        """Answer one request, if one waits; never blocks. The newest views give the picture's size."""
        self._views = views or self._views
        self._clicks.poll(now_ns, self.begin)

    def begin(self, request: JointsRequest) -> Reply:
        """Start with the next picture; whether the arm is found there, the tracker's status shows."""
        if not isinstance(self._tracker, MonocularTracker):
            return _refusal(request, "no_joints", "this tracker finds the arm by itself, without clicks")
        if self._views is None:
            return _refusal(request, "no_picture", "no picture has come yet; check the camera, then click again")
        height, width = self._views.views[self._tracker.camera].current.image.shape[:2]
        joints = request.shoulder, request.elbow, request.wrist
        self._tracker.start_at(*((across * width, down * height) for across, down in joints))
        structlog.get_logger().info("joints", shoulder=request.shoulder, elbow=request.elbow, wrist=request.wrist)
        return Reply(id=request.id, done=True, code="ok", reason="tracking begins where the joints were clicked")


def _refusal(request: JointsRequest, code: str, reason: str) -> Reply:
    return Reply(id=request.id, done=False, code=code, reason=reason)
