"""The key of fine adjustment as the samples report it; what has ended does not start by itself; pure."""

from common.clock import NS_PER_MS
from common.messages.hand import Intent

SILENT_NS = 200 * NS_PER_MS


class HeldKey:
    """Which target the operator holds the key for; after a silence only a press that follows a release counts."""

    def __init__(self) -> None:
        self._target: str | None = None
        self._pressed: str | None = None
        self._released = False
        self._heard_ns: int | None = None

    @property
    def held(self) -> bool:
        """Whether the key is held, as far as that counts."""
        return self._target is not None

    def see(self, intent: Intent | None, now_ns: int) -> None:
        """Take a sample's intent, None where no page reported one."""
        if intent is None:
            self._forget()
            return
        self._heard_ns = now_ns
        target = intent.assist if self._released else None
        if target is not None and self._target is None:
            self._pressed = target
        if target is None or target != (self._target or target):
            self._pressed = target = None
        self._released = intent.assist is None or (self._released and target is not None)
        self._target = target

    def pressed(self) -> str | None:
        """The target that the key was pressed for since the last call, None without a press."""
        pressed, self._pressed = self._pressed, None
        return pressed

    def lapse(self, now_ns: int) -> int | None:
        """For how long nothing was reported, ns, once that is too long: the key no longer counts as held."""
        if self._heard_ns is None or now_ns - self._heard_ns <= SILENT_NS:
            return None
        silent_ns = now_ns - self._heard_ns
        self._forget()
        return silent_ns

    def _forget(self) -> None:
        self._target = self._pressed = self._heard_ns = None
        self._released = False
