"""The figures of the tracking benchmark: errors, gaps, toggles and the honesty of sigmas, on made-up results."""

import io
import json

import numpy as np
import pytest
from rich.console import Console
from scipy.spatial.transform import Rotation

from lab.measure.tracking.comparison import as_table
from lab.measure.tracking.figures import SETTLED, Found, flat, judge, normalised_square, openings, rank_correlation
from local_site.simulation.body import ArmTruth

ELBOW, WRIST, INDEX, THUMB = np.eye(4, 3)
POINTS = {"elbow": ELBOW, "wrist": WRIST, "index": INDEX, "thumb": THUMB}
OFF = np.array([0.0, 3e-3, -4e-3])


def truth(count, hand_open=()):
    return [ArmTruth(ELBOW, WRIST, INDEX, THUMB, k in hand_open) for k in range(count)]


def found(points=None, ms=2.0, **more):
    return Found({**POINTS, **(points or {})}, ms, ms / 2, **{"covariances": {}, **more})


def test_errors_are_those_after_the_first_frames():
    early = [found({"wrist": WRIST + 1.0}, ms=99.0)] * SETTLED
    figures = judge([*early, *[found({"wrist": WRIST + OFF})] * 5], truth(SETTLED + 5), ("wrist",))
    wrist = figures.points["wrist"]
    assert (wrist["frames"], figures.whole["frames"]) == (5, 5)
    assert [wrist[f"{name} mm"] for name in ("mean", "p95", "max")] == pytest.approx([5.0, 5.0, 5.0])
    assert [wrist[f"bias {axis} mm"] for axis in "xyz"] == pytest.approx([0.0, 3.0, -4.0])
    times = ("median ms per pair", "p95 ms per pair", "median processor ms per pair")
    assert [figures.whole[name] for name in times] == pytest.approx([2.0, 2.0, 1.0])
    assert figures.points["elbow"]["max mm"] == 0.0


def test_a_frame_without_a_needed_point_is_one_without_result():
    blind = Found({"wrist": WRIST}, 1.0, 1.0, covariances={})
    figures = judge([found()] * SETTLED + [blind, found(), blind], truth(SETTLED + 3), ("wrist", "index"))
    assert figures.whole["frames without result"] == 2
    assert figures.points["wrist"]["frames"] == 3
    assert figures.points["index"]["frames"] == 1


def test_a_thumb_that_was_inferred_is_counted_apart():
    inferred = found({"thumb": THUMB + OFF}, thumb_inferred=True)
    figures = judge([found()] * (SETTLED + 2) + [inferred], truth(SETTLED + 3), ())
    assert (figures.points["thumb seen"]["frames"], figures.points["thumb seen"]["mean mm"]) == (2, 0.0)
    assert figures.points["thumb inferred"]["mean mm"] == pytest.approx(5.0)


def test_points_never_found_have_no_figures():
    figures = judge([Found({}, 1.0, 1.0, covariances={})] * (SETTLED + 1), truth(SETTLED + 1), ("wrist",))
    assert figures.points == {}
    assert figures.whole["frames without result"] == 1


def test_openings_are_rising_edges():
    assert openings(truth(10, hand_open=(0, 1, 4, 5, 9))) == 3
    assert openings(truth(3)) == 0


def test_honest_covariances_give_three():
    random = np.random.default_rng(3)
    spread = random.standard_normal((3, 3))
    covariance = spread @ spread.T + 0.1 * np.eye(3)
    errors = random.multivariate_normal(np.zeros(3), covariance, 20000)
    covariances = np.broadcast_to(covariance, (len(errors), 3, 3))
    assert normalised_square(errors, covariances) == pytest.approx(3.0, abs=0.1)
    assert normalised_square(2.0 * errors, covariances) == pytest.approx(12.0, abs=0.4)
    assert np.isnan(normalised_square(errors[:0], covariances[:0]))


def test_ranks_agree_however_the_values_are_spread():
    values = np.array([1.0, 2.0, 5.0, 9.0])
    assert rank_correlation(values, values**3) == pytest.approx(1.0)
    assert rank_correlation(values, -values) == pytest.approx(-1.0)
    assert np.isnan(rank_correlation(values, np.ones(4)))


def test_only_figures_that_could_be_had_are_written():
    sure = found({"wrist": WRIST + OFF}, covariances={"wrist": 25e-6 / 3 * np.eye(3)}, toggles=2)
    names = flat(judge([sure] * (SETTLED + 4), truth(SETTLED + 4, hand_open=(3, 4, 8)), ("wrist",)))
    assert names["wrist, normalised error squared (3)"] == pytest.approx(3.0)
    assert names["wrist, bias z mm"] == pytest.approx(-4.0)
    assert (names["toggles"], names["true toggles"]) == (2.0, 2.0)
    assert "wrist, rank correlation of sigma and error" not in names
    assert "elbow, normalised error squared (3)" not in names
    assert json.loads(json.dumps(names, allow_nan=False)) == names
    assert "toggles" not in flat(judge([found()] * (SETTLED + 1), truth(SETTLED + 1), ()))


def test_the_table_tells_both_trackers_and_why_one_is_missing():
    figures = judge([found({"index": INDEX + OFF}, toggles=1)] * (SETTLED + 4), truth(SETTLED + 4), ("index",))
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(as_table("yz", {"ours": figures, "theirs": figures}, ("another skipped: no network",)))
    text = console.export_text()
    assert "5.0" in text
    assert text.count("thumb seen") == 2
    assert "ours: median 2.0, p95 2.0 ms" in text
    assert "0 of 4 frames without result; 1 toggles of 0" in text
    assert "another skipped: no network" in text


def test_a_relative_error_does_not_count_a_constant_offset():
    moved = [found({"index": INDEX + OFF + [0.0, 0.0, 0.002 * (-1) ** k]}) for k in range(4)]
    index = judge([found()] * SETTLED + moved, truth(SETTLED + 4), ()).points["index"]
    assert index["relative mm"] == pytest.approx(2.0)
    assert index["mean mm"] > 4.0


def turned(deg):
    """The hand turned about the wrist."""
    rotation = Rotation.from_euler("x", deg, degrees=True)
    return {name: WRIST + rotation.apply(POINTS[name] - WRIST) for name in ("index", "thumb")}


def test_a_rotation_is_measured_after_a_constant_offset_and_only_while_it_turns_the_tool():
    steady = [found(turned(deg)) for deg in (17.0, 23.0)]
    not_counted = [found(turned(90.0), is_tracked=False), Found({"wrist": WRIST}, 1.0, 1.0, covariances={})]
    figures = judge([found()] * SETTLED + steady + not_counted, truth(SETTLED + 4), ())
    assert figures.whole["rotation mean deg"] == pytest.approx(3.0)
    assert "rotation mean deg" not in judge([not_counted[1]] * (SETTLED + 1), truth(SETTLED + 1), ()).whole
