"""Trains the eye's networks from nothing, and exports them: `python -m lab.eye train hand --hours 3`."""

import argparse
import os
from pathlib import Path

import torch

from lab.eye.arms.poses import PoseStore, stored_poses
from lab.eye.judging import judge
from lab.eye.judging_finder import judge_finder
from lab.eye.learning import eye_losses
from lab.eye.learning_to_find import finder_losses
from lab.eye.network import FINDER_WIDTH, WIDTHS, EyeNetwork, FinderNetwork
from lab.eye.pictures.backgrounds import Picture, room_tiles
from lab.eye.pictures.hands_in_rooms import FinderSource
from lab.eye.pictures.photographs import installed_photographs
from lab.eye.pictures.samples import SampleSource
from lab.eye.trained import WEIGHTS
from lab.eye.training import Training

FOLDER = Path("build/eye")
BODIES, HELD_OUT_BODIES = 2000, 60
LEARNING_SEED, JUDGING_SEED = 1, 1_000_001
JUDGED_BATCHES = 12


def main() -> None:
    """Read the command line and do what it asks."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # of the processes that draw poses: there is one for each core
    parser = argparse.ArgumentParser(prog="python -m lab.eye", description=__doc__)
    parser.add_argument("command", choices=["draw", "train", "judge", "export"])
    parser.add_argument("kind", choices=["arm", "hand", "finder"], nargs="?", default="arm")
    parser.add_argument("--hours", type=float, default=3.0, help="how long to train, what was trained before included")
    parser.add_argument("--go-on", action="store_true", help="begin with the weights in lab/eye, not from nothing")
    parser.add_argument("--folder", type=Path, default=FOLDER)
    parser.add_argument("--bodies", type=int, default=BODIES, help="how many bodies are drawn, each in 100 postures")
    parser.add_argument("--batch", type=int, default=0, help="pictures at a time; 128 on an accelerator, else 24")
    arguments = parser.parse_args()
    if arguments.command == "export":
        _export()
        return
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    arguments.batch = arguments.batch or (128 if device.type == "cuda" else 24)
    poses = _poses(arguments.folder, arguments.bodies, LEARNING_SEED)
    torch.manual_seed(LEARNING_SEED)
    if arguments.command == "draw":
        _poses(arguments.folder, HELD_OUT_BODIES, JUDGING_SEED)
    elif arguments.kind == "finder":
        _train_finder(arguments, poses, device)
    else:
        _train_eye(arguments, poses, device)


def _train_eye(arguments: argparse.Namespace, poses: PoseStore, device: torch.device) -> None:
    kind, folder = arguments.kind, arguments.folder
    source = SampleSource(poses, _tiles(LEARNING_SEED), kind, device, LEARNING_SEED)
    training = Training(EyeNetwork(WIDTHS[kind]), source.batch, eye_losses, folder / f"{kind}.pt", device)
    if arguments.go_on or arguments.command == "judge":
        training.begin_with(WEIGHTS / f"{kind}.pt")
    if arguments.command == "train":
        training.run(3600.0 * arguments.hours, arguments.batch)
    held_out = _poses(folder, HELD_OUT_BODIES, JUDGING_SEED)
    unseen = SampleSource(held_out, _tiles(JUDGING_SEED), kind, device, JUDGING_SEED)
    _tell(judge(training.averaged, unseen, kind, JUDGED_BATCHES, arguments.batch).text(), folder / f"{kind}.json")


def _train_finder(arguments: argparse.Namespace, poses: PoseStore, device: torch.device) -> None:
    folder = arguments.folder
    source = FinderSource(poses, _tiles(LEARNING_SEED), device, LEARNING_SEED)
    training = Training(FinderNetwork(FINDER_WIDTH), source.batch, finder_losses, folder / "finder.pt", device)
    if arguments.go_on or arguments.command == "judge":
        training.begin_with(WEIGHTS / "finder.pt")
    if arguments.command == "train":
        training.run(3600.0 * arguments.hours, arguments.batch)
    held_out = _poses(folder, HELD_OUT_BODIES, JUDGING_SEED)
    unseen = FinderSource(held_out, _tiles(JUDGING_SEED), device, JUDGING_SEED)
    _tell(judge_finder(training.averaged, unseen, JUDGED_BATCHES, arguments.batch).text(), folder / "finder.json")


def _export() -> None:
    from lab.eye.exporting import export_all  # noqa: PLC0415  # a machine that only trains need not have ONNX

    export_all()


def _tell(text: str, path: Path) -> None:
    path.write_text(text)
    print(text)


def _poses(folder: Path, bodies: int, seed: int) -> PoseStore:
    return stored_poses(folder / f"poses-{seed}-{bodies}.npz", bodies, seed, os.cpu_count() or 1)


def _tiles(seed: int) -> Picture:
    return room_tiles(installed_photographs(), seed)


if __name__ == "__main__":
    main()
