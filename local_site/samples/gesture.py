"""The opening hand as a gripper toggle: debounced, counted once on the rising edge (thesis 4.2)."""

from dataclasses import dataclass

from common.clock import NS_PER_MS


@dataclass(frozen=True, slots=True)
class OpenHand:
    """What the counter knows: the debounced state, since when the observation differs from it, and the count."""

    is_open: bool = False
    differs_since_ns: int | None = None
    toggles: int = 0


def observe(state: OpenHand, open_now: bool | None, t_ns: int, hold_ms: float = 120.0) -> OpenHand:
    """The state after an observation at `t_ns`; a change counts once it has lasted for `hold_ms`.

    None, a frame that did not show the hand, says nothing: the state stays as it was and a pending change starts anew.
    """
    if open_now is None or open_now == state.is_open:
        return OpenHand(state.is_open, None, state.toggles)
    since = state.differs_since_ns if state.differs_since_ns is not None else t_ns
    if t_ns - since < hold_ms * NS_PER_MS:
        return OpenHand(state.is_open, since, state.toggles)
    return OpenHand(open_now, None, state.toggles + (1 if open_now else 0))
