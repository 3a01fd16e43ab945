"""Views of a posed arm: a camera anywhere about it, and the crop that a tracker which follows it would cut out."""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from lab.eye.arms.surface import CropKind
from local_site.tracking.eye.arm_points import INDEX_KNUCKLE, LITTLE_KNUCKLE, MIDDLE_KNUCKLE, WRIST
from local_site.tracking.eye.crops import ARM_M, HAND_M

CROP_M: dict[CropKind, float] = {
    "arm": ARM_M,
    "hand": HAND_M,
    "whole": 1.1,
}  # what the width of a crop shows, at the wrist's depth
DISTANCE_M = (0.4, 3.5)
OFF_AXIS = 0.55  # how far from the picture's middle, as a tangent
# How badly a crop may lie: what follows is close most of the time, what was just found is not.
TURN_DEG, LOST_TURN_DEG = 16.0, 80.0
SHIFT, LOST_SHIFT = 0.09, 0.18  # of the crop's width
GROWTH, LOST_GROWTH = 0.10, 0.30  # deviation of the size's logarithm
LOST = 0.08  # the share of crops that lie badly


@dataclass(frozen=True, slots=True)
class CropView:
    """Cameras and crops of B pictures: p_cam = rotation p + translation, in m, z ahead, y down.

    A point is seen at `middle` + turn (xy / z - `centre`), in shares of the crop's width from its upper left corner.
    """

    rotation: Tensor  # (B, 3, 3)
    translation: Tensor  # (B, 3)
    centre: Tensor  # (B, 2)
    turn: Tensor  # (B, 2, 2)
    metres: Tensor  # (B,): what the crop's width shows at the wrist's depth

    def project(self, points: Tensor) -> Tensor:
        """Project points (B, N, 3): x and y in shares of the crop's width, and the depth in m (B, N, 3)."""
        seen = points @ self.rotation.transpose(1, 2) + self.translation[:, None]
        depth = seen[..., 2:].clamp_min(0.05)
        flat = (seen[..., :2] / depth - self.centre[:, None]) @ self.turn.transpose(1, 2)
        return torch.cat([0.5 + flat, depth], dim=-1)


def random_views(points: Tensor, kind: CropKind, random: torch.Generator) -> CropView:
    """Draw a camera and a crop for each arm with points (B, 22, 3): wrist to middle knuckle points up, about."""
    count, device = len(points), points.device

    def normal(*shape: int) -> Tensor:
        return torch.randn(*shape, generator=random, device=device)

    def uniform(*shape: int) -> Tensor:
        return torch.rand(*shape, generator=random, device=device)

    rotation = _rotations(normal(count, 4))
    low, high = (math.log(d) for d in DISTANCE_M)
    distance = torch.exp(low + (high - low) * uniform(count))
    off_axis = OFF_AXIS * (2.0 * uniform(count, 2) - 1.0)
    wrist_in_camera = distance[:, None] * torch.cat([off_axis, torch.ones(count, 1, device=device)], dim=1)
    translation = wrist_in_camera - (rotation @ points[:, WRIST, :, None])[..., 0]
    seen = points @ rotation.transpose(1, 2) + translation[:, None]
    flat = seen[..., :2] / seen[..., 2:].clamp_min(0.05)
    lost = uniform(count) < LOST
    up = flat[:, MIDDLE_KNUCKLE] - flat[:, WRIST]
    angle = torch.atan2(up[:, 0], -up[:, 1])  # how far the hand points to the right of up
    spread = math.radians(1.0) * torch.where(
        lost, LOST_TURN_DEG * (2.0 * uniform(count) - 1.0), TURN_DEG * normal(count)
    )
    metres = CROP_M[kind] * torch.exp(torch.where(lost, LOST_GROWTH, GROWTH) * normal(count))
    turn = _turns(spread - angle) * (distance / metres)[:, None, None]
    shift = torch.where(lost, LOST_SHIFT, SHIFT)[:, None] * (2.0 * uniform(count, 2) - 1.0)
    centre = _middle(flat, kind) + (torch.linalg.inv(turn) @ shift[..., None])[..., 0]
    return CropView(rotation, translation, centre, turn, metres)


def _middle(flat: Tensor, kind: CropKind) -> Tensor:
    """Where the crop's middle lies: the wrist, or the middle of the palm's knuckles."""
    if kind != "hand":
        return flat[:, WRIST]
    return (flat[:, INDEX_KNUCKLE] + flat[:, MIDDLE_KNUCKLE] + flat[:, LITTLE_KNUCKLE]) / 3.0


def _rotations(quaternions: Tensor) -> Tensor:
    """The rotations (B, 3, 3) of quaternions (B, 4) of any length: all rotations alike of normal ones."""
    w, x, y, z = (quaternions / quaternions.norm(dim=1, keepdim=True)).unbind(1)
    rows = [
        torch.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], dim=1),
        torch.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], dim=1),
        torch.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], dim=1),
    ]
    return torch.stack(rows, dim=1)


def _turns(angle: Tensor) -> Tensor:
    """The turns (B, 2, 2) by angles (B,) in rad, clockwise as one sees the picture."""
    cos, sin = torch.cos(angle), torch.sin(angle)
    return torch.stack([torch.stack([cos, -sin], dim=1), torch.stack([sin, cos], dim=1)], dim=1)
