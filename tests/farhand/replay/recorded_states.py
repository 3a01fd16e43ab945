"""A recording with all that a page shows: a site that engages, and states as it would publish them."""

from dataclasses import dataclass
from pathlib import Path

import msgspec

from common.link.channels import STATE
from common.messages.codec import encode
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from tests.browser import scene
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.recording.recorded_site import CELL, RecordedSite

SECONDS = 6.0
ENGAGED_S = 2.0
TICKS_PER_STATE = 5


@dataclass(frozen=True, slots=True)
class RecordedStates:
    """The file, and when the session engages, s after its beginning."""

    file: Path
    engaged_s: float


def recorded_states(folder: Path) -> RecordedStates:
    """Record six seconds, engaged after two of them."""
    site = RecordedSite(folder)
    site.loop.link.activate(CONFIG.robot.start)
    _run(site, ENGAGED_S)
    site.loop.ask(EngagementAction.ENGAGE)
    site.note()
    _run(site, SECONDS - ENGAGED_S)
    site.recorder.step(site.clock.now_ns())
    site.recorder.end(site.clock.now_ns())
    return RecordedStates(site.files[0], ENGAGED_S)


def _run(site: RecordedSite, seconds: float) -> None:
    """A state each 20 ms, as control publishes them."""
    for _ in range(round(seconds * 250 / TICKS_PER_STATE)):
        site.run(TICKS_PER_STATE / 250, 0.02)
        engaged = site.loop.state is SessionState.ENGAGED
        words = ("ok", "the arm follows the hand") if engaged else ("not_engaged", "not engaged yet")
        state = scene.state(site.loop.state, *words, t_ns=site.clock.now_ns())
        state = msgspec.structs.replace(state, q=tuple(site.loop.driven.sent.q.tolist()))
        site.tap.note_message(STATE.key_for(CELL), encode(state), sent=True)
