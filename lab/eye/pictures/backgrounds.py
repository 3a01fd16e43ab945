"""Rooms behind the arm: cut-outs of photographs and painted textures, turned, tinted and put side by side."""

import math

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import grid_sample

from lab.eye.pictures.random_tensors import Draw
from lab.eye.pictures.skin_tones import MONK
from lab.films.picture.light import linear

TILE = 384  # px of a tile of material
CUTS_PER_PHOTOGRAPH = 14
PAINTED = 360
SKIN_COLOURED, PLAIN = 0.25, 0.12

Picture = NDArray[np.uint8]


def room_tiles(photographs: list[Picture], seed: int) -> Picture:
    """Make tiles (N, 384, 384, 3), RGB: cut-outs of photographs, and painted noise, wood, boards, boxes and print."""
    random = np.random.default_rng(seed)
    cuts = [_cut(photograph, random) for photograph in photographs for _ in range(CUTS_PER_PHOTOGRAPH)]
    painters = (_clouds, _wood, _boxes, _print, _checks)
    painted = [painters[k % len(painters)](random) for k in range(PAINTED)]
    return np.array(cuts + painted)


class Rooms:
    """Draws backgrounds from tiles, on one device."""

    def __init__(self, tiles: Picture, device: torch.device) -> None:
        volume = torch.as_tensor(tiles, device=device).permute(3, 0, 1, 2)[None]
        self._tiles = volume.contiguous().float() / 255.0  # (1, 3, N, H, W): cut-outs of any tiles in one call
        tones = np.array([[int(tone[k : k + 2], 16) for k in (0, 2, 4)] for tone in MONK])
        self._tones = torch.as_tensor(linear(tones), dtype=torch.float32, device=device)

    def backgrounds(self, size: int, draw: Draw) -> Tensor:
        """Draw backgrounds (B, 3, S, S), linear RGB: one material, or two with an edge between them."""
        one, other = self.materials(size, draw), self.materials(size, draw)
        cast = other * draw.uniform(0.5, 1.1, 1, 1, 1)
        return torch.where(_half_plane(size, draw) & draw.chance(0.6, 1, 1, 1), cast, one)

    def materials(self, size: int, draw: Draw) -> Tensor:
        """Draw materials (B, 3, S, S), linear RGB: cut-outs, some in a tone of skin, some plain."""
        pixels = self._cut_outs(random_windows(draw, (0.15, 0.9), size), draw)
        light = pixels**2.2 * torch.exp(0.5 * draw.normal(1, 1, 1) + 0.15 * draw.normal(3, 1, 1))
        grey = light.mean(dim=1, keepdim=True)
        contrast = draw.uniform(0.2, 1.0, 1, 1, 1)
        skin = self._tones[draw.integers(len(self._tones))] * torch.exp(0.15 * draw.normal(3))
        texture = grey / grey.mean(dim=(2, 3), keepdim=True).clamp_min(0.02)
        wood = skin[:, :, None, None] * (1.0 + contrast * (texture - 1.0))
        light = torch.where(draw.chance(SKIN_COLOURED, 1, 1, 1), wood, light)
        plain = light.mean(dim=(2, 3), keepdim=True) * draw.uniform(0.0, 1.0, 1, 1, 1)
        return torch.where(draw.chance(PLAIN, 1, 1, 1), plain, light).clamp(0.0, 1.5)

    def _cut_outs(self, windows: Tensor, draw: Draw) -> Tensor:
        """What windows (B, S, S, 2) of tiles show (B, 3, S, S), sRGB from 0 to 1."""
        count = self._tiles.shape[2]
        tile = (2.0 * draw.integers(count, 1, 1, 1) + 1.0) / count - 1.0  # where grid_sample has a tile's middle
        grid = torch.cat([windows, tile.expand(-1, *windows.shape[1:3], 1)], dim=3)
        return grid_sample(self._tiles, grid[None], padding_mode="reflection", align_corners=False)[0].transpose(0, 1)


def random_windows(draw: Draw, zoom: tuple[float, float], size: int) -> Tensor:
    """Draw windows (B, S, S, 2) of pictures for grid_sample: this share of the width, anywhere, turned anyhow."""
    angle = draw.uniform(-math.pi, math.pi)
    scale = draw.uniform(*zoom)
    cos, sin = (scale * torch.cos(angle))[:, None, None], (scale * torch.sin(angle))[:, None, None]
    shift = draw.uniform(-1.0, 1.0, 2) * (1.0 - scale)[:, None].clamp_min(0.0)
    at = (2.0 * torch.arange(size, device=angle.device) + 1.0) / size - 1.0
    x, y = at[None, None, :], at[None, :, None]
    return torch.stack([cos * x - sin * y + shift[:, :1, None], sin * x + cos * y + shift[:, 1:, None]], dim=3)


def _half_plane(size: int, draw: Draw) -> Tensor:
    """Which pixels (B, 1, S, S) lie on one side of a line."""
    at = torch.linspace(-1.0, 1.0, size, device=draw.random.device)
    angle = draw.uniform(-math.pi, math.pi, 1, 1)
    side = torch.cos(angle) * at[None, None, :] + torch.sin(angle) * at[None, :, None]
    return (side > draw.uniform(-0.7, 0.7, 1, 1))[:, None]


def _cut(photograph: Picture, random: np.random.Generator) -> Picture:
    height, width = photograph.shape[:2]
    side = int(min(height, width) * random.uniform(0.35, 1.0))
    top, left = random.integers(height - side + 1), random.integers(width - side + 1)
    cut = photograph[top : top + side, left : left + side]
    return np.asarray(cv2.resize(cut, (TILE, TILE), interpolation=cv2.INTER_AREA), np.uint8)


def _colour(random: np.random.Generator) -> NDArray[np.float64]:
    grey = random.uniform(10.0, 240.0)
    return np.clip(grey * np.exp(random.uniform(0.0, 0.5) * random.standard_normal(3)), 0.0, 255.0)


def _noise(random: np.random.Generator, cells_x: float, cells_y: float) -> NDArray[np.float64]:
    """Smooth noise (TILE, TILE), 0 to 1, with about so many blotches across."""
    coarse = random.random((max(int(cells_y), 2), max(int(cells_x), 2)))
    return np.clip(cv2.resize(coarse, (TILE, TILE), interpolation=cv2.INTER_CUBIC), 0.0, 1.0)


def _mixed(share: NDArray[np.float64], random: np.random.Generator) -> Picture:
    one, other = _colour(random), _colour(random)
    return np.asarray(one + share[..., None] * (other - one), np.uint8)


def _clouds(random: np.random.Generator) -> Picture:
    octaves = [_noise(random, 2.0**k, 2.0**k) / 1.6**k for k in range(1, int(random.integers(3, 8)))]
    total = np.sum(octaves, axis=0)
    return _mixed(np.asarray((total - total.min()) / (np.ptp(total) + 1e-9)), random)


def _wood(random: np.random.Generator) -> Picture:
    grain = _noise(random, random.uniform(2, 4), random.uniform(8, 40)) + 0.3 * _noise(random, 6, 180)
    rings = 0.5 + 0.5 * np.sin(random.uniform(10, 60) * grain)
    return _mixed(np.clip(0.7 * grain + 0.3 * rings, 0.0, 1.0), random)


def _boxes(random: np.random.Generator) -> Picture:
    picture = np.full((TILE, TILE, 3), _colour(random))
    for _ in range(int(random.integers(4, 30))):
        corner, extent = random.integers(-40, TILE, 2), random.integers(8, 160, 2)
        (x, y), (w, h) = corner.tolist(), extent.tolist()
        if random.random() < 0.3:
            cv2.ellipse(picture, ((x, y), (w, h), random.uniform(0, 180)), _colour(random).tolist(), -1)
        else:
            cv2.rectangle(picture, (x, y), (x + w, y + h), _colour(random).tolist(), -1)
    shade = 0.6 + 0.4 * _noise(random, 3, 3)
    return np.asarray(np.clip(picture * shade[..., None], 0, 255), np.uint8)


def _print(random: np.random.Generator) -> Picture:
    """A poster: words of anything, lines and patches."""
    picture = np.full((TILE, TILE, 3), _colour(random).astype(np.uint8))
    for _ in range(int(random.integers(5, 25))):
        text = "".join(chr(random.integers(33, 126)) for _ in range(int(random.integers(3, 14))))
        at = random.integers(-20, TILE, 2).tolist()
        cv2.putText(
            picture, text, at, 0, random.uniform(0.4, 3.0), _colour(random).tolist(), int(random.integers(1, 6))
        )
    return picture


def _checks(random: np.random.Generator) -> Picture:
    across, down = (
        np.sin(random.uniform(5, 120) * np.linspace(0, 1, TILE)) > random.uniform(-0.9, 0.9) for _ in range(2)
    )
    pattern = (
        np.logical_xor(across[None, :], down[:, None]) if random.random() < 0.5 else across[None, :] | down[:, None]
    )
    return _mixed(np.clip(pattern * 0.8 + 0.2 * _noise(random, 20, 20), 0.0, 1.0), random)
