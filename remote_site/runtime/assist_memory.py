"""Memory of control and video for fine adjustment: the measured joints of the last second, and the markers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array
from remote_site.assist.config import AssistConfig
from remote_site.assist.sighting import MarkerSighting
from remote_site.reasons import Code, Reason
from remote_site.shared_record import Record, SharedRecord

KEPT = 256  # a second of control ticks: the pictures of slow cameras are as old
NEWER_NS = 20 * NS_PER_MS  # a picture may be newer than the newest reading of the robot
CODES = {code.value: code for code in Code}
SIGHTING = np.dtype(
    [
        ("marker", np.uint32),
        ("t_ns", np.int64),
        ("seen", np.bool_),
        ("base_T_marker", np.float64, (4, 4)),
        ("code", "S32"),
        ("sentence", "S400"),
        ("views", "S800"),
    ]
)


class AssistMemory:
    """Memory that a fork inherits: control writes the joints, video the markers. Create it before the fork."""

    def __init__(self, config: AssistConfig, joints: int) -> None:
        self._joints = SharedRecord(np.dtype([("t_ns", np.int64), ("q", np.float64, (joints,))]), KEPT)
        self._sightings = SharedRecord(np.dtype([("sightings", SIGHTING, (len(config.marker_sizes_m),))]))
        self._taken = self._sightings.count

    def show_joints(self, t_ns: int, q: Array) -> None:
        """Note the joints `q` (n,) in rad as measured at a time; only control may."""
        self._joints.write(np.array((t_ns, q), self._joints.dtype))

    def joints_at(self, t_ns: int) -> Array | None:
        """The joints (n,) in rad at a time, between the readings around it; None where none are near."""
        after: Record | None = None
        newest = self._joints.count
        for number in range(newest, max(newest - KEPT + 2, 0), -1):
            before = self._joints.read_number(number)
            if before is None or before["t_ns"] == 0:
                return None
            if before["t_ns"] <= t_ns:
                return _between(before, after, t_ns)
            after = before
        return None

    def show_markers(self, sightings: Sequence[MarkerSighting]) -> None:
        """Publish what is known of all markers; only video may."""
        record = np.zeros((), self._sightings.dtype)
        for k, one in enumerate(sightings):
            pose = one.base_T_marker if one.base_T_marker is not None else np.zeros((4, 4))
            code, sentence = (one.refusal.code.value, one.refusal.sentence) if one.refusal is not None else ("", "")
            text = code.encode(), sentence.encode(), ",".join(one.views).encode()
            record["sightings"][k] = (one.marker, one.t_ns, one.base_T_marker is not None, pose, *text)
        self._sightings.write(record)

    def take_markers(self) -> tuple[MarkerSighting, ...]:
        """Take what is newly known of the markers since the last call."""
        if self._sightings.count == self._taken:
            return ()
        self._taken = self._sightings.count
        return tuple(_sighting(record) for record in self._sightings.read()["sightings"])


def _between(before: Record, after: Record | None, t_ns: int) -> Array | None:
    if after is None:
        return np.array(before["q"]) if t_ns - before["t_ns"] <= NEWER_NS else None
    fraction = float((t_ns - before["t_ns"]) / (after["t_ns"] - before["t_ns"]))
    return np.asarray(before["q"] + fraction * (after["q"] - before["q"]), dtype=float)


def _sighting(record: Record) -> MarkerSighting:
    fields: Any = record.item()
    marker, t_ns, seen, base_T_marker, code, sentence, views = fields
    if not seen:
        return MarkerSighting(marker, t_ns, None, Reason(CODES[code.decode()], sentence.decode(errors="replace")))
    return MarkerSighting(marker, t_ns, np.array(base_T_marker), None, tuple(views.decode(errors="ignore").split(",")))
