"""The local site on stepped time: the operator's arm rendered as the hand moves, tracked, smoothed, made a sample."""

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from common.messages.hand import ClockSync, HandArm, Intent
from farhand.experiments.placing.stepped_site import LEASE, SESSION
from local_site.samples.hand_sample import GestureConfig, HandSampler, OpenHand
from local_site.samples.smoothing import SmoothingConfig, make_smoother
from local_site.simulation.cameras import calibrate_simulated
from local_site.simulation.config import SimulationConfig
from local_site.simulation.motion import Path
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import ArmEstimate, View, Views


class TrackedOperator:
    """Two cameras before an operator's arm, the tracker and the sampler; `path` moves the hand, times in s."""

    def __init__(self, config: SimulationConfig, tracking: TrackingConfig, path: Path) -> None:
        self.operator = SimulatedOperator(config, path)
        self._tracker = make_tracker(calibrate_simulated(config), tracking)
        self._smoother = make_smoother(SmoothingConfig())
        self._sampler, self._hand = HandSampler(SESSION), OpenHand()
        self._seq = 0

    def see(self, t_ns: int, start_ns: int) -> ArmEstimate:
        """Expose both cameras at `t_ns` and track the arm; the path counts from `start_ns`."""
        pictures = self.operator.render((t_ns - start_ns) / NS_PER_S)
        views = Views(t_ns, tuple(View(Frame(picture, t_ns, self._seq)) for picture in pictures))
        self._seq += 1
        estimate = self._tracker.track(views)
        self._hand = self._hand.observe(estimate, GestureConfig())
        return self._smoother.smooth(estimate)

    def sample(self, estimate: ArmEstimate, intent: Intent, sent_ns: int) -> HandArm:
        """The sample of an estimate as it is sent at `sent_ns`, both sites' clocks being one."""
        clock = ClockSync(remote_minus_local_ns=0, uncertainty_ns=0, measured_ns=sent_ns)
        return self._sampler.sample(estimate, self._hand, LEASE, clock, intent, sent_ns)
