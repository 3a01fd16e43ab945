"""`farhand export mp4`: a video of each session, all views with time, state and joints below."""

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from common.clock import NS_PER_S
from common.errors import ExportError
from common.geometry import Array
from farhand.export.output_files import ShouldStop, go_on, written_each
from farhand.export.resampling import blocks, check_length, instants, rows_at
from farhand.export.session import MOST_PIXELS, RecordedSession, SessionFacts, Times, ViewPicture, episode_at
from farhand.export.videos.h264 import LONGEST_SIDE_PX, SUFFIX, H264File, Rgb, decoded
from farhand.export.videos.mosaic import MosaicPlan, fitted, mosaic
from farhand.terminal import ShowProgress

TEXT_LINES, CRF = 3, 23
NO_VIEW_PX = 640, 480


def export_mp4(
    sessions: Sequence[RecordedSession], out: Path, fps: int, should_stop: ShouldStop, show: ShowProgress
) -> list[Path]:
    """Write a video of each session into the folder: the views, with time, state and joints below.

    Before any work, ConfigError if one of them exists, ExportError if one would be too long or too large.
    """
    for session in sessions:
        _plan(session.facts, fps)

    def write(session: RecordedSession, path: Path) -> None:
        facts = session.facts
        plan = _plan(facts, fps)
        at = instants(facts.begin_ns, facts.end_ns, fps)
        file = H264File(path, plan.size_px, fps, 2 * fps, CRF)
        text = _text(session, at)
        try:
            for k, pictures in enumerate(_pictures(session, plan, at)):
                go_on(should_stop)
                file.add(mosaic(plan, pictures, next(text)))
                show(facts.name, k + 1, len(at))
        finally:
            file.finish()

    return written_each(sessions, out, SUFFIX, write)


def _plan(facts: SessionFacts, fps: int) -> MosaicPlan:
    check_length(facts, facts.end_ns - facts.begin_ns, fps)
    plan = MosaicPlan(tuple(facts.views), max(facts.views.values(), default=NO_VIEW_PX), TEXT_LINES)
    width, height = plan.size_px
    if width * height > MOST_PIXELS or max(width, height) > LONGEST_SIDE_PX:
        cure = "export its views with 'farhand export lerobot', where --view names those to take"
        raise ExportError(
            f"{facts.name}: {len(plan.views)} views of up to {plan.cell_px[0]}x{plan.cell_px[1]} pixels make a picture "
            f"of {width}x{height}, and {MOST_PIXELS} pixels, {LONGEST_SIDE_PX} a side, are the most; {cure}"
        )
    return plan


def _pictures(session: RecordedSession, plan: MosaicPlan, at: Times) -> Iterator[dict[str, Rgb]]:
    """The newest pictures at each instant, each decoded and fitted once; a view has none before its first."""
    facts, newest, pixels = session.facts, dict[str, ViewPicture](), dict[str, Rgb]()
    coming = session.pictures(facts.begin_ns - NS_PER_S, facts.end_ns)
    after = next(coming, None)
    for instant in at.tolist():
        changed = set()
        while after is not None and after.capture_ns <= instant:
            newest[after.view] = after
            changed.add(after.view)
            after = next(coming, None)
        for view in changed:
            pixels[view] = fitted(decoded(newest[view].jpeg, f"a picture of '{view}'"), plan.cell_px)
        yield pixels


def _text(session: RecordedSession, at: Times) -> Iterator[list[str]]:
    """The lines below the views, instant by instant."""
    facts, signals = session.facts, session.signals()
    for block in blocks(at):
        rows, states = rows_at(signals, block), signals.states.at(block)
        for k, instant in enumerate(block.tolist()):
            measured = _joints("measured", facts, rows.q[k], None if rows.opening is None else rows.opening[k])
            sent = _joints("sent", facts, rows.sent_q[k], rows.sent_opening[k] if facts.has_gripper else None)
            yield [_about(facts, instant, states[k]), measured, sent]


def _about(facts: SessionFacts, instant_ns: int, state: str) -> str:
    utc_ns = instant_ns + facts.utc_minus_clock_ns
    date = datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=utc_ns // 1000)
    episode = episode_at(facts, instant_ns)
    task = f"episode {episode.number}  {episode.task}" if episode else "no episode"
    since = (instant_ns - facts.begin_ns) / NS_PER_S
    return f"{date:%Y-%m-%d %H:%M:%S}.{date.microsecond // 1000:03d} UTC  {since:8.3f} s  {state or 'unknown'}  {task}"


def _joints(what: str, facts: SessionFacts, q: Array, opening_m: float | None) -> str:
    degrees = "  ".join(f"{name} {value:7.2f}" for name, value in zip(facts.joint_names, np.degrees(q), strict=True))
    gripper = "" if opening_m is None else f"  gripper {opening_m * 1000:5.1f} mm"
    return f"{what:8s} [deg]  {degrees}{gripper}"
