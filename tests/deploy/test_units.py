"""The systemd units: what they promise, that systemd takes them, and how far they are shut in."""

import configparser
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from farhand.exits import INTERRUPTED, MISUSE
from local_site.tracking.landmarks.model_files import how_to_install, model_folder

DEPLOY = Path(__file__).parents[2] / "farhand" / "deployment"
UNITS = sorted((DEPLOY / "systemd").glob("farhand-*.service"))
SITES = ("remote", "local")
RECORDERS = {"record": "remote", "record-local": "local"}  # and the site whose configuration each has
MOST_EXPOSED = 2.0

analyse = pytest.mark.skipif(
    shutil.which("systemd-analyze") is None, reason="systemd-analyze is missing; on Debian: apt-get install systemd"
)


def unit_of(site: str) -> configparser.ConfigParser:
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str  # type: ignore[assignment,method-assign]  # as its documentation has it
    unit.read(DEPLOY / "systemd" / f"farhand-{site}.service")
    return unit


def named(unit: Path) -> str:
    return unit.stem


@pytest.mark.parametrize("unit", UNITS, ids=named)
def test_a_unit_waits_for_ready_watches_and_gives_up(unit: Path) -> None:
    name = unit.stem.removeprefix("farhand-")
    sections = unit_of(name)
    service = sections["Service"]
    assert service["Type"] == "notify"
    assert float(service["WatchdogSec"]) >= 1
    command, site = ("record", RECORDERS[name]) if name in RECORDERS else (name, name)
    assert service["ExecStart"].endswith(f"farhand {command} --config /etc/farhand/{site}.toml")
    assert service["User"].startswith("farhand")
    assert service["Restart"] == "on-failure"
    assert int(service["RestartPreventExitStatus"]) == MISUSE
    assert int(service["SuccessExitStatus"]) == INTERRUPTED
    assert int(sections["Unit"]["StartLimitBurst"]) * float(service["RestartSec"]) < float(
        sections["Unit"]["StartLimitIntervalSec"]
    ), "the limit would never be reached"


@pytest.mark.parametrize("site", SITES)
def test_a_site_may_ask_for_real_time_and_make_machine_code(site: str) -> None:
    service = unit_of(site)["Service"]
    assert int(service["LimitRTPRIO"]) >= 50
    assert not {"RestrictRealtime", "MemoryDenyWriteExecute", "CPUSchedulingPolicy"} & set(service)
    assert (DEPLOY / "sites" / f"{site}.toml").exists()


def test_what_the_local_site_compiles_is_kept_where_it_may_write_and_has_time_for() -> None:
    service = unit_of("local")["Service"]
    assert service["Environment"] == f"NUMBA_CACHE_DIR=%C/{service['CacheDirectory']}/numba"
    assert float(service["TimeoutStartSec"]) >= 300


def test_the_local_site_finds_the_models_where_the_installer_says_that_they_are_put(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    service = unit_of("local")["Service"]
    monkeypatch.setenv("CACHE_DIRECTORY", f"/var/cache/{service['CacheDirectory']}")  # as systemd does
    installer = (DEPLOY.parents[1] / "deploy" / "install.sh").read_text()
    assert how_to_install().replace("/var/cache/farhand", "$cache") in installer
    assert model_folder() == Path("/var/cache/farhand/models")


def test_the_local_site_sees_which_processor_it_has() -> None:
    assert "ProcSubset" not in unit_of("local")["Service"], "the landmarks' runtime reads /proc/cpuinfo"


def test_the_local_site_may_schedule_its_idle_process_like_others_to_end_it() -> None:
    assert unit_of("local")["Service"]["LimitNICE"] == "+0"


def test_the_remote_sites_mark_lies_where_it_outlasts_a_power_cut() -> None:
    service = unit_of("remote")["Service"]
    assert service["StateDirectory"] == "farhand"
    assert "RuntimeDirectory" not in service


@pytest.mark.parametrize(("name", "site"), RECORDERS.items())
def test_a_recorder_is_its_sites_user_keeps_files_to_itself_and_has_no_device(name: str, site: str) -> None:
    service, recorded = unit_of(name)["Service"], unit_of(site)["Service"]
    assert (service["User"], service["StateDirectory"]) == (recorded["User"], recorded["StateDirectory"])
    assert service["UMask"] == "0077"
    assert service["PrivateDevices"] == "yes"
    assert unit_of(name)["Unit"]["After"].split()[-1] == f"farhand-{site}.service"


def test_only_the_recorder_that_listens_to_the_sites_has_a_network() -> None:
    cell, operator = (unit_of(name)["Service"] for name in RECORDERS)
    assert cell["PrivateNetwork"] == "yes"
    assert "PrivateNetwork" not in operator
    assert "AF_INET" in operator["RestrictAddressFamilies"].split()


@pytest.mark.parametrize("name", ["remote", "local", "console", "router", "record-local"])
def test_what_listens_ends_before_it_takes_the_hosts_memory_and_has_files_for_silent_connections(name: str) -> None:
    service = unit_of(name)["Service"]
    assert re.fullmatch(r"[5-7]\d%", service["MemoryMax"]), "generous, and less than the host has"
    assert service["MemorySwapMax"] == "0"
    assert service.get("OOMPolicy", "stop") == "stop", "the driver's process is asked to end, and stops the arm"
    assert int(service["LimitNOFILE"]) >= 16384


@analyse
@pytest.mark.parametrize("unit", UNITS, ids=named)
def test_systemd_takes_the_unit(unit: Path, tmp_path: Path) -> None:
    there = tmp_path / unit.name
    there.write_text(unit.read_text().replace("/opt/farhand/.venv/bin/farhand", shutil.which("true") or ""))
    done = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", "--recursive-errors=no", there],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert unit.name not in done.stderr


@analyse
def test_an_unknown_word_in_a_unit_is_noticed(tmp_path: Path) -> None:
    there = tmp_path / "farhand-wrong.service"
    there.write_text("[Service]\nExecStart=/bin/true\nWatchdogSecs=2\n")
    done = subprocess.run(["systemd-analyze", "verify", "--man=no", there], check=False, capture_output=True, text=True)
    assert "WatchdogSecs" in done.stderr


@analyse
@pytest.mark.parametrize("unit", UNITS, ids=named)
def test_a_unit_is_shut_in(unit: Path) -> None:
    done = subprocess.run(
        ["systemd-analyze", "security", "--offline=true", "--no-pager", unit],
        check=True,
        capture_output=True,
        text=True,
    )
    exposure = re.search(r"exposure level for \S+: ([0-9.]+)", done.stdout)
    assert exposure is not None, done.stdout
    assert float(exposure[1]) <= MOST_EXPOSED
