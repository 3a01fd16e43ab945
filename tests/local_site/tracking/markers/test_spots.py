"""Bright spots: centroids to a few hundredths of a pixel, honest noise, and nothing that is no marker."""

import cv2
import numpy as np
import pytest

from local_site.tracking.markers.spots import find_spots
from tests.local_site.tracking.markers.marker_scene import spots_in

SIZE = (120, 160)


def disc(centre, radius, level=220.0, background=10.0, noise=0.0, seed=0):
    """A picture of a disc, drawn eight times finer, a little out of focus as every lens is."""
    columns, rows = (np.arange(length * 8) / 8.0 - 7.0 / 16.0 for length in SIZE[::-1])
    inside = (columns - centre[0]) ** 2 + ((rows - centre[1]) ** 2)[:, None] < radius**2
    coverage = inside.reshape(SIZE[0], 8, SIZE[1], 8).mean(axis=(1, 3))
    image = cv2.GaussianBlur(np.broadcast_to(background, SIZE) * (1.0 - coverage) + level * coverage, (0, 0), 0.6)
    image = image + noise * np.random.default_rng(seed).standard_normal(SIZE)
    return np.clip(np.rint(image), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("radius", [2.5, 4.0, 7.3])
@pytest.mark.parametrize("level", [90.0, 220.0])
def test_centroids_and_areas_are_sub_pixel(radius, level):
    random = np.random.default_rng(3)
    for _ in range(4):
        centre = random.uniform([30, 30], [120, 90])
        found = spots_in(disc(centre, radius, level), 40)
        assert np.abs(found.in_picture - centre).max() < 0.04
        assert found.areas[0] == pytest.approx(np.pi * radius**2, rel=0.08)


def test_a_glove_on_one_side_does_not_draw_the_centroid():
    glove = np.where(np.arange(SIZE[1]) < 80, 10.0, 40.0)
    centre = np.array([80.3, 60.2])
    found = spots_in(disc(centre, 5.0, background=glove), 40)
    assert np.abs(found.in_picture - centre).max() < 0.12


def test_the_told_noise_is_that_of_the_centroid():
    centre = np.array([70.4, 50.7])
    found = [spots_in(disc(centre, 4.0, level=120.0, noise=8.0, seed=seed), 40) for seed in range(60)]
    errors = np.array([f.in_picture[0] - centre for f in found])
    told = np.array([f.sigmas[0] for f in found])
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(np.median(told), rel=0.25)


def test_only_marker_like_places_count():
    image = disc((40.0, 40.0), 5.0)
    cv2.rectangle(image, (80, 20), (150, 100), 200, cv2.FILLED)
    cv2.line(image, (20, 80), (60, 80), 220, 2)
    cv2.circle(image, (0, 100), 5, 220, cv2.FILLED)
    image[10, 10] = 255
    found = spots_in(image, 40)
    assert len(found) == 1
    assert found.in_picture[0] == pytest.approx([40.0, 40.0], abs=0.1)


def test_markers_of_different_brightness_are_all_found():
    image = np.maximum(disc((30.0, 40.0), 4.0, 250.0), disc((90.0, 70.0), 4.0, 110.0))
    assert len(find_spots(image, 40)) == 2


@pytest.mark.parametrize(
    ("image", "reason"),
    [
        (np.full(SIZE, 10, np.uint8), "nothing is bright enough"),
        (np.full(SIZE, 255, np.uint8), "nothing is bright enough"),
        (np.zeros(SIZE), "wrong kind"),
        (np.empty((0, 5), np.uint8), "wrong kind"),
        (np.zeros((20, 20, 4), np.uint8), "wrong kind"),
        (np.random.default_rng(1).integers(0, 256, (200, 200), dtype=np.uint8), "full of bright spots"),
        (cv2.rectangle(np.full(SIZE, 10, np.uint8), (80, 20), (150, 100), 200, cv2.FILLED), "dark glove"),
    ],
)
def test_without_markers_there_is_a_reason(image, reason):
    assert reason in str(find_spots(image, 40))
