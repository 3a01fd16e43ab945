"""How well a network does on arms and rooms that it has not seen: errors by point, by skin tone, and how sure it is."""

import json
from dataclasses import asdict, dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from lab.eye.arms.surface import CropKind
from lab.eye.arms.views import CROP_M
from lab.eye.learning import whitened
from lab.eye.network import EyeNetwork
from lab.eye.pictures.painting import CLASSES, OTHER
from lab.eye.pictures.samples import Sample, SampleSource
from lab.eye.pictures.skin_tones import TONES
from local_site.tracking.eye.arm_points import POINTS

TONE_GROUPS = 5
CHI2_95 = 5.991  # of two degrees of freedom


@dataclass(frozen=True, slots=True)
class EyeJudgement:
    """What was measured over held-out samples; lengths in mm at the wrist's depth, points in the order of the poses.

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
def judge(network: EyeNetwork, source: SampleSource, kind: CropKind, batches: int, size: int) -> EyeJudgement:
    """Measure a network on new samples of a source."""
    network.eval()
    seen = [_looked(network, source.batch(size)) for _ in range(batches)]
    return _judged(kind, _SeenSamples(*(torch.cat(part) for part in zip(*seen, strict=True))))


class _SeenSamples(NamedTuple):
    """Of N samples: errors (N, 22, 2), whitening (N, 22, 3), which points were asked for and seen (N, 22), tone (N,),
    overlaps of the parts (N, 4), whether the answers of bare and of right hands were wrong (N, 2), NaN if not asked."""

    off: Tensor
    sure: Tensor
    asked: Tensor
    seen: Tensor
    tone: Tensor
    overlaps: Tensor
    wrong: Tensor


def _looked(network: EyeNetwork, sample: Sample) -> _SeenSamples:
    parts, points, whole, _ = network(sample.picture)
    return _SeenSamples(
        off=points[..., :2] - sample.points[..., :2],
        sure=points[..., 2:5],
        asked=sample.asked,
        seen=sample.seen & sample.asked,
        tone=sample.tone,
        overlaps=_overlaps(parts, sample.parts),
        wrong=_wrong(whole, sample),
    )


def _judged(kind: CropKind, looked: _SeenSamples) -> EyeJudgement:
    off, sure, asked, seen, tone, overlaps, wrong = looked
    error = 1e3 * CROP_M[kind] * off.norm(dim=2)
    square = whitened(off, sure).square().sum(dim=2)
    group = (tone / (TONES - 1.0) * TONE_GROUPS).long().clamp_max(TONE_GROUPS - 1)
    groups = [(group == k) for k in range(TONE_GROUPS)]
    return EyeJudgement(
        samples=len(off),
        seen_mean_mm=[_number(error[seen[:, k], k].mean()) for k in range(POINTS)],
        seen_median_mm=[_number(error[seen[:, k], k].median()) for k in range(POINTS)],
        hidden_median_mm=[_median(error[asked[:, k] & ~seen[:, k], k]) for k in range(POINTS)],
        scale_95=[_scale(square[asked[:, k], k]) for k in range(POINTS)],
        overlap=[_number(value) for value in overlaps.nanmean(dim=0)],
        tone_error_mm=[_number(error[g][seen[g]].mean()) for g in groups],
        tone_overlap=[_number(overlaps[g].nanmean()) for g in groups],
        bare_wrong=_number(wrong[:, 0].mean()),
        side_wrong=_number(wrong[:, 1].nanmean()),
    )


def _wrong(whole: Tensor, sample: Sample) -> Tensor:
    """Whether the answers (B, 2) are wrong: is a bare hand there, and is it a right one."""
    bare, side = (whole[:, 0] > 0.0) != sample.bare, (whole[:, 1] > 0.0) != sample.right
    return torch.stack([bare.float(), torch.where(sample.bare, side.float(), torch.nan)], dim=1)


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
