"""The networks as they were trained: their weights lie beside this file."""

from pathlib import Path

import torch
from torch import nn

from lab.eye.arms.surface import CropKind
from lab.eye.network import FINDER_WIDTH, WIDTHS, EyeNetwork, FinderNetwork

WEIGHTS = Path(__file__).parent / "weights"


def trained_networks() -> dict[CropKind, EyeNetwork]:
    """Read the networks of arms and of hands, ready to look at pictures."""
    networks = {kind: EyeNetwork(width).eval() for kind, width in WIDTHS.items()}
    for kind, network in networks.items():
        _read(network, kind)
    return networks


def trained_finder() -> FinderNetwork:
    """Read the network that finds hands, ready to look at pictures."""
    network = FinderNetwork(FINDER_WIDTH).eval()
    _read(network, "finder")
    return network


def _read(network: nn.Module, kind: str) -> None:
    network.load_state_dict(torch.load(WEIGHTS / f"{kind}.pt", weights_only=True)["averaged"])
