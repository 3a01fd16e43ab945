"""The pipeline and the driver together: one cycle reads the robot, decides, and commands it."""

from collections.abc import Iterable

from remote_site.assist.sighting import MarkerSighting
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.link import DriverLink, RobotReport
from remote_site.session.lease import LeaseStatus
from remote_site.session.requests import SessionRequest
from remote_site.session.samples import NamedSample
from remote_site.teleop.cycle import Command, CycleInput, RobotObservation, Snapshot
from remote_site.teleop.pipeline import TeleopPipeline


class DrivenPipeline:
    """Runs the pipeline on what the driver's process reports; `report` is the newest, `sent` what it was given last.

    `given` and `command` are those of the last cycle, None before the first; `ordered` is what the driver's process was
    ordered in it, None for an activation or nothing.
    """

    def __init__(self, pipeline: TeleopPipeline, driver: DriverLink) -> None:
        self._pipeline = pipeline
        self._driver = driver
        self.report: RobotReport = driver.read()
        self.sent = self.report.sent
        self.seq = 0
        self.given: CycleInput | None = None
        self.command: Command | None = None
        self.ordered: JointCommand | None = None

    def cycle(
        self,
        now_ns: int,
        lease: LeaseStatus,
        samples: Iterable[NamedSample] = (),
        requests: Iterable[SessionRequest] = (),
        markers: Iterable[MarkerSighting] = (),
        *,
        site_ready: bool = True,
    ) -> Snapshot:
        """One control tick; the driver is activated, or commanded if it takes commands."""
        report = self.report = self._driver.read()
        robot = RobotObservation(report.q, report.fault, report.sent, report.gripper, report.diverted)
        given = self.given = CycleInput(
            now_ns, robot, lease, tuple(samples), tuple(requests), site_ready, tuple(markers)
        )
        command = self.command = self._pipeline.cycle(given)
        self.sent, self.ordered = report.sent, None
        if command.activate_at is not None:
            self._driver.activate(command.activate_at)
            self.sent = command.motion
        elif report.ready:
            self.seq += 1
            self.ordered = self._driver.write(command.joints(self.seq, now_ns))
            self.sent = self.ordered.motion
        return command.snapshot
