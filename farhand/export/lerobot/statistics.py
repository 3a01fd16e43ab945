"""Statistics of columns and pictures as LeRobot keeps them: min, max, mean, std, count, quantiles; pure."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from farhand.export.videos.h264 import Rgb

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
LEVELS = 256
SAMPLES_PER_EPISODE = 100
SMALL_PX = 150  # pictures are thinned to about this width for their statistics
Histogram = NDArray[np.int64]  # (3, 256) pixels of each level, by channel
Statistics = dict[str, Any]


def of_column(values: NDArray[Any]) -> Statistics:
    """Of a column (n,) or (n, k), by axis."""
    table = values.reshape(len(values), -1)
    exact = table.astype(np.float64)
    found = {
        "min": table.min(axis=0).tolist(),
        "max": table.max(axis=0).tolist(),
        "mean": exact.mean(axis=0).tolist(),
        "std": exact.std(axis=0).tolist(),
        "count": [len(table)],
    }
    cuts = np.quantile(exact, list(QUANTILES.values()), axis=0)
    return found | {name: cut.tolist() for name, cut in zip(QUANTILES, cuts, strict=True)}


def of_pictures(histogram: Histogram, count: int) -> Statistics:
    """Of `count` pictures whose pixels have these levels: 0 to 1, shape [3][1][1]."""
    levels = np.arange(LEVELS) / (LEVELS - 1)
    total = histogram.sum(axis=1, keepdims=True)
    mean = (histogram * levels).sum(axis=1, keepdims=True) / total
    variance = (histogram * (levels - mean) ** 2).sum(axis=1, keepdims=True) / total
    reached = np.cumsum(histogram, axis=1) / total
    figures = {
        "min": levels[(histogram > 0).argmax(axis=1)],
        "max": levels[LEVELS - 1 - (histogram[:, ::-1] > 0).argmax(axis=1)],
        "mean": mean[:, 0],
        "std": np.sqrt(variance[:, 0]),
    }
    figures |= {name: levels[(reached >= part).argmax(axis=1)] for name, part in QUANTILES.items()}
    return {name: by_channel.reshape(3, 1, 1).tolist() for name, by_channel in figures.items()} | {"count": [count]}


def levels_of(picture: Rgb) -> Histogram:
    """Count the pixels of a thinned picture that have each level, by channel."""
    step = max(min(picture.shape[:2]) // SMALL_PX, 1)
    thinned = picture[::step, ::step]
    return np.stack([np.bincount(thinned[..., c].ravel(), minlength=LEVELS) for c in range(3)])


def summed(histograms: Iterable[Histogram]) -> Histogram:
    """The levels of all pictures together."""
    total: Histogram = np.sum(list(histograms), axis=0)
    return total


def is_sampled(frame: int, expected: int) -> bool:
    """Return whether a frame, of about so many, counts in the statistics of the pictures."""
    return frame % max(expected // SAMPLES_PER_EPISODE, 1) == 0
