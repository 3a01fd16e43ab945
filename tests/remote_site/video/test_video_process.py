"""The video process publishes every camera, and the absence of those that fail."""

import json
import os
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable

import cv2
import numpy as np
import pytest
from structlog.testing import capture_logs

from common.cameras.camera import Frame
from common.cameras.lost_pictures import LostPictures
from common.errors import CameraError, ConfigError, MessageError
from common.messages.video import (
    CameraStatus,
    VideoFrame,
    ViewCame,
    ViewShown,
    ViewsShown,
)
from remote_site.video import process, sources
from remote_site.video.config import CameraConfig, VideoConfig
from remote_site.video.process import LeaseInForce, VideoTally, VideoWire, run_video
from remote_site.video.sources import ThreadedCamera
from remote_site.video.streaming.adaptation import Adaptation
from tests.common.cameras.losing_camera import LOST, LosingCamera

SIMULATED_RUN = """
import json, time
import numpy as np
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import CellConfig
from remote_site.video.config import VideoConfig
from remote_site.video.process import LeaseInForce, VideoWire, run_video
from remote_site.video.sources import SimulatedViews

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
run_video(VideoConfig(width=160, height=120), views, VideoWire(seen.append), ended, beat)
print(json.dumps([[m.camera, m.status, m.seq, len(m.data), m.reason] for m in seen]))
"""


@pytest.fixture(autouse=True)
def not_nice(monkeypatch):
    monkeypatch.setattr(process, "be_nice", lambda _: None)


@pytest.mark.slow
def test_four_simulated_views_are_live_until_the_cell_dies():
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    run = subprocess.run(
        [sys.executable, "-c", SIMULATED_RUN], env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    if "CameraError" in run.stderr:
        pytest.skip(run.stderr.strip().splitlines()[-1])
    assert run.returncode == 0, run.stderr
    seen = json.loads(run.stdout)
    live = Counter(camera for camera, _, _, jpeg, _ in seen if jpeg)
    assert set(live) == {"front_high", "front_low", "side", "gripper"}
    assert max(live.values()) - min(live.values()) <= 2
    frozen = [row for row in seen if row[1] == "frozen"]
    assert {row[0] for row in frozen} == set(live)
    assert all(row[3] == 0 and "no new picture" in row[4] for row in frozen)


def do_nothing() -> None:
    pass


def run_until(
    config: VideoConfig, enough: Callable[[list[VideoFrame]], bool], beat: Callable[[], None] = lambda: None
) -> list[VideoFrame]:
    seen, deadline = list[VideoFrame](), time.monotonic() + 10
    run_video(config, None, VideoWire(seen.append), lambda: enough(seen) or time.monotonic() > deadline, beat)
    return seen


def test_without_a_camera_the_process_lives_sends_nothing_and_ends_when_asked():
    beats: list[float] = []
    seen = run_until(VideoConfig(cameras=()), lambda _: len(beats) > 3, beat=lambda: beats.append(time.monotonic()))
    assert seen == []
    assert 4 <= len(beats) < 100
    tally = VideoTally(())
    assert (tally.sentences(), tally.lost.read()) == ({}, {})


@pytest.mark.parametrize(("listens", "width"), [(True, 32), (False, 16)])
def test_while_nobody_listens_and_at_first_then_pictures_are_small(tmp_path, listens, width):
    rng = np.random.default_rng(1)
    for k in range(5):
        cv2.imwrite(str(tmp_path / f"{k:03d}.png"), rng.integers(0, 255, (24, 32, 3), dtype=np.uint8))
    config = VideoConfig(cameras=(CameraConfig(name="side", source=str(tmp_path)),))
    seen, deadline = list[VideoFrame](), time.monotonic() + 10
    wire = VideoWire(seen.append, has_listener=lambda: listens)
    run_video(config, None, wire, lambda: any(m.data for m in seen) or time.monotonic() > deadline, lambda: None)
    assert next(m.width for m in seen if m.data) == width


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
    assert all(m.status is CameraStatus.MISSING and m.data == b"" for m in front)
    assert "/nowhere/cam" in front[0].reason


def test_a_simulated_camera_needs_a_cell():
    with pytest.raises(ConfigError, match="no cell is simulated"):
        run_video(VideoConfig(), None, VideoWire(lambda _: None), lambda: True, lambda: None)


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
    monkeypatch.setattr("remote_site.video.sources.REOPEN_S", 0.01)
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


def test_what_a_camera_loses_is_counted_over_its_openings(monkeypatch):
    monkeypatch.setattr("remote_site.video.sources.REOPEN_S", 0.001)
    lost, openings = LostPictures(["front", "side"]), []
    third = threading.Event()

    def open_it() -> LosingCamera:
        openings.append(1)
        if len(openings) > 2:
            third.set()
            raise CameraError("unplugged")
        return LosingCamera("side")

    camera = ThreadedCamera("side", open_it, lost)
    assert third.wait(5)
    camera.close()
    assert lost.read() == {"front": 0, "side": 2 * LOST}


class Endless:
    """A camera that never gives its second picture until it is released, or one as quick as requested."""

    def __init__(self, name: str, hangs: threading.Event | None) -> None:
        self.name = name
        self._hangs = hangs
        self._seq = 0

    def read(self) -> Frame | None:
        if self._hangs is not None and self._seq:
            self._hangs.wait()
            return None
        time.sleep(0.01)
        self._seq += 1
        image = np.random.default_rng(self._seq).integers(0, 255, (24, 32, 3), dtype=np.uint8)
        return Frame(image, time.monotonic_ns(), self._seq)

    def close(self) -> None: ...


def test_a_camera_that_hangs_delays_no_other_and_is_told_as_frozen(monkeypatch):
    released = threading.Event()
    cameras = {"side": Endless("side", None), "front": Endless("front", released)}
    monkeypatch.setattr(sources, "open_camera", lambda _source, name, *_: cameras[name])
    monkeypatch.setattr("remote_site.video.sources.LiveCamera", Endless)
    config = VideoConfig(cameras=(CameraConfig(name="front", source="0"), CameraConfig(name="side", source="1")))

    def enough(seen: list[VideoFrame]) -> bool:
        return any(m.camera == "front" and m.status is CameraStatus.FROZEN for m in seen)

    try:
        seen = run_until(config, enough)
    finally:
        released.set()
    assert [m.status for m in seen if m.camera == "front"] == [CameraStatus.LIVE, CameraStatus.FROZEN]
    assert sum(m.camera == "side" and m.status is CameraStatus.LIVE for m in seen) > 10


def test_no_picture_goes_while_one_waits_in_this_host(monkeypatch):
    monkeypatch.setattr(sources, "open_camera", lambda _source, name, *_: Endless(name, None))
    monkeypatch.setattr("remote_site.video.sources.LiveCamera", Endless)
    seen: list[VideoFrame] = []
    waits_left = 20  # times that it is asked about a picture

    def unsent_bytes() -> int:
        nonlocal waits_left
        waits = len(seen) == 5 and waits_left > 0
        waits_left -= waits
        return 1_000_000 if waits else 0

    wire, deadline = VideoWire(seen.append, unsent_bytes=unsent_bytes), time.monotonic() + 10
    config = VideoConfig(cameras=(CameraConfig(name="side", source="0"),))
    run_video(config, None, wire, lambda: len(seen) > 8 or time.monotonic() > deadline, do_nothing)
    assert waits_left == 0
    assert [frame.seq for frame in seen] == list(range(9))
    assert {frame.status for frame in seen} == {CameraStatus.LIVE}


class Narrow:
    """A console that shows every picture later than the one before."""

    def __init__(self, lease: int = 0, operator: str = "anna") -> None:
        self.lease, self.operator = lease, operator
        self.seen: list[VideoFrame] = []
        self._told = 0

    def shown(self) -> tuple[str, ViewsShown] | None:
        if len(self.seen) < self._told + 4:
            return None
        self._told = len(self.seen)
        last = self.seen[-1]
        came = ViewCame(seq=last.seq, age_ms=20.0 * last.seq, fps=30.0)
        view = ViewShown(seq=last.seq, capture_ns=last.capture_ns, age_ms=20.0 * last.seq, fps=30.0, came=came)
        return self.operator, ViewsShown(session=1, lease=self.lease, h264=False, sent_ns=0, views={last.camera: view})


def test_what_the_console_shows_late_is_sent_smaller(monkeypatch):
    monkeypatch.setattr(sources, "open_camera", lambda _source, name, *_: Endless(name, None))
    monkeypatch.setattr("remote_site.video.sources.LiveCamera", Endless)
    console, deadline = Narrow(lease=41), time.monotonic() + 10
    wire = VideoWire(console.seen.append, [console.shown], lambda: LeaseInForce(41, "anna"))
    config = VideoConfig(cameras=(CameraConfig(name="side", source="0"),))
    run_video(
        config,
        None,
        wire,
        lambda: (bool(console.seen) and console.seen[-1].width < 32) or time.monotonic() > deadline,
        do_nothing,
    )
    assert console.seen[0].width == 32
    assert console.seen[-1].width < 32


def test_the_adaptation_is_told_for_how_long_this_process_has_waited_for_its_processor():
    waits = []

    class Told(Adaptation):
        def wait(self, waited_ms):
            waits.append(waited_ms)

    console = process._Console(VideoWire(print), Told(VideoConfig(), h264=False))
    for now_ns, queued_ns in ((1_000_000_000, 7), (1_100_000_000, 90_000_007), (1_200_000_000, 90_000_007)):
        console.wait.turn(queued_ns, now_ns)
        console.listen(now_ns)
    assert waits == [0.0, 90.0, 90.0]


@pytest.mark.slow
@pytest.mark.parametrize(("lease", "operator"), [(40, "anna"), (41, "ben")])
def test_who_merely_watches_over_a_narrow_link_takes_nothing_from_the_operator(monkeypatch, lease, operator):
    monkeypatch.setattr(sources, "open_camera", lambda _source, name, *_: Endless(name, None))
    monkeypatch.setattr("remote_site.video.sources.LiveCamera", Endless)
    console = Narrow(lease, operator)
    wire = VideoWire(console.seen.append, [console.shown], lambda: LeaseInForce(41, "anna"))
    run_video(
        VideoConfig(cameras=(CameraConfig(name="side", source="0"),)),
        None,
        wire,
        lambda: len(console.seen) > 60,
        do_nothing,
    )
    assert {frame.width for frame in console.seen} == {32}


def test_a_console_of_another_release_is_told_once_and_delays_nothing(monkeypatch):
    monkeypatch.setattr(sources, "open_camera", lambda _source, name, *_: Endless(name, None))
    monkeypatch.setattr("remote_site.video.sources.LiveCamera", Endless)

    def refuse() -> None:
        raise MessageError("version", "version 1, this side speaks 4")

    seen: list[VideoFrame] = []
    config = VideoConfig(cameras=(CameraConfig(name="side", source="0"),))
    with capture_logs() as logs:
        run_video(config, None, VideoWire(seen.append, [refuse]), lambda: len(seen) > 5, do_nothing)
    assert [entry["event"] for entry in logs] == ["a console's report of its views is refused"]
    assert {m.status for m in seen} == {CameraStatus.LIVE}


def test_numbers_that_no_estimate_can_be_made_of_are_told_once_and_end_nothing(monkeypatch):
    monkeypatch.setattr(sources, "open_camera", lambda _source, name, *_: Endless(name, None))
    monkeypatch.setattr("remote_site.video.sources.LiveCamera", Endless)
    seen: list[VideoFrame] = []

    def beyond_every_sum() -> tuple[str, ViewsShown]:
        came = ViewCame(seq=seen[-1].seq if seen else 0, age_ms=1.7e308, fps=1.7e308)
        view = ViewShown(seq=0, capture_ns=0, age_ms=0.0, fps=1.7e308, came=came)
        views = {"side": view, "front": view}
        return "anna", ViewsShown(session=1, lease=0, h264=False, sent_ns=0, views=views)

    cameras = (CameraConfig(name="side", source="0"), CameraConfig(name="front", source="1"))
    with capture_logs() as logs:
        run_video(
            VideoConfig(cameras=cameras),
            None,
            VideoWire(seen.append, [beyond_every_sum]),
            lambda: len(seen) > 9,
            do_nothing,
        )
    assert [entry["event"] for entry in logs] == ["a console's report of its views is refused"]
    assert {m.status for m in seen} == {CameraStatus.LIVE}
