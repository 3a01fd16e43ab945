"""The systemd units: notified readiness, a watchdog that the daemons feed, and the configurations beside them."""

import configparser
from pathlib import Path

import pytest

DEPLOY = Path(__file__).parents[2] / "deploy"


@pytest.mark.parametrize("site", ["remote", "local"])
def test_a_unit_waits_for_ready_and_watches(site: str) -> None:
    unit = configparser.ConfigParser(strict=False)
    unit.optionxform = str
    unit.read(DEPLOY / "systemd" / f"farhand-{site}.service")
    service = unit["Service"]
    assert service["Type"] == "notify"
    assert float(service["WatchdogSec"]) >= 1
    assert service["ExecStart"].endswith(f"farhand {site} --config /etc/farhand/{site}.toml")
    assert service["User"] == "farhand"
    assert (DEPLOY / "sites" / f"{site}.toml").exists()
