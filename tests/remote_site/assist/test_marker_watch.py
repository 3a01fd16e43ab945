"""Markers in pictures with known truth: how exactly their poses are found, and each reason to believe none."""

import numpy as np
import pytest
from msgspec.structs import replace

from common.geometry import inverse, transform
from common.messages.requests import ViewCalibration
from remote_site.assist.config import AssistConfig, AssistTargetConfig
from remote_site.assist.detection import FoundMarkers, MarkerDetector
from remote_site.assist.families import MarkerFamily
from remote_site.assist.marker_watch import MarkerWatch
from remote_site.reasons import Code
from tests.present import present
from tests.remote_site.assist.marker_pictures import FACING, FRONT, calibration, miss, picture, turned

SIZE_M, NUMBER, NOW_NS = 0.045, 3, 10**9
TARGET = AssistTargetConfig(
    name="block", marker=NUMBER, size_mm=45, kind="grasp", xyz_mm=(0, 0, -80), rpy_deg=(0, 0, 0)
)
VIEWS = {name: calibration(position) for name, position in FRONT.items()}
NEAR = {"gripper": calibration((0.72, 0.06, 0.74), focal_px=433.0)}
FAMILY = MarkerFamily.ARUCO_4X4_50


def look(pose, views=VIEWS, family=FAMILY, seed=1, shown=None, tool=None, aged_ns=0, target=TARGET):
    """What is known of the marker at this pose; `shown` gives other views' markers, where they see others."""
    config, rng = AssistConfig(family=family, targets=(target,)), np.random.default_rng(seed)
    watch, detector = MarkerWatch(config, views), MarkerDetector(family, config.marker_sizes_m)
    for name, seen in views.items():
        poses = (shown or {}).get(name, [pose])
        projection = np.reshape(seen.projection, (3, 4)) @ (inverse(tool) if seen.on_tool else np.eye(4))
        markers = [(family, NUMBER, SIZE_M, each) for each in poses]
        found = detector.find(picture(projection, markers, rng))
        watch.observe(name, NOW_NS - aged_ns, found, tool)
    (sighting,) = watch.sightings(NOW_NS)
    return sighting


def code(sighting):
    assert sighting.base_T_marker is None
    return sighting.refusal.code


@pytest.mark.slow
@pytest.mark.parametrize("family", MarkerFamily)
def test_two_views_find_a_small_marker_to_half_a_millimetre_and_half_a_degree(family):
    poses = [turned(FACING, turn) for turn in ((0, 0, 0), (20, 0, 40), (-15, 25, -10), (0, -30, 170))]
    misses = np.array([miss(look(pose, family=family, seed=k).base_T_marker, pose) for k, pose in enumerate(poses)])
    assert misses.max(axis=0)[0] < 0.5
    assert misses.max(axis=0)[1] < 0.6


def test_the_views_that_saw_it_are_named_with_the_oldest_exposure():
    sighting = look(FACING, aged_ns=120_000_000)
    assert sighting.views == tuple(VIEWS)
    assert sighting.t_ns == NOW_NS - 120_000_000


def test_one_view_of_a_fixed_camera_is_not_enough():
    assert code(look(FACING, {"front_low": VIEWS["front_low"]})) is Code.MARKER_ONE_VIEW


def test_the_grippers_view_alone_is_enough_from_near():
    tool = transform(np.eye(3), np.array([0.4, 0.1, 0.8]))
    seen = np.reshape(NEAR["gripper"].projection, (3, 4)) @ tool
    on_tool = {"gripper": ViewCalibration(tuple(seen.ravel().tolist()), on_tool=True)}
    pose = turned(FACING, (15, 10, 5))
    sighting = look(pose, on_tool, tool=tool)
    assert sighting.refusal is None
    assert miss(sighting.base_T_marker, pose)[0] < 1.0
    assert miss(sighting.base_T_marker, pose)[1] < 1.0


def test_the_grippers_view_alone_is_not_enough_from_far():
    far = calibration((0.86, 0.1, 0.78))
    seen = {"gripper": replace(far, on_tool=True)}
    assert code(look(turned(FACING, (25, 20, 0)), seen, tool=np.eye(4))) is Code.MARKER_FAR


def test_a_marker_that_nobody_sees_is_covered():
    assert code(look(FACING, shown={name: [] for name in VIEWS})) is Code.MARKER_UNSEEN


def test_a_marker_that_one_view_sees_twice_is_doubled():
    twice = [FACING, turned(FACING, (0, 0, 0), (0, 0.1, 0))]
    sighting = look(FACING, shown={"front_low": twice})
    assert code(sighting) is Code.MARKER_DOUBLED
    assert "front_low sees marker 3 twice" in sighting.refusal.sentence


def test_a_double_that_only_one_view_sees_contradicts_the_other():
    ways = [np.array(position) - FACING[:3, 3] for position in FRONT.values()]
    across = np.cross(ways[0], ways[1]) / np.linalg.norm(np.cross(ways[0], ways[1]))  # no depth makes up for it
    elsewhere = turned(FACING, (0, 0, 0), tuple(0.01 * across))
    assert code(look(FACING, shown={"front_low": [elsewhere]})) is Code.MARKER_CONTRADICTED


@pytest.mark.parametrize("angle_deg", [72, -72])
def test_a_marker_seen_at_a_grazing_angle_is_not_believed(angle_deg):
    views = {"upper": calibration((0.8, 0.0, 0.8)), "lower": calibration((0.8, 0.0, 0.6))}
    assert code(look(turned(FACING, (0, angle_deg, 0)), views)) is Code.MARKER_GRAZING
    assert look(turned(FACING, (0, angle_deg / 2, 0)), views).refusal is None


def test_a_third_view_that_grazes_the_marker_is_left_out():
    beside = {"beside": calibration((0.65, 0.48, 0.7), focal_px=500.0)}
    assert code(look(FACING, beside | {"front_low": VIEWS["front_low"]})) is Code.MARKER_GRAZING
    sighting = look(FACING, VIEWS | beside)
    assert sighting.refusal is None
    assert sighting.views == tuple(VIEWS)
    assert miss(sighting.base_T_marker, FACING)[0] < 0.5


def test_pictures_that_are_too_old_show_nothing():
    assert look(FACING, aged_ns=450_000_000).refusal is None
    sighting = look(FACING, aged_ns=500_000_000)
    assert code(sighting) is Code.MARKER_STALE
    assert sighting.refusal.sentence.endswith("the pictures are 500 ms old")


def test_of_several_pictures_that_are_too_old_the_newest_is_told():
    watch = MarkerWatch(AssistConfig(targets=(TARGET,)), VIEWS)
    for name, age_ms in zip(VIEWS, (900, 600), strict=True):
        watch.observe(name, NOW_NS - age_ms * 1_000_000, FoundMarkers({}), None)
    (sighting,) = watch.sightings(NOW_NS)
    assert present(sighting.refusal).sentence.endswith("the pictures are 600 ms old")


def test_a_view_with_too_many_candidates_says_so_while_its_picture_is_fresh():
    watch = MarkerWatch(AssistConfig(targets=(TARGET,)), VIEWS)
    watch.observe("front_low", NOW_NS, FoundMarkers({}, (NUMBER,)), None)
    for age_ms, expected in ((450, Code.MARKER_CROWDED), (451, Code.MARKER_STALE)):
        (sighting,) = watch.sightings(NOW_NS + age_ms * 1_000_000)
        assert code(sighting) is expected


def test_a_marker_far_from_where_the_tool_belongs_is_too_uncertain():
    sighting = look(FACING, target=replace(TARGET, xyz_mm=(0, 0, -600)))
    assert code(sighting) is Code.MARKER_UNCERTAIN
    assert "print a larger marker" in sighting.refusal.sentence


def test_views_that_are_wrongly_calibrated_contradict_each_other():
    config = AssistConfig(targets=(TARGET,))
    watch, detector = MarkerWatch(config, VIEWS), MarkerDetector(config.family, (NUMBER,))
    rng = np.random.default_rng(5)
    for name, seen in VIEWS.items():
        markers = [(config.family, NUMBER, SIZE_M, FACING)]
        found = detector.find(picture(np.reshape(seen.projection, (3, 4)), markers, rng))
        if name == "front_low":
            found = FoundMarkers({NUMBER: [found.corners[NUMBER][0] + (0.0, 6.0)]})
        watch.observe(name, NOW_NS, found, None)
    (sighting,) = watch.sightings(NOW_NS)
    assert code(sighting) is Code.MARKER_CONTRADICTED


def test_half_a_marker_is_no_marker():
    rng, detector = np.random.default_rng(1), MarkerDetector(FAMILY, (NUMBER,))
    seen = np.reshape(VIEWS["front_low"].projection, (3, 4))
    whole = picture(seen, [(FAMILY, NUMBER, SIZE_M, FACING)], rng)
    (corners,) = detector.find(whole).corners[NUMBER]
    left, top = corners.min(axis=0).astype(int) - 5
    whole[top : top + 22, left : left + 60] = 90
    assert detector.find(whole) == FoundMarkers({})
