"""The trained networks as files of 8 bits, which the tracker reads: `python -m lab.eye export`."""

import os
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import onnxruntime
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from lab.eye.arms.poses import draw_poses
from lab.eye.export import PICTURE, export_network, quantise
from lab.eye.network import EyeNetwork, FinderNetwork
from lab.eye.pictures.backgrounds import room_tiles
from lab.eye.pictures.hands_in_rooms import CELL_PX, FinderSample, FinderSource
from lab.eye.pictures.painting import SIZE
from lab.eye.pictures.photographs import installed_photographs
from lab.eye.pictures.samples import Sample, SampleSource
from lab.eye.trained import trained_finder, trained_networks

MODELS = Path(__file__).parents[2] / "local_site/tracking/eye/models"
EYE_OUTPUTS, FINDER_OUTPUTS = ["parts", "points", "whole"], ["cells"]
BODIES, SEED = 6, 2_000_001  # neither trained nor judged on
CALIBRATED, COMPARED = 64, 32  # drawn pictures


def export_all(folder: Path = MODELS) -> None:
    """Write the three networks into a folder, and print how large each is and how far 8 bits move its points."""
    poses, tiles = draw_poses(BODIES, SEED, os.cpu_count() or 1), room_tiles(installed_photographs(), SEED)
    device = torch.device("cpu")
    folder.mkdir(parents=True, exist_ok=True)
    for kind, network in trained_networks().items():
        path, source = folder / f"{kind}.onnx", SampleSource(poses, tiles, kind, device, SEED)
        write_of_8_bits(network, EYE_OUTPUTS, source.batch(CALIBRATED).picture, path)
        _tell(path, moved_points(network, path, source.batch(COMPARED)))
    path, finder, pictures = folder / "finder.onnx", trained_finder(), FinderSource(poses, tiles, device, SEED)
    write_of_8_bits(finder, FINDER_OUTPUTS, pictures.batch(CALIBRATED).picture, path)
    _tell(path, moved_middles(finder, path, pictures.batch(COMPARED)))


def write_of_8_bits(network: nn.Module, outputs: list[str], pictures: Tensor, path: Path) -> None:
    """Write a network of 8 bits, whose ranges are taken from pictures (B, 3, H, W)."""
    with TemporaryDirectory() as folder:
        whole = Path(folder) / "whole.onnx"
        export_network(network, (pictures.shape[2], pictures.shape[3]), outputs, whole)
        quantise(whole, [picture[None].numpy() for picture in pictures], path)


@torch.no_grad()
def moved_points(network: EyeNetwork, path: Path, sample: Sample) -> Tensor:
    """Measure in px how far a file's points lie from its network's, of those that are asked for (N,)."""
    told = torch.from_numpy(told_by_file(path, sample.picture, "points"))
    off = told[..., :2] - network(sample.picture)[1][..., :2]
    return SIZE * off.norm(dim=2)[sample.asked]


@torch.no_grad()
def moved_middles(network: FinderNetwork, path: Path, sample: FinderSample) -> Tensor:
    """Measure in px how far a file's middles of hands lie from its network's, where hands are to be found (N,)."""
    off = torch.from_numpy(told_by_file(path, sample.picture, "cells")) - network(sample.picture)
    picture, hand = sample.found.nonzero(as_tuple=True)
    x, y = sample.middle[picture, hand].long().unbind(dim=1)  # of a hand at the border, it may lie outside
    x, y = x.clamp(0, off.shape[3] - 1), y.clamp(0, off.shape[2] - 1)
    return CELL_PX * off[picture, 2:4, y, x].norm(dim=1)


def told_by_file(path: Path, pictures: Tensor, output: str) -> NDArray[np.float32]:
    """Give what a file's network says of pictures (B, 3, H, W) in one of its outputs (B, ...)."""
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    told = [session.run([output], {PICTURE: picture[None].numpy()})[0] for picture in pictures]
    return np.concatenate(told)


def _tell(path: Path, moved: Tensor) -> None:
    kilobytes = path.stat().st_size / 1000.0
    print(f"{path.stem}: {kilobytes:.0f} kB, points moved by {float(moved.median()):.2f} px in the median", flush=True)
