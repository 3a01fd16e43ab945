"""Which of a camera's pictures can be decoded: after a gap none, until a key frame."""

NEVER = -1


class Continuity:
    """Follows one camera's messages as one receiver takes them.

    `wants_after` is the number of the newest picture that cannot be decoded, after which a key frame has to come; None
    while there is none.
    """

    def __init__(self) -> None:
        self.wants_after: int | None = None
        self._seq = NEVER
        self._broken = True

    def take(self, seq: int, *, is_picture: bool, key: bool) -> bool:
        """Take a message; return whether it is of use: a status always, a picture if all that it needs were taken."""
        follows, self._seq = seq == self._seq + 1 and not self._broken, seq
        if is_picture and key:
            self._broken, self.wants_after = False, None
            return True
        self._broken = not follows
        if is_picture and self._broken:
            self.wants_after = seq
        return follows or not is_picture

    def interrupt(self) -> None:
        """The message taken last is lost after all."""
        self._broken, self.wants_after = True, max(0, self._seq)
