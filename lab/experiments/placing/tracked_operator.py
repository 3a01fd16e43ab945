"""The local site on stepped time: the operator's arm rendered as the hand moves, tracked, smoothed, made a sample."""

from collections.abc import Callable

import numpy as np

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from common.errors import NotInstalledError
from common.messages.hand import ClockSync, HandArm, Intent, TrackingStatus
from lab.stage.stepped.site import LEASE, SESSION
from local_site.samples.hand_sample import GestureConfig, HandSampler, OpenHand
from local_site.samples.smoothing import SmoothingConfig, make_smoother
from local_site.simulation.cameras import calibrate_simulated
from local_site.simulation.config import SimulationConfig
from local_site.simulation.motion import Path
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import ArmEstimate, View, Views

EXACT_M = 1e-4


def is_installed(method: str) -> bool:
    """Return whether a tracker runs here: one for rooms needs models and their runtime."""
    try:
        make_tracker(calibrate_simulated(SimulationConfig()), TrackingConfig(method=method))
    except NotInstalledError:
        return False
    return True


class TrackedOperator:
    """Two cameras before an operator's arm, the tracker and the sampler; `path` moves the hand, times in s.

    `exact` leaves cameras and tracker out: the arm is known as it is. `alter` is applied to each estimate before it is
    smoothed.
    """

    def __init__(
        self,
        config: SimulationConfig,
        tracking: TrackingConfig,
        path: Path,
        exact: bool = False,
        smoothing: SmoothingConfig | None = None,
        alter: Callable[[ArmEstimate], ArmEstimate] | None = None,
    ) -> None:
        self.operator = SimulatedOperator(config, path)
        self._tracker = make_tracker(calibrate_simulated(config), tracking)
        self._smoother = make_smoother(smoothing or SmoothingConfig())
        self._sampler, self._hand = HandSampler(SESSION), OpenHand()
        self._exact, self._alter, self._seq = exact, alter, 0

    def see(self, t_ns: int, start_ns: int) -> ArmEstimate:
        """Expose both cameras at `t_ns` and track the arm; the path counts from `start_ns`."""
        t_s = (t_ns - start_ns) / NS_PER_S
        estimate = self._as_it_is(t_ns, t_s) if self._exact else self._tracked(t_ns, t_s)
        self._hand = self._hand.observe(estimate, GestureConfig())
        return self._smoother.smooth(self._alter(estimate) if self._alter is not None else estimate)

    def _tracked(self, t_ns: int, t_s: float) -> ArmEstimate:
        pictures = self.operator.render(t_s)
        views = Views(t_ns, tuple(View(Frame(picture, t_ns, self._seq)) for picture in pictures))
        self._seq += 1
        return self._tracker.track(views)

    def _as_it_is(self, t_ns: int, t_s: float) -> ArmEstimate:
        true = self.operator.truth(t_s)
        sure = dict.fromkeys(("elbow", "wrist", "index", "thumb"), EXACT_M**2 * np.eye(3))
        return ArmEstimate(
            t_ns,
            TrackingStatus.TRACKED,
            "",
            true.elbow,
            true.wrist,
            true.index,
            true.thumb,
            hand_open=true.hand_open,
            covariances=sure,
        )

    def sample(self, estimate: ArmEstimate, intent: Intent, sent_ns: int) -> HandArm:
        """The sample of an estimate as it is sent at `sent_ns`, both sites' clocks being one."""
        clock = ClockSync(remote_minus_local_ns=0, uncertainty_ns=0, measured_ns=sent_ns)
        return self._sampler.sample(estimate, self._hand, LEASE, clock, intent, sent_ns)
