"""The clutch as one receiver of its reports knows it: only a release in an unbroken row of them ends it; pure."""

from common.messages.hand import ClutchKey


class ClutchLatch:
    """`key` goes on to the next receiver; where a release may have been missed, another press and release ends it."""

    def __init__(self) -> None:
        self.key = ClutchKey.UP

    def see(self, key: ClutchKey) -> None:
        """Take the report that follows the one before it."""
        is_missed = self.key is ClutchKey.UNSEEN and key is ClutchKey.UP
        self.key = ClutchKey.UNSEEN if is_missed else key

    def interrupt(self) -> None:
        """The reports have ceased, come too late, or come from somebody else."""
        if self.key is ClutchKey.DOWN:
            self.key = ClutchKey.UNSEEN
