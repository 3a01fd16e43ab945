"""Where the tool has been sent: what the remote site makes of the same samples, and nothing where that is not known."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from common.clock import NS_PER_MS, NS_PER_S, ClockOffset
from common.messages.codec import decode, encode
from common.messages.hand import ClutchKey, HandArm, HandPoint, Intent, Locks, OperatorSettings, TrackingStatus
from common.messages.requests import Description
from common.messages.robot import RobotState, SessionState
from local_site.console.model.sent_target import SentTarget
from remote_site.teleop.config import LocksConfig, MappingConfig
from remote_site.teleop.followed_orientation import FollowedOrientation
from tests.local_site.console.followed_remote import BORN, CONFIG, LEASE, SESSION, Remote, cell, sample

EXACT = 1e-6  # m and rad: numbers travel with single precision
ONE_CLOCK = ClockOffset(0, NS_PER_MS)


def console(described: Description, samples: list[HandArm], state: RobotState) -> SentTarget:
    sent = SentTarget()
    sent.describe(decode(encode(described), Description, 16384))
    for hand in samples:
        sent.add_hand(hand)
    sent.add_state(state)
    return sent


steps = st.tuples(*(st.floats(-0.05, 0.05) for _ in range(3)))
turns = st.none() | st.tuples(*(st.floats(-1.8, 1.8) for _ in range(3)))
locks = st.builds(Locks, x=st.booleans(), z=st.booleans(), roll=st.booleans(), pitch=st.booleans())
changes = st.none() | st.tuples(st.floats(0.05, 3.0), st.floats(0.0, 2.0) | st.just(1.0), locks)
moves = st.lists(st.tuples(steps, turns, changes, st.booleans()), min_size=2, max_size=12)


def hands(given_moves: list[Any]) -> list[HandArm]:
    """A hand that goes step by step, shows its orientation or not, while settings change and the hand opens."""
    made, place, chosen = [], np.zeros(3), OperatorSettings(lease=LEASE)
    for seq, (step, turn, change, opened) in enumerate(given_moves):
        place = place + np.array(step)
        if change is not None:
            scale, rotation, locked = change
            chosen = replace(chosen, revision=chosen.revision + 1, scale=scale, rotation_scale=rotation, locks=locked)
        intent = Intent(hold=True, settings=chosen)
        made.append(sample(seq, place, turn, intent=intent, hand_open=opened and turn is not None))
    return made


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    moves,
    st.integers(0, 11),
    st.sampled_from([0.5, 1.0, 1.7]),
    st.sampled_from([LocksConfig(), LocksConfig(y=True, yaw=True)]),
    st.sampled_from(list(HandPoint)),
)
def test_it_is_what_the_remote_site_makes_of_the_same_samples_but_for_what_it_makes_up_or_takes_back(
    given_moves: list[Any], answered: int, scale: float, own: LocksConfig, point: HandPoint
) -> None:
    mapping = MappingConfig(scale=scale, locks=own, point=point)
    samples, remote = hands(given_moves), Remote(mapping)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(FollowedOrientation, "_made_up", lambda _self, lag, *_: lag)
        patched.setattr(FollowedOrientation, "_take_back", lambda *_: None)
        assert_foreseen(mapping, samples, remote, answered)


def assert_foreseen(mapping: MappingConfig, samples: list[HandArm], remote: Remote, answered: int) -> None:
    answered = min(answered, len(samples) - 1)
    for hand in samples[: answered + 1]:
        remote.follow(hand)
    sent = console(cell(mapping), samples, remote.state(samples[answered].capture_ns))
    for hand in samples[answered + 1 :]:
        remote.follow(hand)
    found = sent.base_T_tool(samples[-1].capture_ns, ONE_CLOCK)
    assert found is not None
    assert np.abs(found - remote.tool.base_T_tool).max() < EXACT


def following(moved: int = 4, *, held: bool = False) -> tuple[SentTarget, Remote, list[HandArm]]:
    """A console that has seen a hand go on for some samples since the state, which answers the second."""
    mapping, samples = MappingConfig(), [sample(seq, (0.0, -0.02 * seq, 0.0)) for seq in range(2 + moved)]
    remote = Remote(mapping)
    for hand in samples[:2]:
        remote.follow(hand)
    return console(cell(mapping, held=held), samples, remote.state(samples[1].capture_ns)), remote, samples


def test_it_leads_the_state_by_the_hands_motion_since() -> None:
    sent, remote, samples = following()
    found = sent.base_T_tool(samples[-1].capture_ns, ONE_CLOCK)
    assert found is not None
    assert found[:3, 3] - remote.tool.base_T_tool[:3, 3] == pytest.approx([0.08, 0.0, 0.0], abs=EXACT)


def test_it_stays_inside_the_box_however_far_the_hand_goes() -> None:
    sent, _, samples = following()
    far = sample(len(samples), (0.0, -3.0, 0.0))
    sent.add_hand(far)
    found = sent.base_T_tool(far.capture_ns, ONE_CLOCK)
    assert found is not None
    assert found[0, 3] == pytest.approx(CONFIG.safety.workspace_max_m[0], abs=EXACT)
    assert sent.wanted is not None
    assert sent.wanted[0] > CONFIG.safety.workspace_max_m[0] + 1.0
    assert sent.base_T_tool(far.capture_ns + 10**9, ONE_CLOCK) is None
    assert sent.wanted is None


Spoil = Callable[[SentTarget, Remote, list[HandArm]], None]


def state_of(**changes: Any) -> Spoil:
    def spoil(sent: SentTarget, remote: Remote, samples: list[HandArm]) -> None:
        sent.add_state(remote.state(**({"t_ns": samples[1].capture_ns} | changes)))

    return spoil


def newest_is(**changes: Any) -> Spoil:
    return lambda sent, _remote, samples: sent.add_hand(sample(len(samples), **changes))


def a_sample_is_missing(sent: SentTarget, _remote: Remote, samples: list[HandArm]) -> None:
    sent.add_hand(sample(len(samples) + 1))


def the_answered_sample_is_forgotten(sent: SentTarget, _remote: Remote, samples: list[HandArm]) -> None:
    for seq in range(len(samples), len(samples) + 200):
        sent.add_hand(sample(seq, capture_ns=samples[-1].capture_ns))


SPOILT: dict[str, Spoil] = {
    "the arm does not follow": state_of(state=SessionState.HOLDING, target=None, reference=None),
    "each target begins at the measured tool": state_of(reference=None),
    "nobody holds the lease": state_of(settings=None),
    "settings changed with a refused sample": state_of(settings=OperatorSettings(lease=LEASE, revision=1)),
    "the state is older than a second": state_of(t_ns=BORN - NS_PER_S),
    "the hand is lost": newest_is(status=TrackingStatus.LOST, wrist=None),
    "the hand is being learned": newest_is(status=TrackingStatus.INITIALISING),
    "the wrist is not seen": newest_is(wrist=None),
    "the key was let go": newest_is(intent=Intent(hold=False)),
    "the clutch is down": newest_is(intent=Intent(hold=True, clutch=ClutchKey.DOWN)),
    "nobody saw the clutch let go": newest_is(intent=Intent(hold=True, clutch=ClutchKey.UNSEEN)),
    "nobody reports the key": newest_is(intent=None),
    "the local site has started again": newest_is(session=SESSION + 1),
    "a sample is missing": a_sample_is_missing,
    "the answered sample is forgotten": the_answered_sample_is_forgotten,
}


@pytest.mark.parametrize("why", SPOILT)
def test_nothing_is_shown_where(why: str) -> None:
    sent, remote, samples = following(held=True)
    now_ns = samples[-1].capture_ns
    assert sent.base_T_tool(now_ns, ONE_CLOCK) is not None
    SPOILT[why](sent, remote, samples)
    assert sent.base_T_tool(now_ns, ONE_CLOCK) is None


def test_nothing_is_shown_without_clocks_with_an_old_hand_or_before_anything_is_known() -> None:
    sent, _, samples = following()
    newest_ns = samples[-1].capture_ns
    assert sent.base_T_tool(newest_ns + 250 * NS_PER_MS, ONE_CLOCK) is not None
    assert sent.base_T_tool(newest_ns + 251 * NS_PER_MS, ONE_CLOCK) is None
    assert sent.base_T_tool(newest_ns, None) is None
    assert SentTarget().base_T_tool(newest_ns, ONE_CLOCK) is None


def test_a_key_that_nobody_has_to_hold_is_not_asked_for() -> None:
    sent, _, samples = following(held=False)
    released = sample(len(samples), intent=Intent(hold=False))
    sent.add_hand(released)
    assert sent.base_T_tool(released.capture_ns, ONE_CLOCK) is not None


@pytest.mark.parametrize(
    "changes",
    [
        {"status": TrackingStatus.LOST, "wrist": None},
        {"intent": Intent(hold=False)},
        {"intent": Intent(hold=True, clutch=ClutchKey.DOWN)},
    ],
)
def test_after_what_stops_the_arm_nothing_is_shown_until_the_remote_site_has_answered(changes: dict[str, Any]) -> None:
    sent, _, samples = following(held=True)
    back = sample(len(samples) + 1)
    sent.add_hand(sample(len(samples), **changes))
    sent.add_hand(back)
    assert sent.base_T_tool(back.capture_ns, ONE_CLOCK) is None


def test_what_an_incremental_command_will_make_of_the_hand_is_not_known() -> None:
    remote = Remote(MappingConfig(command="incremental"))
    remote.follow(sample(0))
    remote.follow(sample(1))
    assert remote.tool.reference is None
