"""The log ratios of many pixels at once are those of the formula, written out for one."""

import math

import numpy as np
import pytest

from local_site.tracking.foreground.arm_colour import (
    BRIGHTNESS_STEP,
    CHROMA_STEP,
    DARK,
    ArmColour,
    bin_of,
    chromaticity,
)
from local_site.tracking.foreground.likelihood import (
    BRIGHTEST,
    BRIGHTNESS_NOISE,
    BRIGHTNESS_SPREAD,
    CHROMA_FLOOR,
    CHROMA_NOISE,
    DARKEST,
    FARTHEST,
    MOST,
    MOVING,
    STEADY,
    UNSEEN,
    log_ratios,
    ratio_tables,
)

SKIN, WALL = (120, 150, 200), (160, 150, 140)


@pytest.fixture(scope="module")
def colour():
    learned = ArmColour()
    skin, wall = (np.full((1600, 3), colour, np.uint8) for colour in (SKIN, WALL))
    learned.learn(skin, wall, 0.0)
    return learned


def expected(colour, seen, behind, known):
    """The log ratio of one pixel."""
    brightness, before = float(sum(seen)), float(sum(behind))
    r, g = chromaticity(*map(float, seen))
    number = bin_of(r, g, brightness)
    arm, rest = float(colour.arm[number]), float(colour.rest[number])
    unseen = min(max(math.log((arm + UNSEEN) / (rest + UNSEEN)), -MOST), MOST)
    if not known:
        return unseen
    back_r, back_g = chromaticity(*map(float, behind))
    sigma = CHROMA_FLOOR + CHROMA_NOISE / (brightness + DARK)
    square = ((r - back_r) ** 2 + (g - back_g) ** 2) / sigma**2
    if square > FARTHEST:
        return min(unseen - math.log(MOVING), MOST)
    of_colour = min(CHROMA_STEP**2 / (2 * math.pi * sigma**2), 1.0) * math.exp(-square / 2)
    spread = BRIGHTNESS_NOISE + BRIGHTNESS_SPREAD * before
    steady = min(BRIGHTNESS_STEP / (2.5 * spread), 1.0) * math.exp(-(((brightness - before) / spread) ** 2) / 2)
    is_shaded = DARKEST * before < brightness < BRIGHTEST * before
    shaded = min(BRIGHTNESS_STEP / ((BRIGHTEST - DARKEST) * before + 1.0), 1.0) if is_shaded else 0.0
    of_room = of_colour * (STEADY * steady + (1 - STEADY) * shaded)
    of_rest = MOVING * rest + (1 - MOVING) * of_room
    return min(max(math.log((arm + UNSEEN) / (of_rest + UNSEEN)), -MOST), MOST)


def test_many_pixels_have_the_ratios_of_the_formula(colour):
    random = np.random.default_rng(3)
    middles = np.array([SKIN, WALL, (40, 60, 30)])[random.integers(0, 3, 600)]
    seen = np.clip(middles + random.normal(0, 12, (600, 3)), 0, 255).astype(np.uint8)
    lit = np.clip(seen * random.uniform(0.7, 1.4, (600, 1)) + random.normal(0, 6, (600, 3)), 0, 255)
    known = (random.random(600) < 0.8).astype(np.uint8)
    behind = lit.astype(np.float32)
    seen_planes, behind_planes = np.ascontiguousarray(seen.T), np.ascontiguousarray(behind.T)
    found = log_ratios(seen_planes, behind_planes, known, ratio_tables(colour.arm, colour.rest))
    wanted = [expected(colour, *pixel) for pixel in zip(seen.tolist(), behind.tolist(), known, strict=True)]
    assert np.allclose(found, wanted, atol=2e-3)
    assert min(wanted) < -1.0 < 1.0 < max(wanted)


def test_the_pixels_keep_their_order_in_a_picture(colour):
    seen = np.zeros((3, 2, 4), np.uint8)
    seen[:] = np.array(WALL)[:, None, None]
    seen[:, 1, 2] = SKIN
    behind = np.tile(np.array(WALL, np.float32)[:, None, None], (1, 2, 4))
    ratios = log_ratios(seen, behind, np.ones((2, 4), np.uint8), ratio_tables(colour.arm, colour.rest))
    assert ratios.shape == (2, 4)
    assert np.argwhere(ratios > 0).tolist() == [[1, 2]]
