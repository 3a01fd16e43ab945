"""How well a finder finds hands in pictures of arms and rooms that it has not seen."""

import json
from dataclasses import asdict, dataclass

import torch
from torch import Tensor

from lab.eye.learning_to_find import COLUMNS
from lab.eye.network import FinderNetwork
from lab.eye.pictures.hands_in_rooms import FinderSample, FinderSource

SURE = 0.35  # a cell that says at least this is taken for a hand
NEAR_ENOUGH = 0.8  # tenths of a metre from the palm's middle


@dataclass(frozen=True, slots=True)
class FinderJudgement:
    """Shares of hands that were found, of those taken for the other side, and of pictures with something found that is
    none; medians of the errors of middle (mm), direction (deg) and size (share) of those that were found."""

    hands: int
    found: float
    other_side: float
    pictures_with_false: float
    middle_mm: float
    direction_deg: float
    size: float

    def text(self) -> str:
        """Write it as JSON."""
        return json.dumps(asdict(self), indent=1)


@torch.no_grad()
def judge_finder(network: FinderNetwork, source: FinderSource, batches: int, size: int) -> FinderJudgement:
    """Measure a finder on new samples of a source."""
    network.eval()
    rows, false = [], []
    for _ in range(batches):
        sample = source.batch(size)
        answer = network(sample.picture)
        rows.append(_of_hands(answer, sample))
        false.append(_false(answer, sample))
    of_hand = torch.cat(rows)
    found = of_hand[of_hand[:, 0] > 0.5]
    return FinderJudgement(
        hands=len(of_hand),
        found=_rounded(of_hand[:, 0].mean()),
        other_side=_rounded(found[:, 1].mean()),
        pictures_with_false=_rounded(torch.cat(false).float().mean()),
        middle_mm=_rounded(found[:, 2].median()),
        direction_deg=_rounded(found[:, 3].median()),
        size=_rounded(found[:, 4].median()),
    )


def _peaks(heat: Tensor) -> Tensor:
    """Which cells (B, 1, H, W) are sure, and surer than all about them."""
    share = torch.sigmoid(heat)
    return (share >= SURE) & (share == torch.nn.functional.max_pool2d(share, 5, 1, 2))


def _middles(answer: Tensor) -> Tensor:
    """Where each cell says that the hand's middle is (B, 2, H, W), in cells."""
    x = torch.arange(answer.shape[3], device=answer.device) + 0.5
    y = torch.arange(answer.shape[2], device=answer.device) + 0.5
    return answer[:, 2:4] + torch.stack(torch.meshgrid(x, y, indexing="xy"))


def _of_hands(answer: Tensor, sample: FinderSample) -> Tensor:
    """Of each hand to be found (N, 5): found, taken for the other side, errors of middle, direction and size."""
    peaks, middles = _peaks(answer[:, :1])[:, 0], _middles(answer)
    rows = []
    for b, k in sample.found.nonzero().tolist():
        unit = COLUMNS * torch.exp(sample.size[b, k])  # a tenth of a metre, in cells
        off = (middles[b] - sample.middle[b, k][:, None, None]).norm(dim=0) / unit
        near = peaks[b] & (off < NEAR_ENOUGH)
        cell = torch.where(near, off, torch.inf).flatten().argmin()
        told = answer[b, :, cell // answer.shape[3], cell % answer.shape[3]]
        cosine = torch.nn.functional.cosine_similarity(told[4:6], sample.direction[b, k], dim=0)
        errors = [
            100.0 * off.flatten()[cell],
            torch.rad2deg(torch.arccos(cosine.clamp(-1, 1))),
            (told[6] - sample.size[b, k]).abs(),
        ]
        other = (told[1] > 0.0) != sample.right[b, k]
        rows.append(torch.stack([near.any().float(), other.float(), *errors]))
    return torch.stack(rows) if rows else torch.empty((0, 5), device=answer.device)


def _false(answer: Tensor, sample: FinderSample) -> Tensor:
    """Whether (B,) something is found far from every hand, those included that were not asked for."""
    off = (_middles(answer)[:, None] - sample.middle[..., None, None]).norm(dim=2)
    near = (off < 2.0 * COLUMNS * torch.exp(sample.size)[..., None, None]).any(dim=1, keepdim=True)
    return (_peaks(answer[:, :1]) & ~near).any(dim=(1, 2, 3))


def _rounded(value: Tensor) -> float:
    return round(float(value), 4)
