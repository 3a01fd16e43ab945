"""Films composed of recordings: the recorded arm, tinted like skin, before a room, with the recording's truth."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from bench.tracking.films.cutout import Cutout, cut_out
from bench.tracking.films.film import FilmInstant, HandTruth, TrackingFilm
from bench.tracking.films.person import ellipsoid
from bench.tracking.films.rendering import Layer, Picture, lay
from bench.tracking.films.skin import TONES, Tone, linear, srgb
from bench.tracking.films.surroundings import FilmSetting, Surroundings
from bench.tracking.scenes import RECORDINGS, Instant, recorded
from common.errors import CalibrationError
from common.geometry import Array
from local_site.calibration.physical_camera import PhysicalCamera, decomposed
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.calibration.triangulation import triangulate_many

RecordingName = Literal["yz", "toggle", "icr_elbow", "pick"]

FPS: dict[RecordingName, float] = {"yz": 15.0, "toggle": 15.0, "icr_elbow": 15.0, "pick": 30.0}
EVENLY_LIT = 175.0  # the grey level of evenly lit skin in the recordings
SHADOW_REDNESS = np.array([1.12, 1.04, 0.94])  # BGR exponents: light that skin scatters into its shadows is red
END_PX = 6  # columns at the right of the arm, where it ends in every recording
END_FOLLOWED = 0.2  # how much of the newest end the sleeve takes on, so that it does not tremble
SLEEVE_M, SLEEVE_BEYOND_M = 0.075, 0.045
CLOTH = (84, 96, 120)
SIZE = (640, 480)


@dataclass(frozen=True, slots=True, kw_only=True)
class ComposedFilm:
    """What is composed: a recording, skin, surroundings; `empty_s` is how long the arm is missing first."""

    name: str
    recording: RecordingName
    tone: Tone = "light"
    setting: FilmSetting = FilmSetting(noise=1.5)  # noqa: RUF009
    empty_s: float = 0.0
    seed: int = 1


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
        self._end: Array | None = None

    def instant(self, recorded_instant: Instant | None, number: int) -> FilmInstant:
        """The instant of a number: with the arm of a recorded instant, or without."""
        fps = FPS[self._config.recording]
        pictures = self._around.pictures(number / fps)
        if recorded_instant is None:
            return FilmInstant(self._around.views(pictures, number, fps), None)
        cutouts = [cut_out(view.current.image) for view in recorded_instant.views.views]
        lay([None if cutout is None else self._layer(cutout) for cutout in cutouts], pictures)
        self._lay_sleeve(cutouts, pictures)
        arm = recorded_instant.truth
        truth = HandTruth(arm, None, right=True, posture="open" if arm.hand_open else "u_shape")
        return FilmInstant(self._around.views(pictures, number, fps), truth)

    def _layer(self, cutout: Cutout) -> Layer:
        alpha = cutout.matte.astype(np.float32) / 255.0
        return Layer(cutout.left, cutout.top, self._skin[cutout.grey] * alpha[..., None], alpha)

    def _lay_sleeve(self, cutouts: Sequence[Cutout | None], pictures: Sequence[Picture]) -> None:
        """A sleeve of cloth where the recorded arm ends."""
        ends = [_end_px(cutout) for cutout in cutouts if cutout is not None]
        if len(ends) == len(cutouts):
            seen = [c.undistort_pixels(end) for c, end in zip(self._rig.cameras, ends, strict=True)]
            end = triangulate_many(self._rig.matrices, np.array(seen)[None])[0]
            self._end = end if self._end is None else self._end + END_FOLLOWED * (end - self._end)
        if self._end is not None:
            middle = self._end + np.array([SLEEVE_BEYOND_M, 0.0, 0.0])
            lay(self._around.layers([ellipsoid(middle, np.full(3, SLEEVE_M), linear(np.array(CLOTH)))]), pictures)


def _end_px(cutout: Cutout) -> Array:
    """The middle (2,) of the arm's right end in px."""
    rows, columns = np.nonzero(cutout.matte > 128)
    last = columns > columns.max() - END_PX
    return np.array([columns[last].mean() + cutout.left, rows[last].mean() + cutout.top])


def _tinted(tone: Tone) -> Picture:
    """The skin's colour (256, 3), BGR from 0 to 255, of each recorded grey level."""
    light = (linear(np.arange(256.0)) / linear(np.array(EVENLY_LIT)))[:, None]
    colour = srgb(linear(np.array(TONES[tone]))[::-1] * np.clip(light, 0.0, None) ** SHADOW_REDNESS)
    return colour.astype(np.float32)
