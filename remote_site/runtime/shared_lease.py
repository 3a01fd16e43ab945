"""The number of the lease in force, shared by control with the other processes of the remote site."""

import mmap

NO_LEASE = 0


class SharedLease:
    """One number in memory that a fork inherits; control writes it, others read it. Create it before the fork."""

    def __init__(self) -> None:
        self._number = memoryview(mmap.mmap(-1, mmap.PAGESIZE))[:8].cast("Q")

    def show(self, number: int) -> None:
        """Publish the number of the lease in force, `NO_LEASE` without one; only control may."""
        self._number[0] = number

    @property
    def number(self) -> int:
        """The number of the lease in force, `NO_LEASE` without one."""
        return self._number[0]
