"""What an arm wears: sleeves of every length, watches, rings, and gloves, which hide that it is a bare hand."""

from dataclasses import dataclass

import torch
from torch import Tensor

from lab.eye.arms.surface import SkinAttributes
from lab.eye.pictures.random_tensors import Draw

# Shares of arms by where their sleeve ends, along the arm: 1 is the elbow, 2 the wrist.
SLEEVES = ((0.30, 0.0, 0.0), (0.27, 0.2, 0.85), (0.15, 0.85, 1.2), (0.28, 1.2, 1.97))
GLOVED = 0.06
WATCH, RING = 0.2, 0.2
WIDE_NOISES = (3, 7, 11)  # of the skin's noises those that make folds, not fur
THICKNESS_M = (0.002, 0.014)


@dataclass(frozen=True, slots=True)
class Clothes:
    """Of each arm where its sleeve ends (B,), how thick the cloth is (B,) in m, and whether it wears a glove (B,)."""

    sleeve: Tensor
    thickness: Tensor
    gloved: Tensor


@dataclass(frozen=True, slots=True)
class WornSurface:
    """Where each pixel lies on the arm, (B, S, S, 1) each: along and around it, on which digit and how far along it."""

    along: Tensor
    around: Tensor
    digit: Tensor
    along_digit: Tensor


def random_clothes(draw: Draw) -> Clothes:
    """Draw what each arm of a batch wears."""
    kind, end = draw.uniform(0.0, 1.0), torch.zeros(draw.count, device=draw.random.device)
    for share, low, high in SLEEVES:
        end = torch.where((kind >= 0.0) & (kind < share), draw.uniform(low, high), end)
        kind = kind - share
    return Clothes(end, draw.uniform(*THICKNESS_M), draw.chance(GLOVED))


def swell(vertices: Tensor, normals: Tensor, clothes: Clothes, skin: SkinAttributes, draw: Draw) -> Tensor:
    """Move vertices (B, F, 3) outwards where a sleeve covers them, with wrinkles."""
    along = torch.as_tensor(skin.along, dtype=torch.float32, device=vertices.device)
    noises = torch.as_tensor(skin.noises[:, WIDE_NOISES], dtype=torch.float32, device=vertices.device)
    wrinkles = 1.0 + 0.35 * draw.normal(len(WIDE_NOISES)) @ noises.T
    covered = ((clothes.sleeve[:, None] - along) / 0.04).clamp(0.0, 1.0)
    return vertices + (clothes.thickness[:, None] * wrinkles.clamp_min(0.2) * covered)[..., None] * normals


def covered_by_cloth(worn: WornSurface, clothes: Clothes, draw: Draw) -> Tensor:
    """Tell which pixels (B, S, S, 1) show a sleeve or a glove; a hem is not straight."""
    waves = 0.03 * torch.sin(worn.around + draw.uniform(0.0, 6.3, 1, 1, 1)) * draw.uniform(0.0, 1.0, 1, 1, 1)
    glove = clothes.gloved[:, None, None, None] & (worn.along > draw.uniform(1.8, 2.02, 1, 1, 1))
    return (worn.along + waves < clothes.sleeve[:, None, None, None]) | glove


def dressed(albedo: Tensor, worn: WornSurface, cloth: Tensor, draw: Draw) -> Tensor:
    """Colour cloth (B, S, S, 1), watches and rings over skin with albedo (B, S, S, 3)."""
    band = (worn.along - draw.uniform(1.86, 1.96, 1, 1, 1)).abs() < draw.uniform(0.01, 0.05, 1, 1, 1)
    albedo = torch.where(band & draw.chance(WATCH, 1, 1, 1), draw.uniform(0.01, 0.8, 1, 1, 3), albedo)
    on_finger = (worn.digit - 1.0 - draw.integers(5, 1, 1, 1)).abs() < 0.2
    ring = on_finger & ((worn.along_digit - draw.uniform(0.3, 0.6, 1, 1, 1)).abs() < 0.08)
    albedo = torch.where(ring & draw.chance(RING, 1, 1, 1), draw.uniform(0.2, 0.9, 1, 1, 3), albedo)
    glove, sleeve = _cloth(worn, draw), _cloth(worn, draw)
    return torch.where(cloth, torch.where(worn.along > 1.75, glove, sleeve), albedo)


def _cloth(worn: WornSurface, draw: Draw) -> Tensor:
    """A cloth's albedo (B, S, S, 3): plain, in rings, stripes or checks of two colours."""
    one, other = (_dye(draw) for _ in range(2))
    rings = torch.sin(worn.along * draw.uniform(20.0, 120.0, 1, 1, 1)) > 0.0
    stripes = torch.sin(worn.around * draw.integers(9, 1, 1, 1)) > 0.2
    second = (rings & draw.chance(0.25, 1, 1, 1)) ^ (stripes & draw.chance(0.25, 1, 1, 1))
    return torch.where(second, other, one)


def _dye(draw: Draw) -> Tensor:
    """A colour (B, 1, 1, 3): greys, and colours from pale to deep."""
    grey = draw.uniform(0.02, 0.95, 1, 1, 1) ** 2.0
    return (grey * torch.exp(0.9 * draw.normal(1, 1, 3) * draw.uniform(0.0, 1.0, 1, 1, 1))).clamp(0.01, 0.95)
