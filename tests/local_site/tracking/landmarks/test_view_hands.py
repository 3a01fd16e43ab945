"""The hands in one camera's pictures: searched part by part, followed in the crop, interpolated between exposures."""

import numpy as np
import pytest

from common.cameras.camera import Frame
from local_site.tracking.landmarks.crop import Crop
from local_site.tracking.landmarks.view_follower import SEARCHES
from local_site.tracking.landmarks.view_hands import ViewHands, as_bgr
from local_site.tracking.tracker import View
from tests.local_site.tracking.landmarks.fake_networks import (
    LANDMARKER_SIDE,
    fake_follower,
    hand_outputs,
    middle_palm,
    palm_outputs,
    upright_hand,
)
from tests.local_site.tracking.landmarks.seen_hands import PAIR_RIG

CAMERA = PAIR_RIG.cameras[0]
POINTS = np.column_stack([np.full(21, 110.0), np.linspace(190.0, 40.0, 21)])


def frame(seq, level=120, shape=(480, 640, 3)):
    return Frame(np.full(shape, level, np.uint8), seq * 33_000_000, seq)


def no_palm(_):
    return palm_outputs([])


def says(score=0.9, right=0.9, points=POINTS):
    """A network that sees the same hand everywhere."""
    return lambda _: hand_outputs(points, score, right)


def hands_of(follower, right_arm=True):
    return ViewHands(CAMERA, follower, right_arm)


def counted(answer):
    """The answer, and a list that grows with every picture that was shown."""
    shown = []

    def network(picture):
        shown.append(picture)
        return answer(picture)

    return network, shown


def test_an_empty_picture_shows_no_hand():
    assert hands_of(fake_follower(no_palm)).hands(View(frame(0))) == []


def test_a_palm_becomes_a_hand_inside_its_picture():
    (hand,) = hands_of(fake_follower()).hands(View(frame(0)))
    assert hand.points.shape == (21, 2)
    assert (hand.points > 0).all()
    assert (hand.points < (640, 480)).all()
    assert (hand.score, hand.right) == pytest.approx((0.9, 0.9))


def test_a_palm_on_which_no_hand_is_seen_is_left_out():
    assert hands_of(fake_follower(middle_palm, says(score=0.3))).hands(View(frame(0))) == []


def test_every_part_of_the_picture_is_searched_and_then_brighter():
    network, shown = counted(no_palm)
    follower = fake_follower(network)
    picture = np.zeros((480, 640, 3), np.uint8)
    for k, (rows, columns) in enumerate(
        (r, c) for r in (slice(0, 240), slice(240, 480)) for c in (slice(0, 320), slice(320, 640))
    ):
        picture[rows, columns] = 40 + 15 * k
    for _ in SEARCHES:
        follower.search(picture)
    means = [float(seen.max()) for seen in shown]
    assert len({seen.tobytes() for seen in shown}) == len(SEARCHES)
    assert max(means[len(SEARCHES) // 2 :]) > 1.5 * max(means[: len(SEARCHES) // 2])


@pytest.mark.parametrize("search", range(len(SEARCHES)))
def test_a_palm_found_in_a_part_lies_where_that_part_lies(search):
    """The fake sees a palm in the middle of what it is shown: the part's middle."""
    seen: list[object] = []
    seeing = fake_follower(lambda shown: middle_palm(shown) if len(seen) >= search else no_palm(shown))
    image = np.full((480, 640, 3), 100, np.uint8)
    for _ in range(search):
        seen += [seeing.search(image)]
    (hand,) = seeing.search(image)
    region = SEARCHES[search]
    if not region.square:
        middle = np.array([320.0, 240.0])
    else:
        side = 0.83 * 480
        middle = np.array([region.left * (640 - side), region.top * (480 - side)]) + side / 2
    assert abs(hand.crop.centre[0] - middle[0]) < 2.0
    assert hand.crop.centre[1] < middle[1]
    assert (hand.points[:, 0] - middle[0]).min() > -200


def test_a_hand_that_is_kept_is_followed_without_a_search():
    palms, searches = counted(middle_palm)
    view = hands_of(fake_follower(palms))
    (hand,) = view.hands(View(frame(0)))
    assert not view.is_following
    view.keep(hand)
    assert view.is_following
    (followed,) = view.hands(View(frame(1)))
    assert len(searches) == 1
    expected = hand.next_crop()
    np.testing.assert_allclose(followed.crop.centre, expected.centre)
    view.lose()
    view.hands(View(frame(2)))
    view.hands(View(frame(3)))
    assert len(searches) == 2


def test_a_followed_hand_that_is_gone_is_searched_at_once():
    state = {"score": 0.9}
    view = hands_of(fake_follower(middle_palm, lambda _: hand_outputs(POINTS, state["score"])))
    view.keep(view.hands(View(frame(0)))[0])
    state["score"] = 0.05
    assert view.hands(View(frame(1))) == []
    assert not view.is_following
    state["score"] = 0.9
    assert len(view.hands(View(frame(2)))) == 1


def test_a_hand_that_its_crop_misses_is_seen_in_another_crop():
    scores = [0.05, 0.02, 0.3, 0.7, 0.9]
    network, shown = counted(lambda _: hand_outputs(POINTS, scores.pop(0)))
    view = hands_of(fake_follower(no_palm, network))
    view.keep(hands_of(fake_follower()).hands(View(frame(0)))[0])
    (hand,) = view.hands(View(frame(1)))
    assert hand.score == pytest.approx(0.7)
    assert len(shown) == 4
    assert view.is_following


@pytest.mark.parametrize(("surest", "is_seen"), [(0.4, True), (0.2, False)])
def test_the_surest_of_other_crops_counts_where_none_is_sure(surest, is_seen):
    scores = [0.01, 0.1, surest, 0.15, 0.05, 0.1, 0.0]
    view = hands_of(fake_follower(no_palm, lambda _: hand_outputs(POINTS, scores.pop(0))))
    view.keep(hands_of(fake_follower()).hands(View(frame(0)))[0])
    assert [hand.score for hand in view.hands(View(frame(1)))] == ([pytest.approx(0.4)] if is_seen else [])
    assert len(scores) == (1 if is_seen else 0)


def test_a_hand_that_is_let_go_is_looked_for_where_it_was_before_the_picture_is_searched():
    palms, searches = counted(no_palm)
    view = hands_of(fake_follower(palms))
    kept = hands_of(fake_follower()).hands(View(frame(0)))[0]
    view.keep(kept)
    view.lose()
    (hand,) = view.hands(View(frame(1)))
    np.testing.assert_allclose(hand.crop.centre, kept.next_crop().centre)
    assert searches == []


def test_a_doubtful_hand_is_followed_but_not_found():
    state = {"score": 0.9}
    view = hands_of(fake_follower(middle_palm, lambda _: hand_outputs(POINTS, state["score"])))
    view.keep(view.hands(View(frame(0)))[0])
    state["score"] = 0.3
    assert len(view.hands(View(frame(1)))) == 1
    view.lose()
    assert view.hands(View(frame(2))) == []


def test_each_frame_is_looked_at_once_and_exposures_are_interpolated():
    def at(picture):
        return hand_outputs(np.add(POINTS, (100 * float(picture.mean()), 0.0)))

    network, shown = counted(at)
    view = hands_of(fake_follower(middle_palm, network))
    first, second = frame(0, 180), frame(1, 230)
    view.keep(view.hands(View(first))[0])
    (before,) = view.hands(View(first))
    view.keep(before)
    (now,) = view.hands(View(second))
    looked = len(shown)
    (between,) = view.hands(View(second, first, 0.25))
    assert len(shown) == looked
    np.testing.assert_allclose(between.points, 0.75 * before.points + 0.25 * now.points)
    (whole,) = view.hands(View(second, first, 1.0))
    np.testing.assert_array_equal(whole.points, now.points)


@pytest.mark.parametrize("right_arm", [True, False])
def test_another_crop_counts_only_where_it_shows_this_side_more_clearly(right_arm):
    for right, score, taken in (
        (0.9, 0.9, right_arm),
        (0.1, 0.9, not right_arm),
        (0.9 if right_arm else 0.1, 0.01, False),
    ):
        view = hands_of(fake_follower(middle_palm, says(score, right)), right_arm)
        seen = hands_of(fake_follower(middle_palm, says(0.9, 0.5))).hands(View(frame(0)))[0]
        other = view.again(View(frame(0)), seen, 0)
        assert (other is not seen) == taken


def test_every_attempt_is_another_crop():
    network, shown = counted(says(0.9, 0.9))
    view = hands_of(fake_follower(middle_palm, network))
    image = np.random.default_rng(1).integers(0, 255, (480, 640, 3)).astype(np.uint8)
    seen = hands_of(fake_follower(middle_palm, says(0.9, 0.5))).hands(View(Frame(image, 0, 0)))[0]
    for attempt in range(5):
        view.again(View(Frame(image, 0, 0)), seen, attempt)
    assert len({picture.tobytes() for picture in shown}) == 5


def test_a_quick_look_that_is_unsure_or_sees_the_other_side_is_checked():
    for quick, checked in ((says(0.9, 0.9), False), (says(0.3, 0.9), True), (says(0.9, 0.1), True)):
        network, shown = counted(says(0.8, 0.8))
        view = hands_of(fake_follower(middle_palm, network, quick))
        view.keep(view.hands(View(frame(0)))[0])
        looked = len(shown)
        (hand,) = view.hands(View(frame(1)), quickly=True)
        assert (len(shown) > looked) == checked
        assert hand.score == pytest.approx(0.8 if checked else 0.9)


@pytest.mark.parametrize("shape", [(48, 64), (48, 64, 1), (48, 64, 4), (48, 64, 3)])
def test_every_picture_is_made_one_of_three_colours(shape):
    seen = as_bgr(np.full(shape, 90, np.uint8))
    assert seen.shape == (48, 64, 3)
    assert (seen == 90).all()


def test_the_landmarks_are_those_of_the_crop_in_px_of_the_picture():
    follower = fake_follower(middle_palm, upright_hand)
    crop = Crop(np.array([200.0, 150.0]), 112.0, 0.0)
    hand = follower.again(np.zeros((480, 640, 3), np.uint8), crop)
    expected = upright_hand(np.zeros(1, np.float32))[0].reshape(21, 3)[:, :2]
    np.testing.assert_allclose(hand.points, (200 - 56, 150 - 56) + expected * 112 / LANDMARKER_SIDE, atol=1e-4)
