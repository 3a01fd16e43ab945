"""The video process publishes every camera, and the absence of those that fail."""

import json
import os
import subprocess
import sys
import time
from collections import Counter

import cv2
import numpy as np
import pytest

from common.cameras.camera import Frame
from common.errors import CameraError, ConfigError
from common.messages import CameraStatus
from remote_site.video import process
from remote_site.video.config import CameraConfig, VideoConfig
from remote_site.video.live_camera import ThreadedCamera
from remote_site.video.process import run_video

SIMULATED_RUN = """
import json, time
import numpy as np
from remote_site.config import RobotConfig
from remote_site.shared_memory import CellMemory
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import CellConfig
from remote_site.video.config import VideoConfig
from remote_site.video.process import SimulatedViews, run_video

memory, seen = CellMemory.create(6), []
snapshot = np.zeros((), memory.snapshot.dtype)
qpos = build_cell(CellConfig(), RobotConfig()).start().qpos

def beat():
    if len(seen) < 40:  # then the cell dies
        snapshot[()] = (time.monotonic_ns(), qpos)
        memory.snapshot.write(snapshot)

def ended():
    return sum(m.status == "frozen" for m in seen) >= 4

views = SimulatedViews(CellConfig(), RobotConfig(), memory)
run_video(VideoConfig(width=160, height=120), views, seen.append, ended, beat)
print(json.dumps([[m.camera, m.status, m.seq, len(m.jpeg), m.reason] for m in seen]))
"""


@pytest.fixture(autouse=True)
def not_nice(monkeypatch):
    monkeypatch.setattr(process, "be_nice", lambda _: None)


def test_four_simulated_views_are_live_until_the_cell_dies():
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    run = subprocess.run(
        [sys.executable, "-c", SIMULATED_RUN], env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    if "CameraError" in run.stderr:
        pytest.skip(run.stderr.strip().splitlines()[-1])
    assert run.returncode == 0, run.stderr
    seen = json.loads(run.stdout)
    live = Counter(camera for camera, status, *_ in seen if status == "live")
    assert set(live) == {"front_high", "front_low", "side", "gripper"}
    assert max(live.values()) - min(live.values()) <= 2
    frozen = [row for row in seen if row[1] == "frozen"]
    assert {row[0] for row in frozen} == set(live)
    assert all(row[3] == 0 and "no new picture" in row[4] for row in frozen)


def run_until(config: VideoConfig, enough) -> list:
    seen, deadline = [], time.monotonic() + 10
    run_video(config, None, seen.append, lambda: enough(seen) or time.monotonic() > deadline, lambda: None)
    return seen


def test_a_folder_of_images_stands_in_for_a_camera_and_a_missing_one_is_told(tmp_path):
    rng = np.random.default_rng(1)
    for k in range(5):
        cv2.imwrite(str(tmp_path / f"{k:03d}.png"), rng.integers(0, 255, (24, 32, 3), dtype=np.uint8))
    config = VideoConfig(
        cameras=(CameraConfig(name="side", source=str(tmp_path)), CameraConfig(name="front", source="/nowhere/cam"))
    )
    seen = run_until(
        config, lambda seen: sum(m.camera == "side" for m in seen) >= 4 and any(m.camera == "front" for m in seen)
    )
    side = [m for m in seen if m.camera == "side" and m.status is CameraStatus.LIVE]
    front = [m for m in seen if m.camera == "front"]
    assert [m.seq for m in side] == list(range(len(side)))
    assert (side[0].width, side[0].height) == (32, 24)
    assert all(m.status is CameraStatus.MISSING and m.jpeg == b"" for m in front)
    assert "/nowhere/cam" in front[0].reason


def test_a_simulated_camera_needs_a_cell():
    with pytest.raises(ConfigError, match="no cell is simulated"):
        run_video(VideoConfig(), None, lambda _: None, lambda: True, lambda: None)


class Flaky:
    """A camera that gives one frame, then fails as if unplugged."""

    name = "flaky"

    def __init__(self) -> None:
        self.reads = 0

    def read(self) -> Frame:
        self.reads += 1
        if self.reads > 1:
            raise CameraError("camera flaky: unplugged")
        return Frame(np.zeros((4, 4, 3), np.uint8), 5, 0)

    def close(self) -> None: ...


def test_a_camera_that_fails_says_so_and_is_opened_again(monkeypatch):
    monkeypatch.setattr("remote_site.video.live_camera.REOPEN_S", 0.01)
    openings = []

    def open_it() -> Flaky:
        openings.append(1)
        return Flaky()

    camera, failures = ThreadedCamera("flaky", open_it), 0
    deadline = time.monotonic() + 5
    while len(openings) < 3 and time.monotonic() < deadline:
        try:
            camera.newest()
        except CameraError as error:
            failures += "unplugged" in str(error)
        time.sleep(0.001)
    camera.close()
    assert len(openings) >= 3
    assert failures
