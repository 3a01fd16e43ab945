"""The pipeline around the kinematic driver on stepped time: for experiments, benchmarks and tests."""

from collections.abc import Iterable

from common.clock import NS_PER_MS, Clock
from remote_site.assist.sighting import MarkerSighting
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import DriverSetup
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import load_arm
from remote_site.session.config import EngagementMode
from remote_site.session.lease import LeaseStatus
from remote_site.session.requests import SessionRequest
from remote_site.session.samples import NamedSample
from remote_site.teleop.cycle import Command, CycleInput, RobotObservation
from remote_site.teleop.pipeline import TeleopPipeline

STOP_WITHIN_NS = 50 * NS_PER_MS


class KinematicLoop:
    """An arm that follows commands perfectly, and the pipeline that commands it; `sent` is the newest command.

    Nobody is there to request an engagement, so it is automatic unless it needs a key or pedal.
    """

    def __init__(self, config: RemoteConfig, clock: Clock) -> None:
        if config.engagement.mode is EngagementMode.ON_REQUEST:
            config = config.engaging(EngagementMode.AUTOMATIC)
        self.config = config
        self.model, self.limits = load_arm(config.robot)
        self.pipeline = TeleopPipeline(config, self.model, self.limits)
        self.sent = JointMotion.at_rest(config.robot.start)
        self._clock = clock
        self._driver = KinematicDriver(clock)
        dt = 1.0 / config.control.rate_hz
        self._driver.configure(DriverSetup(self.model.joint_names, self.limits, dt, STOP_WITHIN_NS))
        self._driver.activate(config.robot.start)
        self._seq = 0

    def cycle(
        self,
        lease: LeaseStatus,
        samples: Iterable[NamedSample] = (),
        requests: Iterable[SessionRequest] = (),
        markers: Iterable[MarkerSighting] = (),
    ) -> Command:
        """One control tick at the clock's time."""
        now_ns = self._clock.now_ns()
        robot = RobotObservation(self._driver.read().q, None, self.sent, None)
        given = CycleInput(now_ns, robot, lease, tuple(samples), tuple(requests), markers=tuple(markers))
        command = self.pipeline.cycle(given)
        self._seq += 1
        self.sent = self._driver.write(command.joints(self._seq, now_ns)).motion
        return command
