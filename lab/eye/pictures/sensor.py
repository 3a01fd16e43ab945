"""What a camera makes of a scene: exposure, colour, blur, few pixels, noise, grey, and JPEG."""

import math

import torch
from torch import Tensor
from torch.nn.functional import conv2d, grid_sample, interpolate, pad

from lab.eye.pictures.random_tensors import Draw

GREY, COMPRESSED, SHAKEN, BORDERED = 0.12, 0.6, 0.2, 0.15
SHAKEN_PX = 3.0
COARSEST = 0.22  # of the crop's pixels, those that a far hand has in the picture
FARTHEST_BLUR_PX = 2.2
BLUR_RADIUS = 9
MOTION_STEPS = 7

# ITU-T T.81, annex K: the quantisation tables that most encoders scale.
_LUMINANCE = """
16 11 10 16 24 40 51 61 12 12 14 19 26 58 60 55 14 13 16 24 40 57 69 56 14 17 22 29 51 87 80 62
18 22 37 56 68 109 103 77 24 35 55 64 81 104 113 92 49 64 78 87 103 121 120 101 72 92 95 98 112 100 103 99
"""
_CHROMINANCE = """
17 18 24 47 99 99 99 99 18 21 26 66 99 99 99 99 24 26 56 99 99 99 99 99 47 66 99 99 99 99 99 99
99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99
"""


def filmed(colour: Tensor, draw: Draw) -> Tensor:
    """Film scenes (B, 3, S, S), linear RGB: pictures (B, 3, S, S), sRGB from 0 to 1."""
    light = _exposed(colour, draw)
    shaken, some = draw.some(SHAKEN)
    light = light.index_copy(0, shaken, moved(light[shaken], some, SHAKEN_PX))
    light = blurred(light, draw.uniform(0.0, 1.0) ** 2 * FARTHEST_BLUR_PX)
    light = _with_few_pixels(light, draw)
    picture = _encoded(_noisy(light.clamp(0.0, 1.0), draw), draw)
    which, some = draw.some(COMPRESSED)
    picture = picture.index_copy(0, which, compressed(picture[which], some.uniform(25.0, 96.0)))
    grey = picture.mean(dim=1, keepdim=True).expand(-1, 3, -1, -1)
    return torch.where(draw.chance(GREY, 1, 1, 1), grey, picture)


def random_borders(size: int, draw: Draw) -> Tensor:
    """Draw which pixels (B, 1, S, S) of crops lie inside of the camera's picture, 1 or 0: most of them, all."""
    at = torch.linspace(-1.0, 1.0, size, device=draw.random.device)
    angle = 0.5 * math.pi * draw.integers(4, 1, 1, 1) + 0.3 * draw.normal(1, 1, 1)
    side = torch.cos(angle) * at[None, None, None, :] + torch.sin(angle) * at[None, None, :, None]
    beyond = (side > draw.uniform(0.2, 1.0, 1, 1, 1)) & draw.chance(BORDERED, 1, 1, 1)
    return (~beyond).float()


def blurred(picture: Tensor, sigma: Tensor) -> Tensor:
    """Blur pictures (B, C, S, S), each by a Gaussian of its own deviation (B,) in px, at most about 8."""
    count, channels = picture.shape[:2]
    at = torch.arange(-BLUR_RADIUS, BLUR_RADIUS + 1, device=picture.device)
    kernel = torch.exp(-0.5 * (at / sigma.clamp_min(0.05)[:, None]) ** 2)
    kernel = (kernel / kernel.sum(dim=1, keepdim=True)).repeat_interleave(channels, dim=0)
    flat = picture.reshape(1, count * channels, *picture.shape[2:])
    flat = conv2d(pad(flat, (BLUR_RADIUS,) * 2 + (0, 0), "replicate"), kernel[:, None, None], groups=count * channels)
    flat = conv2d(
        pad(flat, (0, 0) + (BLUR_RADIUS,) * 2, "replicate"), kernel[:, None, :, None], groups=count * channels
    )
    return flat.reshape(picture.shape)


def moved(light: Tensor, draw: Draw, most_px: float) -> Tensor:
    """Average pictures (B, C, S, S) along a short way, each its own, as of what moves while a camera exposes."""
    size = light.shape[2]
    at = torch.linspace(-1.0, 1.0, size, device=light.device)
    grid = torch.stack(torch.meshgrid(at, at, indexing="xy"), dim=2)[None]
    way = draw.normal(1, 1, 2) * draw.uniform(0.0, most_px, 1, 1, 1) * 2.0 / size
    total = torch.zeros_like(light)
    for share in torch.linspace(-1.0, 1.0, MOTION_STEPS).tolist():
        total = total + grid_sample(light, grid + share * way, padding_mode="border", align_corners=True)
    return total / MOTION_STEPS


def compressed(picture: Tensor, quality: Tensor) -> Tensor:
    """Compress pictures (B, 3, S, S), 0 to 1, as JPEG does at a quality (B,) from 1 to 100; colours are halved."""
    y, cb, cr = _to_ycbcr(255.0 * picture)
    scale = torch.where(quality < 50.0, 50.0 / quality, 2.0 - quality / 50.0)[:, None, None, None, None]
    luma = _quantised(y - 128.0, _LUMINANCE, scale)
    small = [torch.nn.functional.avg_pool2d(c[:, None], 2)[:, 0] for c in (cb, cr)]
    chroma = [interpolate(_quantised(c, _CHROMINANCE, scale)[:, None], scale_factor=2.0)[:, 0] for c in small]
    return (_to_rgb(luma + 128.0, *chroma) / 255.0).clamp(0.0, 1.0)


def _exposed(colour: Tensor, draw: Draw) -> Tensor:
    """Automatic exposure and white balance, each off by some, and a lens that darkens one side."""
    level = colour.mean(dim=(1, 2, 3), keepdim=True).clamp_min(0.02)
    aimed = (0.25 / level) ** draw.uniform(0.0, 1.0, 1, 1, 1)
    gain = aimed * torch.exp(0.35 * draw.normal(1, 1, 1)) * torch.exp(0.10 * draw.normal(3, 1, 1))
    at = torch.linspace(-1.0, 1.0, colour.shape[2], device=colour.device)
    tilt = draw.uniform(-0.3, 0.3, 2, 1, 1)
    return colour * gain * (1.0 + tilt[:, :1] * at[None, None, None, :] + tilt[:, 1:] * at[None, None, :, None])


def _with_few_pixels(light: Tensor, draw: Draw) -> Tensor:
    """As if the crop had fewer pixels in the camera's picture; one size for a group of samples."""
    groups = []
    for part in light.chunk(8):
        share = torch.rand((), generator=draw.random, device=light.device).item()
        size = int(light.shape[2] * (COARSEST + (1.0 - COARSEST) * min(1.4 * share, 1.0)))
        small = interpolate(part, size=(size, size), mode="area")
        groups.append(interpolate(small, size=part.shape[2:], mode="bilinear", align_corners=False))
    return torch.cat(groups)


def _noisy(light: Tensor, draw: Draw) -> Tensor:
    """Noise of photons and of the amplifier, some of it as blotches over several pixels."""
    noise = torch.randn(light.shape, generator=draw.random, device=light.device)
    coarse = interpolate(noise[:, :, ::2, ::2], scale_factor=2.0, mode="bilinear", align_corners=False)
    noise = torch.where(draw.chance(0.5, 1, 1, 1), noise, 1.3 * coarse)
    strength = draw.uniform(0.0, 1.0, 1, 1, 1) ** 2
    return light + noise * strength * torch.sqrt(0.0025 * light + 2e-4)


def _encoded(light: Tensor, draw: Draw) -> Tensor:
    """Gamma and contrast as cameras differ in them, and sharpening."""
    gamma = light.clamp_min(1e-4) ** (1.0 / draw.uniform(1.9, 2.6, 1, 1, 1))
    contrast = 0.5 + (gamma - 0.5) * draw.uniform(0.8, 1.25, 1, 1, 1)
    soft = blurred(contrast, torch.full((len(light),), 1.0, device=light.device))
    return (contrast + draw.uniform(-0.3, 0.9, 1, 1, 1).clamp_min(0.0) * (contrast - soft)).clamp(0.0, 1.0)


def _to_ycbcr(rgb: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    r, g, b = rgb.unbind(1)
    y = 0.299 * r + 0.587 * g + 0.114 * b
    return y, 0.564 * (b - y), 0.713 * (r - y)


def _to_rgb(y: Tensor, cb: Tensor, cr: Tensor) -> Tensor:
    return torch.stack([y + 1.402 * cr, y - 0.344 * cb - 0.714 * cr, y + 1.772 * cb], dim=1)


def _quantised(plane: Tensor, table: str, scale: Tensor) -> Tensor:
    """Round the cosine transform of each block of 8 × 8 px of a plane (B, S, S) to multiples of a scaled table."""
    steps = torch.tensor([float(step) for step in table.split()], device=plane.device).reshape(8, 8)
    k = torch.arange(8, device=plane.device, dtype=plane.dtype)
    cosines = torch.cos(math.pi / 8.0 * k[:, None] * (k[None, :] + 0.5)) * 0.5
    cosines[0] /= math.sqrt(2.0)
    count, size = len(plane), plane.shape[1]
    blocks = plane.reshape(count, size // 8, 8, size // 8, 8).transpose(2, 3)
    step = (steps * scale).clamp_min(1.0)
    rounded = torch.round(cosines @ blocks @ cosines.T / step) * step
    return (cosines.T @ rounded @ cosines).transpose(2, 3).reshape(count, size, size)
