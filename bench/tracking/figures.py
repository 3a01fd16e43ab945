"""How well a tracker did against the truth: time, gaps, errors, and whether its sigmas are honest; pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import rankdata

from common.geometry import Array
from local_site.simulation.body import ArmTruth

SETTLED = 10
POINTS = ("elbow", "wrist", "index", "thumb seen", "thumb inferred")


@dataclass(frozen=True, slots=True)
class Found:
    """What was made of one pair: the points (3,) in m that were found, their covariances (3, 3) in m², and the cost.

    `toggles` is the count so far, None where openings are not counted; `wall_ms` and `processor_ms` are the time that
    passed and the time computed.
    """

    points: Mapping[str, Array]
    wall_ms: float
    processor_ms: float
    covariances: Mapping[str, Array]
    thumb_inferred: bool = False
    toggles: int | None = None


@dataclass(frozen=True, slots=True)
class PointFigures:
    """One point over a recording: errors in mm, bias (3,) in mm; the last two are NaN without covariances.

    `normalised` is the mean of e^T C^-1 e, 3 where the covariances are honest; `rank` how well sigma ranks the errors.
    """

    frames: int
    mean: float
    p95: float
    largest: float
    bias: Array
    normalised: float
    rank: float


@dataclass(frozen=True, slots=True)
class TrackingFigures:
    """One tracker on one recording, after the first frames; `points` has those that were found at least once."""

    frames: int
    median_ms: float
    p95_ms: float
    processor_ms: float
    without_result: int
    toggles: int | None
    true_toggles: int
    points: Mapping[str, PointFigures]


def judge(found: Sequence[Found], truth: Sequence[ArmTruth], needed: Sequence[str]) -> TrackingFigures:
    """The figures of a recording; a frame without any of the points `needed` is one without result."""
    after = found[SETTLED:]
    wall = [f.wall_ms for f in after]
    return TrackingFigures(
        frames=len(after),
        median_ms=float(np.median(wall)),
        p95_ms=float(np.percentile(wall, 95)),
        processor_ms=float(np.median([f.processor_ms for f in after])),
        without_result=sum(any(name not in f.points for name in needed) for f in after),
        toggles=found[-1].toggles,
        true_toggles=openings(truth),
        points={p: figures for p in POINTS if (figures := _judge_point(p, after, truth[SETTLED:])) is not None},
    )


def openings(truth: Sequence[ArmTruth]) -> int:
    """How often the hand opens."""
    is_open = [t.hand_open for t in truth]
    return sum(now and not before for before, now in zip([False, *is_open], is_open, strict=False))


def _judge_point(point: str, found: Sequence[Found], truth: Sequence[ArmTruth]) -> PointFigures | None:
    name, _, kind = point.partition(" ")
    chosen = [
        (f, t)
        for f, t in zip(found, truth, strict=True)
        if name in f.points and (not kind or f.thumb_inferred == (kind == "inferred"))
    ]
    if not chosen:
        return None
    errors = np.array([f.points[name] - getattr(t, name) for f, t in chosen])
    sizes_mm = 1e3 * np.linalg.norm(errors, axis=1)
    known = [k for k, (f, _) in enumerate(chosen) if name in f.covariances]
    covariances = np.array([chosen[k][0].covariances[name] for k in known]).reshape(-1, 3, 3)
    return PointFigures(
        frames=len(chosen),
        mean=float(np.mean(sizes_mm)),
        p95=float(np.percentile(sizes_mm, 95)),
        largest=float(np.max(sizes_mm)),
        bias=1e3 * np.mean(errors, axis=0),
        normalised=normalised_square(errors[known], covariances),
        rank=rank_correlation(np.trace(covariances, axis1=1, axis2=2), sizes_mm[known]),
    )


def normalised_square(errors: Array, covariances: Array) -> float:
    """The mean of e^T C^-1 e over errors (N, 3) with covariances (N, 3, 3); NaN without any."""
    if not len(errors):
        return float("nan")
    weighted = np.linalg.solve(covariances, errors[..., None])[..., 0]
    return float(np.mean(np.sum(errors * weighted, axis=1)))


def rank_correlation(first: Array, second: Array) -> float:
    """Spearman's rank correlation of (N,) with (N,); NaN where either is constant or there are fewer than three."""
    if len(first) < 3 or np.ptp(first) == 0 or np.ptp(second) == 0:
        return float("nan")
    return float(np.corrcoef(rankdata(first), rankdata(second))[0, 1])


def flat(figures: TrackingFigures) -> dict[str, float]:
    """All figures by name, without those that could not be had."""
    result = {
        "median ms per pair": figures.median_ms,
        "p95 ms per pair": figures.p95_ms,
        "median processor ms per pair": figures.processor_ms,
        "frames": float(figures.frames),
        "frames without result": float(figures.without_result),
    }
    if figures.toggles is not None:
        result |= {"toggles": float(figures.toggles), "true toggles": float(figures.true_toggles)}
    for name, point in figures.points.items():
        result |= {f"{name}, {figure}": value for figure, value in _flat_point(point).items() if np.isfinite(value)}
    return result


def _flat_point(point: PointFigures) -> dict[str, float]:
    x, y, z = (float(value) for value in point.bias)
    return {
        "frames": float(point.frames),
        "mean mm": point.mean,
        "p95 mm": point.p95,
        "max mm": point.largest,
        "bias x mm": x,
        "bias y mm": y,
        "bias z mm": z,
        "normalised error squared (3)": point.normalised,
        "rank correlation of sigma and error": point.rank,
    }
