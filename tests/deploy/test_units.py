"""The systemd units: notified readiness, a watchdog that the daemons feed, and the configurations beside them."""

import configparser
from pathlib import Path

import pytest

DEPLOY = Path(__file__).parents[2] / "deploy"


def service_of(site: str) -> configparser.SectionProxy:
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str
    unit.read(DEPLOY / "systemd" / f"farhand-{site}.service")
    return unit["Service"]


@pytest.mark.parametrize("site", ["remote", "local"])
def test_a_unit_waits_for_ready_and_watches(site: str) -> None:
    service = service_of(site)
    assert service["Type"] == "notify"
    assert float(service["WatchdogSec"]) >= 1
    assert service["ExecStart"].endswith(f"farhand {site} --config /etc/farhand/{site}.toml")
    assert service["User"] == "farhand"
    assert (DEPLOY / "sites" / f"{site}.toml").exists()


def test_what_the_local_site_compiles_is_kept_where_it_may_write_and_has_time_for() -> None:
    service = service_of("local")
    assert service["Environment"] == f"NUMBA_CACHE_DIR=%C/{service['CacheDirectory']}/numba"
    assert float(service["TimeoutStartSec"]) >= 300
