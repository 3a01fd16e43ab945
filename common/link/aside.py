"""Work that waits for a network, on a thread of its own: who wants it goes on meanwhile."""

import contextvars
import threading
from collections.abc import Callable

from common.errors import FarhandError


class Aside:
    """Does one piece of work at a time; what another asks for meanwhile is left out."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._thread: threading.Thread | None = None
        self._error: FarhandError | None = None
        self._wanted: object | None = None

    def start(self, work: Callable[[], object]) -> None:
        """Begin, unless some is still being done."""
        if self._thread is None or not self._thread.is_alive():
            self._wanted = token = object()
            run = contextvars.copy_context().run  # with what its log lines are to carry
            self._thread = threading.Thread(target=run, args=(self._do, work, token), name=self._name, daemon=True)
            self._thread.start()

    def check(self) -> None:
        """Raise, once, the FarhandError with which the last work ended."""
        error, self._error = self._error, None
        if error is not None:
            raise error

    def forget(self) -> None:
        """Drop what the work found, or will find."""
        self._wanted = self._error = None

    def _do(self, work: Callable[[], object], token: object) -> None:
        try:
            work()
        except FarhandError as error:
            if self._wanted is token:
                self._error = error
