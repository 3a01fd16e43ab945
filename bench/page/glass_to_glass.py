"""Benchmark of the console page: glass-to-glass latency, narrow links, stop latency, and the load of an open page."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from bench.page.bare_console import BareConsole
from bench.page.narrow_link import NarrowLink
from bench.page.painted_clock import PageClock, ages_ms, compare, watch
from bench.page.stand import PageStand, browsing, opened, wait
from bench.processes import child_of, cpu_s
from bench.video.link import live_frame
from common.cameras.camera import Image
from common.clock import NS_PER_MS, NS_PER_S
from common.messages.requests import Description
from common.messages.robot import RobotState, SessionState
from common.messages.video import Codec
from farhand.loopback.site_process import free_ports
from local_site.console.hub import Hub
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.request_server import describe
from remote_site.simulation.cell import build_cell
from remote_site.video.cell_cameras import CellRenderer
from remote_site.video.streaming.clock_strip import draw_clock
from remote_site.video.streaming.encoding import Encoded
from remote_site.video.streaming.pictures import encode_jpeg

SETTLE_S, MEASURE_S = 6.0, 15.0
LINK_SETTLE_S = 10.0
LATENESS_S = 17.0  # the window over which the control loop takes its lateness percentile
NARROW_MBIT_S = (20.0, 5.0)
OPEN_MBIT_S = 1e4  # not limited
NOTE_ESCAPE = (
    "() => addEventListener('keydown', (e) => { if (e.key === 'Escape') window.pressed = e.timeStamp; }, true)"
)
STOP_TRIALS = 5
MIN_MOTION_RAD = 0.01  # over four states, 80 ms
Figures = dict[str, float]


def measure() -> Figures:
    """The figures by name; CameraError where EGL is missing."""
    with browsing() as browser:
        bare = bare_figures(browser)
        whole = whole_figures(browser)
    ratio = {
        f"glass_to_glass_{level}_ratio_to_bare": whole[f"glass_to_glass_{level}_ms"] / bare[f"bare_{level}_ms"]
        for level in ("p50", "p95")
    }
    return {name: round(value, 3) for name, value in (bare | whole | ratio | narrow_figures()).items()}


def bare_figures(browser: Any) -> Figures:
    """The baseline, without the sites: this process draws the clock into the same pictures, encodes and sends them."""
    config = RemoteConfig()
    model = ArmModel.from_urdf(config.robot.urdf, config.robot.tool_frame, config.robot.tool_T_tcp)
    cell = describe(config, model, JointLimits.from_model(model, config.robot))
    with BareConsole() as console, feeding(console, cell, rendered(config)):
        page = opened(browser, console.address)
        ages = painted_ages(page, MEASURE_S)
        page.close()
    return {f"bare_{name}": value for name, value in age_figures(ages).items()}


def rendered(config: RemoteConfig) -> dict[str, Image]:
    """A picture (H, W, 3) of every view, by the view's name."""
    cell = build_cell(config.simulation, config.robot, dressed=True)
    renderer = CellRenderer(cell, config.video.width, config.video.height)
    names = [camera.name for camera in config.video.cameras]
    pictures = {name: renderer.render(renderer.view_id(name), cell.start().qpos.copy()) for name in names}
    renderer.close()
    return pictures


@contextmanager
def feeding(console: BareConsole, cell: Description, pictures: dict[str, Image]) -> Iterator[None]:
    """Send pictures of all views in turn, 30 a second of each, the time drawn into them, while the block lasts."""
    ended = threading.Event()

    def feed() -> None:
        console.feed(lambda hub: hub.described(cell))
        period_s, seq, due_s = 1 / 30 / len(pictures), 0, time.monotonic()
        while not ended.wait(max(0.0, due_s - time.monotonic())):
            name = tuple(pictures)[seq % len(pictures)]
            image, now_ns = pictures[name], time.monotonic_ns()
            draw_clock(image, now_ns)
            encoded = Encoded(Codec.JPEG, True, image.shape[1], image.shape[0], encode_jpeg(image, 80))
            frame = live_frame(name, seq, now_ns, encoded)
            console.feed(partial(Hub.camera, frame=frame))
            seq, due_s = seq + 1, due_s + period_s

    thread = threading.Thread(target=feed, name="pictures", daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def whole_figures(browser: Any) -> Figures:
    """With both sites and the page: the pictures' ages, processor load, control lateness, and stop latency."""
    with ExitStack() as stack:
        stand = PageStand(stack)
        console, address = stand.console(stand.video_port)
        time.sleep(LATENESS_S)
        closed_us = stand.record.states[-1].timing.late_p99_us
        page = opened(browser, address)
        video = child_of(stand.remote.pid, "farhand-video")
        console_s, video_s, began_s = cpu_s(console.pid), cpu_s(video), time.monotonic()
        ages = painted_ages(page, LATENESS_S)
        passed_s = time.monotonic() - began_s
        figures = {f"glass_to_glass_{name}": value for name, value in age_figures(ages).items()}
        figures["console_core_percent"] = 100 * (cpu_s(console.pid) - console_s) / passed_s
        figures["video_core_percent_per_stream"] = 100 * (cpu_s(video) - video_s) / passed_s / max(1, len(ages))
        figures["control_late_p99_us_page_closed"] = closed_us
        figures["control_late_p99_us_page_open"] = stand.record.states[-1].timing.late_p99_us
        return figures | stop_figures(stand, page)


def painted_ages(page: Any, seconds: float) -> dict[str, list[float]]:
    """The ages, ms, of each view's pictures when they are painted, over `seconds` once the page has settled."""
    clock = compare(page)
    watch(page)
    page.wait_for_timeout(1000 * SETTLE_S)
    ages_ms(page, clock)  # discards what was painted meanwhile
    page.wait_for_timeout(1000 * seconds)
    return ages_ms(page, clock)


def age_figures(ages: dict[str, list[float]]) -> Figures:
    """Percentiles of the ages (ms) of all views' pictures together, and how many pictures there were."""
    together = np.concatenate([*ages.values(), []])
    return {
        "p50_ms": float(np.percentile(together, 50)),
        "p95_ms": float(np.percentile(together, 95)),
        "pictures": float(len(together)),
    }


def stop_figures(stand: PageStand, page: Any) -> Figures:
    """From the stop key, pressed while the arm moves, to the end of the session and to rest: medians and maxima, ms."""
    clock = compare(page)
    page.evaluate(NOTE_ESCAPE)
    ended_ms, rested_ms = [], []
    for _ in range(STOP_TRIALS):
        wait("a moving arm", lambda: _engage_until_moving(stand, page), lambda: page.wait_for_timeout(50))
        page.keyboard.press("Escape")
        wait("rest", lambda: _rests(stand), lambda: page.wait_for_timeout(50))
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


def _engage_until_moving(stand: PageStand, page: Any) -> bool:
    """Whether the arm moves; resets and engages it when it is disengaged."""
    state, before = stand.record.states[-1], stand.record.states[-5]
    if state.state is SessionState.DISENGAGED:
        for key in ("r", "e"):
            page.keyboard.press(key)
            page.wait_for_timeout(300)
    return bool(np.abs(np.subtract(state.q_commanded, before.q_commanded)).max() > MIN_MOTION_RAD)


def _rests(stand: PageStand) -> bool:
    """Whether the arm is stopped and its commanded joint positions have been the same for ten states, 0.2 s."""
    states = stand.record.states[-10:]
    return all(state.code == "stopped" and state.q_commanded == states[-1].q_commanded for state in states)


def narrow_figures() -> Figures:
    """The page's figures over links of too little bandwidth, with pictures at full quality."""
    figures: Figures = {}
    with browsing() as browser, ExitStack() as stack:
        stand, port = PageStand(stack, "video.quality=100"), free_ports(1)[0]
        link = stack.enter_context(NarrowLink(port, stand.video_port, OPEN_MBIT_S))
        _, address = stand.console(port)
        page = opened(browser, address)
        clock = compare(page)
        watch(page)
        for mbit_s in (OPEN_MBIT_S, *NARROW_MBIT_S):
            link.mbit_s = mbit_s
            page.wait_for_timeout(1000 * LINK_SETTLE_S)
            figures |= link_figures(page, clock, link, "open" if mbit_s == OPEN_MBIT_S else f"{mbit_s:g}_mbit_s")
    return figures


def link_figures(page: Any, clock: PageClock, link: NarrowLink, name: str) -> Figures:
    """Ages, the frame rates of the slowest and the fastest view, and the bandwidth used."""
    ages_ms(page, clock)  # discards what was painted before
    before_bytes, began_ns = link.carried_bytes, time.monotonic_ns()
    page.wait_for_timeout(1000 * MEASURE_S)
    ages, passed_s = ages_ms(page, clock), (time.monotonic_ns() - began_ns) / NS_PER_S
    rates = [len(values) / passed_s for values in ages.values()]
    return {
        f"link_{name}_used_mbit_s": 8e-6 * (link.carried_bytes - before_bytes) / passed_s,
        f"link_{name}_p50_ms": age_figures(ages)["p50_ms"],
        f"link_{name}_p95_ms": age_figures(ages)["p95_ms"],
        f"link_{name}_fps_min": min(rates),
        f"link_{name}_fps_max": max(rates),
    }
