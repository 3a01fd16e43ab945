"""How well a network does on arms and rooms that it has not seen: errors by point, by skin tone, and how sure it is."""

import json
from dataclasses import asdict, dataclass

import torch
from torch import Tensor

from lab.eye.arms.poses import POINTS
from lab.eye.arms.surface import CropKind
from lab.eye.arms.views import CROP_M
from lab.eye.learning import whitened
from lab.eye.network import EyeNetwork
from lab.eye.pictures.painting import CLASSES, OTHER
from lab.eye.pictures.samples import Sample, SampleSource
from lab.eye.pictures.skin_tones import TONES

TONE_GROUPS = 5
CHI2_95 = 5.991  # of two degrees of freedom


@dataclass(frozen=True, slots=True)
class Judgement:
    """What was measured over held-out samples; lengths in mm at the wrist's depth, points as the store of poses has them.

    `tone_error_mm` is of groups of tones from the palest to the darkest, over all points that are seen, `tone_overlap`
    the overlap of all parts. `scale_95` is by how much a point's covariance, in deviations, must grow so that 95 % lie
    within its 95 % ellipse.
    """

    samples: int
    seen_mean_mm: list[float]
    seen_median_mm: list[float]
    hidden_median_mm: list[float]
    scale_95: list[float]
    overlap: list[float]
    tone_error_mm: list[float]
    tone_overlap: list[float]
    bare_wrong: float
    side_wrong: float

    def text(self) -> str:
        """Write it as JSON."""
        return json.dumps(asdict(self), indent=1)


@torch.no_grad()
def judge(network: EyeNetwork, source: SampleSource, kind: CropKind, batches: int, size: int) -> Judgement:
    """Measure a network on new samples of a source."""
    network.eval()
    off, sure, asked, seen, tone, wrong, parts = [], [], [], [], [], [], []
    for _ in range(batches):
        sample = source.batch(size)
        logits, points, whole, _ = network(sample.picture)
        off.append(points[..., :2] - sample.points[..., :2])
        sure.append(points[..., 2:5])
        asked.append(sample.asked)
        seen.append(sample.seen & sample.asked)
        tone.append(sample.tone)
        wrong.append(_wrong(whole, sample))
        parts.append(_overlaps(logits, sample.parts))
    return _judged(
        kind, *(torch.cat(part) for part in (off, sure, asked, seen, tone)), torch.stack(wrong).mean(0), torch.cat(parts)
    )


def _judged(
    kind: CropKind,
    off: Tensor,
    sure: Tensor,
    asked: Tensor,
    seen: Tensor,
    tone: Tensor,
    wrong: Tensor,
    overlaps: Tensor,
) -> Judgement:
    error = 1e3 * CROP_M[kind] * off.norm(dim=2)
    square = whitened(off, sure).square().sum(dim=2)
    group = (tone / (TONES - 1.0) * TONE_GROUPS).long().clamp_max(TONE_GROUPS - 1)
    groups = [(group == k) for k in range(TONE_GROUPS)]
    return Judgement(
        samples=len(off),
        seen_mean_mm=[_number(error[seen[:, k], k].mean()) for k in range(POINTS)],
        seen_median_mm=[_number(error[seen[:, k], k].median()) for k in range(POINTS)],
        hidden_median_mm=[_median(error[asked[:, k] & ~seen[:, k], k]) for k in range(POINTS)],
        scale_95=[_scale(square[asked[:, k], k]) for k in range(POINTS)],
        overlap=[_number(value) for value in overlaps.nanmean(dim=0)],
        tone_error_mm=[_number(error[g][seen[g]].mean()) for g in groups],
        tone_overlap=[_number(overlaps[g].nanmean()) for g in groups],
        bare_wrong=_number(wrong[0]),
        side_wrong=_number(wrong[1]),
    )


def _wrong(whole: Tensor, sample: Sample) -> Tensor:
    """The shares of wrong answers (2,): is a bare hand there, and is it a right one."""
    bare = ((whole[:, 0] > 0.0) != sample.bare).float().mean()
    side = ((whole[:, 1] > 0.0) != sample.right)[sample.bare].float().mean()
    return torch.stack([bare, side])


def _overlaps(logits: Tensor, shares: Tensor) -> Tensor:
    """Intersection over union (B, 4) of each part but the room; NaN where the picture has none."""
    guessed = torch.nn.functional.one_hot(logits.argmax(dim=1), CLASSES).bool()
    true = torch.nn.functional.one_hot(shares.argmax(dim=1), CLASSES).bool()
    both, either = (guessed & true).sum(dim=(1, 2)).float(), (guessed | true).sum(dim=(1, 2)).float()
    there = true.sum(dim=(1, 2)) > 20
    return torch.where(there, both / either.clamp_min(1.0), torch.nan)[:, OTHER + 1 :]


def _median(values: Tensor) -> float:
    return _number(values.median()) if len(values) else float("nan")


def _number(value: Tensor) -> float:
    return round(float(value), 4)


def _scale(squares: Tensor) -> float:
    return _number((squares.quantile(0.95) / CHI2_95).sqrt()) if len(squares) else float("nan")
