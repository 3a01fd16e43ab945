"""Where the tool has been sent, against the remote site's whole pipeline behind a slow link."""

import math
from collections import deque
from typing import Any

import numpy as np
from msgspec.structs import replace

from common.clock import NS_PER_MS, NS_PER_S, ClockOffset
from common.geometry import Array, rotation_from_vector
from common.messages.hand import HandArm, Intent, OperatorSettings
from common.messages.requests import EngagementAction
from common.messages.robot import Pose, RobotState, SessionState
from lab.measure.page import scene
from local_site.console.model.sent_target import SentTarget
from remote_site.teleop.cycle import Snapshot
from tests.local_site.console.followed_remote import cell
from tests.remote_site.remote_loop import START_NS, RemoteLoop, hand

EVERY = 8  # ticks between samples
BEHIND = 20  # samples: a round trip of 640 ms
ONE_CLOCK = ClockOffset(0, NS_PER_MS)
FREQUENCY = 2 * math.pi / (4 * NS_PER_S)


def moving(seq: int, capture_ns: int, settings: OperatorSettings) -> HandArm:
    """A hand that goes round and turns, at a walking pace."""
    angle = FREQUENCY * (capture_ns - START_NS)
    wrist = np.array((0.05 * math.sin(angle), 0.04 * math.sin(2 * angle), 0.3))
    turn = rotation_from_vector(0.3 * math.sin(angle) * np.array((0.6, 0.0, 0.8)))
    index, thumb = (wrist + turn @ np.array(tip) for tip in ((0.02, -0.17, 0.0), (-0.05, -0.1, 0.01)))
    tips: dict[str, Any] = {"index": tuple(index.tolist()), "thumb": tuple(thumb.tolist())}
    intent = Intent(settings=settings)
    return hand(seq, capture_ns, tuple(wrist.tolist()), lease=settings.lease, intent=intent, **tips)


def reported(snapshot: Snapshot) -> RobotState:
    """The state that the remote site publishes of a cycle, in what matters here."""
    known = scene.state(SessionState.ENGAGED, "ok", "")
    follows = snapshot.state is SessionState.ENGAGED
    return replace(
        known,
        state=snapshot.state,
        t_ns=snapshot.now_ns,
        target=Pose.from_transform(snapshot.target) if follows else None,
        reference=snapshot.reference if follows else None,
        settings=snapshot.settings,
    )


def apart(first: Array, second: Array) -> float:
    return float(np.abs(first - second).max())


def test_behind_a_slow_link_it_is_where_the_pipeline_will_lead_the_tool() -> None:
    """With half the scales and a lock set on the way, which the console knows of before the remote site does."""
    loop, sent = RemoteLoop(), SentTarget()
    sent.describe(replace(cell(loop.config.mapping), held=False))
    before = OperatorSettings(lease=loop.lease)
    after = replace(before, revision=1, scale=0.5, rotation_scale=0.5, locks=replace(before.locks, x=True, roll=True))
    states: deque[RobotState] = deque(maxlen=BEHIND)
    foreseen: dict[int, Array] = {}
    errors, ahead = [], []
    for seq in range(1, 200):
        sample = moving(seq, loop.clock.now_ns(), before if seq < 120 else after)
        sent.add_hand(sample)
        loop.tick(sample)
        if seq == 60:
            assert loop.ask(EngagementAction.ENGAGE).done
        states.append(reported(loop.snapshot))
        sent.add_state(states[0])
        known = sent.base_T_tool(loop.clock.now_ns(), ONE_CLOCK)
        if known is not None:
            foreseen[seq] = known
            ahead.append(apart(known, states[0].target.transform()) if states[0].target is not None else 0.0)
        if loop.snapshot.obeys is not None and (made := foreseen.get(loop.snapshot.obeys.sample.seq)) is not None:
            errors.append(apart(made, loop.snapshot.target))
        for _ in range(EVERY - 1):
            loop.tick()
    assert len(errors) > 100
    assert max(ahead) > 0.02
    assert max(errors) < 1e-9
