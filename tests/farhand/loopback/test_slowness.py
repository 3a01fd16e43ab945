"""A run in which the arm followed little says that this machine was too slow where the measured figures show it."""

import msgspec
import numpy as np
import pytest

from common.messages.robot import HandLink, RobotState, SessionState
from farhand.loopback.recorder import Record
from farhand.loopback.verdict import slow_views, too_slow
from tests.farhand.loopback.test_figures import hand, state

FPS = 30.0
SIMULATOR = 'remote: level=warning event="the simulated robot was slower than real time" pace=0.38'


def run(states: list[RobotState], followed: int, fps: float = FPS) -> Record:
    """These states, and so many of a hundred more in which the arm followed; pictures at this rate."""
    record, plain = Record(), state(0, np.zeros(3))
    holding = msgspec.structs.replace(plain, state=SessionState.HOLDING)
    record.states.extend([*states, *[plain] * followed, *[holding] * (100 - followed)])
    record.hands.extend(hand(round(k * 1e9 / fps), 0.0) for k in range(20))
    return record


def linked(age_ms: float | None, code: str) -> RobotState:
    link = HandLink(
        age_ms=age_ms,
        network_ms=1.0,
        clock_ms=1.0,
        tracking_ms=1.0,
        interval_ms=33.0,
        jitter_ms=1.0,
        loss=0.0,
        code=code,
    )
    return msgspec.structs.replace(state(0, np.zeros(3)), hand_link=link)


KEPT_UP = [linked(40.0, ""), linked(None, "samples_old"), state(0, np.zeros(3))]
LATE = [*KEPT_UP, linked(160.0, "samples_old"), linked(219.0, "samples_old"), linked(60.0, "")]


def test_late_hand_samples_few_pictures_and_a_slow_simulator_are_told_with_the_cure() -> None:
    told = too_slow(run(LATE, 34, fps=17.0), FPS, ["local: other", SIMULATOR])
    assert told == (
        "this machine was too slow: the tracking was late, with hand samples 219 ms old (limit 100 ms); it "
        "tracked 17 of 30 pictures a second; the simulated robot was slower than real time. End what else runs on it, "
        "or try less: --headless, --tracker markers, --driver kinematic"
    )


def test_a_run_that_ended_in_a_stop_is_explained_however_well_it_followed_before() -> None:
    record = run(LATE, 97)
    record.states.append(msgspec.structs.replace(state(0, np.zeros(3)), state=SessionState.DISENGAGED))
    told = too_slow(record, FPS, [])
    assert told is not None
    assert "hand samples 219 ms old" in told


def test_a_machine_that_did_not_even_start_the_sites_is_told_by_its_simulator_alone() -> None:
    told = too_slow(Record(), FPS, [SIMULATOR])
    assert told is not None
    assert "too slow: the simulated robot was slower than real time. End" in told


@pytest.mark.parametrize(
    ("record", "warnings"),
    [
        (run(LATE, 97, fps=17.0), [SIMULATOR]),  # it followed in spite of it
        (run(KEPT_UP, 34), ["local: other"]),  # it did not, for another reason
        (Record(), []),
    ],
)
def test_it_is_not_blamed_for_anything_else(record: Record, warnings: list[str]) -> None:
    assert too_slow(record, FPS, warnings) is None


def test_views_that_came_rarely_or_late_are_told_with_rate_and_age() -> None:
    def view(fps: float, age_ms: float | None) -> dict[str, object]:
        return {"fps": fps, "glass_to_glass_ms": {"p50": age_ms, "p95": age_ms}, "not_live": 0}

    good = {"side": view(15.0, 300.0), "gripper": view(30.0, 20.0), "never_seen": view(0.0, None)}
    assert slow_views(good, FPS) is None
    told = slow_views(good | {"front_high": view(4.4, 249.0), "front_low": view(29.0, 301.0)}, FPS)
    assert told == (
        "but it was too slow for pictures of the cell: front high 4 of 30 a second, 249 ms old; front low 29 of 30 a "
        "second, 301 ms old. End what else runs on this machine"
    )
