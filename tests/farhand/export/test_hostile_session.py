"""A session that claims more than anybody records: an export of it is refused in a sentence, and nothing is left."""

import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest

from common.clock import NS_PER_S
from common.errors import ConfigError, ExportError, InterruptionError, RecordingError
from farhand.export.lerobot.dataset_export import ExportSettings, export_lerobot
from farhand.export.resampling import MOST_INSTANTS
from farhand.export.session import RecordedSession, SessionEpisode, SessionFacts, SessionSignals, episode_at
from farhand.export.tables import export_csv
from farhand.export.videos.write import export_mp4
from tests.farhand.export.made_session import BEGIN_NS, MadeSession

MONTH_S = 30 * 86_400
Stop = Callable[[], bool]
Export = Callable[[RecordedSession, Path, int, Stop], object]


@dataclass
class ClaimingSession(MadeSession):
    """A session of a few messages whose facts claim what `claimed` says."""

    claimed: dict[str, Any] = field(default_factory=dict)

    @property
    def facts(self) -> SessionFacts:
        """Those of the messages, but for what is claimed."""
        return replace(super().facts, **self.claimed)


class UnreadableSession(MadeSession):
    """A session whose messages turn out to be damaged."""

    def signals(self) -> SessionSignals:
        """Never."""
        raise RecordingError("damaged")


def never() -> bool:
    return False


def to_csv(session: RecordedSession, out: Path, fps: int, should_stop: Stop = never) -> object:
    return export_csv([session], out, fps, should_stop)


def to_mp4(session: RecordedSession, out: Path, fps: int, should_stop: Stop = never) -> object:
    return export_mp4([session], out, fps, should_stop, lambda *_: None)


def to_lerobot(session: RecordedSession, out: Path, fps: int, should_stop: Stop = never) -> object:
    return export_lerobot([session], ExportSettings(out, fps), should_stop, lambda *_: None)


def episodes(count: int, seconds: float) -> tuple[SessionEpisode, ...]:
    """Episodes that all begin with the session."""
    end_ns = BEGIN_NS + round(seconds * NS_PER_S)
    return tuple(an_episode(k + 1, BEGIN_NS, end_ns) for k in range(count))


def an_episode(number: int, begin_ns: int, end_ns: int) -> SessionEpisode:
    return SessionEpisode(number, begin_ns, end_ns, "", None, "")


def a_month(**claimed: Any) -> ClaimingSession:
    return ClaimingSession(claimed={"end_ns": BEGIN_NS + MONTH_S * NS_PER_S, **claimed})


@pytest.mark.parametrize(("export", "fps"), [(to_csv, 50), (to_mp4, 25), (to_lerobot, 30)])
def test_a_month_is_refused_with_its_rows_and_a_rate_that_works(export: Export, fps: int, tmp_path: Path) -> None:
    session = a_month(episodes=episodes(1, MONTH_S))
    with pytest.raises(ExportError, match=f"{MONTH_S * fps} rows or frames.*give --fps 1 or less"):
        export(session, tmp_path / "out", fps, never)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InterruptionError):
        export(session, tmp_path / "out", 1, lambda: True)


def test_what_is_too_long_at_any_rate_is_refused(tmp_path: Path) -> None:
    session = ClaimingSession(claimed={"end_ns": BEGIN_NS + 100 * 12 * MONTH_S * NS_PER_S})
    with pytest.raises(ExportError, match="leave it out"):
        to_csv(session, tmp_path, 1)


@pytest.mark.slow
@pytest.mark.parametrize("export", [to_csv, to_mp4])
def test_of_a_long_session_some_rows_at_a_time_are_in_memory(export: Export, tmp_path: Path) -> None:
    """Three million rows are 1 GB."""
    session = ClaimingSession(claimed={"end_ns": BEGIN_NS + MOST_INSTANTS // 50 * NS_PER_S})
    asked = iter(range(10))
    tracemalloc.start()
    try:
        with pytest.raises(InterruptionError):
            export(session, tmp_path, 50, lambda: next(asked) >= 5)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 150e6


def test_rows_are_the_same_however_many_are_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    to_csv(MadeSession(), tmp_path / "whole", 50)
    monkeypatch.setattr("farhand.export.resampling.INSTANTS_AT_ONCE", 7)
    to_csv(MadeSession(), tmp_path / "blocks", 50)
    assert (tmp_path / "blocks/made.csv").read_bytes() == (tmp_path / "whole/made.csv").read_bytes()


def test_thousands_of_episodes_at_one_time_are_refused(tmp_path: Path) -> None:
    session = ClaimingSession(claimed={"episodes": episodes(10_000, 2.0)})
    with pytest.raises(ExportError, match="its 10000 episodes overlap, together 20000 s"):
        to_lerobot(session, tmp_path / "out", 30)
    assert list(tmp_path.iterdir()) == []


def test_of_episodes_at_one_time_the_one_begun_last_holds() -> None:
    """The first one's end was lost, so that it lasts to the end."""
    first, second = (an_episode(number, *bounds) for number, bounds in ((1, (0, 100)), (2, (10, 20))))
    facts = replace(MadeSession().facts, episodes=(first, second))
    assert [episode_at(facts, t_ns) for t_ns in (-1, 5, 15, 25)] == [None, first, second, None]


@pytest.mark.parametrize("sizes", [[(8000, 8000)] * 9, [(60_000, 2)]])
def test_views_that_make_too_large_a_picture_are_refused(sizes: list[tuple[int, int]], tmp_path: Path) -> None:
    views = {f"v{k}": size for k, size in enumerate(sizes)}
    session = ClaimingSession(claimed={"views": views})
    with pytest.raises(ExportError, match=r"views of up to .* pixels make a picture of .*farhand export lerobot"):
        to_mp4(session, tmp_path, 25)
    with pytest.raises(ExportError, match="--view"):
        to_lerobot(session, tmp_path / "out", 30)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("size", [(33, 48), (48, 33), (1, 1), (16_386, 16)])
def test_a_view_of_a_size_that_no_video_has_is_refused(size: tuple[int, int], tmp_path: Path) -> None:
    session = ClaimingSession(claimed={"views": {"front": (160, 120), "odd": size}})
    with pytest.raises(ExportError, match=rf"'odd' has {size[0]}x{size[1]} pixels, .* even sizes .*--view"):
        to_lerobot(session, tmp_path / "out", 30)
    assert list(tmp_path.iterdir()) == []


def test_an_export_that_fails_leaves_nothing_behind_and_one_that_is_ended_goes_on(tmp_path: Path) -> None:
    with pytest.raises(RecordingError):
        to_lerobot(UnreadableSession(), tmp_path / "out", 30)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(InterruptionError):
        to_lerobot(MadeSession(), tmp_path / "out", 30, lambda: True)
    assert [path.name for path in tmp_path.iterdir()] == ["out.part"]


@pytest.mark.parametrize("export", [to_csv, to_mp4])
def test_a_file_with_part_in_its_name_is_as_safe_as_any_other(export: Export, tmp_path: Path) -> None:
    mine = [tmp_path / f"made.part{suffix}" for suffix in (".csv", ".mp4")]
    for path in mine:
        path.write_text("mine")
    export(MadeSession(seconds=0.5), tmp_path, 10, never)
    assert [path.read_text() for path in mine] == ["mine", "mine"]
    assert len(list(tmp_path.iterdir())) == 3


def test_a_folder_that_no_export_made_is_not_used_and_stays(tmp_path: Path) -> None:
    mine = tmp_path / "out.part/mine"
    mine.parent.mkdir()
    mine.write_text("mine")
    with pytest.raises(ConfigError, match="which no export made; give another --out"):
        to_lerobot(MadeSession(), tmp_path / "out", 30)
    assert [path.read_text() for path in mine.parent.iterdir()] == ["mine"]
