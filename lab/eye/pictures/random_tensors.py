"""Random numbers for a batch, on its device, from one generator."""

import torch
from torch import Tensor


class Draw:
    """Draws for B samples at a time; the same for the same seed on the same device."""

    def __init__(self, count: int, random: torch.Generator) -> None:
        self.count = count
        self.random = random

    def uniform(self, low: float, high: float, *shape: int) -> Tensor:
        """Draw numbers (B, *shape) between two."""
        return low + (high - low) * torch.rand(self.count, *shape, generator=self.random, device=self.random.device)

    def normal(self, *shape: int) -> Tensor:
        """Draw numbers (B, *shape) of mean 0 and deviation 1."""
        return torch.randn(self.count, *shape, generator=self.random, device=self.random.device)

    def chance(self, share: float, *shape: int) -> Tensor:
        """Draw truths (B, *shape), of which this share holds."""
        return self.uniform(0.0, 1.0, *shape) < share

    def some(self, share: float) -> tuple[Tensor, "Draw"]:
        """Draw which samples, this share of them and at least one: their numbers (K,), and draws for these alone."""
        count = max(round(share * self.count), 1)
        which = torch.randperm(self.count, generator=self.random, device=self.random.device)[:count]
        return which, Draw(count, self.random)

    def integers(self, below: int, *shape: int) -> Tensor:
        """Draw whole numbers (B, *shape) from 0 to below."""
        return torch.randint(below, (self.count, *shape), generator=self.random, device=self.random.device)

    def directions(self) -> Tensor:
        """Draw unit vectors (B, 3), all directions alike."""
        return torch.nn.functional.normalize(self.normal(3), dim=1)
