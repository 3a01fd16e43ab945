"""Networks that answer what a test wants, in the shapes of the real ones."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from local_site.tracking.landmarks.hand_landmarks import HandLandmarker
from local_site.tracking.landmarks.network import LandmarkNetwork, Tensor
from local_site.tracking.landmarks.palm_detector import PalmDetector, anchors
from local_site.tracking.landmarks.view_follower import ViewFollower

DETECTOR_SIDE, LANDMARKER_SIDE = 192, 224
NO_PALM = -9.0
Answer = Callable[[Tensor], Sequence[Tensor]]


class FakeNetwork(LandmarkNetwork):
    """A network whose outputs a function makes; it keeps the pictures that it was shown."""

    def __init__(self, side_px: int, answer: Answer) -> None:
        self.side_px = side_px
        self._answer = answer
        self.shown: list[NDArray[np.float32]] = []

    def run(self, picture: Tensor) -> Sequence[Tensor]:
        self.shown.append(picture)
        return self._answer(picture)


def palm_outputs(palms: Sequence[tuple[int, float, Sequence[float]]]) -> list[Tensor]:
    """The detector's outputs: each palm by its anchor's number, its logit, and centre and size of its box with the
    seven points, (9, 2) flat, in px from the anchor; the size is in px."""
    boxes = np.zeros((len(anchors()), 18), np.float32)
    logits = np.full((len(anchors()), 1), NO_PALM, np.float32)
    for anchor, logit, box in palms:
        boxes[anchor], logits[anchor] = box, logit
    return [boxes, logits]


def hand_outputs(points_px: NDArray[np.float64], score: float = 0.9, right: float = 0.9) -> list[Tensor]:
    """The landmarker's outputs for points (21, 2) in px of its crop."""
    flat = np.column_stack([points_px, np.zeros(21)]).astype(np.float32).ravel()
    return [flat, np.array([score], np.float32), np.array([right], np.float32)]


def middle_palm(_: Tensor) -> list[Tensor]:
    """A palm in the middle, a fifth as wide as the picture, whose fingers point up."""
    middle = int(np.argmin(np.sum((anchors() - 0.5) ** 2, axis=1)))
    off = DETECTOR_SIDE * (0.5 - anchors()[middle])
    down = np.array([0.0, 20.0])
    points = [off, (40.0, 40.0), off + down, off, off - down, off, off, off, off]
    return palm_outputs([(middle, 4.0, np.ravel(points).tolist())])


def upright_hand(_: Tensor) -> list[Tensor]:
    """A hand that fills the middle of its crop."""
    across, down = np.meshgrid(np.linspace(80.0, 140.0, 3), np.linspace(180.0, 50.0, 7), indexing="ij")
    return hand_outputs(np.column_stack([across.ravel(), down.ravel()]))


def fake_follower(
    palms: Answer = middle_palm, hands: Answer = upright_hand, quick: Answer | None = None
) -> ViewFollower:
    """A follower of one view whose networks are fakes."""
    detector = PalmDetector(FakeNetwork(DETECTOR_SIDE, palms))
    careful, quickly = (HandLandmarker(FakeNetwork(LANDMARKER_SIDE, answer)) for answer in (hands, quick or hands))
    return ViewFollower(detector, careful, quickly)
