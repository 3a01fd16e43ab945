"""The tool for pages: where the newest hand sample sent it before the remote site answers, and as measured; pure."""

from collections import deque
from typing import Any

import msgspec
import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, ClockOffset
from common.geometry import Array, transform
from common.mapping.relative_mapping import RelativeMapping
from common.mapping.shown_hand import shown_orientation, shown_position
from common.messages.hand import ClutchKey, HandArm, OperatorSettings, TrackingStatus
from common.messages.requests import Description
from common.messages.robot import MappingReference, Pose, RobotState

KEPT = 128  # samples: more than a second of them at 60 Hz, and a link's delay
OLDEST_STATE_NS = NS_PER_S
OLDEST_HAND_NS = 250 * NS_PER_MS
UNSEEN = (TrackingStatus.LOST, TrackingStatus.INITIALISING)


class SentTarget:
    """Computes what the remote site's mapping will make of the samples that it has not yet answered.

    It goes on from the newest state's reference, with the same mapping, through every own sample since. The target is
    inside the workspace box; the leash, which depends on where the arm will be, is left out.
    """

    def __init__(self) -> None:
        self._samples: deque[HandArm] = deque(maxlen=KEPT)
        self._replay: _Replay | None = None
        self._state: RobotState | None = None
        self._wanted: Array | None = None

    @property
    def wanted(self) -> Array | None:
        """The place (3,) where the hand last wanted the tool, outside the box too; None without a target."""
        return self._wanted

    def describe(self, cell: Description) -> None:
        """Take the cell's mapping and box; ConfigError when the mapping's rotation is none."""
        self._replay = _Replay(cell)

    def add_hand(self, sample: HandArm) -> None:
        """Take a sample that was sent to the remote site; a local site that has started again ends those before."""
        if self._samples and self._samples[-1].session != sample.session:
            self._samples.clear()
        self._samples.append(sample)

    def add_state(self, state: RobotState) -> None:
        """Take the remote site's newest state."""
        self._state = state

    def base_T_tool(self, now_ns: int, remote: ClockOffset | None) -> Array | None:
        """The target (4 x 4) of the newest sample; None where the arm does not follow it, or where it is not known.

        It is not known without the clocks' offset, with a state older than a second or a hand older than 250 ms, and
        while a sample since the state's is missing or stops the arm: after a stop the arm follows from new origins.
        """
        self._wanted = None
        state, replay = self._state, self._replay
        if state is None or replay is None or remote is None or remote.age_ns(state.t_ns, now_ns) > OLDEST_STATE_NS:
            return None
        if state.reference is None or state.settings is None or state.target is None:
            return None
        samples = self._since(state.reference)
        if not samples or now_ns - samples[-1].capture_ns > OLDEST_HAND_NS or not all(map(replay.is_followed, samples)):
            return None
        if state.settings.revision != state.reference.revision:  # a change came with a sample that was refused
            return None
        target = replay.target(samples, state.reference, state.settings, state.target.transform())
        self._wanted = replay.wanted
        return target

    def _since(self, reference: MappingReference) -> list[HandArm]:
        """The reference's sample and all after it; empty where one of them is missing."""
        samples = [s for s in self._samples if s.session == reference.session and s.seq >= reference.seq]
        whole = [s.seq for s in samples] == list(range(reference.seq, reference.seq + len(samples)))
        return samples if whole else []


class _Replay:
    """The remote site's mapping and box, led through samples again; `wanted` (3,) is the last target before the box."""

    def __init__(self, cell: Description) -> None:
        self._mapping = RelativeMapping(cell.mapping)
        self._point, self._held = cell.mapping.point, cell.held
        self._box = np.array(cell.workspace_min), np.array(cell.workspace_max)
        self.wanted: Array | None = None

    def is_followed(self, sample: HandArm) -> bool:
        """Return whether the arm can follow this sample: it shows the hand, clutch up, and key down where needed."""
        if sample.status in UNSEEN or shown_position(sample, self._point) is None:
            return False
        intent = sample.intent
        if intent is None:
            return not self._held
        return intent.clutch is ClutchKey.UP and (intent.hold or not self._held)

    def target(
        self, samples: list[HandArm], reference: MappingReference, settings: OperatorSettings, base_T_target: Array
    ) -> Array:
        """The target (4 x 4) of the last sample; `base_T_target` and `reference` are those after the first."""
        self._mapping.restore(reference, settings)
        first, *later = samples
        if not later:
            return self._aimed(first, None)
        for sample in later:
            settings = self._mapping.bounded(settings.followed_by(sample.intent.settings if sample.intent else None))
            base_T_target = self._steered(sample, settings, base_T_target)
        return base_T_target

    def _steered(self, sample: HandArm, settings: OperatorSettings, base_T_target: Array) -> Array:
        operator_R_hand = shown_orientation(sample)
        self._mapping.steer(settings, self._position(sample), operator_R_hand, base_T_target)
        return self._aimed(sample, operator_R_hand)

    def _aimed(self, sample: HandArm, operator_R_hand: Array | None) -> Array:
        target = self._mapping.target(self._position(sample), operator_R_hand)
        self.wanted = target[:3, 3].copy()
        return transform(target[:3, :3], np.clip(target[:3, 3], *self._box))

    def _position(self, sample: HandArm) -> Array:
        return np.array(shown_position(sample, self._point))


def tools_json(
    state: RobotState | None, hand: HandArm | None, sent: Array | None, wanted: Array | None, remote: ClockOffset | None
) -> str:
    """The tool as measured and where it was sent, with times by this host's clock in ms; None where one is not known.

    The measured tool is as old as the newest state, the target `sent` (4 x 4) as the newest hand sample;
    `wanted` (3,) is where that hand would have the tool, outside the box too.
    """
    measured = sent_to = None
    if state is not None and remote is not None:
        measured = _tool(state.base_T_tool, state.t_ns - remote.offset_ns)
    if sent is not None and hand is not None:
        sent_to = _tool(Pose.from_transform(sent), hand.capture_ns)
    where = None if wanted is None else wanted.tolist()
    return msgspec.json.encode({"type": "tools", "measured": measured, "sent": sent_to, "wanted": where}).decode()


def _tool(pose: Pose, t_ns: int) -> dict[str, Any]:
    return {"position": pose.position, "orientation": pose.orientation, "t_ms": t_ns / NS_PER_MS}
