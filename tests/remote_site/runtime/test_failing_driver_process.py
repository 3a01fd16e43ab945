"""Whatever fails in the driver's process, the robot is not left to itself."""

import gc

import pytest

from common.process.children import Heartbeat
from common.process.service import StopFlag
from remote_site.config import RemoteConfig
from remote_site.drivers.config import KINEMATIC, DriverConfig
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.memory import DriverMemory
from remote_site.drivers.registry import DriverHost
from remote_site.runtime import driver_process


class CountedStops(KinematicDriver):
    """A robot that counts how often it was stopped."""

    stops = 0

    def stop(self) -> None:
        """Count it."""
        self.stops += 1
        super().stop()


class FailingHeartbeat(Heartbeat):
    """A part of the process, outside the driver's calls, that fails."""

    def beat(self) -> None:
        """Fail."""
        raise MemoryError


def test_a_process_that_fails_outside_the_drivers_calls_stops_the_robot(monkeypatch: pytest.MonkeyPatch) -> None:
    robots: list[CountedStops] = []

    def create(_name: str, host: DriverHost) -> CountedStops:
        robots.append(CountedStops(host.clock))
        return robots[0]

    monkeypatch.setattr(driver_process, "create_driver", create)
    monkeypatch.setattr(driver_process, "ask_for_real_time", lambda _priority: True)
    monkeypatch.setattr(gc, "freeze", lambda: None)
    config = RemoteConfig(driver=DriverConfig(name=KINEMATIC))
    with pytest.raises(MemoryError):
        driver_process.run_driver(config, DriverMemory.create(6), None, StopFlag(), FailingHeartbeat())
    assert robots[0].stops == 1
