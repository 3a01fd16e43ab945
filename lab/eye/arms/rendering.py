"""Posed arms to pictures: skin moved by bones, and which point of it each pixel shows, for a whole batch at once."""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from lab.eye.arms.surface import CropKind, skin_points
from lab.eye.arms.views import CropView
from lab.films.arm.arm_mesh import load_arm_mesh

NOTHING = (1 << 62) - 1
DEPTH_STEPS = 1 << 30
FARTHEST_M = 8.0
UNUSED_CELLS = 65536  # for points that no pixel shows: in one cell they would wait for each other
HOLE_PX, HOLE_DEPTH_M = 2, 0.008


@dataclass(frozen=True, slots=True)
class SkinRaster:
    """Which point of the surface each pixel shows: its number (B, S, S), -1 where there is none; depth (B, S, S) in m."""

    point: Tensor
    depth: Tensor

    @property
    def covered(self) -> Tensor:
        """Whether (B, S, S) a pixel shows skin or cloth."""
        return self.point >= 0


class SkinRenderer:
    """Moves the skin of batches of arms, and draws it; everything stays on one device."""

    def __init__(self, kind: CropKind, device: torch.device) -> None:
        mesh, samples = load_arm_mesh("average"), skin_points(kind)

        def tensor(values: object, dtype: torch.dtype = torch.float32) -> Tensor:
            return torch.as_tensor(np.asarray(values), dtype=dtype, device=device)

        self._weights = tensor(mesh.weights)
        fine = mesh.fine.tocoo()
        self._fine = torch.sparse_coo_tensor(
            tensor(np.stack(fine.coords), torch.int64), tensor(fine.data), fine.shape, check_invariants=False
        ).coalesce()
        self._triangles = tensor(mesh.triangles, torch.int64)
        self._corners = self._triangles[tensor(samples.triangle, torch.int64)].T.contiguous()  # (3, P)
        self._triangle = tensor(samples.triangle, torch.int64)
        self._barycentric = tensor(samples.barycentric.T)  # (3, P)

    def vertices(self, rest: Tensor, rotations: Tensor, offsets: Tensor) -> Tensor:
        """Move coarse vertices (B, V, 3) at rest with bones (B, K, 3, 3), (B, K, 3); the drawn vertices (B, F, 3)."""
        transforms = torch.cat([rotations.flatten(2), offsets], dim=2)  # (B, K, 12)
        blended = self._weights @ transforms  # (B, V, 12)
        matrices = blended[..., :9].unflatten(2, (3, 3))
        coarse = (matrices @ rest[..., None])[..., 0] + blended[..., 9:]
        return self._made_fine(coarse)

    def normals(self, vertices: Tensor) -> Tensor:
        """Compute the unit normals (B, F, 3) of drawn vertices (B, F, 3), outwards."""
        a, b, c = (vertices[:, self._triangles[:, k]] for k in range(3))
        across = torch.linalg.cross(b - a, c - a)
        normals = torch.zeros_like(vertices)
        for k in range(3):
            normals.index_add_(1, self._triangles[:, k], across)
        return torch.nn.functional.normalize(normals, dim=2)

    def hollowness(self, vertices: Tensor, normals: Tensor) -> Tensor:
        """Compute how far (B, F) in m each vertex lies below the mean of its neighbours."""
        around, count = torch.zeros_like(vertices), torch.zeros(vertices.shape[1], device=vertices.device)
        for one, other in ((0, 1), (1, 2), (2, 0)):
            around.index_add_(1, self._triangles[:, one], vertices[:, self._triangles[:, other]])
            count.index_add_(0, self._triangles[:, one], torch.ones(len(self._triangles), device=vertices.device))
        return ((around / count.clamp_min(1.0)[:, None] - vertices) * normals).sum(dim=2)

    def raster(self, vertices: Tensor, view: CropView, size: int) -> SkinRaster:
        """Draw vertices (B, F, 3) as a view sees them, `size` px wide: the nearest point of each pixel wins."""
        seen = view.project(vertices)  # (B, F, 3)
        facing = self._facing(seen)[:, self._triangle]  # (B, P)
        at = sum(seen[:, self._corners[k]] * self._barycentric[k, :, None] for k in range(3))  # (B, P, 3)
        column, row = (at[..., k].mul(size).floor().long() for k in (0, 1))
        kept = facing & (column >= 0) & (column < size) & (row >= 0) & (row < size) & (at[..., 2] < FARTHEST_M)
        depth = (at[..., 2] * (DEPTH_STEPS / FARTHEST_M)).long()
        number = torch.arange(at.shape[1], device=at.device)
        key = torch.where(kept, (depth << 32) | number, NOTHING)
        cell = torch.where(kept, row * size + column, size * size + number % UNUSED_CELLS)
        cells = torch.full((len(at), size * size + UNUSED_CELLS), NOTHING, dtype=torch.int64, device=at.device)
        cells.scatter_reduce_(1, cell, key, "amin")
        pixels = _filled(cells[:, : size * size].unflatten(1, (size, size)))
        empty = pixels == NOTHING
        point = torch.where(empty, -1, pixels & 0xFFFFFFFF)
        return SkinRaster(point, torch.where(empty, FARTHEST_M, (pixels >> 32) * (FARTHEST_M / DEPTH_STEPS)))

    def pixels(self, raster: SkinRaster, values: Tensor) -> Tensor:
        """Spread values (B, F, C) of vertices over a raster's pixels (B, S, S, C); 0 where there is nothing."""
        point = raster.point.clamp_min(0).flatten(1)  # (B, S S)
        batch = torch.arange(len(point), device=point.device)[:, None]
        spread = sum(
            values[batch, self._corners[k][point]] * self._barycentric[k][point][..., None] for k in range(3)
        )
        size = raster.point.shape[1]
        return spread.unflatten(1, (size, size)) * raster.covered[..., None]

    def _made_fine(self, coarse: Tensor) -> Tensor:
        count = len(coarse)
        columns = coarse.permute(1, 0, 2).reshape(coarse.shape[1], -1)  # the matrix takes columns
        return torch.sparse.mm(self._fine, columns).unflatten(1, (count, 3)).permute(1, 0, 2).contiguous()

    def _facing(self, seen: Tensor) -> Tensor:
        """Whether (B, T) triangles are seen from outside."""
        a, b, c = (seen[:, self._triangles[:, k], :2] for k in range(3))
        return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) < (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])


def _filled(pixels: Tensor) -> Tensor:
    """Give holes, and pixels that see through one, the nearest of their neighbours where three of four lie before."""
    step = int(HOLE_DEPTH_M * DEPTH_STEPS / FARTHEST_M) << 32
    for _ in range(HOLE_PX):
        padded = torch.nn.functional.pad(pixels, (1, 1, 1, 1), value=NOTHING)
        around = torch.stack(
            [padded[:, 1:-1, :-2], padded[:, 1:-1, 2:], padded[:, :-2, 1:-1], padded[:, 2:, 1:-1]]
        )
        hole = (around < pixels - step).sum(dim=0) >= 3
        pixels = torch.where(hole, around.amin(dim=0), pixels)
    return pixels
