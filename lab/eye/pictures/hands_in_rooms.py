"""Whole pictures to find hands in: no arm or several, right and left ones, near and far, anywhere."""

import math
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import affine_grid, grid_sample

from lab.eye.arms.poses import PoseStore
from lab.eye.pictures.backgrounds import Picture, Rooms
from lab.eye.pictures.painting import ArmLayer, ArmPainter
from lab.eye.pictures.random_tensors import Draw
from lab.eye.pictures.samples import SCENES_PER_ARM
from lab.eye.pictures.scenes import BODY, THING_BEFORE, over, something
from lab.eye.pictures.sensor import filmed
from local_site.tracking.eye.arm_points import INDEX_KNUCKLE, LITTLE_KNUCKLE, MIDDLE_KNUCKLE, WRIST

WIDTH, HEIGHT = 192, 144
CELL_PX = 4
EXTENT = (0.28, 1.7)  # of the whole arm's crop, in widths of the picture
FIRST, SECOND = 0.9, 0.45  # the shares of pictures that have them
SEEN_ENOUGH, TOO_HIDDEN = 0.55, 0.25  # of the hand's points: enough to be found, and so few that none is to be


@dataclass(frozen=True, slots=True)
class FinderSample:
    """A batch to learn from: `picture` (B, 3, 144, 192), RGB from -1 to 1; of two arms each, what the network tells.

    `middle` of the palm (B, 2, 2) in cells, `direction` (B, 2, 2), `size` (B, 2), a logarithm, whether it is a `right`
    hand (B, 2), and whether it is to be `found` (B, 2); where that is not to be judged, `unclear` (B, 2).
    """

    picture: Tensor
    middle: Tensor
    direction: Tensor
    size: Tensor
    right: Tensor
    found: Tensor
    unclear: Tensor


@dataclass(frozen=True, slots=True)
class _Placed:
    colour: Tensor
    coverage: Tensor
    points: Tensor  # (B, 22, 2) in px of the square picture
    seen: Tensor
    size: Tensor  # (B,): the crop's width in widths of the picture
    right: Tensor
    there: Tensor


class FinderSource:
    """Makes batches on one device; the same ones for the same seed there."""

    def __init__(self, poses: PoseStore, tiles: Picture, device: torch.device, seed: int) -> None:
        self._painter = ArmPainter(poses, "whole", device)
        self._rooms = Rooms(tiles, device)
        self._random = torch.Generator(device).manual_seed(seed)

    @torch.no_grad()
    def batch(self, count: int) -> FinderSample:
        """Make a batch of new samples, of a number that four divides."""
        arms = Draw(max(count // SCENES_PER_ARM, 1), self._random)
        draw = Draw(arms.count * SCENES_PER_ARM, self._random)
        layer = self._painter.paint(arms).repeated(SCENES_PER_ARM)
        behind, before = _placed(layer, 1, SECOND, draw), _placed(layer, 0, FIRST, draw)
        colour = self._rooms.backgrounds(WIDTH, draw)
        colour = over(colour, *something(self._rooms, (0.3, 1.2), BODY, WIDTH, draw))
        colour = over(over(colour, behind.colour, behind.coverage), before.colour, before.coverage)
        thing, hidden = something(self._rooms, (0.05, 0.3), THING_BEFORE, WIDTH, draw)
        picture = filmed(over(colour, thing, hidden), draw)
        rows = slice((WIDTH - HEIGHT) // 2, (WIDTH + HEIGHT) // 2)
        hands = [_hand(before, layer, 0, hidden), _hand(behind, layer, 1, torch.maximum(hidden, before.coverage))]
        return FinderSample(
            picture[:, :, rows] * 2.0 - 1.0, *(torch.stack(part, dim=1) for part in zip(*hands, strict=True))
        )


def _placed(layer: ArmLayer, shift: int, share: float, draw: Draw) -> _Placed:
    """Put arms of a batch anywhere into a square picture, turned, of any size, half of them as left arms."""
    low, high = (math.log(extent) for extent in EXTENT)
    size, angle = torch.exp(draw.uniform(low, high)), draw.uniform(-math.pi, math.pi)
    side = torch.where(draw.chance(0.5), 1.0, -1.0)
    cos, sin = torch.cos(angle), torch.sin(angle)
    # A point of the crop, -1 to 1, lies at turn point + shift in the picture; grid_sample asks for the inverse.
    turn = size[:, None, None] * torch.stack([torch.stack([side * cos, -sin], 1), torch.stack([side * sin, cos], 1)], 1)
    there, shifted = draw.chance(share), draw.uniform(-0.9, 0.9, 2)
    back = torch.linalg.inv(turn)
    grid = torch.cat([back, -back @ shifted[..., None]], dim=2)
    both = torch.cat([layer.colour, layer.coverage], dim=1).roll(shift, dims=0)
    moved = grid_sample(both, affine_grid(grid, list(both.shape), align_corners=False), align_corners=False)
    moved = moved * there[:, None, None, None]
    points = 2.0 * layer.points[..., :2].roll(shift, dims=0) - 1.0
    at = points @ turn.transpose(1, 2) + shifted[:, None]
    seen = layer.seen.roll(shift, dims=0)
    return _Placed(moved[:, :3], moved[:, 3:], WIDTH * (0.5 + 0.5 * at), seen, size, side > 0.0, there)


def _hand(placed: _Placed, layer: ArmLayer, shift: int, hidden: Tensor) -> tuple[Tensor, ...]:
    """What is told of one arm of each picture."""
    top = 0.5 * (WIDTH - HEIGHT)
    points = placed.points - torch.tensor([0.0, top], device=hidden.device)
    at = (2.0 * placed.points / WIDTH - 1.0)[:, None]
    covered = grid_sample(hidden, at, align_corners=False)[:, 0, 0] > 0.5
    limits = torch.tensor([WIDTH, HEIGHT], device=hidden.device)
    inside = ((points > 0.0) & (points < limits)).all(dim=2)
    share = (inside & ~covered)[:, WRIST:].float().mean(dim=1)
    knuckles = points[:, [INDEX_KNUCKLE, MIDDLE_KNUCKLE, LITTLE_KNUCKLE]].mean(dim=1)
    direction = torch.nn.functional.normalize(points[:, MIDDLE_KNUCKLE] - points[:, WRIST], dim=1)
    size = torch.log(0.1 * placed.size / layer.metres.roll(shift))
    bare = layer.bare.roll(shift) & placed.there
    middle_inside = ((knuckles > 0.0) & (knuckles < limits)).all(dim=1)
    found = bare & (share > SEEN_ENOUGH) & middle_inside
    unclear = bare & ~found & (share > TOO_HIDDEN)
    return 0.5 * (points[:, WRIST] + knuckles) / CELL_PX, direction, size, placed.right, found, unclear
