"""Whose lease is in force, for the processes of the remote site that are not control."""

import mmap

NOBODY = 0


class SharedLease:
    """One number in memory that a fork inherits; control shows it, others look. Create it before the fork."""

    def __init__(self) -> None:
        self._number = memoryview(mmap.mmap(-1, mmap.PAGESIZE))[:8].cast("Q")

    def show(self, number: int) -> None:
        """The number of the lease in force, `NOBODY` without one; only control may."""
        self._number[0] = number

    @property
    def number(self) -> int:
        """The lease in force, `NOBODY` without one."""
        return self._number[0]
