"""Which pairs a report shows: those of the greatest sigma or jump, apart in time, and the first of each reason."""

import cv2
import numpy as np

from common.messages.hand import TrackingStatus
from farhand.tracking.results.report.worst_pairs import APART_S, REASONS, WORST, ShownPair, WorstPairs
from farhand.tracking.results.tracked_pair import TrackedPair
from tests.farhand.tracking.results.tracked import FPS, pair

APART = round(APART_S * FPS)


def shown(*pairs: TrackedPair) -> WorstPairs:
    worst = WorstPairs()
    for found in pairs:
        worst.add(found)
    return worst


def frames(pairs: list[ShownPair]) -> list[int]:
    return [found.frame for found in pairs]


def moving(frame: int, *, off_mm: float = 0.0, **more: float) -> TrackedPair:
    """A wrist on its steady way, or off it."""
    return pair(frame, (0.01 * frame, 0.0, 1e-3 * off_mm), **more)  # type: ignore[arg-type]


def test_a_steady_motion_is_no_jump_and_one_point_off_its_way_is() -> None:
    steady = shown(*(moving(k) for k in range(20)))
    assert {found.why for found in steady.worst} == {"wrist: sigma 1.0 mm"}
    jumped = shown(*(moving(k, off_mm=30.0 * (k == 7)) for k in range(20)))
    assert [(found.frame, found.why) for found in jumped.worst[:1]] == [(8, "wrist: a jump of 60.0 mm")]
    assert jumped.worst[1].why == "wrist: sigma 1.0 mm", "the pair before, of the same fifth of a second, is left out"


def test_after_a_loss_a_new_place_is_no_jump() -> None:
    found = shown(moving(0), moving(1), pair(2), moving(3, off_mm=90.0), moving(4, off_mm=90.0))
    assert {kept.why for kept in found.worst} == {"wrist: sigma 1.0 mm"}


def test_the_worst_are_the_greatest_sigmas_of_their_time_in_their_order() -> None:
    random = np.random.default_rng(1)
    sigmas_mm = random.uniform(1.0, 9.0, 40 * APART)
    found = shown(*(moving(k, sigma_mm=sigma) for k, sigma in enumerate(sigmas_mm)))
    of_each_time = sigmas_mm.reshape(-1, APART)
    places = np.arange(len(of_each_time)) * APART + of_each_time.argmax(axis=1)
    expected = sorted(places, key=lambda k: -sigmas_mm[k])[:WORST]
    assert frames(found.worst) == expected


def test_pairs_without_a_point_are_shown_by_their_reasons_only() -> None:
    found = shown(*(pair(k, reason=f"reason {k % 3}") for k in range(9)))
    assert not found.worst
    assert [(kept.frame, kept.why) for kept in found.first_of_reason] == [
        *((0, "lost: reason 0"), (1, "lost: reason 1"), (2, "lost: reason 2"))
    ]


def test_counting_reasons_are_one_and_there_are_never_more_than_a_few() -> None:
    learning = (pair(k, reason=f"learning ({k} of 10 pairs)", status=TrackingStatus.INITIALISING) for k in range(10))
    assert frames(shown(*learning).first_of_reason) == [0]
    assert len(shown(*(pair(k, reason=f"reason {k}") for k in range(50))).first_of_reason) == REASONS


def test_a_shown_pair_is_its_own_picture() -> None:
    (kept,) = shown(pair(0, (0.4, 0.3, 0.5), grey=77)).worst
    picture = cv2.imdecode(np.frombuffer(kept.png, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    assert np.array_equal(picture, pair(0, (0.4, 0.3, 0.5), grey=77).picture)
