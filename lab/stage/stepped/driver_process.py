"""The driver's process on stepped time, and control's end of it: whoever assembles a site decides when each turns."""

from common.clock import Clock
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import Driver
from remote_site.drivers.link import DriverLink
from remote_site.drivers.memory import DriverMemory
from remote_site.drivers.supervisor.grip import GripWatch
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.kinematics.limits import load_arm
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.runtime.driver_process import DriverLoop, grip_settings, setup_of
from remote_site.teleop.pipeline import TeleopPipeline


class SteppedDriverProcess:
    """A driver behind its supervisor as its process runs it, turn by turn; control orders and reads by `link`."""

    def __init__(self, config: RemoteConfig, driver: Driver, clock: Clock) -> None:
        self._config = config
        self.model, self.limits = load_arm(config.robot)
        setup, memory = setup_of(config), DriverMemory.create(len(config.robot.start_deg))
        driver.configure(setup)
        self.supervisor = DriverSupervisor(driver, setup, clock, memory.busy, GripWatch(grip_settings(config)))
        self.turn = DriverLoop(self.supervisor, memory, clock).turn
        self.link = DriverLink(memory, self.limits, clock)

    def pipeline(self) -> DrivenPipeline:
        """Control: a new pipeline that commands the driver."""
        return DrivenPipeline(TeleopPipeline(self._config, self.model, self.limits), self.link)
