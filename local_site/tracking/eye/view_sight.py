"""What the networks see of an arm in one camera's frames: crops about where it is expected, points, and the outline."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Frame
from common.geometry import Array
from local_site.calibration.rig import CameraCalibration
from local_site.calibration.triangulation import image_of, project
from local_site.tracking.eye.arm_points import ELBOW, KNUCKLES, MIDDLE_KNUCKLE, POINTS, WRIST
from local_site.tracking.eye.crops import ARM_M, CROP_PX, HAND_M, PictureCrop, crop_about, in_colour
from local_site.tracking.eye.fitted_points import PointSight
from local_site.tracking.eye.networks import CropAnswer, EyeNetworks

WIDENED = 1.5  # deviations, so that 95 % lie in the ellipses of 95 % (lab/eye/README.md)
BIAS = 0.004  # of the crop's width: what a network errs by in every picture alike
BORDER = 0.02  # of the crop: nearer to its edge, a point may lie beyond
OTHER, HAND = 0, 1  # of the parts
MASK_PX = 96
LEAST_SHOWN = 0.01  # of the hand's crop: a smaller hand is none


@dataclass(frozen=True, slots=True)
class ViewSight:
    """An arm in one picture: undistorted `pixels` (22, 2) with covariances (22, 2, 2) in px², infinite where nothing is
    told; how probably it is a `bare` hand, and one of the operator's `side`; the outline (N, 2) in px of the camera's
    own picture."""

    pixels: Array
    covariances: Array
    bare: float
    side: float
    contour: NDArray[np.int32] | None

    def of(self, projection: Array) -> PointSight:
        """Make it an observation through a projection (3, 4)."""
        told = np.isfinite(self.covariances[:, 0, 0])
        whitening = np.zeros((POINTS, 2, 2))
        whitening[told] = np.linalg.inv(np.linalg.cholesky(self.covariances[told]))
        return PointSight(projection, self.pixels, whitening)


class ViewEye:
    """Looks at an arm with one camera."""

    def __init__(self, camera: CameraCalibration, networks: EyeNetworks, *, right_arm: bool) -> None:
        self.camera = camera
        self._networks, self._mirrored = networks, not right_arm

    def in_picture(self, point: Array) -> Array:
        """Project a point (3,) in m to the camera's own picture, px (2,)."""
        pixel: Array = self.camera.distort_pixels(project(self.camera.matrix, point))
        return pixel

    def look(self, frame: Frame, points: Array, *, whole_arm: bool = True) -> ViewSight:
        """See the hand where its points (22, 3) in m are expected, and elbow and wrist if asked for the `whole_arm`.

        That takes a second, wider crop. A point outside of its crop, or at its edge, tells nothing.
        """
        picture = in_colour(frame.image)
        at = self.camera.distort_pixels(project(self.camera.matrix, points))
        px_per_m = float(np.linalg.norm(image_of(self.camera.matrix, points[WRIST])[1], 2))
        up = at[MIDDLE_KNUCKLE] - at[WRIST]
        narrow = crop_about(at[list(KNUCKLES)].mean(axis=0), up, HAND_M * px_per_m)
        hand = self._networks.look("hand", narrow.cut(picture), mirrored=self._mirrored)
        pixels, covariances = self._in_picture(narrow, hand)
        covariances[ELBOW] = np.inf  # it lies outside of the hand's crop, where the network was never asked for it
        bare = hand.bare if np.mean(hand.parts.argmax(axis=0) == HAND) >= LEAST_SHOWN else 0.0
        if not whole_arm:
            return ViewSight(pixels, covariances, bare, hand.right, _contour(narrow, hand))
        wide = crop_about(at[WRIST], up, ARM_M * px_per_m)
        arm = self._networks.look("arm", wide.cut(picture), mirrored=self._mirrored)
        of_arm, arm_covariances = self._in_picture(wide, arm)
        for point in (ELBOW, WRIST):
            pixels[point], covariances[point] = _joined(
                (pixels[point], covariances[point]), (of_arm[point], arm_covariances[point])
            )
        return ViewSight(pixels, covariances, bare, hand.right, _contour(wide, arm))

    def _in_picture(self, crop: PictureCrop, answer: CropAnswer) -> tuple[Array, Array]:
        pixels = self.camera.undistort_pixels(crop.in_picture(answer.points))
        back = CROP_PX * crop.back
        spread = WIDENED**2 * answer.covariances + BIAS**2 * np.eye(2)
        covariances = back @ spread @ back.T
        inside = np.all((answer.points > BORDER) & (answer.points < 1.0 - BORDER), axis=1)
        return pixels, np.where(np.reshape(inside, (-1, 1, 1)), covariances, np.inf)


def blended(before: ViewSight, after: ViewSight, weight: float) -> ViewSight:
    """Place the arm between two exposures, by the weight of the second; what the first does not tell is as in that."""
    told = np.isfinite(before.covariances[:, 0, 0])[:, None]
    pixels = np.where(told, (1.0 - weight) * before.pixels + weight * after.pixels, after.pixels)
    return ViewSight(pixels, after.covariances, after.bare, after.side, after.contour)


def _joined(one: tuple[Array, Array], other: tuple[Array, Array]) -> tuple[Array, Array]:
    """Join two observations (2,) of a point with covariances (2, 2); infinite ones tell nothing."""
    if not np.isfinite(other[1]).all():
        return one
    if not np.isfinite(one[1]).all():
        return other
    gain = one[1] @ np.linalg.inv(one[1] + other[1])
    return one[0] + gain @ (other[0] - one[0]), one[1] - gain @ one[1]


def _contour(crop: PictureCrop, answer: CropAnswer) -> NDArray[np.int32] | None:
    """The outline (N, 2) of the largest part that is arm, in px of the picture."""
    mask = (answer.parts.argmax(axis=0) != OTHER).astype(np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    largest = max(contours, key=len)[:, 0].astype(np.float64)
    return np.rint(crop.in_picture((largest + 0.5) / MASK_PX)).astype(np.int32)
