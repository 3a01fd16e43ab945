"""The gripper's toggles: each opening of the hand while engaged acts once, however its messages come; pure."""


class GripperToggles:
    """Turns the count in the hand samples into open and closed; toggles made while not engaged are never applied."""

    def __init__(self, *, is_open: bool) -> None:
        self.is_open = is_open
        self.applied = 0
        self._baseline: int | None = None

    def rebase(self, count: int) -> None:
        """Count from here, as at an engagement."""
        self._baseline = count

    def follow(self, count: int) -> None:
        """Apply what has been counted since the baseline."""
        if self._baseline is not None and count > self._baseline:
            self.applied += count - self._baseline
            self.is_open ^= bool((count - self._baseline) % 2)
        self._baseline = count
