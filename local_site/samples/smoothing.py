"""Smooths the tracked arm over time: the One Euro filter, or the mean of the last frames for comparison."""

import math
from collections import deque
from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta, Struct

from common.clock import NS_PER_S
from common.geometry import Array, hand_rotation, rotation_from_vector, vector_from_rotation
from common.messages.hand import TrackingStatus
from local_site.samples.jumps import JumpGate, Smoother
from local_site.tracking.tracker import ArmEstimate

POINTS = ("elbow", "wrist", "index", "thumb")


class SmoothingConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the tracked points are smoothed."""

    method: Literal["one_euro", "mean"] = "one_euro"
    min_cutoff_hz: Annotated[float, Meta(gt=0, le=100, description="cut-off at rest: lower is calmer")] = 1.0
    beta_per_m: Annotated[float, Meta(ge=0, le=1000, description="rise of the cut-off with speed, Hz per m/s")] = 8.0
    beta_per_rad: Annotated[
        float, Meta(ge=0, le=1000, description="rise of the cut-off with turning, Hz per rad/s")
    ] = 1.5
    speed_cutoff_hz: Annotated[float, Meta(gt=0, le=100, description="cut-off of the speed itself")] = 1.0
    mean_frames: Annotated[int, Meta(ge=1, le=100, description="window of the mean; the thesis takes 9")] = 9
    jump_m_s: Annotated[
        float, Meta(gt=0, le=20, description="a faster wrist is a jump: sent as it is, for the remote site to refuse")
    ] = 3.0
    jump_noise_m: Annotated[float, Meta(ge=0, le=0.2, description="added to the jump limit for noise, m")] = 0.03
    max_gap_s: Annotated[float, Meta(gt=0, le=10, description="a point absent for longer starts anew")] = 0.2


def make_smoother(config: SmoothingConfig) -> Smoother:
    """The smoother that the configuration asks for."""
    smoother = ArmMean(config) if config.method == "mean" else ArmOneEuro(config)
    return JumpGate(smoother, config.jump_m_s, config.jump_noise_m)


class OneEuro:
    """The One Euro filter (Casiez, Roussel and Vogel 2012) of a vector, its cut-off rising with the vector's speed."""

    def __init__(self, config: SmoothingConfig, beta: float) -> None:
        self._config = config
        self._beta = beta
        self._speed: Array | None = None
        self._t_ns = 0

    def reset(self) -> None:
        """Start anew with the next value."""
        self._speed = None

    def share(self, t_ns: int, change: Array) -> float:
        """How much of `change`, the new value less the smoothed one, is to be taken over; 1 at the start."""
        dt_s = (t_ns - self._t_ns) / NS_PER_S
        self._t_ns = t_ns
        if self._speed is None or not 0.0 < dt_s <= self._config.max_gap_s:
            self._speed = np.zeros_like(change)
            return 1.0
        self._speed = self._speed + _share(self._config.speed_cutoff_hz, dt_s) * (change / dt_s - self._speed)
        speed = math.sqrt(float(self._speed @ self._speed))
        return _share(self._config.min_cutoff_hz + self._beta * speed, dt_s)


def _share(cutoff_hz: float, dt_s: float) -> float:
    return 1.0 / (1.0 + 1.0 / (2.0 * math.pi * cutoff_hz * dt_s))


class PointFilter:
    """One Euro on a point (3,) in m; an absent point stays absent and ends what was known of it."""

    def __init__(self, config: SmoothingConfig) -> None:
        self._filter = OneEuro(config, config.beta_per_m)
        self._value = np.zeros(3)

    def smooth(self, t_ns: int, point: Array | None) -> Array | None:
        """The smoothed point."""
        if point is None:
            self._filter.reset()
            return None
        change = point - self._value
        self._value = self._value + self._filter.share(t_ns, change) * change
        return self._value


class RotationFilter:
    """One Euro on a rotation (3, 3), along the shortest turn from the smoothed to the new one."""

    def __init__(self, config: SmoothingConfig) -> None:
        self._filter = OneEuro(config, config.beta_per_rad)
        self._value = np.eye(3)

    def smooth(self, t_ns: int, rotation: Array | None) -> Array | None:
        """The smoothed rotation."""
        if rotation is None:
            self._filter.reset()
            return None
        change = vector_from_rotation(self._value.T @ rotation)
        self._value = self._value @ rotation_from_vector(self._filter.share(t_ns, change) * change)
        return self._value


class ArmOneEuro:
    """One Euro on elbow, wrist, palm, the hand's rotation, and the tips in the hand's frame.

    So a turning hand keeps its size: its tips move on arcs about the wrist, not on chords.
    """

    def __init__(self, config: SmoothingConfig) -> None:
        self._config = config
        self._reset()

    def smooth(self, estimate: ArmEstimate) -> ArmEstimate:
        """The estimate with smoothed points."""
        if estimate.status is TrackingStatus.LOST:
            self._reset()
            return estimate
        elbow = self._elbow.smooth(estimate.t_ns, estimate.elbow)
        wrist = self._wrist.smooth(estimate.t_ns, estimate.wrist)
        palm = self._palm.smooth(estimate.t_ns, estimate.palm)
        index, thumb = self._tips(estimate, wrist)
        return replace(estimate, elbow=elbow, wrist=wrist, index=index, thumb=thumb, palm=palm)

    def _tips(self, estimate: ArmEstimate, wrist: Array | None) -> tuple[Array | None, Array | None]:
        """Index and thumb about the smoothed wrist; as they are while the three points give no rotation."""
        t_ns, raw = estimate.t_ns, (estimate.index, estimate.thumb)
        rotation = self._rotation.smooth(t_ns, raw_rotation := _rotation(estimate))
        offsets = [
            tip_filter.smooth(t_ns, _in_hand(raw_rotation, estimate.wrist, tip))
            for tip_filter, tip in zip(self._offsets, raw, strict=True)
        ]
        if wrist is None or rotation is None:
            return raw
        index, thumb = (None if offset is None else wrist + rotation @ offset for offset in offsets)
        return index, thumb

    def _reset(self) -> None:
        self._elbow, self._wrist, self._palm = (PointFilter(self._config) for _ in range(3))
        self._rotation = RotationFilter(self._config)
        self._offsets = (PointFilter(self._config), PointFilter(self._config))


def _rotation(estimate: ArmEstimate) -> Array | None:
    if estimate.wrist is None or estimate.index is None or estimate.thumb is None:
        return None
    return hand_rotation(estimate.wrist, estimate.index, estimate.thumb)


def _in_hand(rotation: Array | None, wrist: Array | None, tip: Array | None) -> Array | None:
    return None if rotation is None or wrist is None or tip is None else rotation.T @ (tip - wrist)


class ArmMean:
    """The mean of each point over the last frames, as in the thesis's teleoperation."""

    def __init__(self, config: SmoothingConfig) -> None:
        self._config = config
        self._last_ns = 0
        self._windows = {name: deque[Array](maxlen=config.mean_frames) for name in (*POINTS, "palm")}

    def smooth(self, estimate: ArmEstimate) -> ArmEstimate:
        """The estimate with each point averaged over the frames in which it was present without a gap."""
        lost = estimate.status is TrackingStatus.LOST
        if lost or estimate.t_ns - self._last_ns > self._config.max_gap_s * NS_PER_S:
            for window in self._windows.values():
                window.clear()
        self._last_ns = estimate.t_ns
        if lost:
            return estimate
        elbow, wrist, index, thumb = (self._mean(name, getattr(estimate, name)) for name in POINTS)
        palm = self._mean("palm", estimate.palm)
        return replace(estimate, elbow=elbow, wrist=wrist, index=index, thumb=thumb, palm=palm)

    def _mean(self, name: str, point: Array | None) -> Array | None:
        window = self._windows[name]
        if point is None:
            window.clear()
            return None
        window.append(point)
        mean: Array = np.mean(window, axis=0)
        return mean
