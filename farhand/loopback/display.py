"""Display of a loopback run: a progress bar with the state in words; at the end a table and pictures."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Self

import cv2
import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column, Table
from rich.text import Text

from common.cameras.camera import Image
from common.cameras.images import write_image
from common.clock import NS_PER_MS
from common.text import escaped, file_name
from farhand.loopback.figures import POINTS, Figures
from farhand.loopback.recorder import CameraRecord, Record
from farhand.terminal import table_of

TILE_PX = (480, 360)
BAR_WIDTH = 12
LOG_LINE = re.compile(r"(?P<site>[\w-]+): (?P<fields>level=.*)")
FIELD = re.compile(r'(\w+)=("(?:[^"\\]|\\.)*"|\S*)')
USUAL = "level", "time", "site", "event", "reason", "code"
OF_ARM = re.compile(r"-?\d+\.\d s: ")  # since the first engagement


def rows_of(events: Iterable[str]) -> list[tuple[str, str, str]]:
    """Who, how grave, and what, once for what several sites have logged in the same words."""
    who: dict[tuple[str, str], list[str]] = {}
    for event in events:
        site, level, what = _row(event)
        sites = who.setdefault((level, what), [])
        if site not in sites:
            sites.append(site)
    return [(", ".join(sites), level, what) for (level, what), sites in who.items()]


def _row(event: str) -> tuple[str, str, str]:
    logged = LOG_LINE.fullmatch(event)
    if logged is None:
        site, separator, words = event.partition(": ")
        if separator and site.isidentifier():
            return site, "", words
        return "arm" if OF_ARM.match(event) else "", "", event
    fields = {name: _value(text) for name, text in FIELD.findall(logged["fields"])}
    what = fields.get("event", "")
    others = ", ".join(f"{name} {value}" for name, value in fields.items() if name not in USUAL)
    why = fields.get("reason") or others
    return logged["site"], fields.get("level", ""), f"{what}: {why}" if why else what


def _value(text: str) -> str:
    """A value without the quotes that it is written in."""
    return re.sub(r"\\(.)", r"\1", text[1:-1]) if text.startswith('"') else text


class LiveSummary:
    """A progress bar over the seconds of a run, with the newest state of both sites."""

    def __init__(self, seconds: float) -> None:
        words = TextColumn("{task.description}", markup=False, table_column=Column(ratio=1, no_wrap=True))
        columns = (words, BarColumn(BAR_WIDTH), TimeElapsedColumn())
        self._progress = Progress(*columns, console=Console(stderr=True), expand=True)
        self._task = self._progress.add_task("starting both sites", total=seconds or None)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def print(self, sentence: str) -> None:
        """Print a sentence that stays above the bar."""
        self._progress.console.print(escaped(sentence), markup=False, highlight=False, soft_wrap=True)

    def show(self, elapsed_s: float, record: Record) -> None:
        """Show the newest state."""
        self._progress.update(self._task, completed=elapsed_s, description=_words(record))


def _words(record: Record) -> str:
    if not record.states or not record.hands:
        return "waiting for both sites"
    state, hand = record.states[-1], record.hands[-1]
    obeyed = state.obeyed
    late = "" if obeyed is None else f", {(obeyed.command_ns - obeyed.capture_ns) / NS_PER_MS:.0f} ms to the command"
    return escaped(f"{state.state.value}, hand {hand.status.value}{late}; {state.reason}")


def print_table(figures: Figures, console: Console) -> None:
    """Print the figures of a run as one table."""
    table = Table(title="loopback", show_header=False)
    for name, value in _rows(figures):
        table.add_row(Text(escaped(name)), Text(value))
    console.print(table)
    if events := rows_of(figures["events"]):
        console.print(table_of(("who", "level", "what happened"), events))


def _rows(figures: Figures) -> list[tuple[str, str]]:
    tracking, control, follow = figures["tracking"], figures["control"], figures["follow_mm"]
    command, motion, path = figures["capture_to_command_ms"], figures["capture_to_motion_ms"], figures["trace_ms"]
    errors = [f"{name} {_show(tracking['error_mm'][name]['mean'])}" for name in POINTS]
    return [
        ("exposure to joint command, ms", _levels(command)),
        ("pictures read to joint command, ms", _levels(figures["picture_to_command_ms"])),
        ("exposure to motion, ms", _levels(motion)),
        ("path of one sample, p50 ms", " → ".join(f"{name} {_show(levels['p50'])}" for name, levels in path.items())),
        (
            "hand tracked",
            f"{tracking['frames'] - tracking['lost']} of {tracking['frames']} at {tracking['fps']:.1f} fps",
        ),
        ("tracking error, mean mm", ", ".join(errors)),
        ("tool follows hand, mm", f"mean {_show(follow['mean'])}, p95 {_show(follow['p95'])}"),
        ("lag of the tool, ms", _show(figures["follow_lag_ms"])),
        *((f"camera {name}", _camera(camera)) for name, camera in figures["video"].items()),
        (
            "control",
            f"{_show(control['hz'])} Hz, {control['missed']} late by a period, p99 {_show(control['late_p99_us'])} µs",
        ),
        ("scheduling", "SCHED_FIFO" if control["real_time"] else "ordinary: no right to SCHED_FIFO"),
        ("engagements", str(figures["engagements"])),
        ("followed", f"{figures['followed_share']:.1%} of the time, {figures['holds']} holds"),
        ("gripper toggles", f"{figures['toggles']['sent']} sent, {figures['toggles']['applied']} applied"),
        ("samples refused", ", ".join(f"{n} {code}" for code, n in figures["rejected"].items()) or "none"),
        *([("recording", _recording(figures["recording"]))] if "recording" in figures else []),
    ]


def _recording(recording: Figures) -> str:
    same = "gives the same figures" if not recording["differing"] else f"gives other {recording['differing']}"
    rate = (recording["bytes_a_minute"] or 0) / 1e6
    return f"{recording['bytes'] / 1e6:.1f} MB, {rate:.0f} MB a minute; {same}, {recording['missing']} messages missing"


def _camera(camera: Figures) -> str:
    return f"{camera['fps']:.1f} fps, glass to glass {_levels(camera['glass_to_glass_ms'])} ms"


def _levels(levels: Figures) -> str:
    return ", ".join(f"{name} {_show(value)}" for name, value in levels.items())


def _show(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"


def save_camera_views(cameras: Mapping[str, CameraRecord], folder: Path) -> None:
    """Write the last decoded picture of every camera as NAME.png."""
    for name, camera in cameras.items():
        if camera.last is not None:
            write_image(folder, name, camera.last)


def save_overview(names: tuple[str, ...], folder: Path) -> None:
    """Join the pictures NAME.png of a folder into overview.png, two in a row; a missing one stays black."""
    tiles = [_tile(folder / f"{file_name(name)}.png") for name in names]
    tiles += [np.zeros_like(tiles[0])] * (len(tiles) % 2)
    rows = [np.hstack(tiles[k : k + 2]) for k in range(0, len(tiles), 2)]
    write_image(folder, "overview", np.vstack(rows))


def _tile(path: Path) -> Image:
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        return np.zeros((TILE_PX[1], TILE_PX[0], 3), dtype=np.uint8)
    return np.asarray(cv2.resize(picture, TILE_PX, interpolation=cv2.INTER_AREA), dtype=np.uint8)
