"""The fault with which a remote site ended, until an operator answers it at the one that came after; pure."""

from common.messages.robot import RobotState, SessionState


class UnansweredFault:
    """Keeps the fault of a remote site that was started again before anybody reset it; the new one knows nothing of it.

    A reset answers it, and so does an engagement of the new site.
    """

    def __init__(self) -> None:
        self._session: int | None = None
        self._reason = ""
        self.reason: str | None = None

    def see(self, state: RobotState) -> None:
        """Take the newest state; `reason` is then the fault's sentence, None where none is left to answer."""
        if state.state is SessionState.FAULT:
            self._session, self._reason, self.reason = state.session, state.reason, None
        elif self._session not in (None, state.session) and state.state is SessionState.DISENGAGED:
            self.reason = self._reason
        else:
            self._session = self.reason = None
