"""Films composed of recordings: the recorded arm, tinted like skin, before a room, with the recording's truth."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.errors import CalibrationError
from common.geometry import Array
from lab.films.arm.person import ColouredSurface, body_of, ellipsoid
from lab.films.arm.skin import TONES
from lab.films.film import FilmInstant, HandTruth, TrackingFilm
from lab.films.picture.light import linear, srgb
from lab.films.picture.rendering import FilmLayer, Picture, lay
from lab.films.scenes import RECORDINGS, Instant, recorded
from lab.films.surroundings import FilmSetting, Surroundings
from local_site.calibration.physical_camera import PhysicalCamera, decomposed
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.calibration.triangulation import project, triangulate_many
from local_site.simulation.room.config import SkinName

RecordingName = Literal["yz", "toggle", "icr_elbow", "pick"]

FPS: dict[RecordingName, float] = {"yz": 15.0, "toggle": 15.0, "icr_elbow": 15.0, "pick": 30.0}
EVENLY_LIT = 175.0  # the grey level of evenly lit skin in the recordings
SHADOW_REDNESS = np.array([1.12, 1.04, 0.94])  # BGR exponents: light that skin scatters into its shadows is red
END_PX = 8  # at the right of the arm, where it ends in every recording
END_FOLLOWED = 0.2  # how much of the newest end the sleeve takes on, so that it does not tremble
UPPER_ARM_M = 0.26
SLEEVE_M, SLEEVE_BEYOND_M = 0.066, 0.03
CLOTH = (84, 96, 120)
SIZE = (640, 480)
ARM_ABOVE = 26  # grey levels; the wall stays below
SURE_PX, EDGE_PX = 3, 3  # how far inside and outside of the arm's edge the matte is mixed
INNER_SIGMA_PX = 3.0
LEAST_CONTRAST = 20.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ComposedFilm:
    """The parts of a film: a recording, skin, surroundings; `empty_s` is how long the arm is missing first."""

    name: str
    recording: RecordingName
    tone: SkinName = "light"
    setting: FilmSetting = FilmSetting(noise=1.5)  # noqa: RUF009
    empty_s: float = 0.0
    seed: int = 1


@dataclass(frozen=True, slots=True)
class Cutout:
    """An arm, cut out of its dark wall by brightness: its part of the picture from `left`, `top`.

    Its own grey levels (h, w), and the soft matte (h, w), how much of each pixel it is, from 0 to 255.
    """

    left: int
    top: int
    grey: Image
    matte: Image


def composed_film(config: ComposedFilm) -> TrackingFilm:
    """The film of a configuration; CalibrationError where the recording's rig has no pinhole cameras."""
    scene = recorded(RECORDINGS / config.recording)
    fps = FPS[config.recording]
    cameras = [_physical(calibration) for calibration in scene.rig.cameras]

    def instants() -> Iterator[FilmInstant]:
        composer = _Composer(config, scene.rig, cameras)
        empty = round(config.empty_s * fps)
        for k in range(empty):
            yield composer.instant(None, k)
        for k, instant in enumerate(scene.instants(), start=empty):
            yield composer.instant(instant, k)

    return TrackingFilm(config.name, scene.rig, fps, instants)


def _physical(calibration: CameraCalibration) -> PhysicalCamera:
    camera = decomposed(calibration.matrix)
    if camera is None:
        raise CalibrationError(f"the projection of {calibration.name} mirrors; calibrate the recording again")
    return camera


class _Composer:
    """Lays the recorded arm over its new surroundings, instant by instant."""

    def __init__(self, config: ComposedFilm, rig: Rig, cameras: Sequence[PhysicalCamera]) -> None:
        self._config, self._rig = config, rig
        self._around = Surroundings(config.setting, cameras, SIZE, config.tone, config.seed)
        self._skin = _tinted(config.tone)
        self._upper_arm: Array | None = None  # from the elbow to where the recorded arm ends, m

    def instant(self, recorded_instant: Instant | None, number: int) -> FilmInstant:
        """The instant of a number: with the arm of a recorded instant, or without."""
        fps = FPS[self._config.recording]
        pictures = self._around.pictures(number / fps)
        arm = None if recorded_instant is None else recorded_instant.truth
        if recorded_instant is None or arm is None:
            return FilmInstant(self._around.views(pictures, number, fps), None)
        cutouts = [cut_out(view.current.image) for view in recorded_instant.views.views]
        clothes = self._clothes(cutouts, arm.elbow)
        if clothes is not None:
            lay(self._around.layers(clothes[:1]), pictures)
        lay([None if cutout is None else self._layer(cutout) for cutout in cutouts], pictures)
        if clothes is not None:
            lay(self._around.layers(clothes[1:]), pictures)
        truth = HandTruth(arm, None, right=True, posture="open" if arm.hand_open else "u_shape")
        return FilmInstant(self._around.views(pictures, number, fps), truth)

    def _layer(self, cutout: Cutout) -> FilmLayer:
        alpha = cutout.matte.astype(np.float32) / 255.0
        return FilmLayer(cutout.left, cutout.top, self._skin[cutout.grey] * alpha[..., None], alpha)

    def _clothes(
        self, cutouts: Sequence[Cutout | None], elbow: Array
    ) -> tuple[ColouredSurface, ColouredSurface] | None:
        """The operator's body, and a sleeve over the recorded arm's end; None until both views have shown the end."""
        ends = [
            _end_px(cutout, calibration.distort_pixels(project(calibration.matrix, elbow)))
            for cutout, calibration in zip(cutouts, self._rig.cameras, strict=True)
            if cutout is not None
        ]
        if len(ends) == len(cutouts):
            seen = [c.undistort_pixels(end) for c, end in zip(self._rig.cameras, ends, strict=True)]
            upper_arm = triangulate_many(self._rig.matrices, np.array(seen)[None])[0] - elbow
            self._upper_arm = upper_arm if self._upper_arm is None else _nearer(self._upper_arm, upper_arm)
        if self._upper_arm is None:
            return None
        length = float(np.linalg.norm(self._upper_arm))
        shoulder = elbow + UPPER_ARM_M / length * self._upper_arm
        end = elbow + (length + SLEEVE_BEYOND_M) / length * self._upper_arm
        cloth = linear(np.array(CLOTH))
        return body_of(shoulder, cloth, self._config.tone), ellipsoid(end, np.full(3, SLEEVE_M), cloth)


def _nearer(old: Array, new: Array) -> Array:
    return np.asarray(old + END_FOLLOWED * (new - old), dtype=np.float64)


def _end_px(cutout: Cutout, elbow_px: Array) -> Array:
    """The middle (2,) in px of the arm's right end, as seen from the elbow at (2,) in px."""
    rows, columns = np.nonzero(cutout.matte > 128)
    pixels = np.column_stack([columns + cutout.left, rows + cutout.top]) - elbow_px
    right = pixels[pixels[:, 0] > 0.7 * pixels[:, 0].max()].mean(axis=0)
    along = pixels @ right / np.linalg.norm(right)
    return np.asarray(pixels[along > along.max() - END_PX].mean(axis=0) + elbow_px, dtype=np.float64)


def _tinted(tone: SkinName) -> Picture:
    """The skin's colour (256, 3), BGR from 0 to 255, of each recorded grey level."""
    light = (linear(np.arange(256.0)) / linear(np.array(EVENLY_LIT)))[:, None]
    colour = srgb(linear(np.array(TONES[tone]))[::-1] * np.clip(light, 0.0, None) ** SHADOW_REDNESS)
    return colour.astype(np.float32)


def cut_out(image: Image) -> Cutout | None:
    """The brightest thing before the dark wall of a picture (H, W, 3) or (H, W); None where all is dark."""
    grey = image if image.ndim == 2 else np.asarray(image[..., 1], dtype=np.uint8)
    bright = (cv2.GaussianBlur(grey, (0, 0), 1.0) > ARM_ABOVE).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(bright)
    if count < 2:
        return None
    arm = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    x, y, width, height = (int(v) for v in stats[arm, :4])
    margin = 2 * EDGE_PX
    left, top = max(x - margin, 0), max(y - margin, 0)
    part = np.s_[top : y + height + margin, left : x + width + margin]
    wall = float(np.median(grey[bright == 0]))
    return Cutout(left, top, *_matted(grey[part], (labels[part] == arm).astype(np.uint8), wall))


def _matted(grey: Image, mask: NDArray[np.uint8], wall: float) -> tuple[Image, Image]:
    """The arm's levels carried on over its edge, and the matte by which the picture mixes them with the wall."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
    sure = cv2.erode(mask, disc, iterations=SURE_PX).astype(np.float32)
    levels = grey.astype(np.float32)
    weight = cv2.GaussianBlur(sure, (0, 0), INNER_SIGMA_PX)
    carried = cv2.GaussianBlur(levels * sure, (0, 0), INNER_SIGMA_PX) / np.maximum(weight, 1e-3)
    known = weight > 1e-3
    matte = np.clip((levels - wall) / np.maximum(carried - wall, LEAST_CONTRAST), 0.0, 1.0)
    near = cv2.dilate(mask, disc, iterations=EDGE_PX) > 0
    matte = np.where(sure > 0, 1.0, np.where(near & known, matte, mask * near))
    arm = np.where(sure > 0, levels, np.where(known, carried, levels))
    return arm.astype(np.uint8), np.rint(255.0 * matte).astype(np.uint8)
