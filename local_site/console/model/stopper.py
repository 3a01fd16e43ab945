"""Which page of this console has asked for the stop that stands, so that a page can say who it was; pure."""

from common.clock import NS_PER_S
from common.messages.robot import STOPPED, RobotState, SessionState
from local_site.console.model.seat import Visitor

ASKED_WITHIN_NS = 2 * NS_PER_S  # a page asks each second until the remote site has acknowledged it


class Stopper:
    """Takes the pages' stops and the remote site's states; `page` is whose stop stands, None if nobody's here."""

    def __init__(self) -> None:
        self.page: Visitor | None = None
        self._asked_by: Visitor | None = None
        self._asked_ns = 0

    def ask(self, page: Visitor, now_ns: int) -> None:
        """A page asks for a stop."""
        self._asked_by, self._asked_ns = page, now_ns

    def see(self, state: RobotState, now_ns: int) -> None:
        """Take the newest state."""
        if state.state is not SessionState.FAULT and state.readiness.code != STOPPED:
            self.page = None
        elif self._asked_by is not None and now_ns - self._asked_ns <= ASKED_WITHIN_NS:
            self.page = self._asked_by
