"""The report of a track: its figures are those of the pairs, its pictures have words, and it needs nothing else."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest

from common.errors import CameraError
from common.messages.hand import TrackingStatus
from farhand.tracking.results.report.history import TrackHistory
from farhand.tracking.results.report.track_report import PAGE, track_report
from farhand.tracking.results.tracked_pair import TrackedPair
from tests.farhand.tracking.results.tracked import FPS, pair, write_then_fail

ORIGIN = [("camera left", "films/left <1>.avi"), ("tracker", "learned")]
RED = (0x30, 0x30, 0xC2)  # blue, green, red of a loss


class Elements(HTMLParser):
    """The elements of a page with their attributes, and its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += f" {data}"

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.found if name == tag]


def a_track() -> list[TrackedPair]:
    """40 pairs: 5 lost, 10 degraded, 25 tracked at 1 m/s with a jump in one."""
    lost = [pair(k, reason="too <dark>") for k in range(5)]
    degraded = [pair(k, (0.04 * k, 0.2, 0.3), reason="folded", status=TrackingStatus.DEGRADED) for k in range(5, 15)]
    tracked = [pair(k, (0.04 * k, 0.2 + 0.05 * (k == 30), 0.3), residual_px=0.5) for k in range(15, 40)]
    return [*lost, *degraded, *tracked]


def report(folder: Path, pairs: list[TrackedPair]) -> Elements:
    with track_report(folder, ORIGIN) as take:
        for found in pairs:
            take(found)
    return Elements((folder / PAGE).read_text())


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Elements]:
    """The report of `a_track`, to be read: its folder, and its page."""
    folder = tmp_path_factory.mktemp("track") / "report"
    return folder, report(folder, a_track())


def test_the_tables_have_the_figures_of_the_pairs(reported: tuple[Path, Elements]) -> None:
    words = " ".join(reported[1].text.split())
    assert "tracked 25 62.5 % degraded 10 25.0 % lost 5 12.5 %" in words
    assert "rms epipolar residual between the views, px 0.50 0.50 0.50" in words
    assert "wrist 87.5 % 1.0 1.0 1.000" in words
    assert "1: folded 10 25.0 % 2: too <dark> 5 12.5 %" in words
    assert "camera left films/left <1>.avi tracker learned" in words
    assert "gripper toggles: 0." in words
    assert "elbow 0.0 % – – – –" in words
    assert "palm" not in words
    assert "Pair 31 at 1.240 s, wrist: a jump of 100.0 mm" in words


def test_the_toggles_are_those_of_the_last_pair(tmp_path: Path) -> None:
    last = pair(1)
    toggled = replace(last, line=msgspec.structs.replace(last.line, gripper_toggles=3))
    assert "gripper toggles: 3." in report(tmp_path, [pair(0), toggled]).text


@pytest.mark.slow
def test_a_share_does_not_wrap(reported: tuple[Path, Elements]) -> None:
    text = reported[1].text
    assert "62.5\N{NO-BREAK SPACE}%" in text
    assert not re.search(r"\d\.\d %", text)


def test_every_picture_is_there_has_words_and_opens_by_a_link(reported: tuple[Path, Elements]) -> None:
    folder, page = reported
    pictures = [image["src"] or "" for image in page.all("img")]
    assert {name for name in pictures if not name.startswith("worst")} == {
        *("position.png", "speed_sigma.png", "course.png", "reason_01.png", "reason_02.png")
    }
    assert all(cv2.imread(str(folder / name)) is not None for name in pictures)
    assert [link["href"] for link in page.all("a")] == pictures
    assert all(image["alt"] for image in page.all("img"))
    assert "wrist x 0.200 to 1.560 m, y 0.200 to 0.250 m" in str(page.all("img")[0]["alt"])
    assert {path.name for path in folder.iterdir()} == {PAGE, *pictures}


def test_the_page_needs_nothing_from_elsewhere(reported: tuple[Path, Elements]) -> None:
    assert not re.search(r"https?:|//|<script|@import|url\(", (reported[0] / PAGE).read_text())


@pytest.mark.slow
def test_a_loss_is_drawn_where_it_was(reported: tuple[Path, Elements], tmp_path: Path) -> None:
    course = cv2.imread(str(reported[0] / "course.png"))
    assert course is not None
    columns = np.flatnonzero((course == RED).all(axis=2).sum(axis=0) > 10)
    report(tmp_path, [pair(k) for k in range(40)])
    everything = cv2.imread(str(tmp_path / "course.png"))
    assert everything is not None
    all_columns = np.flatnonzero((everything == RED).all(axis=2).sum(axis=0) > 10)
    assert len(columns) / len(all_columns) == pytest.approx(5 / 40, abs=0.02)
    assert columns[0] == pytest.approx(all_columns[0], abs=3)


def test_a_recording_in_which_nothing_was_found_is_shown_by_its_reason(tmp_path: Path) -> None:
    page = report(tmp_path, [pair(k, reason="the views do not fit together") for k in range(3)])
    assert "In no pair was a point measured." in page.text
    assert [image["src"] for image in page.all("img")] == ["course.png", "reason_01.png"]


def test_one_pair_is_enough(tmp_path: Path) -> None:
    assert "1 pairs over 0.00 s" in report(tmp_path, [pair(0, (0.4, 0.3, 0.5))]).text


def test_a_track_that_fails_leaves_a_report_of_what_was_tracked(tmp_path: Path) -> None:
    with pytest.raises(CameraError, match="unplugged"):
        write_then_fail(track_report(tmp_path / "a" / "b", ORIGIN), 2, CameraError("unplugged"))
    assert "2 pairs" in (tmp_path / "a" / "b" / PAGE).read_text()
    with pytest.raises(CameraError, match="unplugged"):
        write_then_fail(track_report(tmp_path / "none", ORIGIN), 0, CameraError("unplugged"))
    assert not (tmp_path / "none").exists()


def test_speed_is_unknown_at_and_after_a_gap() -> None:
    history = TrackHistory()
    for found in (pair(0, (0.0, 0.0, 0.0)), pair(1, (0.0, 0.3, 0.4)), pair(2), pair(3, (0.0, 0.0, 0.0))):
        history.add(found)
    np.testing.assert_allclose(history.speed("wrist"), [np.nan, 0.5 * FPS, np.nan, np.nan])


@pytest.mark.slow
def test_a_report_replaces_an_earlier_one_and_keeps_what_is_not_its_own(tmp_path: Path) -> None:
    foreign = tmp_path / "worst_of_all.png", tmp_path / "worst_99.png", tmp_path / "notes.txt"
    for path in foreign:
        path.write_text("mine")
    report(tmp_path, a_track())
    assert {"worst_05.png", "reason_02.png", "position.png"} <= {path.name for path in tmp_path.iterdir()}
    lost = report(tmp_path, [pair(0, reason="too dark")])
    shown = {image["src"] for image in lost.all("img")}
    assert {path.name for path in tmp_path.iterdir()} == {*shown, PAGE, *(path.name for path in foreign)}


def test_pictures_without_an_earlier_report_are_not_its_own(tmp_path: Path) -> None:
    (tmp_path / "worst_09.png").write_text("mine")
    report(tmp_path, [pair(0, reason="too dark")])
    assert (tmp_path / "worst_09.png").read_text() == "mine"
