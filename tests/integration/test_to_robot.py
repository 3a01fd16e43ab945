"""A recorded episode on a real remote site: nothing moves before the key is held, then the tool runs the path."""

import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from common.link.channels import INTENT, PREVIEW
from common.messages.hand import Intent, OperatorIntent
from common.messages.robot import SessionState
from common.messages.video import CameraStatus, VideoFrame
from farhand.loopback.site_process import options_of
from tests.farhand.replay.recorded_states import LENGTH_M, moves_back, recorded_states, start_pose
from tests.integration.sites import CELL, PATIENT, Sites, running_sites

OPERATOR = "anna"
NEAR_M = 2e-3
AGAIN_S, RELEASED_S = 3.0, 0.3


@contextmanager
def key(sites: Sites) -> Iterator[threading.Event]:
    """A console that reports, 50 times a second, whether the key is held: as long as the event is set."""
    held, stop = threading.Event(), threading.Event()
    publisher = sites.link.publisher(INTENT, CELL, operator=OPERATOR)

    def report() -> None:
        while not stop.wait(0.02):
            publisher.put(OperatorIntent(session=1, sent_ns=time.monotonic_ns(), intent=Intent(hold=held.is_set())))

    thread = threading.Thread(target=report)
    thread.start()
    try:
        yield held
    finally:
        stop.set()
        thread.join()


@contextmanager
def replaying(sites: Sites, file: Path) -> Iterator["subprocess.Popen[str]"]:
    given = options_of([*sites.endpoints.local, f"authority.operator={OPERATOR}"])
    command = [sys.executable, "-m", "farhand", "replay", str(file), "--to-robot", *given]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        try:
            yield process
        finally:
            process.terminate()


def wait_pressing(sites: Sites, held: threading.Event, what: str, is_so: Callable[[], bool]) -> None:
    """Wait until something is so; where the arm does not follow, since a machine was late, press the key again."""
    pressed_s = time.monotonic()

    def so_while_pressed() -> bool:
        nonlocal pressed_s
        if sites.is_in(SessionState.DISENGAGED) and time.monotonic() - pressed_s > AGAIN_S:
            held.clear()
            time.sleep(RELEASED_S)
            held.set()
            pressed_s = time.monotonic()
        return is_so()

    held.set()
    sites.wait(what, so_while_pressed)


def off_m(sites: Sites, position: np.ndarray) -> float:
    return float(np.linalg.norm(np.array(sites.state.base_T_tool.position) - position))


def test_the_recorded_path_is_run_while_the_key_is_held_and_ends_with_it(tmp_path: Path) -> None:
    file = recorded_states(tmp_path, moves_back).file
    begin = start_pose()[:3, 3]
    end = begin + np.array([-0.05 - LENGTH_M, 0.0, -0.02])
    with running_sites() as sites:
        sites.remote("driver.name=kinematic", "engagement.mode=hold_to_run", *PATIENT)
        sites.wait_for_states()
        views, shown = sites.link.latest(PREVIEW, CELL, "left", operator=OPERATOR), list[VideoFrame]()

        def told() -> VideoFrame | None:
            shown.extend(frame for frame in [views.take()] if frame is not None)
            return shown[-1] if shown else None

        with replaying(sites, file), key(sites) as held:
            sites.wait("readiness", lambda: sites.state.readiness.ready)
            sites.wait("the words in the place of a view", lambda: told() is not None)
            assert (shown[-1].status, shown[-1].data) == (CameraStatus.MISSING, b"")
            assert shown[-1].reason == f"no camera is used: a recorded path is run, episode 1 of {file.name}"
            assert off_m(sites, begin) < NEAR_M
            wait_pressing(sites, held, "the path to begin", lambda: off_m(sites, begin) > 0.06)
            held.clear()
            sites.wait("the stop", lambda: sites.is_in(SessionState.DISENGAGED))
            stood = np.array(sites.state.base_T_tool.position)
            time.sleep(1.0)
            assert off_m(sites, stood) < NEAR_M
            assert off_m(sites, end) > 0.02
            wait_pressing(sites, held, "the path's end", lambda: off_m(sites, end) < NEAR_M)


@pytest.mark.slow
def test_a_cell_that_needs_no_key_is_refused(tmp_path: Path) -> None:
    file = recorded_states(tmp_path, moves_back).file
    with running_sites() as sites:
        sites.remote("driver.name=kinematic", *PATIENT)
        sites.wait_for_states()
        with replaying(sites, file) as process:
            assert process.wait(60) == 1
            assert process.stdout is not None
            assert 'set engagement.mode = "hold_to_run"' in process.stdout.read()
