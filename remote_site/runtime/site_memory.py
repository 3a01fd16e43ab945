"""Memory of all processes of the remote site: the lease, whether all have started, whether and why all end."""

import mmap

import numpy as np

from common.messages.robot import VideoLink
from remote_site.session.lease import Lease
from remote_site.shared_record import SharedRecord
from remote_site.video.process import LeaseInForce

LEASE = np.dtype([("number", np.uint64), ("holder", "S32")])
VIDEO_LINK = np.dtype([("carries_mbit_s", np.float64), ("needs_mbit_s", np.float64), ("reason", "S400")])
FAILURE = np.dtype([("sentence", "S360")])  # what a state has room for, with the words before it

READY, ENDING = range(2)


class SiteMemory:
    """A lease, the video's link, a failure and two flags in memory that a fork inherits, each with one writer.

    Create it before the fork.
    """

    def __init__(self) -> None:
        self._lease = SharedRecord(LEASE)
        self._video_link = SharedRecord(VIDEO_LINK)
        self._failure = SharedRecord(FAILURE)
        self._flags = memoryview(mmap.mmap(-1, mmap.PAGESIZE))[:16].cast("Q")

    def show_lease(self, lease: Lease | None) -> None:
        """Publish the lease in force, None without one; only control may."""
        number, holder = (lease.number, lease.holder.name) if lease is not None else (0, "")
        self._lease.write(np.array((number, holder.encode()), LEASE))

    @property
    def lease(self) -> LeaseInForce | None:
        """The lease in force, None without one."""
        record = self._lease.read()
        number = int(record["number"])
        return LeaseInForce(number, record["holder"].item().decode()) if number else None

    def show_video_link(self, link: VideoLink | None) -> None:
        """Publish what the link carries of the pictures, None while it carries all; only video may."""
        fields = (link.carries_mbit_s, link.needs_mbit_s, link.reason.encode()) if link is not None else (0.0, 0.0, b"")
        self._video_link.write(np.array(fields, VIDEO_LINK))

    @property
    def video_link(self) -> VideoLink | None:
        """A link too narrow for the pictures, None while it carries all."""
        record = self._video_link.read()
        reason = record["reason"].item().decode(errors="replace")
        carries, needs = float(record["carries_mbit_s"]), float(record["needs_mbit_s"])
        return VideoLink(carries_mbit_s=carries, needs_mbit_s=needs, reason=reason) if reason else None

    def set_ready(self) -> None:
        """Every process has started; only the parent of all may call it."""
        self._flags[READY] = 1

    @property
    def ready(self) -> bool:
        """Return whether every process has started."""
        return self._flags[READY] == 1

    def set_ending(self) -> None:
        """The site was asked to end; only the parent of all may call it, before it ends them."""
        self._flags[ENDING] = 1

    @property
    def ending(self) -> bool:
        """Return whether the site was asked to end."""
        return self._flags[ENDING] == 1

    def set_failure(self, sentence: str) -> None:
        """The site has to end by itself; only the parent of all may call it, before it ends them."""
        self._failure.write(np.array((sentence.encode(),), FAILURE))

    @property
    def failure(self) -> str:
        """The reason why the site has to end by itself, empty as long as it has not to; cut off after 360 bytes."""
        failure: bytes = self._failure.read()["sentence"].item()
        return failure.decode(errors="ignore")
