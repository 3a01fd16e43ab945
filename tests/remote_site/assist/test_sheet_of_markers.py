"""A sheet of markers before a camera takes no more time than a look has, and hides no marker that is beside it."""

from typing import Any

import cv2
import numpy as np
import pytest

from common.cameras.camera import Frame
from common.clock import NS_PER_MS, FakeClock
from remote_site.assist.config import AssistConfig, AssistTargetConfig
from remote_site.assist.detection import FoundMarkers, MarkerDetector
from remote_site.assist.families import MarkerFamily
from remote_site.assist.marker_watch import FRESH_NS, MarkerWatch
from remote_site.reasons import Code
from remote_site.video.marker_look import BUDGET_NS, LOOK_NS, REST, MarkerLook
from tests.present import present
from tests.remote_site.assist.marker_pictures import FRONT, calibration

FAMILY = MarkerFamily.ARUCO_4X4_50
SIDE_PX, STEP_PX, LARGE_PX = 20, 27, 60
SIZE = (720, 960)
TRUE = 7  # the marker beside the sheet
SIXTEEN = tuple(range(16))  # as many as a configuration may name
FIT_NS = 10 * NS_PER_MS
LOOKS_NS = (1 + REST) * (BUDGET_NS + FIT_NS)  # from one look of a view to the next, where each uses up its time
VIEWS = {name: calibration(position) for name, position in FRONT.items()}
SQUARE = np.array([(30, 30), (90, 30), (90, 90), (30, 90)], dtype=float)
TARGETS = tuple(
    AssistTargetConfig(name=f"t{n}", marker=n, size_mm=45, kind="grasp", xyz_mm=(0, 0, -80), rpy_deg=(0, 0, 0))
    for n in SIXTEEN
)


def sheet(numbers, beside=None):
    """A picture full of small markers of these numbers in turn; with a large one of another in its corner."""
    picture, printed = np.full(SIZE, 255, np.uint8), 0
    for y in range(4, SIZE[0] - STEP_PX, STEP_PX):
        for x in range(4, SIZE[1] - STEP_PX, STEP_PX):
            if beside is None or max(x, y) > 2 * LARGE_PX:
                paste(picture, numbers[printed % len(numbers)], (x, y), SIDE_PX)
                printed += 1
    if beside is not None:
        paste(picture, beside, (30, 30), LARGE_PX)
    smeared = cv2.GaussianBlur(picture, (0, 0), 0.6) + np.random.default_rng(1).normal(0.0, 3.0, SIZE)
    return np.clip(smeared, 0, 255).astype(np.uint8), printed


def pairs():
    """Two markers of each of sixteen numbers."""
    picture = np.full(SIZE, 255, np.uint8)
    for k in range(32):
        paste(picture, SIXTEEN[k // 2], (20 + k % 8 * 110, 20 + k // 8 * 110), LARGE_PX)
    return cv2.GaussianBlur(picture, (0, 0), 0.6)


def paste(picture, number, at, side_px, family=FAMILY):
    small = cv2.resize(family.printed(number, 16, quiet=0), (side_px, side_px), interpolation=cv2.INTER_AREA)
    picture[at[1] : at[1] + side_px, at[0] : at[0] + side_px] = small


@pytest.fixture
def fitted(monkeypatch):
    """The sizes in pixels of the pictures in which a print was fitted, and a clock that each moves on by 10 ms."""
    fit, areas, clock = cv2.findTransformECC, [], FakeClock()

    def counted(template, picture, *others):
        areas.append(picture.size)
        clock.time_ns += FIT_NS
        return fit(template, picture, *others)

    monkeypatch.setattr(cv2, "findTransformECC", counted)
    return areas, clock


def test_a_number_that_is_there_more_than_twice_is_not_fitted(fitted):
    picture, printed = sheet([TRUE])
    found = MarkerDetector(FAMILY, [TRUE]).find(picture)
    assert printed > 800
    assert fitted[0] == []
    assert len(found.corners[TRUE]) > 800


def test_a_marker_beside_a_sheet_is_found_as_if_there_were_none(fitted):
    picture, printed = sheet([9, 10, 11], TRUE)
    assert printed > 800
    found = MarkerDetector(FAMILY, [TRUE, 9]).find(picture)
    (corners,) = found.corners[TRUE]
    assert np.abs(corners - SQUARE).max() < 0.2
    assert set(found.corners) == {TRUE, 9}
    assert len(found.corners[9]) > 2
    assert found.unreached == ()
    (area,) = fitted[0]
    assert area < 0.05 * picture.size


@pytest.mark.parametrize("family", MarkerFamily)
def test_no_other_marker_of_a_family_is_taken_for_one_that_is_looked_for(family):
    """Though the detector knows of no others, and corrects bits."""
    detector, others = MarkerDetector(family, SIXTEEN), range(16, family.size)
    for first in range(16, family.size, 96):
        picture = np.full(SIZE, 255, np.uint8)
        for k, number in enumerate(others[first - 16 : first + 80]):
            paste(picture, number, (20 + k % 12 * 76, 20 + k // 12 * 76), LARGE_PX, family)
        assert detector.find(picture).corners == {}


def test_no_more_than_two_of_a_number_are_fitted(fitted):
    found = MarkerDetector(FAMILY, SIXTEEN).find(pairs())
    assert {number: len(places) for number, places in found.corners.items()} == dict.fromkeys(SIXTEEN, 2)
    assert len(fitted[0]) == 32


def test_a_look_ends_in_time_and_the_next_ones_of_the_view_begin_with_what_it_left(fitted):
    areas, clock = fitted
    published, picture, codes = list[Any](), pairs(), []
    look = MarkerLook(AssistConfig(targets=TARGETS), VIEWS, lambda _t_ns: None, published.append, clock)
    for k in range(1, 9):
        for view in VIEWS:
            before = len(areas)
            look.see(view, Frame(picture, k * LOOKS_NS, k), k * LOOKS_NS)
            assert len(areas) - before <= BUDGET_NS // FIT_NS + 1
        codes.append({sighting.marker: sighting.refusal.code for sighting in published[-1]})
    assert set(codes[0].values()) == {Code.MARKER_CROWDED, Code.MARKER_DOUBLED}
    assert {marker for each in codes for marker, code in each.items() if code is Code.MARKER_DOUBLED} == set(SIXTEEN)


@pytest.mark.parametrize(("took_ms", "looks"), [(5, 20), (200, 3)])
def test_looks_at_a_view_take_a_fifth_of_the_time_at_most(monkeypatch, took_ms, looks):
    """The search alone may take longer than a look has: of a large picture full of markers, or of what is like them."""
    clock, picture = FakeClock(), np.full(SIZE, 255, np.uint8)
    search = MarkerDetector.find

    def slow(*given, **named):
        clock.advance_ms(took_ms)
        looked.append(clock.now_ns())
        return search(*given, **named)

    looked = list[int]()
    monkeypatch.setattr(MarkerDetector, "find", slow)
    look = MarkerLook(AssistConfig(targets=TARGETS), VIEWS, lambda _t_ns: None, list[Any]().append, clock)
    for k in range(20):
        look.see(next(iter(VIEWS)), Frame(picture, k * LOOK_NS, k), k * LOOK_NS)
    assert len(looked) == looks


def test_what_is_not_reached_is_as_before_while_that_is_fresh_and_then_refused():
    watch = MarkerWatch(AssistConfig(targets=TARGETS[:1]), VIEWS)
    for view in VIEWS:
        watch.observe(view, 0, FoundMarkers({0: [SQUARE, SQUARE]}), None)
        watch.observe(view, FRESH_NS, FoundMarkers({}, (0,)), None)
    assert present(watch.sightings(FRESH_NS)[0].refusal).code is Code.MARKER_DOUBLED
    (sighting,) = watch.sightings(FRESH_NS + 1)
    assert present(sighting.refusal).code is Code.MARKER_CROWDED
    assert "front_high shows too many markers to look at marker 0 in time" in present(sighting.refusal).sentence
