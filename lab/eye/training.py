"""Training: a network from nothing within a time, resumed where it was interrupted, its curves written."""

import copy
import json
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import torch
from torch import Tensor, nn

RATE, DECAY = 2e-3, 0.01
TRAINED_RATE = 1e-3  # of a network that was trained before
WARM_UP = 0.02  # of the time, in which the rate rises
REMEMBERED = 0.999  # of the averaged weights, at each step
Network = TypeVar("Network", bound=nn.Module)


class _Record(Protocol):
    """A dataclass, of tensors."""

    __dataclass_fields__: ClassVar[dict[str, Any]]


Batch = TypeVar("Batch", bound=_Record)

SAVED_EVERY_S, TOLD_EVERY = 60.0, 20
STEPS_AT_ONCE = 4  # batches that are drawn together, which costs less than to draw each


@dataclass(slots=True)
class Progress:
    """How far a training has come: seconds of it, steps, images, and its curve (seconds, images, losses by name)."""

    seconds: float = 0.0
    steps: int = 0
    images: int = 0
    curve: list[dict[str, float]] = field(default_factory=list)


class Training(Generic[Network, Batch]):
    """One network's training, with a checkpoint in a file; `batch` makes samples, `losses` compares with the truth."""

    def __init__(
        self,
        network: Network,
        batch: Callable[[int], Batch],
        losses: Callable[[Network, Batch], dict[str, Tensor]],
        checkpoint: Path,
        device: torch.device,
    ) -> None:
        self.network = network.to(device, memory_format=torch.channels_last)
        self.averaged = copy.deepcopy(network)
        self.progress = Progress()
        self._batch, self._losses = batch, losses
        self._device = device
        self._optimiser = torch.optim.AdamW(self.network.parameters(), RATE, weight_decay=DECAY)
        self._rate = RATE
        self._checkpoint, self._weights = checkpoint, checkpoint.with_suffix(".weights.pt")
        checkpoint.parent.mkdir(parents=True, exist_ok=True)
        if self._checkpoint.exists():
            self._resume()

    def run(self, seconds: float, batch: int) -> None:
        """Train until the time is over, what was trained before included; a checkpoint is kept every minute."""
        progress, saved = self.progress, self.progress.seconds
        before = time.monotonic()
        while progress.seconds < seconds:
            for sample in _split(self._batch(STEPS_AT_ONCE * batch), STEPS_AT_ONCE):
                told = self.step(sample, progress.seconds / seconds)
                if progress.steps % TOLD_EVERY == 0:
                    progress.curve.append({"seconds": progress.seconds, "images": progress.images, **_numbers(told)})
                    print(json.dumps(progress.curve[-1]), flush=True)
                progress.steps, progress.images = progress.steps + 1, progress.images + batch
            now = time.monotonic()
            progress.seconds, before = progress.seconds + now - before, now
            if progress.seconds - saved > SAVED_EVERY_S:
                self.save()
                saved = progress.seconds
        self.save()

    def begin_with(self, weights: Path) -> None:
        """Begin with a network that was trained before, and learn more slowly; a checkpoint that was found stays."""
        self._rate = TRAINED_RATE
        if self.progress.steps == 0:
            content: dict[str, Any] = torch.load(weights, map_location=self._device, weights_only=True)
            self.network.load_state_dict(content["averaged"])
            self.averaged.load_state_dict(content["averaged"])

    def save(self) -> None:
        """Keep all that is needed to go on."""
        content = {
            "network": self.network.state_dict(),
            "averaged": self.averaged.state_dict(),
            "optimiser": self._optimiser.state_dict(),
            "progress": asdict(self.progress),
        }
        _written(content, self._checkpoint)
        _written({name: content[name] for name in ("averaged", "progress")}, self._weights)

    def _resume(self) -> None:
        content: dict[str, Any] = torch.load(self._checkpoint, map_location=self._device, weights_only=True)
        self.network.load_state_dict(content["network"])
        self.averaged.load_state_dict(content["averaged"])
        self._optimiser.load_state_dict(content["optimiser"])
        self.progress = Progress(**content["progress"])

    def step(self, sample: Batch, done: float) -> dict[str, Tensor]:
        """Learn from one batch, when this share of the time is over; give the losses by name."""
        for group in self._optimiser.param_groups:
            group["lr"] = self._rate * min(done / WARM_UP + 0.01, 0.5 + 0.5 * math.cos(math.pi * min(done, 1.0)))
        self.network.train()
        with torch.autocast(self._device.type, torch.bfloat16, enabled=self._device.type == "cuda"):
            told = self._losses(self.network, sample)
        self._optimiser.zero_grad(set_to_none=True)
        sum(told.values(), torch.zeros((), device=self._device)).backward()
        norm = nn.utils.clip_grad_norm_(self.network.parameters(), 5.0)
        if torch.isfinite(norm):  # a step that is not a number would spoil all that was learned
            self._optimiser.step()
        self._average()
        return {name: loss.detach() for name, loss in told.items()}

    @torch.no_grad()
    def _average(self) -> None:
        """Let the averaged weights follow: quickly at first, then by 1/1000 a step."""
        share = max(1.0 - REMEMBERED, 1.0 / (self.progress.steps + 1.0))
        for kept, new in zip(self.averaged.state_dict().values(), self.network.state_dict().values(), strict=True):
            if kept.dtype.is_floating_point:
                kept.lerp_(new.to(kept.dtype), share)
            else:
                kept.copy_(new)


def _split(sample: Batch, parts: int) -> list[Batch]:
    """Divide a record of tensors (B, ...) into as many with (B / parts, ...)."""
    columns = [torch.chunk(getattr(sample, field.name), parts) for field in fields(sample)]
    return [type(sample)(*values) for values in zip(*columns, strict=True)]


def _written(content: dict[str, Any], path: Path) -> None:
    part = path.with_suffix(".part")
    torch.save(content, part)
    part.replace(path)


def _numbers(told: dict[str, Tensor]) -> dict[str, float]:
    return {name: round(float(value), 4) for name, value in told.items()}
