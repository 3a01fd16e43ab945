"""Statistics of pictures from how many pixels have each level: the same as those of the pixels."""

import numpy as np

from farhand.export.lerobot.statistics import is_sampled, levels_of, of_column, of_pictures, summed


def test_levels_give_the_statistics_of_the_pixels():
    random = np.random.default_rng(1)
    shown = [random.integers(30, 220, (60, 80, 3), np.uint8) // (k + 1) for k in range(3)]
    found = of_pictures(summed(levels_of(picture) for picture in shown), len(shown))
    pixels = np.concatenate([picture.reshape(-1, 3) for picture in shown]) / 255
    for name, exact in (
        ("min", pixels.min(0)),
        ("max", pixels.max(0)),
        ("mean", pixels.mean(0)),
        ("std", pixels.std(0)),
    ):
        np.testing.assert_allclose(np.reshape(found[name], 3), exact, atol=1e-12)
    np.testing.assert_allclose(np.reshape(found["q10"], 3), np.quantile(pixels, 0.1, axis=0), atol=1 / 255)
    assert found["count"] == [3]


def test_large_pictures_are_thinned():
    assert levels_of(np.zeros((480, 640, 3), np.uint8)).sum() == 3 * 160 * 214


def test_a_column_of_numbers_has_a_figure_for_each_axis():
    found = of_column(np.array([[1.0, 5.0], [3.0, 5.0]]))
    assert (found["mean"], found["std"], found["count"]) == ([2.0, 5.0], [1.0, 0.0], [2])
    assert of_column(np.arange(101))["q90"] == [90.0]


def test_about_a_hundred_frames_of_an_episode_are_sampled():
    assert sum(is_sampled(k, 1000) for k in range(1000)) == 100
    assert sum(is_sampled(k, 50) for k in range(50)) == 50
