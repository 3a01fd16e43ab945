"""The tracker by networks on films: found from nothing, followed, refused where there is none of the operator's."""

from dataclasses import dataclass, replace

import msgspec
import numpy as np
import pytest

from common.cameras.camera import Frame
from common.messages.hand import TrackingStatus
from lab.films.film import FilmInstant
from lab.films.meshed import FilmedArm, MeshFilm, mesh_film
from lab.films.surroundings import FilmSetting
from local_site.calibration.rig import Rig
from local_site.simulation.room.config import SkinName
from local_site.tracking.config import EyeConfig
from local_site.tracking.eye.arm_points import AVERAGE_M
from local_site.tracking.eye.eye_tracker import EyeTracker
from local_site.tracking.eye.fitted_points import Lengths
from local_site.tracking.tracker import ArmEstimate, TrackingReason, View, Views

OFFICE = FilmSetting(room="office")


@dataclass(frozen=True)
class Drawn:
    """A film whose instants are drawn once."""

    rig: Rig
    instants: tuple[FilmInstant, ...]

    def views(self, count: int) -> list[Views]:
        """Return the first instants' views."""
        return [instant.views for instant in self.instants[:count]]


def drawn(spec: MeshFilm) -> Drawn:
    film = mesh_film(spec)
    return Drawn(film.rig, tuple(film.instants()))


def tracked(film: Drawn, *, right_arm: bool = True) -> list[tuple[ArmEstimate, FilmInstant]]:
    tracker = EyeTracker(film.rig, EyeConfig(right_arm=right_arm))
    return [(tracker.track(instant.views), instant) for instant in film.instants]


def off_mm(pairs: list[tuple[ArmEstimate, FilmInstant]], name: str) -> np.ndarray:
    """By how much (N, 3) in mm a point is off in the tracked pairs."""
    found = [(getattr(e, name), getattr(i.truth.arm, name)) for e, i in pairs if i.truth and e.wrist is not None]
    return 1e3 * np.array([a - b for a, b in found])


@pytest.fixture(scope="module")
def left() -> Drawn:
    return drawn(MeshFilm(name="a", arm=FilmedArm(right=False), seconds=1.5))


@pytest.fixture(scope="module")
def short() -> Drawn:
    return drawn(MeshFilm(name="a", seconds=0.3))


@pytest.mark.slow
@pytest.mark.parametrize("tone", ["light", "dark"])
def test_an_arm_is_found_and_followed_in_a_room(tone: SkinName) -> None:
    film = drawn(MeshFilm(name="a", arm=FilmedArm(tone=tone), setting=OFFICE, seconds=2.0))
    pairs = tracked(film)
    estimates = [estimate for estimate, _ in pairs]
    found = next(k for k, e in enumerate(estimates) if e.status is TrackingStatus.INITIALISING)
    assert found < 40
    assert {e.status for e in estimates[found + 9 :]} == {TrackingStatus.TRACKED}
    wrist, index = off_mm(pairs, "wrist"), off_mm(pairs, "index")
    assert np.linalg.norm(wrist - wrist.mean(axis=0), axis=1).mean() < 5.0
    assert np.linalg.norm(wrist, axis=1).mean() < 15.0
    assert np.linalg.norm(index, axis=1).mean() < 35.0
    last = estimates[-1]
    assert {"wrist", "index", "thumb", "elbow"} == set(last.covariances)
    assert last.overlays[0].contour is not None
    assert not any(e.hand_open for e in estimates)


@pytest.mark.slow
def test_a_left_arm_is_followed_as_well(left: Drawn) -> None:
    pairs = tracked(left, right_arm=False)
    assert sum(e.status is TrackingStatus.TRACKED for e, _ in pairs) >= len(pairs) - 15
    wrist = off_mm(pairs, "wrist")
    assert np.linalg.norm(wrist - wrist.mean(axis=0), axis=1).mean() < 5.0


@pytest.mark.slow
def test_a_left_arm_is_refused_where_a_right_one_is_expected(left: Drawn) -> None:
    pairs = tracked(left)
    assert sum(e.status is TrackingStatus.TRACKED for e, _ in pairs) < 0.1 * len(pairs)


@pytest.mark.slow
@pytest.mark.parametrize("setting", [OFFICE, replace(OFFICE, second_person=True), FilmSetting(room="poster")])
def test_without_the_operators_arm_nothing_is_tracked(setting: FilmSetting) -> None:
    film = drawn(MeshFilm(name="none", arm=None, setting=setting, seconds=1.0))
    assert {e.status for e, _ in tracked(film)} == {TrackingStatus.LOST}


def test_the_first_pairs_learn_and_say_so(short: Drawn) -> None:
    tracker = EyeTracker(short.rig)
    first = [tracker.track(views) for views in short.views(3)]
    assert {e.status for e in first} == {TrackingStatus.INITIALISING}
    assert first[0].reason == TrackingReason.LEARNING
    assert first[0].wrist is not None


def test_an_instant_between_two_exposures_lies_between_them(short: Drawn) -> None:
    one, other = short.views(2)
    tracker = EyeTracker(short.rig)
    tracker.track(one)
    views = tuple(View(b.current, a.current, 0.5) for a, b in zip(one.views, other.views, strict=True))
    estimate = tracker.track(Views((one.t_ns + other.t_ns) // 2, views))
    assert estimate.status is TrackingStatus.INITIALISING


def test_after_a_gap_the_hand_is_searched_and_learned_again(short: Drawn) -> None:
    tracker = EyeTracker(short.rig, EyeConfig(initial_pairs=5))
    views = short.views(7)
    assert [tracker.track(each).status for each in views][-1] is TrackingStatus.TRACKED
    later = replace(views[-1], t_ns=views[-1].t_ns + 10**9)
    assert tracker.track(later).status is TrackingStatus.INITIALISING


def test_black_pictures_lose_the_arm_with_a_reason(short: Drawn) -> None:
    tracker = EyeTracker(short.rig)
    for views in short.views(2):
        tracker.track(views)
    black = []
    for view in views.views:
        frame = view.current
        black.append(View(Frame(np.zeros_like(frame.image), frame.capture_ns + 1, frame.seq + 1)))
    estimates = [tracker.track(Views(views.t_ns + k * 30_000_000, tuple(black))) for k in range(1, 9)]
    assert estimates[-1].status is TrackingStatus.LOST
    assert estimates[-1].reason == TrackingReason.NO_HAND
    assert not any(e.status is TrackingStatus.TRACKED for e in estimates)
    unclear = [e for e in estimates if e.wrist is not None]
    assert min(np.linalg.eigvalsh(e.covariances["wrist"])[0] for e in unclear) > 0.039**2


def test_a_time_that_jumps_back_begins_anew(short: Drawn) -> None:
    tracker = EyeTracker(short.rig, EyeConfig(initial_pairs=5))
    views = short.views(7)
    assert [tracker.track(each).status for each in views][-1] is TrackingStatus.TRACKED
    earlier = tracker.track(replace(views[-1], t_ns=views[-1].t_ns - 10**10))
    assert earlier.status is TrackingStatus.INITIALISING
    assert earlier.wrist is not None
    assert short.rig.contains(earlier.wrist)


def test_a_hand_outside_the_calibrated_volume_is_told_as_such(short: Drawn) -> None:
    above = tuple(x + 2.0 for x in short.rig.volume_max)
    rig = msgspec.structs.replace(short.rig, volume_min=above, volume_max=tuple(x + 0.5 for x in above))
    tracker = EyeTracker(rig)
    assert {tracker.track(views).reason for views in short.views(3)} == {TrackingReason.OUTSIDE_VOLUME}


def test_too_few_views_and_wrong_pictures_are_named(short: Drawn) -> None:
    (views,) = short.views(1)
    tracker = EyeTracker(short.rig)
    assert "1 views for 2" in tracker.track(Views(views.t_ns, views.views[:1])).reason


def test_a_third_camera_that_does_not_show_the_hand_prevents_no_start(short: Drawn) -> None:
    left = short.rig.cameras[0]
    rig = msgspec.structs.replace(short.rig, cameras=(*short.rig.cameras, msgspec.structs.replace(left, name="third")))
    tracker, found = EyeTracker(rig), []
    for views in short.views(3):
        frame = views.views[0].current
        dark = View(Frame(np.zeros_like(frame.image), frame.capture_ns, frame.seq))
        found.append(tracker.track(Views(views.t_ns, (*views.views, dark))).status)
    assert set(found) == {TrackingStatus.INITIALISING}


def test_lengths_learned_of_one_hand_are_not_those_of_the_next(short: Drawn) -> None:
    tracker = EyeTracker(short.rig)
    (views,) = short.views(1)
    tracker._lengths = Lengths(1.2 * AVERAGE_M, np.full(len(AVERAGE_M), 0.001))
    tracker.track(Views(views.t_ns, views.views[:1]))
    wrist = tracker.track(views).wrist
    expected = EyeTracker(short.rig).track(views).wrist
    assert wrist is not None
    assert expected is not None
    assert wrist == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("channels", [1, 2, 4])
def test_pictures_of_other_channels_are_seen_grey_or_without_transparency(short: Drawn, channels: int) -> None:
    (views,) = short.views(1)
    shown = []
    for frame in (view.current for view in views.views):
        image = np.dstack([frame.image, frame.image[..., :1]])[..., :channels]
        shown.append(View(Frame(np.ascontiguousarray(image), frame.capture_ns, frame.seq)))
    assert EyeTracker(short.rig).track(Views(views.t_ns, tuple(shown))).status is TrackingStatus.INITIALISING


@pytest.mark.slow
def test_exchanged_cameras_are_never_tracked() -> None:
    film = drawn(MeshFilm(name="a", seconds=1.0))
    tracker, statuses = EyeTracker(film.rig), set()
    for instant in film.instants:
        views = instant.views
        statuses.add(tracker.track(Views(views.t_ns, views.views[::-1])).status)
    assert TrackingStatus.TRACKED not in statuses
