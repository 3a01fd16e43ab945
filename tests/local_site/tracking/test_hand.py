"""The hand's tips along its contour: as many as there are fingers, at their ends."""

import cv2
import numpy as np
import pytest

from local_site.tracking.silhouette.hand import measure_hand

WRIST = np.array([200.0, 380.0])


def drawn_hand(angles_deg, length=150.0, thickness=22):
    """The contour from one side of the wrist to the other of a palm with fingers at these angles, and their ends."""
    image = np.zeros((420, 420), dtype=np.uint8)
    palm = WRIST - np.array([0.0, 70.0])
    cv2.ellipse(image, (200, 310), (48, 60), 0, 0, 360, 255, cv2.FILLED)
    cv2.rectangle(image, (170, 300), (230, 400), 255, cv2.FILLED)
    ends = []
    for angle in np.radians(angles_deg):
        end = palm + length * np.array([np.sin(angle), -np.cos(angle)])
        ends.append(end)
        cv2.line(image, (200, 310), tuple(int(v) for v in end), 255, thickness, cv2.LINE_AA)
    image[380:] = 0
    contour = max(cv2.findContours(image, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0], key=cv2.contourArea)
    points = contour.reshape(-1, 2).astype(float)
    base = np.flatnonzero(points[:, 1] >= 379)
    order = np.roll(points, -int(base[np.argmax(points[base, 0])]), axis=0)
    return order[order[:, 1] < 379], ends


@pytest.mark.parametrize("angles", [(-40, 35), (-55, -20, 15, 60), (-60, -32, -6, 20, 62)])
def test_every_finger_has_its_tip(angles):
    contour, ends = drawn_hand(angles)
    hand = measure_hand(contour, WRIST, 30.0)
    assert sum(tip.prominence > 0.1 for tip in hand.tips) == len(angles)
    for end in ends:
        assert min(np.hypot(*(tip.point - end)) for tip in hand.tips) < 15
        assert min(np.hypot(*(corner - end)) for corner in hand.corners) < 18


@pytest.mark.parametrize(
    ("angles", "spread"), [((-40, 35), False), ((-50, 0, 45), False), ((-60, -32, -6, 20, 62), True)]
)
def test_only_a_hand_with_many_fingers_apart_is_open(angles, spread):
    contour, _ = drawn_hand(angles)
    assert measure_hand(contour, WRIST, 30.0).spread is spread


def test_a_finger_tip_is_sharper_than_a_fist():
    contour, _ = drawn_hand((-40, 35))
    angles = [tip.angle for tip in measure_hand(contour, WRIST, 30.0).tips if tip.prominence > 0.1]
    assert max(angles) < np.radians(100)
    knuckles, _ = drawn_hand(())
    assert all(tip.angle > np.radians(100) for tip in measure_hand(knuckles, WRIST, 30.0).tips)


def test_a_fist_has_no_finger_to_count():
    contour, _ = drawn_hand(())
    assert measure_hand(contour, WRIST, 30.0).open_tips <= 1
