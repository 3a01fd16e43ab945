"""Samples to learn from: pictures of crops and what is to be found in them, without end."""

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import avg_pool2d

from lab.eye.arms.poses import PoseStore
from lab.eye.arms.surface import CropKind
from lab.eye.pictures.backgrounds import Picture, Rooms
from lab.eye.pictures.painting import OTHER, ArmPainter
from lab.eye.pictures.random_tensors import Draw
from lab.eye.pictures.scenes import ArmScene, composed, uncovered
from lab.eye.pictures.sensor import filmed, random_borders

MIRRORED = 0.25  # left arms: to be told from right ones, and nothing else is learned of them
SCENES_PER_ARM = 4  # an arm costs more than a room
PARTS_COARSER = 2
MARGIN = 0.02  # how far outside of the crop, in shares of its width, a point is still asked for


@dataclass(frozen=True, slots=True)
class Sample:
    """A batch to learn from.

    `picture` (B, 3, 192, 192), RGB from -1 to 1; `parts` (B, 5, 96, 96) add up to 1; `points` (B, 22, 3), x, y and
    depth against the wrist's in shares of the crop's width; `asked` (B, 22): whether a point is to be found; `seen`
    (B, 22): nothing hides it; `bare` (B,): a bare hand is there; `right` (B,): it is a right one; `tone` (B,), 0 to 9.
    """

    picture: Tensor
    parts: Tensor
    points: Tensor
    asked: Tensor
    seen: Tensor
    bare: Tensor
    right: Tensor
    tone: Tensor


class SampleSource:
    """Makes batches on one device; the same ones for the same seed there."""

    def __init__(self, poses: PoseStore, tiles: Picture, kind: CropKind, device: torch.device, seed: int) -> None:
        self._painter = ArmPainter(poses, kind, device)
        self._rooms = Rooms(tiles, device)
        self._random = torch.Generator(device).manual_seed(seed)

    @torch.no_grad()
    def batch(self, count: int) -> Sample:
        """Make a batch of new samples, of a number that four divides."""
        arms = Draw(max(count // SCENES_PER_ARM, 1), self._random)
        draw = Draw(arms.count * SCENES_PER_ARM, self._random)
        scene = composed(self._painter.paint(arms).repeated(SCENES_PER_ARM), self._rooms, draw)
        return _sample(scene, filmed(scene.colour, draw), draw)


def _sample(scene: ArmScene, picture: Tensor, draw: Draw) -> Sample:
    mirrored = draw.chance(MIRRORED)
    flip = mirrored[:, None, None, None]
    inside = random_borders(picture.shape[2], draw)
    picture = picture * inside
    parts = scene.parts * inside
    parts[:, OTHER] += 1.0 - inside[:, 0]
    parts = avg_pool2d(parts, PARTS_COARSER)
    at = scene.points[..., :2]
    near = ((at > -MARGIN) & (at < 1.0 + MARGIN)).all(dim=2)
    return Sample(
        picture=torch.where(flip, picture.flip(3), picture) * 2.0 - 1.0,
        parts=torch.where(flip, parts.flip(3), parts),
        points=scene.points,
        asked=near & (scene.bare_arm & ~mirrored)[:, None],
        seen=scene.seen & uncovered(inside, scene.points),
        bare=scene.bare_arm,
        right=~mirrored,
        tone=scene.tone,
    )
