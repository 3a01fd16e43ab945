"""Watches a cell over its links, and shows its status until asked to stop, or once."""

import time
from collections.abc import Sequence
from contextlib import ExitStack
from importlib.metadata import version

from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from common.clock import NS_PER_MS
from common.errors import InterruptionError, TransportError
from common.link.channel_feeds import ChannelFeeds
from common.link.channels import CAMERA, DESCRIBE, STATE, ChannelSession
from common.link.remote_clock import RemoteClock
from common.link.transport import Link, open_link
from common.messages.requests import DescribeQuestion
from common.messages.robot import VideoTrouble
from common.process.service import StopFlag
from common.text import escaped
from farhand.authority.asking import link_to, no_answer, remote_at
from farhand.status.observed import OVER_NS, Observed
from farhand.status.words import Mood, Row, as_builtins, rows_of
from farhand.terminal import say, tell
from local_site.console.config import ConsoleConfig

PATIENCE_S = 5.0
REFRESH_S = 0.25
NARROW = "not counted since the link was narrow: counting takes as much of it as a page"
STYLES = {Mood.GOOD: "green", Mood.PLAIN: "", Mood.WORTH_A_LOOK: "yellow", Mood.WRONG: "bold red"}


def screen(rows: Sequence[Row], title: str) -> Table:
    """The rows as a table; what another site says in them does nothing to the terminal."""
    table = Table(title=title, show_header=False, title_justify="left", expand=True, box=None)  # 24 lines are few
    table.add_column(no_wrap=True)
    table.add_column(ratio=1)
    for row in rows:
        table.add_row(Text(escaped(row.name)), Text(escaped(row.words), style=STYLES[row.mood]))
    return table


def as_lines(rows: Sequence[Row]) -> list[str]:
    """The same as one line for each row, for what is no terminal."""
    return [f"{row.name}: {row.words}" for row in rows]


class StatusWatch:
    """Keeps what is received of a cell, a thread for each channel, until the stack closes its links."""

    def __init__(self, config: ConsoleConfig, stack: ExitStack) -> None:
        self._config, self._stack = config, stack
        self._feeds = ChannelFeeds()
        stack.callback(self._feeds.join)  # once the links are closed
        asked = remote_at(config.links.control)
        self._control = control = stack.enter_context(link_to(config.cell, asked, security=config.links))
        self._clock = RemoteClock(control, config.cell)
        self._video: Link | None = None
        self._counts = False
        self.seen = Observed(config.links.control, config.cell)
        self._feeds.add(control.latest(STATE, config.cell), self.seen.take_state)

    def measure(self, *, pictures: bool) -> None:
        """One round trip; then what is not known yet of the cell, and its pictures, unless its link is narrow."""
        seen, trip = self.seen, self._clock.measure()
        seen.round_trip_ms = None if trip is None else trip.duration_ns / NS_PER_MS
        if trip is None:
            seen.description = None  # another start of the site may be another release
        elif seen.description is None:
            seen.description = self._control.ask(DESCRIBE, self._config.cell, DescribeQuestion())
        trouble = None if seen.state is None else seen.state.video_link
        if trouble is not None and trouble.code is VideoTrouble.NARROW:
            self._leave_pictures(NARROW)
        elif not pictures:
            self._leave_pictures("not counted, as asked")
        elif not self._counts and seen.description is not None:
            self._counts = True
            names = [camera.name for camera in seen.description.cameras]
            if names:
                self._count_pictures(names)
            else:
                seen.pictures = "the cell has no camera"

    def _count_pictures(self, names: list[str]) -> None:
        links, only_video = self._config.links, [ChannelSession.VIDEO]
        try:
            video = open_link(connect=(links.video,), security=links, sessions=only_video)
        except TransportError as error:
            self.seen.pictures = f"not counted: {error}"
            return
        self._video = self._stack.enter_context(video)
        self.seen.expect(names)
        for name, camera in self.seen.cameras.items():
            self._feeds.add(video.latest(CAMERA, self._config.cell, name), camera.take)

    def _leave_pictures(self, why: str) -> None:
        if self._video is not None:
            self._video.close()
        self._counts = True
        self.seen.expect(())
        self.seen.pictures = why


def show_status(config: ConsoleConfig, should_stop: StopFlag, console: Console, *, once: bool, pictures: bool) -> None:
    """Show the status until asked to stop; `once`, or where the console is no terminal, print it once.

    TransportError, which says what to check, when no site has answered in five seconds.
    """
    with ExitStack() as stack:
        watch = StatusWatch(config, stack)
        _await_state(watch, should_stop, pictures=pictures)
        if once or not console.is_terminal:
            _show_once(watch, should_stop, console, pictures=pictures)
        else:
            _show_live(watch, should_stop, console, pictures=pictures)


def print_status(config: ConsoleConfig, should_stop: StopFlag, *, pictures: bool) -> None:
    """Print the status once, as JSON; errors as `show_status`."""
    with ExitStack() as stack:
        watch = StatusWatch(config, stack)
        _await_state(watch, should_stop, pictures=pictures)
        _count(watch, should_stop, pictures=pictures)
        if (state := watch.seen.state) is not None:
            tell((), as_builtins(watch.seen, state, time.monotonic_ns(), version("farhand")), as_json=True)


def _await_state(watch: StatusWatch, should_stop: StopFlag, *, pictures: bool) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while watch.seen.state is None:
        if should_stop():
            raise InterruptionError("interrupted")
        if time.monotonic() > deadline:
            seen = watch.seen
            raise TransportError(no_answer(f"cell {seen.cell}", remote_at(seen.endpoint)))
        watch.measure(pictures=pictures)
        should_stop.wait(REFRESH_S)


def _count(watch: StatusWatch, should_stop: StopFlag, *, pictures: bool) -> None:
    """Watch for as long as rates are measured over."""
    deadline_ns = time.monotonic_ns() + OVER_NS
    while time.monotonic_ns() < deadline_ns and not should_stop():
        watch.measure(pictures=pictures)
        should_stop.wait(REFRESH_S)


def _show_once(watch: StatusWatch, should_stop: StopFlag, console: Console, *, pictures: bool) -> None:
    _count(watch, should_stop, pictures=pictures)
    state = watch.seen.state
    if state is None:
        return
    rows = rows_of(watch.seen, state, time.monotonic_ns(), version("farhand"))
    if console.is_terminal:
        console.print(screen(rows, f"cell {watch.seen.cell}"))
        return
    for line in as_lines(rows):
        say(line)


def _show_live(watch: StatusWatch, should_stop: StopFlag, console: Console, *, pictures: bool) -> None:
    software, title = version("farhand"), f"cell {watch.seen.cell}, live; Ctrl-C ends this"
    with Live(console=console, auto_refresh=False) as live:
        while not should_stop():
            watch.measure(pictures=pictures)
            if (state := watch.seen.state) is not None:
                live.update(screen(rows_of(watch.seen, state, time.monotonic_ns(), software), title), refresh=True)
            should_stop.wait(REFRESH_S)
