"""One mistake in control points is named as what it is, and implausible camera poses are reported."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from common.errors import CalibrationError
from farhand.calibration.points import doubts
from local_site.calibration.checks import likely_cause
from local_site.calibration.control_points import read_control_points
from local_site.calibration.solve import solve_rig
from tests.local_site.calibration.plate_cameras import (
    ANGLES,
    GRID,
    camera,
    control,
)

CSV = Path(__file__).parents[4] / "shared/data/recordings/yz/control_points.csv"


def recorded_or_made():
    """Sets of good control points to spoil."""
    return [control(noise=0.3), *([read_control_points(CSV)] if CSV.exists() else [])]


def refused(points):
    with pytest.raises(CalibrationError) as caught:
        solve_rig(points, "now")
    return str(caught.value)


def with_heights(good, order):
    heights, which = np.unique(good.points[:, 2], return_inverse=True)
    return replace(good, points=np.column_stack([good.points[:, :2], heights[list(order)][which]]))


@pytest.mark.parametrize("good", recorded_or_made())
@pytest.mark.parametrize("order", [(1, 0, 2), (0, 2, 1), (2, 1, 0), (1, 2, 0), (2, 0, 1)])
def test_heights_in_the_wrong_order_are_told_with_the_right_one(good, order):
    said = refused(with_heights(good, order))
    right = [f"{1e3 * h:g}" for h in np.unique(good.points[:, 2])[list(np.argsort(order))]]
    for name in ("left", "right"):
        assert f"{name} camera: its heights are in the wrong order" in said
    assert f"its pixels fit {', '.join(right)};" in said
    assert ("give Z_mm upwards" in said) == (order == (2, 1, 0))


def test_one_cameras_pictures_in_the_wrong_order_are_told_for_it_alone():
    good = control(noise=0.3)
    swapped = good.pixels[0].reshape(3, 25, 2)[[1, 0, 2]].reshape(75, 2)
    said = refused(replace(good, pixels=(swapped, good.pixels[1])))
    assert "left camera: its heights are in the wrong order" in said
    assert "right camera" not in said


@pytest.mark.parametrize("good", recorded_or_made())
@pytest.mark.parametrize(
    ("spoil_points", "spoil_pixels", "cause"),
    [
        (lambda p: p, lambda q: (640.0, 0.0) + q * (-1.0, 1.0), "switch off the mirroring"),
        (lambda p: p, lambda q: (0.0, 480.0) + q * (1.0, -1.0), "count v from the top"),
        (lambda p: p, lambda q: q[:, ::-1], "u and v are exchanged"),
        (lambda p: p * (-1.0, 1.0, 1.0), lambda q: q, "if X_mm runs to the left, correct the axes"),
        (lambda p: p * (1.0, -1.0, 1.0), lambda q: q, "Y_mm ran towards the cameras"),
        (lambda p: p * (1.0, 1.0, -1.0), lambda q: q, "give Z_mm upwards"),
        (lambda p: p[:, [1, 0, 2]], lambda q: q, "X_mm and Y_mm were exchanged"),
    ],
)
def test_what_was_done_to_points_or_pixels_is_named(good, spoil_points, spoil_pixels, cause):
    pixels = tuple(spoil_pixels(own) for own in good.pixels)
    said = refused(replace(good, points=spoil_points(good.points), pixels=pixels))
    assert said.count(cause) == 2


def test_pixels_without_sense_have_no_likely_cause():
    pixels = np.random.default_rng(1).uniform(0.0, 640.0, (75, 2))
    assert likely_cause(GRID, pixels) == ""


def test_rows_that_slipped_are_told_as_such_and_not_only_point_by_point():
    good = control(noise=0.3)
    said = refused(replace(good, pixels=tuple(np.roll(own, 1, axis=0) for own in good.pixels)))
    assert "left camera: its pixels fit no camera" in said
    assert "each line holds one point's position" in said


def turned(own):
    return (640.0, 480.0) - own


def test_a_camera_upside_down_is_told_and_does_not_pass_for_an_exchanged_one():
    good = control(noise=0.3)
    both = solve_rig(replace(good, pixels=tuple(turned(own) for own in good.pixels)), "now")
    assert [sentence.partition(":")[0] for sentence in doubts(both)] == [
        "left camera is upside down",
        "right camera is upside down",
    ]
    one = solve_rig(replace(good, pixels=(good.pixels[0], turned(good.pixels[1]))), "now")
    assert [sentence.partition(":")[0] for sentence in doubts(one)] == ["right camera is upside down"]
    exchanged = tuple(turned(own) for own in good.pixels[::-1])
    assert "exchange the two" in refused(replace(good, pixels=exchanged))


def test_axes_turned_half_round_are_told():
    good = control(noise=0.3)
    rig = solve_rig(replace(good, points=good.points * (-1.0, -1.0, 1.0)), "now")
    assert all("sees X_mm run to the left" in sentence for sentence in doubts(rig))
    assert len(doubts(rig)) == 2


@pytest.mark.parametrize("drop", [-0.3, 0.2, 4.0])
def test_cameras_below_above_and_overhead_stand_well(drop):
    cameras = [camera(angle, drop=drop) for angle in ANGLES]
    assert doubts(solve_rig(control(cameras), "now")) == []


def test_a_wrong_pitch_shows_in_pixels_that_are_not_square():
    flat = replace(control(noise=0.3), points=GRID * (1.0, 1.0, 0.1))
    assert [s for s in doubts(solve_rig(flat, "now")) if "pixels come out" in s]
