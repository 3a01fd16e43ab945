"""The driver in the guide is complete, short, and passes the conformance suite as it stands."""

import re
from pathlib import Path

from common.clock import NS_PER_MS, FakeClock
from remote_site.drivers.conformance.suite import run_checks
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.registry import DriverHost
from tests.contracts.driver_stands import CONFIG, SETUP

GUIDE = Path(__file__).parents[2] / "docs" / "writing-a-driver.md"


def test_the_driver_of_the_guide_passes_every_check() -> None:
    (source,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(source.splitlines()) < 100
    namespace: dict = {}
    exec(compile(source, str(GUIDE), "exec"), namespace)  # noqa: S102  # the project's own document
    host = DriverHost(FakeClock(1000 * NS_PER_MS))
    stand = DriverStand(host.clock, SETUP, lambda: namespace["LibraryDriver"](host), CONFIG.robot.start)
    lines: list[str] = []
    assert run_checks(stand, lines.append) == [], lines
