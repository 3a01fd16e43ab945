"""The fault or stop with which a remote site ended, until an operator answers it at the one that came after; pure."""

from common.messages.robot import SITE_ENDED, STOPPED, RobotState, SessionState


class UnansweredFault:
    """Keeps the fault or stop of a remote site that was started again before a reset; the new one knows nothing of it.

    A reset answers it, and so does an engagement of the new site.
    """

    def __init__(self) -> None:
        self._session: int | None = None
        self._reason = ""
        self.reason: str | None = None

    def see(self, state: RobotState) -> None:
        """Take the newest state; `reason` is then the former site's sentence, None where none is left to answer."""
        if state.code == SITE_ENDED:
            return
        if state.state is SessionState.FAULT or state.code == STOPPED:
            self._session, self._reason, self.reason = state.session, state.reason, None
        elif self._session not in (None, state.session) and state.state is SessionState.DISENGAGED:
            self.reason = self._reason
        else:
            self._session = self.reason = None
