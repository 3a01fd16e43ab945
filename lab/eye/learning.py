"""What is learned: how wrong a network's answer is, and what of it is told."""

import math

import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits, log_softmax

from lab.eye.network import EyeNetwork
from lab.eye.pictures.samples import Sample

FREEDOM = 4.0  # of Student's distribution: some errors are far beyond what most are
SHARPEST = 7.0  # the logarithm of the greatest whitening: a deviation of 1/1000 of the crop
POINT_WEIGHT, SURE_WEIGHT, DEPTH_WEIGHT = 20.0, 0.1, 4.0
HEAT_WEIGHT, HEAT_SPREAD = 0.3, 1.0 / 48.0  # about a point, in shares of the crop: one cell
DICE_WEIGHT, SEEN_WEIGHT, WHOLE_WEIGHT = 0.5, 0.3, 0.5
LEFT_WEIGHT = 3.0  # of a left hand, which is rarer: the answer is to favour no side
HIDDEN_WEIGHT = 0.35  # of a point that is hidden, against one that is seen


def eye_losses(network: EyeNetwork, sample: Sample) -> dict[str, Tensor]:
    """Compare a network's answer with the truth: the losses by name, each one number; their sum is made small."""
    answer = network(sample.picture)
    parts, points, whole = answer[0].float(), answer[1].float(), answer[2].float()
    weight = sample.asked.float() * torch.where(sample.seen, 1.0, HIDDEN_WEIGHT)
    count = weight.sum().clamp_min(1.0)
    off = points[..., :2] - sample.points[..., :2]
    depth_off = (points[..., 5] - sample.points[..., 2]).abs()
    seen = binary_cross_entropy_with_logits(points[..., 7], sample.seen.float(), sample.asked.float())
    unsure = SURE_WEIGHT * surprise(off.detach(), points[..., 2:5])
    depth = DEPTH_WEIGHT * depth_off + SURE_WEIGHT * _depth_surprise(depth_off.detach(), points[..., 6])
    return {
        "parts": _cross_entropy(parts, sample.parts) + DICE_WEIGHT * _dice(parts, sample.parts),
        "points": POINT_WEIGHT * (off.abs().sum(dim=2) * weight).sum() / count,
        "heat": HEAT_WEIGHT * (_heat_loss(answer[3], sample.points[..., :2], network.grid) * weight).sum() / count,
        "sure": (unsure * weight).sum() / count + SEEN_WEIGHT * seen,
        "depth": (depth * weight).sum() / count,
        "whole": WHOLE_WEIGHT * _whole_loss(whole, sample),
    }


def whitened(off: Tensor, whitening: Tensor) -> Tensor:
    """Whiten errors (..., 2) by a, b, c (..., 3): exp(a) x, and b x + exp(c) y; of deviation 1 where c is true."""
    a, b, c = whitening.unbind(-1)
    along = torch.exp(a.clamp(-3.0, SHARPEST)) * off[..., 0]
    return torch.stack([along, b * off[..., 0] + torch.exp(c.clamp(-3.0, SHARPEST)) * off[..., 1]], dim=-1)


def surprise(off: Tensor, whitening: Tensor) -> Tensor:
    """Compute the negative logarithm (...) of Student's density of errors (..., 2), but for a constant."""
    square = whitened(off, whitening).square().sum(dim=-1)
    sharpness = whitening[..., 0].clamp(-3.0, SHARPEST) + whitening[..., 2].clamp(-3.0, SHARPEST)
    return 0.5 * (FREEDOM + 2.0) * torch.log1p(square / FREEDOM) - sharpness


def _depth_surprise(off: Tensor, log_deviation: Tensor) -> Tensor:
    bounded = log_deviation.clamp(-SHARPEST, 1.0)
    return 0.5 * (FREEDOM + 1.0) * torch.log1p((off * torch.exp(-bounded)).square() / FREEDOM) + bounded


def _heat_loss(heat: Tensor, points: Tensor, grid: Tensor) -> Tensor:
    """The cross entropy (B, 22) of each point's heat, against what lies narrowly about the point."""
    square = ((grid - points[:, :, None]) ** 2).sum(dim=3)
    target = torch.softmax(-0.5 * square / HEAT_SPREAD**2, dim=2)
    return -(target * log_softmax(heat, dim=2)).sum(dim=2)


def _cross_entropy(logits: Tensor, shares: Tensor) -> Tensor:
    return -(shares * log_softmax(logits, dim=1)).sum(dim=1).mean() * math.log2(math.e)


def _dice(logits: Tensor, shares: Tensor) -> Tensor:
    """How little masks overlap: 0 where they agree, of the parts that are not empty, over the batch."""
    guessed, true = torch.softmax(logits, dim=1)[:, 1:], shares[:, 1:]
    both = (guessed * true).sum(dim=(0, 2, 3))
    either = (guessed + true).sum(dim=(0, 2, 3)).clamp_min(1.0)
    return (1.0 - 2.0 * both / either).mean()


def _whole_loss(logits: Tensor, sample: Sample) -> Tensor:
    """Whether a bare hand is there; its side only where one is, most of whose points are seen."""
    bare = binary_cross_entropy_with_logits(logits[:, 0], sample.bare.float())
    judged = (sample.bare & (sample.seen.float().mean(dim=1) > 0.3)) * torch.where(sample.right, 1.0, LEFT_WEIGHT)
    side = binary_cross_entropy_with_logits(logits[:, 1], sample.right.float(), reduction="none")
    return bare + (side * judged).sum() / judged.sum().clamp_min(1.0)
