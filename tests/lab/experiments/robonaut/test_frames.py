"""Frames of a film as pictures: the model lies on the arm, a lost arm is told, captions leave the pictures whole."""

import cv2
import numpy as np

from farhand.reports.plate import CAPTION_PX, GAP_PX, plate
from lab.experiments.robonaut.figures.frames import COLUMNS, TILE_PX, frames_plate, frames_shown, overlays_plate
from lab.experiments.robonaut.footage import Footage, Tracked, bare, render_footage, track_footage
from local_site.simulation.hazel import Swing, film_pixel, hazel_film
from local_site.tracking.config import MonocularConfig

CONFIG = MonocularConfig()
HEIGHT_PX = TILE_PX * 3 // 4


def decoded(png):
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)


def tile(picture, row, column):
    top, left = row * (HEIGHT_PX + CAPTION_PX), column * (TILE_PX + GAP_PX)
    return picture[top : top + HEIGHT_PX, left : left + TILE_PX].astype(int)


def test_the_model_is_drawn_where_the_arm_is_and_a_lost_arm_has_none():
    footage = render_footage(hazel_film(), [bare(Swing().arm(k)) for k in range(2)], lambda: None)
    tracked = track_footage(footage, CONFIG, 0.0)
    lost = Tracked(tracked.true_arms, (tracked.poses[0], None), tracked.estimates)
    picture = decoded(overlays_plate(footage, lost, (1, 2), CONFIG))
    coloured = [np.ptp(tile(picture, 1, column), axis=2) > 12 for column in (0, 1)]
    assert not coloured[1].any()
    assert not (np.ptp(tile(picture, 0, 0), axis=2) > 12).any()
    scale = TILE_PX / 640
    for joint in (footage.true_arms[0].elbow, footage.true_arms[0].wrist):
        x, y = (round(scale * v) for v in film_pixel(joint))
        assert coloured[0][y - 4 : y + 5, x - 4 : x + 5].mean() > 0.9
    assert 0.02 < coloured[0].mean() < 0.12


def test_frames_stand_in_rows_of_three():
    grey = tuple(np.full((480, 640), 40 * k, np.uint8) for k in range(5))
    picture = decoded(frames_plate(Footage(grey, ()), (1, 2, 3, 5)))
    assert picture.shape == (2 * (HEIGHT_PX + CAPTION_PX), COLUMNS // 2 * (TILE_PX + GAP_PX), 3)
    levels = [tile(picture, k // 3, k % 3).mean() for k in range(6)]
    assert levels == [0.0, 40.0, 80.0, 160.0, 255.0, 255.0]


def test_only_frames_that_are_there_are_shown():
    assert frames_shown((1, 40, 80), 60) == (1, 40)
    assert frames_shown((40, 80), 12) == (12,)


def test_a_plate_takes_grey_and_colour_and_writes_captions():
    red = np.zeros((30, 60, 3), np.uint8)
    red[..., 2] = 200
    picture = decoded(plate([("grey", np.full((30, 60), 90, np.uint8)), ("red", red)], 2, 120))
    assert picture[30, 60].tolist() == [90, 90, 90]
    assert picture[30, 60 + 120 + GAP_PX].tolist() == [0, 0, 200]
    assert (picture[60:].min(axis=2) < 128).sum() > 20
