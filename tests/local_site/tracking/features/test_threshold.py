"""The threshold: between background and arm where the histogram has two modes, refused where it has one."""

import numpy as np
import pytest

from local_site.tracking.features.silhouette import find_threshold


def scene(background=10.0, arm=120.0, noise=3.0, share=0.03, seed=0):
    random = np.random.default_rng(seed)
    image = background + noise * random.standard_normal((240, 320))
    image[: round(240 * share * 4), :80] = arm + 25 * random.standard_normal((round(240 * share * 4), 80))
    return np.clip(image, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("background", [5.0, 20.0, 60.0])
@pytest.mark.parametrize("arm", [110.0, 180.0])
def test_the_threshold_lies_between_the_modes(background, arm):
    level = find_threshold(scene(background, arm))
    assert isinstance(level, float)
    assert background + 8 < level < background + 0.5 * (arm - background)


def test_a_gradient_and_folds_do_not_move_it_into_the_background():
    image = scene().astype(float) + np.linspace(0, 12, 320)[None, :]
    level = find_threshold(image.astype(np.uint8))
    assert isinstance(level, float)
    assert np.mean(image > level) < 0.04


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((240, 320)),
        np.full((240, 320), 255.0),
        np.random.default_rng(1).integers(0, 256, (240, 320)),
        np.random.default_rng(2).normal(60, 20, (240, 320)).clip(0, 255),
        scene(share=0.0),
    ],
)
def test_one_mode_is_refused_with_a_reason(image):
    reason = find_threshold(image.astype(np.uint8))
    assert isinstance(reason, str)
    assert reason
