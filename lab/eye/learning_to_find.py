"""What a finder of hands learns: in which cells they are, and how they lie there."""

import math

import torch
from torch import Tensor
from torch.nn.functional import logsigmoid

from lab.eye.network import FinderNetwork
from lab.eye.pictures.hands_in_rooms import CELL_PX, HEIGHT, WIDTH, FinderSample

COLUMNS, ROWS = WIDTH // CELL_PX, HEIGHT // CELL_PX
SPREAD = 0.35  # of the heat about a hand's middle, in tenths of a metre there
NARROWEST = 0.7  # cells
NEAR = 1.6  # cells from the middle, within which a cell tells how the hand lies
LIES_WEIGHT = 0.5


def finder_losses(network: FinderNetwork, sample: FinderSample) -> dict[str, Tensor]:
    """Compare a finder's answer with the truth: the losses of heat and of how hands lie."""
    answer = network(sample.picture).float()
    off = _offsets(sample.middle)  # (B, 2, 2, 36, 48)
    distance = off.norm(dim=2)
    heat = _heat(distance, sample)
    unclear = (sample.unclear[:, :, None, None] & (distance < 3.0 * _spread(sample))).any(dim=1, keepdim=True)
    return {"heat": _focal(answer[:, :2], heat, unclear), "lies": LIES_WEIGHT * _lies(answer[:, 2:], off, distance, sample)}


def _offsets(middle: Tensor) -> Tensor:
    """From each cell's middle to each hand's (B, 2, 2, 36, 48), in cells."""
    x = torch.arange(COLUMNS, device=middle.device) + 0.5
    y = torch.arange(ROWS, device=middle.device) + 0.5
    grid = torch.stack(torch.meshgrid(x, y, indexing="xy"))
    return middle[..., None, None] - grid


def _spread(sample: FinderSample) -> Tensor:
    return (SPREAD * COLUMNS * torch.exp(sample.size)).clamp_min(NARROWEST)[:, :, None, None]


def _heat(distance: Tensor, sample: FinderSample) -> Tensor:
    """What each cell is to say (B, 2, 36, 48) for right and left hands: 1 in their middle, less about it."""
    each = torch.exp(-0.5 * (distance / _spread(sample)) ** 2) * sample.found[:, :, None, None]
    peak = (distance <= math.sqrt(0.5)) & (distance == distance.amin(dim=(2, 3), keepdim=True))
    each = torch.where(peak & sample.found[:, :, None, None], 1.0, each.clamp_max(0.98))
    right = sample.right[:, :, None, None]
    return torch.stack([(each * right).amax(dim=1), (each * ~right).amax(dim=1)], dim=1)


def _focal(logits: Tensor, heat: Tensor, unclear: Tensor) -> Tensor:
    """The focal loss of finding objects as points, per hand."""
    share = torch.sigmoid(logits)
    peak = heat >= 1.0
    missed = -logsigmoid(logits) * (1.0 - share) ** 2 * peak
    wrong = -logsigmoid(-logits) * share**2 * (1.0 - heat) ** 4 * ~peak * ~unclear
    return (missed.sum() + wrong.sum()) / peak.sum().clamp_min(1)


def _lies(values: Tensor, off: Tensor, distance: Tensor, sample: FinderSample) -> Tensor:
    """The errors of middle, direction and size, in cells near a hand; the nearer of two hands counts."""
    nearest = distance.argmin(dim=1, keepdim=True)
    asked = (distance < NEAR) & sample.found[:, :, None, None]
    weight = asked.gather(1, nearest)[:, 0].float()

    def of_nearest(each: Tensor) -> Tensor:
        spread = each if each.ndim == 5 else each[..., None, None].expand(-1, -1, -1, *distance.shape[2:])
        return spread.gather(1, nearest[:, :, None].expand(-1, -1, spread.shape[2], -1, -1))[:, 0]

    truth = torch.cat([of_nearest(off), of_nearest(sample.direction), of_nearest(sample.size[..., None])], dim=1)
    error = (values - truth).abs().sum(dim=1)
    return (error * weight).sum() / weight.sum().clamp_min(1.0)
