"""Figures of a tracker against the truth: time, gaps, errors, and whether its covariances are consistent; pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import rankdata

from common.geometry import Array, hand_rotation
from local_site.simulation.body import ArmTruth

SETTLED = 10
POINTS = ("elbow", "wrist", "index", "thumb seen", "thumb inferred")
NEES, RANK = "normalised error squared (3)", "rank correlation of sigma and error"


@dataclass(frozen=True, slots=True)
class Found:
    """The estimate of one pair: the points (3,) in m that were found, their covariances (3, 3) in m², and the cost.

    `is_tracked` is whether it may turn the tool; `toggles` is the count so far, None where openings are not counted;
    `wall_ms` and `processor_ms` are the time that passed and the time computed.
    """

    points: Mapping[str, Array]
    wall_ms: float
    processor_ms: float
    covariances: Mapping[str, Array]
    thumb_inferred: bool = False
    is_tracked: bool = True
    toggles: int | None = None


@dataclass(frozen=True, slots=True)
class TrackingFigures:
    """One tracker on one recording, after the first frames: figures of the whole, and of each point, by name.

    `points` has the points that were found at least once: errors in mm, relative ones after a constant offset; NEES,
    which is 3 where the covariances are consistent with the errors; RANK, how well sigma ranks the errors. The last two
    are NaN without covariances.
    """

    whole: Mapping[str, float]
    points: Mapping[str, Mapping[str, float]]


def judge(found: Sequence[Found], truth: Sequence[ArmTruth], needed: Sequence[str]) -> TrackingFigures:
    """The figures of a recording; a frame without any of the points `needed` is one without result."""
    after = found[SETTLED:]
    wall = [f.wall_ms for f in after]
    whole = {
        "median ms per pair": float(np.median(wall)),
        "p95 ms per pair": float(np.percentile(wall, 95)),
        "median processor ms per pair": float(np.median([f.processor_ms for f in after])),
        "frames": float(len(after)),
        "frames without result": float(sum(any(name not in f.points for name in needed) for f in after)),
    }
    whole |= _rotation_figures(after, truth[SETTLED:])
    if found[-1].toggles is not None:
        whole |= {"toggles": float(found[-1].toggles), "true toggles": float(openings(truth))}
    points = {point: _judge_point(point, after, truth[SETTLED:]) for point in POINTS}
    return TrackingFigures(whole, {point: figures for point, figures in points.items() if figures})


def flat(figures: TrackingFigures) -> dict[str, float]:
    """All figures by name, without those that are not a number."""
    of_points = {f"{point}, {name}": value for point, of in figures.points.items() for name, value in of.items()}
    return {name: value for name, value in {**figures.whole, **of_points}.items() if np.isfinite(value)}


def openings(truth: Sequence[ArmTruth]) -> int:
    """Count how often the hand opens."""
    is_open = [t.hand_open for t in truth]
    return sum(now and not before for before, now in zip([False, *is_open], is_open, strict=False))


def _rotation_figures(found: Sequence[Found], truth: Sequence[ArmTruth]) -> dict[str, float]:
    """Compute the hand frame's turn from the true one, deg, after a constant offset, while it turns the tool."""
    offsets = []
    for each, true in zip(found, truth, strict=True):
        if true.hand_open or not each.is_tracked or not {"wrist", "index", "thumb"} <= each.points.keys():
            continue
        seen = hand_rotation(*(each.points[name] for name in ("wrist", "index", "thumb")))
        right = hand_rotation(true.wrist, true.index, true.thumb)
        if seen is not None and right is not None:
            offsets.append(right.T @ seen)
    if not offsets:
        return {}
    rotations = Rotation.from_matrix(np.array(offsets))
    deg = np.degrees((rotations.mean().inv() * rotations).magnitude())
    return {"rotation mean deg": float(np.mean(deg)), "rotation p95 deg": float(np.percentile(deg, 95))}


def _judge_point(point: str, found: Sequence[Found], truth: Sequence[ArmTruth]) -> dict[str, float]:
    name, _, kind = point.partition(" ")
    chosen = [
        (f, t)
        for f, t in zip(found, truth, strict=True)
        if name in f.points and (not kind or f.thumb_inferred == (kind == "inferred"))
    ]
    if not chosen:
        return {}
    errors = np.array([f.points[name] - getattr(t, name) for f, t in chosen])
    sizes_mm = 1e3 * np.linalg.norm(errors, axis=1)
    known = [k for k, (f, _) in enumerate(chosen) if name in f.covariances]
    covariances = np.array([chosen[k][0].covariances[name] for k in known]).reshape(-1, 3, 3)
    bias_mm = 1e3 * np.mean(errors, axis=0)
    return {
        "frames": float(len(chosen)),
        "mean mm": float(np.mean(sizes_mm)),
        "relative mm": float(np.mean(np.linalg.norm(1e3 * (errors - np.mean(errors, axis=0)), axis=1))),
        "p95 mm": float(np.percentile(sizes_mm, 95)),
        "max mm": float(np.max(sizes_mm)),
        **{f"bias {axis} mm": float(value) for axis, value in zip("xyz", bias_mm, strict=True)},
        NEES: normalised_square(errors[known], covariances),
        RANK: rank_correlation(np.trace(covariances, axis1=1, axis2=2), sizes_mm[known]),
    }


def normalised_square(errors: Array, covariances: Array) -> float:
    """NEES, the mean of e^T C^-1 e over errors (N, 3) with covariances (N, 3, 3); NaN without any."""
    if not len(errors):
        return float("nan")
    weighted = np.linalg.solve(covariances, errors[..., None])[..., 0]
    return float(np.mean(np.sum(errors * weighted, axis=1)))


def rank_correlation(first: Array, second: Array) -> float:
    """Spearman's rank correlation of (N,) with (N,); NaN where either is constant or there are fewer than three."""
    if len(first) < 3 or np.ptp(first) == 0 or np.ptp(second) == 0:
        return float("nan")
    return float(np.corrcoef(rankdata(first), rankdata(second))[0, 1])
