"""A recorded session made of formulas: smooth joints, pictures that tell their view and number, known episodes."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import cv2
import numpy as np
import simplejpeg

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from farhand.export.session import (
    SentActions,
    SessionEpisode,
    SessionFacts,
    SessionSignals,
    SessionStates,
    Signal,
    Times,
    ViewPicture,
)
from farhand.export.videos.h264 import Rgb

JOINTS = ("waist", "shoulder", "elbow")
BEGIN_NS = 1_000 * NS_PER_S  # of the clock of the host that recorded
EPOCH_NS = 1_790_000_000 * NS_PER_S
OPERATOR_NS = 77 * NS_PER_S  # the operator's clock is behind by so much
TICK_NS, SENT_LATER_NS = 4 * NS_PER_MS, NS_PER_MS
OPEN_M = 0.05


@dataclass
class MadeSession:
    """`seconds` of a session with two views (width, height), and episodes of these bounds in seconds."""

    name: str = "made"
    seconds: float = 5.0
    spans: tuple[tuple[float, float], ...] = ((0.5, 2.5), (2.7, 4.4))
    tasks: tuple[str, ...] = ("put the block on the mark", "öffne die Schublade")
    success: tuple[bool | None, ...] = (True, False)
    views: dict[str, tuple[int, int]] = field(default_factory=lambda: {"front": (160, 120), "tool": (128, 96)})
    camera_hz: float = 25.0
    has_gripper: bool = True
    phase: float = 0.0
    pictures_read: int = 0

    @property
    def facts(self) -> SessionFacts:
        """What holds for the whole session."""
        episodes = tuple(
            SessionEpisode(k + 1, at_s(a), at_s(b), self.tasks[k % 2], self.success[k % 2], f"note {k}")
            for k, (a, b) in enumerate(self.spans)
        )
        end = at_s(self.seconds)
        return SessionFacts(
            self.name, f"{self.name} {self.phase}", "a465", JOINTS, self.has_gripper, self.views, BEGIN_NS, end,
            EPOCH_NS - BEGIN_NS, episodes,
        )  # fmt: skip

    def signals(self) -> SessionSignals:
        """Joints each 4 ms, sent 1 ms later 0.01 rad ahead; the gripper closes for the middle third of each second."""
        t_ns = np.arange(BEGIN_NS, at_s(self.seconds), TICK_NS, dtype=np.int64)
        q = joints(t_ns, self.phase)
        tool = np.column_stack((q * 0.1, np.sin(q), np.cos(q[:, 0])))
        sent_ns = t_ns + SENT_LATER_NS
        third = ((t_ns - BEGIN_NS) % NS_PER_S) * 3 // NS_PER_S
        commanded = np.where(third == 1, 0.0, np.where(third == 2, np.nan, OPEN_M))
        opening = OPEN_M * (0.5 + 0.5 * np.sin(4 * (t_ns - BEGIN_NS) / NS_PER_S))
        actions = SentActions(
            Signal(sent_ns, q + 0.01),
            commanded if self.has_gripper else np.full(len(t_ns), np.nan),
            t_ns - 60 * NS_PER_MS,
            t_ns - 60 * NS_PER_MS - OPERATOR_NS,
        )
        gripper = Signal(t_ns, opening[:, None]) if self.has_gripper else None
        states = SessionStates(np.array([BEGIN_NS, at_s(0.5)], np.int64), ("disengaged", "engaged"))
        return SessionSignals(Signal(t_ns, q), Signal(t_ns, tool), gripper, actions, states)

    def pictures(self, begin_ns: int, end_ns: int) -> Iterator[ViewPicture]:
        """The pictures of all views; the second view is exposed 7 ms after the first."""
        period_ns = round(NS_PER_S / self.camera_hz)
        for number in range(int(self.seconds * self.camera_hz)):
            for k, (view, size) in enumerate(self.views.items()):
                t_ns = BEGIN_NS + number * period_ns + 7 * k * NS_PER_MS
                if begin_ns <= t_ns < end_ns:
                    self.pictures_read += 1
                    yield ViewPicture(view, t_ns, jpeg(drawn(size, number, k)))


def at_s(seconds: float) -> int:
    """A time of the session by the clock of the host that recorded, ns."""
    return BEGIN_NS + round(seconds * NS_PER_S)


def joints(t_ns: Times, phase: float) -> Array:
    """The joints (n, 3) at these times, rad."""
    t = (t_ns - BEGIN_NS) / NS_PER_S
    return np.column_stack([np.sin((1 + 0.3 * k) * t + phase + k) for k in range(len(JOINTS))])


def drawn(size: tuple[int, int], number: int, view: int) -> Rgb:
    """A smooth picture that differs from each other one by where its disc is."""
    width, height = size
    ramp = np.linspace(40, 200, width).astype(np.uint8)
    picture = np.stack([np.tile(ramp, (height, 1)), np.full((height, width), 90 + 60 * view, np.uint8),
                        np.tile(ramp[::-1], (height, 1))], axis=-1)  # fmt: skip
    centre = 20 + number * 5 % (width - 40), 20 + number * 3 % (height - 40)
    cv2.circle(picture, centre, 14, (230, 40, 40), -1, cv2.LINE_AA)
    return picture


def jpeg(picture: Rgb) -> bytes:
    """A picture as the cell's cameras give it."""
    return bytes(simplejpeg.encode_jpeg(np.ascontiguousarray(picture), 92, "RGB", "420"))
