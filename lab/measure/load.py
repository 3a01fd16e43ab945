"""Processor time with both sites and the page open, by process and stage, and how much of it is the demonstration's."""

import os
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path

from lab.measure.page.ages import painting
from lab.measure.page.chromium import Chromium
from lab.measure.page.stand import AS_LOOPBACK, PageStand
from lab.stage.processes import family, name_of
from remote_site.config import RemoteConfig
from remote_site.simulation.cell import build_cell
from remote_site.video.cell_cameras import CellRenderer

MEASURE_S = 30.0
DRAWN = 60  # pictures of each view, to learn what one costs
STEP_RAD = 0.01  # from one to the next
TRACKING, VIDEO = "farhand-local", "farhand-video"
DEMONSTRATION = ("farhand-cell", "farhand-filmed")  # processes without which a real cell and operator do
DRAWING = "drawing of simulated views"
MAIN, NETWORK, OTHER = "own work", "network", "other threads"
STAGES = {
    ("tx-", "rx-", "acc-", "net-", "app-"): NETWORK,  # the threads of Zenoh
    ("Compositor", "VizCompositor"): "compositing",
    ("ThreadPool",): "decoding and raster",
}

Stages = dict[tuple[str, str], float]


def measure() -> dict[str, float]:
    """Core percent by process and stage; CameraError where EGL is missing, ProcessError where Chromium is."""
    picture_s = drawing_s()
    with Chromium() as chromium, ExitStack() as stack:
        stand = PageStand(stack, *AS_LOOPBACK)
        local = stand.follow()
        console, address = stand.console(stand.video_port)
        page = chromium.open(address)
        roots = {"remote": stand.remote.pid, TRACKING: local.pid, "console": console.pid, "browser": chromium.pid}
        before, began_s = used_s(roots), time.monotonic()
        painted = painting(chromium, page, MEASURE_S)
        after, passed_s = used_s(roots), time.monotonic() - began_s
    used = {stage: taken_s - before.get(stage, 0.0) for stage, taken_s in after.items()}
    pictures_s = sum(len(ages) for ages in painted.ages.values()) / painted.seconds
    return shares(used, passed_s, picture_s * pictures_s * passed_s)


def drawing_s() -> float:
    """The processor time that drawing one picture takes, a mean over all views of a moving arm."""
    config = RemoteConfig()
    cell = build_cell(config.simulation, config.robot, dressed=True)
    renderer, posture = CellRenderer(cell, config.video.width, config.video.height), cell.start().qpos.copy()
    views = [renderer.view_id(camera.name) for camera in config.video.cameras]
    for view in views:
        renderer.render(view, posture)  # what stands still is drawn once
    began_s = time.process_time()
    for _ in range(DRAWN):
        posture[cell.arm] += STEP_RAD
        for view in views:
            renderer.render(view, posture)
    taken_s = time.process_time() - began_s
    renderer.close()
    return taken_s / DRAWN / len(views)


def shares(used: Stages, passed_s: float, drawn_s: float) -> dict[str, float]:
    """Core percent of each process's stages (s used), the most costly first; the sum, and the demonstration's share.

    Of the video's own work `drawn_s` was for the drawing of views, which a cell with cameras does without.
    """
    stages = dict(used)
    drawn_s = min(drawn_s, stages.get((VIDEO, MAIN), 0.0))
    if drawn_s:
        stages[VIDEO, MAIN] -= drawn_s
        stages[VIDEO, DRAWING] = drawn_s
    of_demonstration = drawn_s + sum(taken for (process, _), taken in used.items() if process in DEMONSTRATION)
    total = sum(stages.values())
    figures = {
        f"{process}, {stage}{' (demonstration)' if _is_demonstration(process, stage) else ''}, core %": taken
        for (process, stage), taken in sorted(stages.items(), key=lambda item: -item[1])
        if taken > 0.0
    }
    figures |= {"all, core %": total, "the demonstration's own, core %": of_demonstration}
    figures = {name: 100.0 * taken / passed_s for name, taken in figures.items()}
    return figures | {"the demonstration's share, %": 100.0 * of_demonstration / total if total else 0.0}


def used_s(roots: Mapping[str, int]) -> Stages:
    """The processor time (s) that these processes, by name, and all below them have used so far, by name and stage."""
    used: defaultdict[tuple[str, str], float] = defaultdict(float)
    for name, root in roots.items():
        for pid in family(root):
            process = _name(pid, name, is_root=pid == root)
            for stage, taken_s in _threads(pid):
                used[process, stage] += taken_s
    return used


def _is_demonstration(process: str, stage: str) -> bool:
    return process in DEMONSTRATION or stage == DRAWING


def _name(pid: int, root: str, *, is_root: bool) -> str:
    """The name of a process: its own, a browser's with its kind, or that of whoever started it."""
    words = Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace").replace("\0", " ").split()
    kinds = [word.removeprefix("--type=") for word in words if word.startswith("--type=")]
    if kinds:
        return f"{root} {kinds[0]}"
    own = name_of(pid)
    return own if own.startswith("farhand-") and not is_root else root


def _threads(pid: int) -> Iterator[tuple[str, float]]:
    """Each thread's stage and what it has used; none of a process that has just ended."""
    try:
        for thread in Path(f"/proc/{pid}/task").iterdir():
            used = (thread / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()
            seconds = (int(used[11]) + int(used[12])) / os.sysconf("SC_CLK_TCK")
            yield _stage((thread / "comm").read_text(encoding="utf-8"), is_main=int(thread.name) == pid), seconds
    except OSError:
        return


def _stage(thread: str, *, is_main: bool) -> str:
    if is_main:
        return MAIN
    return next((stage for names, stage in STAGES.items() if thread.startswith(names)), OTHER)
