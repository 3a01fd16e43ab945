"""This arm's colour in one camera's pictures, learned against the colours of everything else.

A colour is counted by its chromaticity, which shading changes little, and coarsely by its brightness.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from local_site.kernels.compiled import compiled

CHROMAS, BRIGHTNESSES = 48, 16
CHROMA_STEP = 0.0125  # about twice the noise of a camera at medium brightness
LEAST_RED, LEAST_GREEN = 0.13, 0.06
BRIGHTNESS_STEP = 48.0  # of the sum of the three channels
DARK = 24.0  # added to the sum as grey, since dark pixels have no colour but noise
CHROMA_SMOOTHING, BRIGHTNESS_SMOOTHING = 0.8, 1.5  # bins
GREY_STRIDE, GREY_SHARE, GREY_SPREAD = (
    7,
    99,
    4,
)  # px, per cent of the pixels, levels between the channels: compression's

Table = NDArray[np.float32]
Colours = NDArray[np.uint8]


@compiled
def chromaticity(blue: float, green: float, red: float) -> tuple[float, float]:
    """The red and the green share of a colour, from 0 to 1."""
    total = blue + green + red + DARK
    return (red + DARK / 3.0) / total, (green + DARK / 3.0) / total


@compiled
def bin_of(red: float, green: float, brightness: float) -> int:
    """The bin of a chromaticity and a sum of the channels."""
    i = min(max(int((red - LEAST_RED) / CHROMA_STEP), 0), CHROMAS - 1)
    j = min(max(int((green - LEAST_GREEN) / CHROMA_STEP), 0), CHROMAS - 1)
    k = min(max(int(brightness / BRIGHTNESS_STEP), 0), BRIGHTNESSES - 1)
    return (k * CHROMAS + i) * CHROMAS + j


class ArmColour:
    """How likely each colour is on the arm and elsewhere in one camera's pictures; old ones are forgotten slowly."""

    def __init__(self) -> None:
        self._counts = np.zeros((2, BRIGHTNESSES * CHROMAS * CHROMAS), np.float32)
        self.arm: Table = np.zeros(self._counts.shape[1], np.float32)
        self.rest: Table = np.zeros(self._counts.shape[1], np.float32)

    @property
    def is_known(self) -> bool:
        """Whether any pixel of the arm has been seen."""
        return bool(self.arm.any())

    def learn(self, arm: Colours, rest: Colours, kept: float) -> None:
        """Count colours (N, 3) surely on the arm and (M, 3) surely elsewhere; `kept` is what remains of before."""
        self._counts *= kept
        for counts, colours in zip(self._counts, (arm, rest), strict=True):
            _count(counts, np.ascontiguousarray(colours))
        self.arm, self.rest = (_smoothed(counts) for counts in self._counts)


def is_grey(picture: Colours) -> bool:
    """Whether a picture (H, W, 3) has no colours, as of a grey camera or in infrared light."""
    sample = picture[::GREY_STRIDE, ::GREY_STRIDE].astype(np.int16)
    return float(np.percentile(np.ptp(sample, axis=2), GREY_SHARE)) <= GREY_SPREAD


@compiled
def _count(counts: Table, colours: Colours) -> None:
    for n in range(len(colours)):
        blue, green, red = float(colours[n, 0]), float(colours[n, 1]), float(colours[n, 2])
        r, g = chromaticity(blue, green, red)
        counts[bin_of(r, g, blue + green + red)] += 1.0


def _smoothed(counts: Table) -> Table:
    """The share of each bin, spread over its neighbours."""
    layers = counts.reshape(BRIGHTNESSES, CHROMAS * CHROMAS)
    along = cv2.GaussianBlur(layers, (1, 0), sigmaX=1.0, sigmaY=BRIGHTNESS_SMOOTHING)
    spread = [cv2.GaussianBlur(layer.reshape(CHROMAS, CHROMAS), (0, 0), CHROMA_SMOOTHING) for layer in along]
    total = float(counts.sum())
    return np.ascontiguousarray(np.array(spread, np.float32).reshape(-1) / max(total, 1.0))
