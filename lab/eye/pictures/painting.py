"""Drawn arms as layers: colour, coverage, parts and points of a batch, ready to be laid over a room."""

from dataclasses import dataclass, fields

import torch
from torch import Tensor
from torch.nn.functional import avg_pool2d, grid_sample

from lab.eye.arms.poses import PoseStore
from lab.eye.arms.rendering import SkinRaster, SkinRenderer
from lab.eye.arms.surface import CropKind, skin_attributes
from lab.eye.arms.views import CropView, random_views
from lab.eye.pictures.clothes import Clothes, WornSurface, covered_by_cloth, dressed, random_clothes, swell
from lab.eye.pictures.lighting import random_light, random_shine
from lab.eye.pictures.random_tensors import Draw
from lab.eye.pictures.skin_tones import TONES, SkinColours
from local_site.tracking.eye.arm_points import ELBOW, POINTS, WRIST
from local_site.tracking.eye.crops import CROP_PX

OTHER, HAND, FOREARM, UPPER_ARM, CLOTH = range(5)
CLASSES = 5
SIZE = CROP_PX
FINER = 2  # pixels are drawn this much finer, and averaged
FINGER_DEPTH_M, WRIST_DEPTH_M, ELBOW_DEPTH_M = (
    0.022,
    0.05,
    0.07,
)  # how deep in the flesh a point lies that still is seen


@dataclass(frozen=True, slots=True)
class ArmLayer:
    """A batch of arms: colour (B, 3, S, S), linear RGB times coverage; parts (B, 5, S, S), which add up to 1.

    Points (B, 22, 3): x, y and depth against the wrist's, all in shares of the crop's width; `seen` (B, 22) whether
    nothing of the arm itself hides a point; `bare` (B,): no glove; `tone` (B,) from 0, the palest, to 9; `metres` (B,)
    what the crop's width shows at the wrist's depth.
    """

    colour: Tensor
    parts: Tensor
    points: Tensor
    seen: Tensor
    bare: Tensor
    tone: Tensor
    metres: Tensor

    def repeated(self, times: int) -> "ArmLayer":
        """Repeat the whole batch, so that each arm can be laid over several rooms."""
        parts = (getattr(self, field.name) for field in fields(self))
        return ArmLayer(*(part.repeat(times, *(1,) * (part.ndim - 1)) for part in parts))

    @property
    def coverage(self) -> Tensor:
        """How much (B, 1, S, S) of each pixel the arm covers."""
        return 1.0 - self.parts[:, OTHER : OTHER + 1]


class ArmPainter:
    """Paints batches of arms from a store of poses, each seen, lit and clad in its own way."""

    def __init__(self, poses: PoseStore, kind: CropKind, device: torch.device) -> None:
        self._rest, self._rotations, self._offsets, self._points = (
            torch.as_tensor(part, device=device)
            for part in (poses.vertices, poses.rotations, poses.offsets, poses.points)
        )
        self._body = torch.as_tensor(poses.body, dtype=torch.int64, device=device)
        self._kind = kind
        self._skin = skin_attributes()
        self._renderer = SkinRenderer(kind, device)
        self._colours = SkinColours(self._skin, device)
        fields = (self._skin.along, self._skin.around, self._skin.digit, self._skin.along_digit)
        self._worn = torch.stack([torch.as_tensor(field, dtype=torch.float32, device=device) for field in fields], 1)

    def paint(self, draw: Draw) -> ArmLayer:
        """Paint as many arms as are drawn for."""
        pose = torch.randint(len(self._body), (draw.count,), generator=draw.random, device=draw.random.device)
        points = self._points[pose]
        view = random_views(points, self._kind, draw.random)
        clothes = random_clothes(draw)
        vertices, normals = self._surface(pose, clothes, draw)
        raster = self._renderer.raster(vertices, view, SIZE * FINER)
        tone = draw.uniform(0.0, TONES - 1.0)
        colour, cloth, worn = self._coloured(raster, vertices, normals, view, clothes, tone, draw)
        projected = view.project(points)
        return ArmLayer(
            colour=_averaged(colour),
            parts=_averaged(_parts(worn.along, cloth, raster.covered)),
            points=_relative(projected, view),
            seen=_seen(projected, raster),
            bare=~clothes.gloved,
            tone=tone,
            metres=view.metres,
        )

    def _surface(self, pose: Tensor, clothes: Clothes, draw: Draw) -> tuple[Tensor, Tensor]:
        """The skin's and cloth's vertices (B, F, 3) in m, and their normals."""
        rest = self._rest[self._body[pose]]
        skin = self._renderer.vertices(rest, self._rotations[pose], self._offsets[pose])
        swollen = swell(skin, self._renderer.normals(skin), clothes, self._skin, draw)
        return swollen, self._renderer.normals(swollen)

    def _coloured(
        self,
        raster: SkinRaster,
        vertices: Tensor,
        normals: Tensor,
        view: CropView,
        clothes: Clothes,
        tone: Tensor,
        draw: Draw,
    ) -> tuple[Tensor, Tensor, WornSurface]:
        """Linear RGB times coverage (B, S, S, 3); which pixels show cloth; where each lies on the arm."""
        light = random_light(normals, self._renderer.hollowness(vertices, normals), draw)
        shine = random_shine(vertices, normals, view, draw)
        worn = self._worn.expand(draw.count, -1, -1)
        values = torch.cat([self._colours.albedo(tone, draw), light, shine, worn], dim=2)
        albedo, lit, gloss, where = self._renderer.pixels(raster, values).split([3, 3, 1, 4], dim=3)
        surface = WornSurface(*where.split(1, dim=3))
        cloth = covered_by_cloth(surface, clothes, draw) & raster.covered[..., None]
        colour = dressed(albedo, surface, cloth, draw) * lit + torch.where(cloth, 0.0, gloss)
        return colour * raster.covered[..., None], cloth, surface


def _parts(along: Tensor, cloth: Tensor, covered: Tensor) -> Tensor:
    """Which part each pixel (B, S, S, 5) shows, as 0 or 1."""
    part = torch.where(along[..., 0] > 2.0, HAND, torch.where(along[..., 0] > 1.0, FOREARM, UPPER_ARM))
    part = torch.where(cloth[..., 0], CLOTH, part)
    return torch.nn.functional.one_hot(torch.where(covered, part, OTHER), CLASSES).float()


def _averaged(pixels: Tensor) -> Tensor:
    """Average fine pixels (B, F S, F S, C) to a layer (B, C, S, S)."""
    return avg_pool2d(pixels.permute(0, 3, 1, 2), FINER)


def _relative(projected: Tensor, view: CropView) -> Tensor:
    depth = (projected[..., 2] - projected[:, WRIST : WRIST + 1, 2]) / view.metres[:, None]
    return torch.cat([projected[..., :2], depth[..., None]], dim=2)


def _seen(projected: Tensor, raster: SkinRaster) -> Tensor:
    """Whether (B, 22) the surface that hides a point lies hardly before it, in the picture."""
    at = (2.0 * projected[..., :2] - 1.0)[:, None]  # (B, 1, 22, 2), as grid_sample counts
    surface = grid_sample(raster.depth[:, None].float(), at, mode="nearest", padding_mode="border", align_corners=False)
    margin = torch.full((POINTS,), FINGER_DEPTH_M, device=projected.device)
    margin[ELBOW], margin[WRIST] = ELBOW_DEPTH_M, WRIST_DEPTH_M
    inside = ((projected[..., :2] > 0.0) & (projected[..., :2] < 1.0)).all(dim=2)
    return inside & (projected[..., 2] < surface[:, 0, 0] + margin)
