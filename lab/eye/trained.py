"""The networks as they were trained: their weights lie beside this file."""

from pathlib import Path

import torch

from lab.eye.arms.surface import CropKind
from lab.eye.network import WIDTHS, EyeNetwork

WEIGHTS = Path(__file__).parent / "weights"


def trained_networks() -> dict[CropKind, EyeNetwork]:
    """Read the networks of arms and of hands, ready to look at pictures."""
    networks = {kind: EyeNetwork(width).eval() for kind, width in WIDTHS.items()}
    for kind, network in networks.items():
        network.load_state_dict(torch.load(WEIGHTS / f"{kind}.pt", weights_only=True)["averaged"])
    return networks
