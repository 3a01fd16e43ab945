"""Smooths the tracked arm over time, single jumps left out: the One Euro filter, or the mean of the last frames."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Literal, Protocol

import numpy as np
from msgspec import Meta, Struct

from common.clock import NS_PER_S
from common.geometry import Array, hand_rotation, rotation_from_vector, vector_from_rotation
from common.messages.hand import TrackingStatus
from local_site.tracking.tracker import ArmEstimate

POINTS = ("elbow", "wrist", "index", "thumb")
BELIEVED = 3  # a third jump in a row is where the arm is now


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
    max_gap_s: Annotated[float, Meta(gt=0, le=10, description="a point absent for longer starts again")] = 0.2


class Smoother(Protocol):
    """Turns estimates of successive instants into calmer ones; causal, a LOST estimate makes it start again.

    Covariances stay those of the single measurement: they do not include the lag that smoothing trades for noise.
    """

    def smooth(self, estimate: ArmEstimate) -> ArmEstimate: ...


def make_smoother(config: SmoothingConfig) -> Smoother:
    """The smoother that the configuration asks for."""
    smoother = ArmMean(config) if config.method == "mean" else ArmOneEuro(config)
    return JumpGate(smoother, config.jump_m_s, config.jump_noise_m)


class JumpGate:
    """A `Smoother` before another: a wrist faster than `speed_m_s`, with `noise_m` to spare, bypasses the other.

    So one wrong frame does not spread over those after it; the remote site refuses it as it is. With the third jump in
    a row the other starts again there.
    """

    def __init__(self, smoother: Smoother, speed_m_s: float, noise_m: float) -> None:
        self._smoother, self._speed_m_s, self._noise_m = smoother, speed_m_s, noise_m
        self._last: ArmEstimate | None = None
        self._jumps = 0

    def smooth(self, estimate: ArmEstimate) -> ArmEstimate:
        """The estimate, smoothed unless its wrist jumps."""
        if self._jumped(estimate):
            self._jumps += 1
            if self._jumps < BELIEVED:
                return estimate
            self._smoother.smooth(ArmEstimate(estimate.t_ns, TrackingStatus.LOST, "the wrist has jumped"))
        self._last, self._jumps = estimate, 0
        return self._smoother.smooth(estimate)

    def _jumped(self, estimate: ArmEstimate) -> bool:
        if self._last is None or self._last.wrist is None or estimate.wrist is None:
            return False
        passed_s = (estimate.t_ns - self._last.t_ns) / NS_PER_S
        return math.dist(estimate.wrist, self._last.wrist) > self._speed_m_s * passed_s + self._noise_m


class OneEuro:
    """The One Euro filter (Casiez, Roussel and Vogel 2012), its cut-off rising by `beta` with the value's speed.

    `difference` gives the vector from the smoothed to the new value, `moved` the value moved by such a vector. An
    absent value stays absent, and the filter starts again with the next one.
    """

    def __init__(
        self,
        config: SmoothingConfig,
        beta: float,
        difference: Callable[[Array, Array], Array],
        moved: Callable[[Array, Array], Array],
    ) -> None:
        self._config, self._beta = config, beta
        self._difference, self._moved = difference, moved
        self._value: Array | None = None
        self._speed = np.zeros(3)
        self._t_ns = 0

    def smooth(self, t_ns: int, value: Array | None) -> Array | None:
        """The smoothed value."""
        dt_s, self._t_ns = (t_ns - self._t_ns) / NS_PER_S, t_ns
        if value is None or self._value is None or not 0.0 < dt_s <= self._config.max_gap_s:
            self._value, self._speed = value, np.zeros(3)
            return value
        change = self._difference(self._value, value)
        self._speed = self._speed + _gain(self._config.speed_cutoff_hz, dt_s) * (change / dt_s - self._speed)
        speed = math.sqrt(float(self._speed @ self._speed))
        gain = _gain(self._config.min_cutoff_hz + self._beta * speed, dt_s)
        self._value = self._moved(self._value, gain * change)
        return self._value


def _gain(cutoff_hz: float, dt_s: float) -> float:
    """Compute the fraction of a change that a low-pass filter of first order takes over in one step."""
    return 1.0 / (1.0 + 1.0 / (2.0 * math.pi * cutoff_hz * dt_s))


def _of_point(config: SmoothingConfig) -> OneEuro:
    """One Euro on a point (3,) in m."""
    return OneEuro(config, config.beta_per_m, lambda a, b: b - a, lambda a, step: a + step)


def _of_rotation(config: SmoothingConfig) -> OneEuro:
    """One Euro on a rotation (3, 3), along the shortest turn from the smoothed to the new one."""
    return OneEuro(
        config,
        config.beta_per_rad,
        lambda a, b: vector_from_rotation(a.T @ b),
        lambda a, step: a @ rotation_from_vector(step),
    )


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
        self._elbow, self._wrist, self._palm = (_of_point(self._config) for _ in range(3))
        self._rotation = _of_rotation(self._config)
        self._offsets = (_of_point(self._config), _of_point(self._config))


def _rotation(estimate: ArmEstimate) -> Array | None:
    if estimate.wrist is None or estimate.index is None or estimate.thumb is None:
        return None
    return hand_rotation(estimate.wrist, estimate.index, estimate.thumb)


def _in_hand(rotation: Array | None, wrist: Array | None, tip: Array | None) -> Array | None:
    return None if rotation is None or wrist is None or tip is None else rotation.T @ (tip - wrist)


class ArmMean:
    """The mean of each point over the last frames, as in the thesis's teleoperation.

    Index and thumb are averaged as seen from the wrist, and start again when the hand opens or closes: neither a tip
    that was hidden for a moment nor the gesture turns the hand afterwards.
    """

    def __init__(self, config: SmoothingConfig) -> None:
        self._config = config
        self._last_ns = 0
        self._was_open = False
        self._windows = {name: deque[Array](maxlen=config.mean_frames) for name in (*POINTS, "palm")}

    def smooth(self, estimate: ArmEstimate) -> ArmEstimate:
        """The estimate with each point averaged over the frames in which it was present without a gap."""
        lost = estimate.status is TrackingStatus.LOST
        if lost or estimate.t_ns - self._last_ns > self._config.max_gap_s * NS_PER_S:
            self._clear(*self._windows)
        elif estimate.hand_open is not self._was_open:
            self._clear("index", "thumb")
        self._last_ns, self._was_open = estimate.t_ns, estimate.hand_open
        if lost:
            return estimate
        elbow, wrist, palm = (self._mean(name, getattr(estimate, name)) for name in ("elbow", "wrist", "palm"))
        index, thumb = (self._tip(name, getattr(estimate, name), estimate.wrist, wrist) for name in ("index", "thumb"))
        return replace(estimate, elbow=elbow, wrist=wrist, index=index, thumb=thumb, palm=palm)

    def _tip(self, name: str, tip: Array | None, wrist: Array | None, mean_wrist: Array | None) -> Array | None:
        """A tip's mean offset from the wrist, beside the mean wrist; the tip as it is without a wrist."""
        offset = self._mean(name, None if tip is None or wrist is None else tip - wrist)
        return tip if offset is None or mean_wrist is None else mean_wrist + offset

    def _clear(self, *names: str) -> None:
        for name in names:
            self._windows[name].clear()

    def _mean(self, name: str, point: Array | None) -> Array | None:
        window = self._windows[name]
        if point is None:
            window.clear()
            return None
        window.append(point)
        mean: Array = np.mean(window, axis=0)
        return mean
