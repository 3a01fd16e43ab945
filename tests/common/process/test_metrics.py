"""The figures of a site: what its messages make of them, and what Prometheus reads on the port."""

import socket
import threading
import time
import urllib.request
from collections.abc import Callable
from typing import Any

import msgspec
import pytest
from prometheus_client import CollectorRegistry

from common.cameras.lost_pictures import LostPictures
from common.errors import TransportError
from common.link.channels import STATE
from common.link.transport import open_link
from common.messages.hand import TrackingStatus
from common.messages.robot import SessionState
from common.messages.video import CameraStatus
from common.process.metrics import AtScrape, MetricsSource, run_metrics
from common.process.service import StopFlag
from farhand.loopback.site_process import free_ports
from local_site.runtime.figures import LocalFigures
from remote_site.runtime.figures import RemoteFigures
from remote_site.video.process import VideoTally
from tests.common.cameras.losing_camera import MOST, PER_FRAME, LosingCamera
from tests.common.messages.golden_examples import HAND, VIDEO
from tests.common.messages.golden_examples import STATE as TOLD
from tests.present import present

with_ = msgspec.structs.replace
Follow = Callable[[str, LosingCamera], Callable[[], None]]
HEARD_NS = 5_000_000_000


@pytest.fixture(autouse=True)
def the_tests_do_not_give_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("common.process.metrics.be_nice", lambda _increment: None)


def losing(name: str, follow: Follow) -> tuple[LosingCamera, Callable[[], None]]:
    """A camera that is opened, and what counts what it loses."""
    camera = LosingCamera(name)
    return camera, follow(name, camera)


def read(figures: MetricsSource[Any], name: str, **labels: str) -> float | None:
    """A figure two seconds after the last message."""
    registry = CollectorRegistry(auto_describe=False)

    class Frozen(AtScrape):
        def collect(self):
            return figures.families(HEARD_NS + 2_000_000_000)

    registry.register(Frozen(figures))
    return registry.get_sample_value(name, labels)


def test_the_remote_site_tells_state_reasons_and_late_ticks() -> None:
    figures = RemoteFigures(VideoTally(["side"]))
    assert read(figures, "farhand_state_age_seconds") is None
    engaged = with_(TOLD, state=SessionState.ENGAGED, rejected={"stale": 3})
    for state in (engaged, with_(engaged, state=SessionState.HOLDING), engaged):
        figures.observe(state, HEARD_NS)
    assert read(figures, "farhand_state_age_seconds") == pytest.approx(2.0)
    assert read(figures, "farhand_session_state", state="engaged") == 1
    assert read(figures, "farhand_session_state", state="holding") == 0
    assert read(figures, "farhand_session_entered_total", state="engaged") == 2
    assert read(figures, "farhand_session_entered_total", state="holding") == 1
    assert read(figures, "farhand_hand_rejected_total", reason="stale") == 3
    timing = TOLD.timing
    assert read(figures, "farhand_control_missed_ticks_total") == timing.missed
    assert read(figures, "farhand_control_late_p99_seconds") == pytest.approx(timing.late_p99_us / 1e6)


def test_latency_is_told_in_one_clock_and_once_per_sample() -> None:
    figures = RemoteFigures(VideoTally(["side"]))
    offset_ns = present(TOLD.clock).remote_minus_local_ns
    capture_ns = 9_000_000_000_000
    obeyed = with_(present(TOLD.obeyed), capture_ns=capture_ns, command_ns=capture_ns + offset_ns + 45_000_000)
    for _ in range(3):
        figures.observe(with_(TOLD, obeyed=obeyed), HEARD_NS)
    assert read(figures, "farhand_capture_to_command_seconds_count") == 1
    assert read(figures, "farhand_capture_to_command_seconds_sum") == pytest.approx(0.045)


def test_video_is_told_camera_by_camera() -> None:
    tally = VideoTally(["front", "side"])
    live = with_(VIDEO, camera="side", status=CameraStatus.LIVE, data=b"12345", capture_ns=HEARD_NS)
    for frame in (live, live, with_(live, status=CameraStatus.FROZEN, data=b"", capture_ns=1)):
        tally.note(frame, frame.capture_ns)
    figures = RemoteFigures(tally)
    assert read(figures, "farhand_video_frames_total", camera="side", status="live") == 2
    assert read(figures, "farhand_video_frames_total", camera="side", status="frozen") == 1
    assert read(figures, "farhand_video_frames_total", camera="front", status="live") == 0
    assert read(figures, "farhand_video_bytes_total", camera="side") == 10
    assert read(figures, "farhand_video_age_seconds", camera="side") == pytest.approx(2.0)
    assert read(figures, "farhand_video_age_seconds", camera="front") is None


def test_what_cameras_lose_is_told_by_both_sites() -> None:
    tally, lost = VideoTally(["front", "side"]), LostPictures(["left", "right"])
    at_remote, at_local = RemoteFigures(tally), LocalFigures(lost)
    for camera, note in (
        losing("side", tally.lost.follow),
        losing("side", tally.lost.follow),
        losing("left", lost.follow),
    ):
        for _ in range(MOST):
            camera.read()
            note()
    told = {name: read(at_remote, "farhand_camera_lost_pictures_total", camera=name) for name in ("front", "side")}
    assert told == {"front": 0, "side": 2 * MOST * PER_FRAME}
    told = {name: read(at_local, "farhand_camera_lost_pictures_total", camera=name) for name in ("left", "right")}
    assert told == {"left": MOST * PER_FRAME, "right": 0}


def test_at_the_end_the_pictures_of_all_cameras_are_told_with_the_oldest_of_the_live_ones() -> None:
    tally = VideoTally(["front", "side"])
    assert tally.sentences() == {}
    live = with_(VIDEO, camera="side", status=CameraStatus.LIVE, data=b"12345", capture_ns=HEARD_NS)
    for age_ms, frame in ((95, live), (20, with_(live, camera="front")), (700, with_(live, status=CameraStatus.DARK))):
        tally.note(frame, HEARD_NS + age_ms * 1_000_000)
    camera, note = losing("side", tally.lost.follow)
    camera.read()
    note()
    assert tally.sentences() == {"pictures": "2 live, the oldest 95 ms from exposure to sending, 1 dark, 2 lost"}


def test_the_local_site_tells_of_its_samples() -> None:
    figures = LocalFigures(LostPictures(["left"]))
    assert read(figures, "farhand_hand_age_seconds") is None
    tracked = with_(HAND, status=TrackingStatus.TRACKED, capture_ns=HEARD_NS - 40_000_000, lease=7)
    figures.observe(tracked, HEARD_NS)
    figures.observe(with_(tracked, status=TrackingStatus.LOST, lease=0), HEARD_NS)
    assert read(figures, "farhand_hand_samples_total", status="tracked") == 1
    assert read(figures, "farhand_hand_samples_total", status="lost") == 1
    assert read(figures, "farhand_lease_held") == 0
    assert read(figures, "farhand_hand_age_seconds") == pytest.approx(2.0)
    assert read(figures, "farhand_capture_to_publish_seconds_sum") == pytest.approx(0.08)


def test_prometheus_reads_the_port_while_messages_come() -> None:
    control, port = free_ports(2)
    endpoint = f"tcp/127.0.0.1:{control}"
    should_stop, figures = StopFlag(), RemoteFigures(VideoTally(["side"]))
    beats: list[int] = []
    arguments = (port, endpoint, STATE, "cell", figures, should_stop, lambda: beats.append(1))
    with open_link(listen=(endpoint,)) as link:
        publisher = link.publisher(STATE, "cell")
        server = threading.Thread(target=run_metrics, args=arguments)
        server.start()
        try:
            page = ""
            deadline = time.monotonic() + 20
            while "farhand_states_total" not in page and time.monotonic() < deadline:
                publisher.put(TOLD)
                page = page_at(port)
        finally:
            should_stop.set()
            server.join(10)
    assert f"farhand_states_total {float(TOLD.seq)}" in page
    assert "# TYPE farhand_hand_rejected_total counter" in page
    assert beats
    assert not server.is_alive()


def page_at(port: int) -> str:
    time.sleep(0.05)
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5) as answer:
            return str(answer.read(), "utf-8")
    except OSError:
        return ""


def test_a_port_that_is_taken_is_told() -> None:
    (port,) = free_ports(1)
    figures = RemoteFigures(VideoTally(["side"]))
    with open_link(listen=(f"tcp/127.0.0.1:{port}",)) as _, pytest.raises(TransportError, match=r"metrics\.port"):
        run_metrics(port, f"tcp/127.0.0.1:{port}", STATE, "c", figures, StopFlag(), lambda: None)


def test_a_request_that_does_not_end_is_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("common.process.metrics.SCRAPE_S", 0.1)
    (port,), stop = free_ports(1), StopFlag()
    with open_link(listen=(endpoint := f"tcp/127.0.0.1:{free_ports(1)[0]}",)):
        served = threading.Event()
        given = (port, endpoint, STATE, "cell", RemoteFigures(VideoTally(["side"])), stop, served.set)
        thread = threading.Thread(target=run_metrics, args=given)
        thread.start()
        try:
            assert served.wait(9.0)
            with socket.create_connection(("127.0.0.1", port), 9.0) as half_open:
                half_open.sendall(b"GET /metrics HTTP/1.1\r\nHost:")
                assert half_open.recv(1) == b""
        finally:
            stop.set()
            thread.join()
