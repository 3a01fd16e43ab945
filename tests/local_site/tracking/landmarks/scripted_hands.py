"""Views that see what a test puts before them, and write down what they are told."""

from collections.abc import Sequence

import numpy as np

from common.cameras.camera import Frame
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.tracking.landmarks.hand_landmarks import HandLandmarks
from local_site.tracking.landmarks.view_hands import ViewHands
from local_site.tracking.tracker import View, Views
from tests.local_site.tracking.landmarks.fake_networks import fake_follower

PERIOD_NS = 33_333_333
BLANK = np.zeros((48, 64, 3), np.uint8)


class ScriptedHands(ViewHands):
    """One view: `shown` are its hands, `clearer` what another crop would show instead, `kept` the hand it follows,
    `looks` how often it was asked."""

    def __init__(self, camera: CameraCalibration, right_arm: bool = True) -> None:
        super().__init__(camera, fake_follower(), right_arm)
        self.shown: Sequence[HandLandmarks] = ()
        self.clearer: HandLandmarks | None = None
        self.kept: HandLandmarks | None = None
        self.retries: list[int] = []
        self.looks = 0

    def hands(self, view: View, *, quickly: bool = False) -> list[HandLandmarks]:
        """What the test shows."""
        del view, quickly
        self.looks += 1
        return list(self.shown)

    def again(self, view: View, seen: HandLandmarks, attempt: int) -> HandLandmarks:
        """What the test says another crop shows."""
        del view
        self.retries.append(attempt)
        return self.clearer or seen

    def keep(self, hand: HandLandmarks) -> None:
        """Follow this hand from now on."""
        self.kept = hand

    def lose(self) -> None:
        """Search from now on."""
        self.kept = None

    @property
    def is_following(self) -> bool:
        """Whether it was told which hand to follow."""
        return self.kept is not None


def scripted_views(rig: Rig, right_arm: bool = True) -> list[ScriptedHands]:
    """A scripted view for each camera."""
    return [ScriptedHands(camera, right_arm) for camera in rig.cameras]


def show(views: Sequence[ScriptedHands], *hands: Sequence[HandLandmarks]) -> None:
    """Show hands, each given by what all views see of it."""
    for k, view in enumerate(views):
        view.shown = [hand[k] for hand in hands]


def instant(k: int, cameras: int = 2, weight: float = 1.0) -> Views:
    """The k-th instant of black pictures; below weight 1 between two exposures of all but the first camera."""
    now, before = Frame(BLANK, k * PERIOD_NS, k), Frame(BLANK, (k - 1) * PERIOD_NS, k - 1)
    late = View(now) if weight >= 1.0 else View(now, before, weight)
    return Views(k * PERIOD_NS, (View(now), *[late] * (cameras - 1)))
