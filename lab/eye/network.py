"""The networks: one that finds hands in a picture, and one that looks at the crop of an arm or of a hand."""

import torch
from torch import Tensor, nn

from lab.eye.arms.surface import CropKind
from lab.eye.pictures.painting import CLASSES
from local_site.tracking.eye.arm_points import POINTS

WIDTHS: dict[CropKind, int] = {"arm": 16, "hand": 20}  # of the trunks that are trained
FINDER_WIDTH = 12
COARSE_PX = 48  # the grid on which points are looked for
OF_A_POINT = 6  # whitening (3), depth, the logarithm of its deviation, and whether it is seen


class Trunk(nn.Module):
    """A U-Net over four scales, from 1/2 of the picture with `width` channels to 1/16 with eight times as many."""

    def __init__(self, width: int) -> None:
        super().__init__()
        w = width
        self.stem = nn.Sequential(_step(3, w, 2), _step(w, w))
        self.down = nn.ModuleList(
            [
                nn.Sequential(_step(w, 2 * w, 2), ResidualStep(2 * w)),
                nn.Sequential(_step(2 * w, 4 * w, 2), ResidualStep(4 * w)),
                nn.Sequential(_step(4 * w, 8 * w, 2), ResidualStep(8 * w), ResidualStep(8 * w)),
            ]
        )
        self.across = nn.ModuleList([nn.Conv2d(k * w, k // 2 * w, 1, bias=False) for k in (8, 4, 2)])
        self.up = nn.ModuleList([ResidualStep(4 * w), ResidualStep(2 * w), _step(w, w)])

    def forward(self, picture: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Give features at 1/2 (B, W, ...), at 1/4 (B, 2 W, ...), and of the whole picture (B, 8 W)."""
        scales = [self.stem(picture)]
        for down in self.down:
            scales.append(down(scales[-1]))
        ups = [scales[-1]]
        for k, (across, up) in enumerate(zip(self.across, self.up, strict=True)):
            ups.append(up(nn.functional.interpolate(across(ups[-1]), scale_factor=2.0) + scales[-2 - k]))
        return ups[3], ups[2], scales[-1].mean(dim=(2, 3))


class EyeNetwork(nn.Module):
    """Looks at the crop of an arm or of a hand.

    Takes pictures (B, 3, 192, 192), RGB from -1 to 1. Gives the parts' logits (B, 5, 96, 96); of each point (B, 22, 8)
    x, y, whitening (3), depth, the depth's log deviation, and the logit of being seen; logits (B, 2) of a bare hand and
    of a right one; and, to learn by, the heat of each point (B, 22, 2304), in logits. Lengths are shares of the width.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.trunk = Trunk(width)
        self.parts = nn.Conv2d(width, CLASSES, 1)
        self.heat = nn.Conv2d(2 * width, POINTS, 1)
        self.detail = nn.Conv2d(2 * width, POINTS * OF_A_POINT, 1)
        self.whole = nn.Linear(8 * width, 2)
        at = (torch.arange(COARSE_PX) + 0.5) / COARSE_PX
        grid = torch.stack(torch.meshgrid(at, at, indexing="xy"), dim=-1)
        self.register_buffer("grid", grid.reshape(-1, 2), persistent=False)

    def forward(self, picture: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Look at pictures."""
        fine, coarse, whole = self.trunk(picture)
        heat = self.heat(coarse).flatten(2).float()
        return self.parts(fine), self._points(coarse, heat), self.whole(whole), heat

    def _points(self, features: Tensor, heat: Tensor) -> Tensor:
        """Where each point is by the mean of its heat, and its other values where the heat is."""
        share = torch.softmax(heat, dim=2)
        detail = self.detail(features).float().unflatten(1, (POINTS, OF_A_POINT)).flatten(3)  # (B, 22, 6, 2304)
        return torch.cat([share @ self.grid, (detail @ share[..., None])[..., 0]], dim=2)


class FinderNetwork(nn.Module):
    """Looks at a whole picture for hands.

    Takes pictures (B, 3, 144, 192), RGB from -1 to 1. Gives of each cell of 4 × 4 px (B, 7, 36, 48) the logits that a
    hand's palm has its middle there, and that it is a right one; x, y to the middle in cells; the direction x, y from
    the wrist to the knuckles; and the logarithm of what 0.1 m measure there in shares of the picture's width.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.trunk = Trunk(width)
        self.cells = nn.Conv2d(2 * width, 7, 1)
        nn.init.constant_(self.cells.bias[:1], -4.0)  # most cells have no hand

    def forward(self, picture: Tensor) -> Tensor:
        """Look at pictures."""
        found: Tensor = self.cells(self.trunk(picture)[1])
        return found


class ResidualStep(nn.Module):
    """Two convolutions whose result is added to what came in."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.first = _step(width, width)
        self.second = nn.Sequential(nn.Conv2d(width, width, 3, padding=1, bias=False), nn.BatchNorm2d(width))

    def forward(self, x: Tensor) -> Tensor:
        """Add what two convolutions make of it."""
        return torch.relu(x + self.second(self.first(x)))


def _step(inputs: int, outputs: int, stride: int = 1) -> nn.Sequential:
    convolution = nn.Conv2d(inputs, outputs, 3, stride, padding=1, bias=False)
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs), nn.ReLU())
