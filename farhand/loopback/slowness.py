"""Slowness of this machine in a run in which the arm followed little or stopped, as measured; pure."""

from collections.abc import Sequence

from common.messages.robot import FOLLOWING, RobotState
from farhand.loopback.figures import followed_share, per_second
from farhand.loopback.recorder import Record
from remote_site.drivers.franka.simulator import SLOWER
from remote_site.reasons import Code

LITTLE = 0.9  # of the time; a machine that keeps up follows for 95 % and more
ENOUGH_PICTURES = 0.8  # of those that the simulated cameras expose
LATE = (Code.SAMPLES_OLD, Code.SAMPLES_RARE)
CURE = "End what else runs on it, or try less: --headless, --tracker markers, --driver kinematic"


def too_slow(record: Record, fps: float, warnings: Sequence[str]) -> str | None:
    """Say what ran late where the arm followed little or stopped, and what to do; None where nothing did.

    `fps` is the rate of the simulated operator's pictures, `warnings` are what the sites have logged.
    """
    states, exposures_ns = list(record.states), [hand.capture_ns for hand in record.hands]
    if followed_share(states) >= LITTLE and states[-1].state in FOLLOWING:
        return None
    late = [*_samples(states), *_pictures(per_second(exposures_ns), fps), *_simulator(warnings)]
    return f"this machine was too slow: {'; '.join(late)}. {CURE}" if late else None


def _samples(states: Sequence[RobotState]) -> list[str]:
    """List how old the hand samples became: both sites are on this machine, so it is not the network."""
    links = [(state.hand_link, state.age_limit_ms) for state in states if state.hand_link is not None]
    ages = [(link.age_ms, limit_ms) for link, limit_ms in links if link.code in LATE and link.age_ms is not None]
    if not ages:
        return []
    age_ms, limit_ms = max(ages)
    return [f"the tracking was late, with hand samples {age_ms:.0f} ms old (limit {limit_ms:.0f} ms)"]


def _pictures(tracked: float, exposed: float) -> list[str]:
    few = 0.0 < tracked < ENOUGH_PICTURES * exposed
    return [f"it tracked {tracked:.0f} of {exposed:.0f} pictures a second"] if few else []


def _simulator(warnings: Sequence[str]) -> list[str]:
    return [SLOWER] if any(SLOWER in warning for warning in warnings) else []
