"""Alterations of a trial: a part replaced by the truth, or by what the thesis had."""

import dataclasses
from typing import Literal

import numpy as np
from msgspec.structs import replace

from common.config.loading import load_config
from common.geometry import Array
from farhand.deployment.shipped import HERE
from local_site.config import LocalConfig
from local_site.tracking.tracker import ArmEstimate
from remote_site.config import RemoteConfig

# Exact are: cameras and tracker; what the operator sees; its hand, then without noise. From the thesis are: errors of
# the fingers; its rate and smoothing. An unseen turn is that of the block in the gripper.
Part = Literal["exact_tracker", "exact_sight", "exact_hand", "thesis_fingers", "unseen_turn", "thesis_rate"]

# Mean and standard deviation of the fingers' errors, m (thesis tables 6.3 to 6.11).
FINGER_ERRORS = {"index": (0.0091, 0.0058), "thumb": (0.0157, 0.0082)}
WANDER_S = 0.5


class FingerErrors:
    """Adds errors as large as the thesis measured to index and thumb: a constant of the trial, and one that wanders.

    Both are in the operator's frame, in which its cameras stand; each direction is as likely as any other.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng, self._t_ns = rng, 0
        directions = {name: rng.standard_normal(3) for name in FINGER_ERRORS}
        self._constant = {n: FINGER_ERRORS[n][0] * d / np.linalg.norm(d) for n, d in directions.items()}
        self._wander = {name: np.zeros(3) for name in FINGER_ERRORS}

    def add(self, estimate: ArmEstimate) -> ArmEstimate:
        """The estimate with both fingers off; a lost one stays as it is."""
        keep = float(np.exp(-(estimate.t_ns - self._t_ns) / 1e9 / WANDER_S))
        self._t_ns = estimate.t_ns
        for name, (_, deviation) in FINGER_ERRORS.items():
            fresh = deviation / np.sqrt(3) * self._rng.standard_normal(3)
            self._wander[name] = keep * self._wander[name] + np.sqrt(1 - keep**2) * fresh
        if estimate.index is None or estimate.thumb is None:
            return estimate
        index, thumb = (self._moved(name, p) for name, p in (("index", estimate.index), ("thumb", estimate.thumb)))
        return dataclasses.replace(estimate, index=index, thumb=thumb)

    def _moved(self, name: str, point: Array) -> Array:
        return np.asarray(point + self._constant[name] + self._wander[name])


def thesis_local() -> LocalConfig:
    """The local site at the thesis's rate."""
    return load_config(LocalConfig, HERE / "sites" / "local-thesis.toml")


def at_thesis_rate(config: RemoteConfig) -> RemoteConfig:
    """The remote site for samples at the thesis's rate."""
    shipped = load_config(RemoteConfig, HERE / "sites" / "remote-thesis.toml")
    engagement = replace(config.engagement, frames=shipped.engagement.frames)
    return replace(config, safety=shipped.safety, engagement=engagement)
