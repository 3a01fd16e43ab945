"""The part of a picture that shows the arm follows it, stays within the picture, and moves only when it has to."""

import math
from itertools import pairwise

import numpy as np
import pytest

from local_site.preview.arm_window import LEAST_MARGIN, LEAST_SIDE, SETTLE_S, WHOLE, ArmWindow, PictureBox

FPS = 12.0
ROUNDING = 1e-9
RNG = np.random.default_rng(3)


def box(x, y, width=0.4, height=0.3):
    return PictureBox(x - width / 2, y - height / 2, x + width / 2, y + height / 2)


def shown(arms, window=None, fps=FPS, since_s=0.0):
    window = window or ArmWindow()
    return [window.at(round(1e9 * (since_s + k / fps)), arm) for k, arm in enumerate(arms)]


def settled(arm=None):
    """A window that has come to rest around an arm, after ten seconds."""
    window = ArmWindow()
    shown([arm or box(0.5, 0.5)] * round(10 * FPS), window)
    return window


def side(part):
    return part.right - part.left


def contains(part, arm, margin=0.0):
    return (
        part.left <= max(arm.left - margin, 0.0) + ROUNDING
        and part.top <= max(arm.top - margin, 0.0) + ROUNDING
        and part.right >= min(arm.right + margin, 1.0) - ROUNDING
        and part.bottom >= min(arm.bottom + margin, 1.0) - ROUNDING
    )


def is_valid(part):
    within = min(part.left, part.top) >= -ROUNDING and max(part.right, part.bottom) <= 1.0 + ROUNDING
    return within and side(part) == pytest.approx(part.bottom - part.top) and side(part) >= LEAST_SIDE - ROUNDING


def circling(seconds, period_s=2.0):
    turns = 2 * math.pi * np.arange(round(seconds * FPS)) / FPS / period_s
    return [box(0.5 + 0.3 * math.cos(turn), 0.5 + 0.3 * math.sin(turn), 0.3, 0.3) for turn in turns]


def test_the_whole_picture_is_shown_until_an_arm_was_seen_for_a_while():
    parts = shown([box(0.5, 0.5)] * round(5 * FPS))
    assert parts[: math.floor(SETTLE_S * FPS)] == [WHOLE] * math.floor(SETTLE_S * FPS)
    assert side(parts[-1]) == pytest.approx(0.56, abs=0.01)
    assert contains(parts[-1], box(0.5, 0.5), LEAST_MARGIN)


def test_a_small_arm_is_not_enlarged_beyond_a_third_of_the_picture():
    part = settled(box(0.5, 0.5, 0.02, 0.02)).at(round(11e9), box(0.5, 0.5, 0.02, 0.02))
    assert side(part) == pytest.approx(LEAST_SIDE)


def test_a_moving_arm_is_followed_and_never_cut():
    window = settled(box(0.8, 0.5, 0.3, 0.3))
    arms = circling(6.0)
    parts = shown(arms, window, since_s=10.0)
    assert all(contains(part, arm) for part, arm in zip(parts, arms, strict=True))
    assert all(is_valid(part) for part in parts)
    assert max(side(part) for part in parts) < 0.75


def test_even_a_leap_is_followed_at_once():
    far = box(0.1, 0.1, 0.15, 0.15)
    (part,) = shown([far], settled(box(0.8, 0.8, 0.3, 0.3)), since_s=10.0)
    assert contains(part, far)
    assert is_valid(part)


@pytest.mark.parametrize(
    "arm", [box(0.2, 0.15), box(0.8, 0.85), PictureBox(0.0, 0.0, 1.0, 0.4), PictureBox(0.6, 0.0, 1.0, 1.0), WHOLE]
)
def test_at_the_border_and_however_large_the_arm_the_part_stays_within_the_picture(arm):
    parts = shown([arm] * 60)
    assert all(is_valid(part) and contains(part, arm) for part in parts)
    assert parts[-1] == parts[-2] or side(parts[-1]) == pytest.approx(side(parts[-2]), abs=1e-6)


def test_any_arms_give_a_valid_part():
    window = ArmWindow()
    for k in range(2000):
        x, y = np.sort(RNG.uniform(0, 1, 2)), np.sort(RNG.uniform(0, 1, 2))
        arm = PictureBox(x[0], y[0], x[1], y[1]) if RNG.uniform() < 0.9 else None
        assert is_valid(window.at(round(k * 1e9 / FPS), arm))


def test_while_the_arm_is_well_inside_the_part_stands_still():
    window = settled(box(0.5, 0.5))
    trembling = [box(*(0.5 + RNG.uniform(-0.04, 0.04, 2))) for _ in range(100)]
    parts = shown(trembling, window, since_s=10.0)
    assert max(abs(a.left - b.left) + abs(a.top - b.top) for a, b in pairwise(parts)) < ROUNDING


@pytest.mark.parametrize("size", [0.2, 0.37, 0.44, 0.61, 0.7])
def test_at_the_border_it_stands_still_too(size):
    trembling = [PictureBox(1.0 - size + RNG.uniform(-0.02, 0.02), 0.5, 1.0, 0.6) for _ in range(100)]
    parts = shown(trembling, settled(PictureBox(1.0 - size, 0.5, 1.0, 0.6)), since_s=10.0)
    assert max(abs(a.left - b.left) + abs(a.top - b.top) for a, b in pairwise(parts)) < ROUNDING


def test_an_arm_that_becomes_larger_or_smaller_is_followed_beyond_the_hysteresis():
    window = settled(box(0.5, 0.5, 0.4, 0.3))
    assert side(shown([box(0.5, 0.5, 0.33, 0.3)] * 50, window, since_s=10.0)[-1]) == pytest.approx(0.56, abs=0.01)
    assert side(shown([box(0.5, 0.5, 0.2, 0.2)] * 50, window, since_s=20.0)[-1]) == pytest.approx(0.36, abs=0.01)
    assert side(shown([box(0.5, 0.5, 0.6, 0.5)] * 50, window, since_s=30.0)[-1]) == pytest.approx(0.76, abs=0.01)


def test_it_moves_smoothly():
    window = settled(box(0.4, 0.5))
    parts = shown([box(0.55, 0.5)] * 40, window, since_s=10.0)
    steps = [b.left - a.left for a, b in pairwise(parts)]
    assert min(steps) >= -ROUNDING
    assert steps == sorted(steps, reverse=True)
    assert sum(steps) > 0.05


def test_single_lost_pictures_change_nothing():
    arms = [box(0.5, 0.5) if k % 4 else None for k in range(120)]
    parts = shown(arms, settled(), since_s=10.0)
    assert max(side(part) for part in parts) == pytest.approx(0.56, abs=0.01)


def test_a_loss_that_lasts_opens_to_the_whole_picture_and_the_arm_found_again_closes_it():
    window = settled()
    lost = shown([None] * round(3 * FPS), window, since_s=10.0)
    sides = [side(part) for part in lost]
    assert max(sides[: math.floor(SETTLE_S * FPS) - 1]) == pytest.approx(0.56, abs=0.01)
    assert min(np.diff(sides)) > -ROUNDING
    assert sides[-1] == pytest.approx(1.0, abs=0.001)
    found = shown([box(0.5, 0.5)] * round(3 * FPS), window, since_s=13.0)
    assert side(found[3]) > 0.999
    assert side(found[-1]) == pytest.approx(0.56, abs=0.01)


def test_an_arm_seen_now_and_then_does_not_keep_a_mostly_lost_view_closed():
    arms = [None if k % 5 else box(0.5, 0.5) for k in range(100)]
    assert side(shown(arms, settled(), since_s=10.0)[-1]) > 0.95


def test_one_picture_after_a_pause_decides_nothing():
    window = settled()
    assert side(window.at(round(60e9), None)) == pytest.approx(0.56, abs=0.01)
    fresh = ArmWindow()
    fresh.at(0, None)
    assert fresh.at(round(60e9), box(0.5, 0.5)) == WHOLE
