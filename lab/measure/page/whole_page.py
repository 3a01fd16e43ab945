"""The page with both sites: ages of the pictures, processor time, lateness of control, from the stop key to rest."""

import os
import time
from collections.abc import Callable
from contextlib import ExitStack
from itertools import pairwise

import numpy as np

from common.clock import NS_PER_MS
from common.messages.robot import RobotState, SessionState
from lab.measure.page.ages import Figures, painting
from lab.measure.page.chromium import Chromium, Tab
from lab.measure.page.painted_clock import compare
from lab.measure.page.stand import PageStand
from lab.stage.processes import child_of, cpu_s, keep_on_core

LATENESS_S = 17.0  # the window over which the control loop takes its lateness percentile
NOTE_ESCAPE = "addEventListener('keydown', (e) => { if (e.key === 'Escape') window.pressed = e.timeStamp; }, true)"
STOP_TRIALS = 5
MIN_MOTION_RAD = 0.01  # over four states, 80 ms
CELL_CORE, PAGE_CORE = 0, 1


def whole_figures() -> Figures:
    """With both sites and the page: the pictures' ages, processor load, control lateness, and stop latency."""
    with Chromium() as chromium, ExitStack() as stack:
        stand = PageStand(stack)
        stand.follow()
        console, address = stand.console(stand.video_port)
        time.sleep(LATENESS_S)
        closed_us = stand.record.states[-1].timing.late_p99_us
        page = chromium.open(address)
        video = child_of(stand.remote.pid, "farhand-video")
        console_s, video_s, began_s = cpu_s(console.pid), cpu_s(video), time.monotonic()
        painted = painting(chromium, page, LATENESS_S)
        passed_s = time.monotonic() - began_s
        figures = painted.figures("glass_to_glass")
        figures["console_core_percent"] = 100 * (cpu_s(console.pid) - console_s) / passed_s
        figures["video_core_percent_per_stream"] = 100 * (cpu_s(video) - video_s) / passed_s / max(1, len(painted.ages))
        figures["control_late_p99_us_page_closed"] = closed_us
        figures["control_late_p99_us_page_open"] = stand.record.states[-1].timing.late_p99_us
        return figures | stop_figures(stand, page)


def split_figures() -> Figures:
    """Cell, control and video on one core, console and browser on the other, nobody tracked: the pictures' ages.

    Without figures on a machine of one core.
    """
    if not {CELL_CORE, PAGE_CORE} <= os.sched_getaffinity(0):
        return {}
    with Chromium() as chromium, ExitStack() as stack:
        stand = PageStand(stack)
        console, address = stand.console(stand.video_port)
        page = chromium.open(address)
        for pid, core in ((stand.remote.pid, CELL_CORE), (console.pid, PAGE_CORE), (chromium.pid, PAGE_CORE)):
            keep_on_core(pid, core)
        return painting(chromium, page, LATENESS_S).figures("split_cores")


def stop_figures(stand: PageStand, page: Tab) -> Figures:
    """From the stop key, pressed while the arm moves, to the end of the session and to rest: medians and maxima, ms."""
    clock = compare(page)
    page.evaluate(NOTE_ESCAPE)
    ended_ms, rested_ms = [], []
    for _ in range(STOP_TRIALS):
        stand.wait("a moving arm", lambda: _engage_until_moving(stand, page))
        page.press("Escape")
        stand.wait("rest", lambda: _rests(stand))
        pressed_ns = round((page.evaluate("window.pressed") + clock.offset_ms) * NS_PER_MS)
        since = [state for state in list(stand.record.states) if state.t_ns > pressed_ns]
        ended_ms.append(_first_ms(since, pressed_ns, lambda _, now: now.code == "stopped"))
        rested_ms.append(
            _first_ms(
                since, pressed_ns, lambda last, now: now.code == "stopped" and last.q_commanded == now.q_commanded
            )
        )
    return {
        "stop_key_to_session_end_p50_ms": float(np.median(ended_ms)),
        "stop_key_to_session_end_max_ms": max(ended_ms),
        "stop_key_to_rest_p50_ms": float(np.median(rested_ms)),
        "stop_key_to_rest_max_ms": max(rested_ms),
    }


def _first_ms(states: list[RobotState], from_ns: int, is_so: Callable[[RobotState, RobotState], bool]) -> float:
    return next((after.t_ns - from_ns) / NS_PER_MS for before, after in pairwise(states) if is_so(before, after))


def _engage_until_moving(stand: PageStand, page: Tab) -> bool:
    """Return whether the arm moves; reset and engage it when it is disengaged."""
    state, before = stand.record.states[-1], stand.record.states[-5]
    if state.state is SessionState.DISENGAGED:
        for key in ("r", "e"):
            page.press(key)
            time.sleep(0.3)
    return bool(np.abs(np.subtract(state.q_commanded, before.q_commanded)).max() > MIN_MOTION_RAD)


def _rests(stand: PageStand) -> bool:
    """Return whether the arm is stopped and its commanded joint positions are the same for ten states, 0.2 s."""
    states = stand.record.states[-10:]
    return all(state.code == "stopped" and state.q_commanded == states[-1].q_commanded for state in states)
