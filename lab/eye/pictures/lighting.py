"""Light on skin and cloth: two lamps, a sky, hollows that are darker, and shine."""

import math

import torch
from torch import Tensor

from lab.eye.arms.views import CropView
from lab.eye.pictures.random_tensors import Draw

WRAP = 0.2  # light scatters under the skin a little way into the shade
CAVITY = (40.0, 260.0)  # by how much 1 m of hollowness darkens
DARKEST, BRIGHTEST = 0.35, 1.15


def random_light(normals: Tensor, hollowness: Tensor, draw: Draw) -> Tensor:
    """Draw lamps, and compute the light (B, F, 3), about 1, that reaches vertices with normals (B, F, 3)."""
    sky = 1.0 + draw.uniform(0.0, 0.7, 1) * (normals @ draw.directions()[..., None])[..., 0]
    light = (sky * draw.uniform(0.15, 0.8, 1))[..., None] * _tint(draw, 0.08)
    for most in (1.1, 0.6):
        lamp = (normals @ draw.directions()[..., None])[..., 0]
        lambert = ((lamp + WRAP) / (1.0 + WRAP)).clamp_min(0.0) * draw.uniform(0.0, most, 1)
        light = light + lambert[..., None] * _tint(draw, 0.12)
    cavity = (1.0 - draw.uniform(*CAVITY, 1) * hollowness).clamp(DARKEST, BRIGHTEST)
    return light * cavity[..., None]


def random_shine(vertices: Tensor, normals: Tensor, view: CropView, draw: Draw) -> Tensor:
    """Draw how skin shines, and compute its highlights (B, F, 1) as the camera sees them."""
    camera = -(view.rotation.transpose(1, 2) @ view.translation[..., None])[..., 0]
    to_camera = torch.nn.functional.normalize(camera[:, None] - vertices, dim=2)
    half = torch.nn.functional.normalize(to_camera + draw.directions()[:, None], dim=2)
    sharpness = torch.exp(draw.uniform(math.log(6.0), math.log(50.0), 1))
    amount = draw.uniform(0.0, 0.3, 1) * draw.chance(0.7, 1)
    return (amount * (normals * half).sum(dim=2).clamp_min(0.0) ** sharpness)[..., None]


def _tint(draw: Draw, deviation: float) -> Tensor:
    """The colour (B, 1, 3) of a lamp, of luminance about 1."""
    return torch.exp(deviation * draw.normal(1, 3))
