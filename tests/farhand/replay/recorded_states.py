"""A recording with all that a page shows: a site that engages, and states as it would publish them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import msgspec
import numpy as np

from common.geometry import Array, transform
from common.link.channels import STATE
from common.messages.codec import encode
from common.messages.requests import EngagementAction
from common.messages.robot import Pose, SessionState
from lab.measure.page import scene
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.recording.recorded_site import CELL, RecordedSite

SECONDS = 6.0
ENGAGED_S = 2.0
TICKS_PER_STATE = 5

LENGTH_M = 0.08

Change = Callable[[float], dict[str, Any]]


@dataclass(frozen=True, slots=True)
class RecordedStates:
    """The file, and when the session engages, s after its beginning."""

    file: Path
    engaged_s: float


def recorded_states(folder: Path, change: Change = lambda _: {}) -> RecordedStates:
    """Record six seconds, engaged after two of them; `change` gives fields of the state at a time in s."""
    name, content = _recording(change)
    file = folder / name
    file.write_bytes(content)
    return RecordedStates(file, ENGAGED_S)


@lru_cache(maxsize=4)
def _recording(change: Change) -> tuple[str, bytes]:
    """Name and content of the file, recorded once: it depends on stepped time alone."""
    with TemporaryDirectory() as folder:
        site = RecordedSite(Path(folder))
        site.loop.link.activate(CONFIG.robot.start)
        _run(site, 0.0, ENGAGED_S, change)
        site.loop.ask(EngagementAction.ENGAGE)
        site.note()
        _run(site, ENGAGED_S, SECONDS, change)
        site.recorder.step(site.clock.now_ns())
        site.recorder.end(site.clock.now_ns())
        (file,) = site.files
        return file.name, file.read_bytes()


def start_pose() -> Array:
    """Where the tool of the default arm begins."""
    robot = RemoteConfig().robot
    return load_arm(robot)[0].forward(np.array(robot.start))


def moves_back(at_s: float) -> dict[str, object]:
    """The tool's target 80 mm back, in the four seconds of the engagement; a cell without gripper."""
    part = min(max((at_s - ENGAGED_S) / (SECONDS - ENGAGED_S - 0.5), 0.0), 1.0)
    begin = start_pose()
    shift = np.array([-0.05 - LENGTH_M * part, 0.0, -0.02])
    target = Pose.from_transform(transform(begin[:3, :3], begin[:3, 3] + shift)) if at_s >= ENGAGED_S else None
    return {"target": target, "gripper": None, "gripper_toggles_applied": 0}


def _run(site: RecordedSite, begin_s: float, end_s: float, change: Change) -> None:
    """A state each 20 ms, as control publishes them."""
    for k in range(round((end_s - begin_s) * 250 / TICKS_PER_STATE)):
        site.run(TICKS_PER_STATE / 250, 0.02)
        engaged = site.loop.state is SessionState.ENGAGED
        words = ("ok", "the arm follows the hand") if engaged else ("not_engaged", "not engaged yet")
        state = scene.state(site.loop.state, *words, t_ns=site.clock.now_ns())
        state = msgspec.structs.replace(state, q=tuple(site.loop.driven.sent.q.tolist()))
        state = msgspec.structs.replace(state, **change(begin_s + k * TICKS_PER_STATE / 250))
        site.tap.note_message(STATE.key_for(CELL), encode(state), sent=True)
