"""What a finder of hands learns: in which cells they are, and how they lie there."""

import math
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits, logsigmoid

from lab.eye.network import FinderNetwork
from lab.eye.pictures.hands_in_rooms import CELL_PX, HEIGHT, WIDTH, FinderSample

COLUMNS, ROWS = WIDTH // CELL_PX, HEIGHT // CELL_PX
SPREAD = 0.35  # of the heat about a hand's middle, in tenths of a metre there
NARROWEST = 0.7  # cells
NEAR = 1.6  # cells from the middle, within which a cell tells how the hand lies
LIES_WEIGHT, SIDE_WEIGHT = 0.5, 0.5


def finder_losses(network: FinderNetwork, sample: FinderSample) -> dict[str, Tensor]:
    """Compare a finder's answer with the truth: the losses of heat, of which side hands are of and of how they lie."""
    answer = network(sample.picture).float()
    off = _offsets(sample.middle)  # (B, 2, 2, 36, 48)
    distance = off.norm(dim=2)
    heat = _heat(distance, sample)
    unclear = (sample.unclear[:, :, None, None] & (distance < 3.0 * _spread(sample))).any(dim=1, keepdim=True)
    told = _Told.about(off, distance, sample)
    lies = (answer[:, 2:] - told.lies).abs().sum(dim=1)
    side = binary_cross_entropy_with_logits(answer[:, 1], told.right, reduction="none")
    return {
        "heat": _focal(answer[:, :1], heat, unclear),
        "side": SIDE_WEIGHT * told.mean(side),
        "lies": LIES_WEIGHT * told.mean(lies),
    }


def _offsets(middle: Tensor) -> Tensor:
    """From each cell's middle to each hand's (B, 2, 2, 36, 48), in cells."""
    x = torch.arange(COLUMNS, device=middle.device) + 0.5
    y = torch.arange(ROWS, device=middle.device) + 0.5
    grid = torch.stack(torch.meshgrid(x, y, indexing="xy"))
    return middle[..., None, None] - grid


def _spread(sample: FinderSample) -> Tensor:
    return (SPREAD * COLUMNS * torch.exp(sample.size)).clamp_min(NARROWEST)[:, :, None, None]


def _heat(distance: Tensor, sample: FinderSample) -> Tensor:
    """What each cell is to say (B, 1, 36, 48): 1 in a hand's middle, less about it."""
    each = torch.exp(-0.5 * (distance / _spread(sample)) ** 2) * sample.found[:, :, None, None]
    peak = (distance <= math.sqrt(0.5)) & (distance == distance.amin(dim=(2, 3), keepdim=True))
    return torch.where(peak & sample.found[:, :, None, None], 1.0, each.clamp_max(0.98)).amax(dim=1, keepdim=True)


def _focal(logits: Tensor, heat: Tensor, unclear: Tensor) -> Tensor:
    """The focal loss of finding objects as points, per hand."""
    share = torch.sigmoid(logits)
    peak = heat >= 1.0
    missed = -logsigmoid(logits) * (1.0 - share) ** 2 * peak
    wrong = -logsigmoid(-logits) * share**2 * (1.0 - heat) ** 4 * ~peak * ~unclear
    return (missed.sum() + wrong.sum()) / peak.sum().clamp_min(1)


@dataclass(frozen=True, slots=True)
class _Told:
    """What cells near a hand are to tell of the nearest: `lies` (B, 5, 36, 48) and `right`, where `weight` is 1."""

    lies: Tensor
    right: Tensor
    weight: Tensor

    @classmethod
    def about(cls, off: Tensor, distance: Tensor, sample: FinderSample) -> "_Told":
        nearest = distance.argmin(dim=1, keepdim=True)

        def of_nearest(each: Tensor) -> Tensor:
            spread = each if each.ndim == 5 else each[..., None, None].expand(-1, -1, -1, *distance.shape[2:])
            return spread.gather(1, nearest[:, :, None].expand(-1, -1, spread.shape[2], -1, -1))[:, 0]

        asked = (distance < NEAR) & sample.found[:, :, None, None]
        lies = [of_nearest(each) for each in (off, sample.direction, sample.size[..., None])]
        right = of_nearest(sample.right.float()[..., None])[:, 0]
        return cls(torch.cat(lies, dim=1), right, asked.gather(1, nearest)[:, 0].float())

    def mean(self, error: Tensor) -> Tensor:
        """Average errors (B, 36, 48) over the cells that tell something."""
        return (error * self.weight).sum() / self.weight.sum().clamp_min(1.0)
