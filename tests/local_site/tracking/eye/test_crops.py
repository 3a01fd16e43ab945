"""Crops: their place, size and upright, in the picture and back."""

import numpy as np

from local_site.tracking.eye.crops import crop_about


def test_a_crop_has_its_middle_its_width_and_its_upright_where_they_were_asked_for() -> None:
    middle, up = np.array([300.0, 200.0]), np.array([3.0, 4.0])
    crop = crop_about(middle, up, width_px=100.0)
    np.testing.assert_allclose(crop.in_picture(np.array([[0.5, 0.5]])), [middle])
    top = crop.in_picture(np.array([[0.5, 0.0]]))[0]
    np.testing.assert_allclose(top, middle + 50.0 * up / 5.0)
    picture = np.zeros((480, 640, 3), np.uint8)
    picture[195:206, 295:306] = 255
    cut = crop.cut(picture)
    assert cut[96, 96].min() > 200
    assert cut[40, 40].max() == 0
