"""Tells the first refused message of each reason: whoever sends many must not fill the log."""

import structlog

from common.errors import MessageError


class RefusalLog:
    """Of one channel, which `event` names."""

    def __init__(self, event: str) -> None:
        self._event = event
        self._told: set[str] = set()

    def note(self, error: MessageError) -> None:
        """Tell of a message that was refused, unless one was for the same reason."""
        if error.reason not in self._told:
            self._told.add(error.reason)
            structlog.get_logger().warning(self._event, reason=str(error))
