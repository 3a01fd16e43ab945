"""Skin from the palest to the darkest: its colour, paler palms, nails, blotches and hair, for every drawn vertex."""

import numpy as np
import torch
from torch import Tensor

from lab.eye.arms.surface import SkinAttributes
from lab.eye.pictures.random_tensors import Draw
from lab.films.picture.light import linear

# The ten tones of the Monk Skin Tone scale, sRGB, by Ellis Monk, published for use by everybody.
MONK = ("f6ede4", "f3e7db", "f7ead0", "eadaba", "d7bd96", "a07e56", "825c43", "604134", "3a312a", "292420")
TONES = len(MONK)
VARNISHED = 0.08
HAIRY = 0.5


class SkinColours:
    """Colours the drawn vertices of a batch of arms."""

    def __init__(self, skin: SkinAttributes, device: torch.device) -> None:
        srgb = np.array([[int(tone[k : k + 2], 16) for k in (0, 2, 4)] for tone in MONK])
        self._tones = torch.as_tensor(linear(srgb), dtype=torch.float32, device=device)
        fields = (skin.palm, skin.nail, skin.knuckle, skin.along)
        self._palm, self._nail, self._knuckle, self._along = (
            torch.as_tensor(field, dtype=torch.float32, device=device)[None, :, None] for field in fields
        )
        self._noises = torch.as_tensor(skin.noises, dtype=torch.float32, device=device)

    def albedo(self, tone: Tensor, draw: Draw) -> Tensor:
        """Colour skin of tones (B,), 0 the palest to 9 the darkest: linear RGB (B, F, 3)."""
        base = 0.85 * self._tone(tone) * torch.exp(0.12 * draw.normal(1) + 0.05 * draw.normal(3))
        palm = 0.85 * self._tone(tone - 2.5 * (tone / 9.0).clamp(0.0, 1.0)) * (1.0 + 0.9 * (tone[:, None] / 9.0) ** 2)
        palm = palm * torch.tensor([1.05, 0.97, 0.94], device=tone.device)
        colour = base[:, None] + self._palm * draw.uniform(0.6, 1.0, 1, 1) * (palm - base)[:, None]
        colour = colour * (1.0 - self._knuckle * draw.uniform(0.0, 0.2, 1, 3))
        colour = colour * torch.exp(self._blotches(draw, 0.03)) * torch.exp(self._blotches(draw, 0.012) * self._red())
        colour = colour * (1.0 - self._hair(draw))
        varnish = torch.where(draw.chance(VARNISHED, 1), draw.uniform(0.02, 0.9, 3), (1.2 * base).clamp_max(0.9))
        return (colour + self._nail * (varnish[:, None] - colour)).clamp(0.004, 0.95)

    def _tone(self, tone: Tensor) -> Tensor:
        """Linear RGB (B, 3) between the scale's tones."""
        at = tone.clamp(0.0, TONES - 1.001)
        low = at.floor().long()
        share = (at - low)[:, None]
        return self._tones[low] * (1.0 - share) + self._tones[low + 1] * share

    def _blotches(self, draw: Draw, most: float) -> Tensor:
        weights = draw.normal(self._noises.shape[1]) * draw.uniform(0.0, most, 1)
        return (weights @ self._noises.T)[..., None]

    def _hair(self, draw: Draw) -> Tensor:
        """How much (B, F, 1) hair darkens the limb; the palm, the fingers' ends and nails have none."""
        hairy = draw.chance(HAIRY, 1, 1) * draw.uniform(0.0, 0.5, 1, 1)
        fine = self._noises[None, :, :1] + self._noises[None, :, 4:5]
        where = (1.0 - self._palm) * ((2.3 - self._along) / 0.4).clamp(0.0, 1.0)
        return hairy * where * fine.clamp(0.0, 2.0) * 0.5

    def _red(self) -> Tensor:
        return torch.tensor([1.0, -0.6, -0.4], device=self._noises.device)
