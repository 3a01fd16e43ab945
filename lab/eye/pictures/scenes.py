"""Scenes: an arm over a room, with bodies, other people's arms and things behind and before it, and its shadow."""

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import grid_sample, interpolate

from lab.eye.pictures.backgrounds import Rooms, random_windows
from lab.eye.pictures.painting import OTHER, ArmLayer
from lab.eye.pictures.random_tensors import Draw
from lab.eye.pictures.sensor import blurred, moved

ANOTHER_BEHIND, ANOTHER_BEFORE = 0.35, 0.06
BODY, THING_BEHIND, THING_BEFORE = 0.45, 0.35, 0.18
SHADOW = 0.4
MOVING, MOVING_PX = 0.25, 7.0
EMPTY = 0.06  # scenes without the arm: rooms, others and things alone


@dataclass(frozen=True, slots=True)
class ArmScene:
    """A batch of scenes, before any camera: colour (B, 3, S, S), linear RGB, and what is to be found in it.

    `parts` (B, 5, S, S) add up to 1; `points` (B, 22, 3) as of a layer; `seen` (B, 22); `bare_arm` (B,): a bare hand is
    there; `tone` (B,).
    """

    colour: Tensor
    parts: Tensor
    points: Tensor
    seen: Tensor
    bare_arm: Tensor
    tone: Tensor


def composed(layer: ArmLayer, rooms: Rooms, draw: Draw) -> ArmScene:
    """Lay a batch of arms over rooms; one arm of the batch stands in for another person beside the next one."""
    size = layer.colour.shape[2]
    colour = rooms.backgrounds(size, draw)
    colour = over(colour, *something(rooms, (0.5, 1.6), BODY, size, draw))
    colour = over(colour, *something(rooms, (0.15, 0.7), THING_BEHIND, size, draw))
    colour = over(colour, *_another(layer, ANOTHER_BEHIND, 1, draw))
    kept = ~draw.chance(EMPTY)
    there = kept.float()[:, None, None, None]
    arm, coverage = _in_motion(layer, draw)
    colour = colour * (1.0 - _shadow(coverage * there, draw))
    colour = over(colour, arm * there, coverage * there)
    front, hidden = something(rooms, (0.08, 0.5), THING_BEFORE, size, draw)
    person, person_hides = _another(layer, ANOTHER_BEFORE, 2, draw)
    colour = over(over(colour, front, hidden), person, person_hides)
    left = (1.0 - hidden) * (1.0 - person_hides) * there
    parts = layer.parts * left
    parts[:, OTHER] += 1.0 - left[:, 0]
    return ArmScene(
        colour, parts, layer.points, layer.seen & uncovered(left, layer.points), layer.bare & kept, layer.tone
    )


def over(under: Tensor, colour: Tensor, coverage: Tensor) -> Tensor:
    """Lay a colour that is already multiplied by its coverage over another."""
    return under * (1.0 - coverage) + colour


def _in_motion(layer: ArmLayer, draw: Draw) -> tuple[Tensor, Tensor]:
    """The arms' colour and coverage, some blurred by their motion."""
    both = torch.cat([layer.colour, layer.coverage], dim=1)
    which, some = draw.some(MOVING)
    both = both.index_copy(0, which, moved(both[which], some, MOVING_PX))
    return both[:, :3], both[:, 3:]


def _another(layer: ArmLayer, share: float, shift: int, draw: Draw) -> tuple[Tensor, Tensor]:
    """Another sample's arm, turned, larger or smaller, anywhere: colour and coverage, 0 where there is none."""
    which, some = draw.some(share)
    window = random_windows(some, (0.7, 2.2), layer.colour.shape[2]) + some.uniform(-1.2, 1.2, 1, 1, 2)
    theirs = (which + shift) % draw.count
    both = torch.cat([layer.colour[theirs], layer.coverage[theirs]], dim=1)
    placed = _alone(grid_sample(both, window, align_corners=False), which, draw.count)
    return placed[:, :3], placed[:, 3:]


def something(rooms: Rooms, extent: tuple[float, float], share: float, size: int, draw: Draw) -> tuple[Tensor, Tensor]:
    """Something with a smooth outline, of some material, of this extent in shares of half the width."""
    which, some = draw.some(share)
    coverage = _outlines(extent, size, some)
    colour = rooms.materials(size, some) * coverage
    return _alone(colour, which, draw.count), _alone(coverage, which, draw.count)


def _outlines(extent: tuple[float, float], size: int, draw: Draw) -> Tensor:
    """How much (B, 1, S, S) of each pixel something covers."""
    at = torch.linspace(-1.0, 1.0, size, device=draw.random.device)
    x, y = at[None, None, :], at[None, :, None]
    middle, radius = draw.uniform(-1.0, 1.0, 2, 1, 1), draw.uniform(*extent, 2, 1, 1)
    waves = interpolate(draw.normal(1, 5, 5), size=(size, size), mode="bicubic", align_corners=False)[:, 0]
    power = draw.uniform(1.5, 6.0, 1, 1)  # from a rhombus over an ellipse to a box
    inside = 1.0 - (
        ((x - middle[:, 0]) / radius[:, 0]).abs() ** power + ((y - middle[:, 1]) / radius[:, 1]).abs() ** power
    )
    return (12.0 * (inside + draw.uniform(0.0, 0.5, 1, 1) * waves)).clamp(0.0, 1.0)[:, None]


def _alone(part: Tensor, which: Tensor, count: int) -> Tensor:
    """What some samples (K, ...) have, among all (count, ...), the others of which have nothing."""
    return torch.zeros(count, *part.shape[1:], device=part.device).index_copy(0, which, part)


def _shadow(coverage: Tensor, draw: Draw) -> Tensor:
    """How much (B, 1, S, S) of the light the arm takes from what is behind it."""
    which, some = draw.some(SHADOW)
    at = torch.linspace(-1.0, 1.0, coverage.shape[2], device=coverage.device)
    grid = torch.stack(torch.meshgrid(at, at, indexing="xy"), dim=2)[None] + some.uniform(-0.25, 0.25, 1, 1, 2)
    soft = blurred(grid_sample(coverage[which], grid, align_corners=True), some.uniform(1.0, 8.0))
    return _alone(soft * some.uniform(0.0, 0.7, 1, 1, 1), which, draw.count)


def uncovered(left: Tensor, points: Tensor) -> Tensor:
    """Tell which points (B, 22) lie where more than half of a layer (B, 1, S, S) is left."""
    at = (2.0 * points[..., :2] - 1.0)[:, None]
    return grid_sample(left, at, padding_mode="border", align_corners=False)[:, 0, 0] > 0.5
