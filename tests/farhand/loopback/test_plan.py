"""What a loopback starts: whose a file or a setting is, which of them wins, and what is refused with its cure."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from common.errors import ConfigError
from farhand.deployment.shipped import HERE
from farhand.loopback.plan import LoopbackOptions, Plan, plan_of

SITES = HERE / "sites"


def planned(*settings: str, configs: tuple[Path, ...] = (), driver: str | None = None) -> Plan:
    return plan_of(LoopbackOptions(settings=settings, configs=configs, driver=driver))


@pytest.fixture
def file(tmp_path: Path) -> Callable[..., Path]:
    def write(text: str, name: str = "site.toml") -> Path:
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


def test_the_shipped_files_of_both_sites_are_known_by_their_tables() -> None:
    plan = planned(configs=(SITES / "local.toml", SITES / "remote.toml"))
    assert (plan.remote.path, plan.local.path) == (SITES / "remote.toml", SITES / "local.toml")
    assert plan.remote.load().cell == plan.local.load().cell == plan.console.load().cell == "cell"


def test_a_files_links_give_way_to_free_ports_and_that_is_reported(file: Callable[..., Path]) -> None:
    path = file(
        '[driver]\nname = "kinematic"\n[links]\ncontrol = "tls/robot:7447"\nrouter = "tls/meet:7450"\n'
        '[links.tls]\nca = "a"\ncertificate = "b"\nkey = "c"\n'
    )
    plan = planned(configs=(path,))
    links, local = plan.remote.load().links, plan.local.load().links
    assert links.control == local.remote == plan.console.load().links.control
    assert links.listened == (links.control, links.video)
    assert links.control.startswith("tcp/127.0.0.1:")
    assert not links.tls.is_given
    assert plan.notes == (f"{path}: its table [links] is not used; the loopback connects both sites itself",)
    assert planned().notes == ()


def test_a_setting_goes_to_the_site_that_knows_it() -> None:
    plan = planned("driver.options.line=7", "driver.name=kinematic", "gesture.hold_ms=50", "simulation.markers=false")
    remote, local = plan.remote.load(), plan.local.load()
    assert (remote.driver.name, remote.driver.options) == ("kinematic", {"line": 7})
    assert local.gesture.hold_ms == 50.0
    assert planned("simulation.servo.bandwidth_hz=9").remote.load().simulation.servo.bandwidth_hz == 9.0


def test_the_cell_is_both_sites() -> None:
    assert planned().remote.load().cell == planned().local.load().cell == "loopback"
    plan = planned("cell=lab")
    assert {plan.remote.load().cell, plan.local.load().cell, plan.console.load().cell} == {"lab"}


def test_the_cell_of_one_file_is_the_other_sites_too(file: Callable[..., Path]) -> None:
    plan = planned(configs=(file('cell = "lab"\n[driver]\nname = "kinematic"\n'),))
    assert plan.local.load().cell == "lab"


def test_settings_override_a_file_and_options_override_both(file: Callable[..., Path]) -> None:
    path = file('[driver]\nname = "simulated"\n[video]\ncalibrated = false\n')
    assert planned("driver.name=kinematic", configs=(path,)).remote.load().driver.name == "kinematic"
    assert planned("driver.name=c500c", configs=(path,), driver="kinematic").remote.load().driver.name == "kinematic"


def test_a_file_overrides_what_the_loopback_only_prefers(file: Callable[..., Path]) -> None:
    assert planned().remote.load().video.calibrated
    assert not planned(configs=(file("[video]\ncalibrated = false\n"),)).remote.load().video.calibrated


def test_what_the_loopback_needs_follows_the_tracker_and_the_driver_of_a_file(file: Callable[..., Path]) -> None:
    path = file('[tracking]\nmethod = "markers"\n[authority]\noperator = "anna"\n')
    plan = planned("driver.name=c500c", configs=(path,))
    local = plan.local.load()
    assert (local.simulation.markers, local.simulation.motion.begins) == (True, "when_engaged")
    assert plan.console.load().operator == "anna"
    assert plan.remote.load().driver.emulate


def test_a_driver_of_one_arm_brings_its_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("farhand.loopback.plan.check_driver", lambda name: name)  # it may be installed later
    for options in (LoopbackOptions(driver="franka"), LoopbackOptions(arm="fr3")):
        remote = plan_of(options).remote.load()
        assert (remote.driver.name, remote.driver.emulate, remote.robot.model) == ("franka", True, "fr3")
    kinematic = plan_of(LoopbackOptions(arm="fr3", driver="kinematic")).remote.load()
    assert (kinematic.driver.name, kinematic.driver.emulate, kinematic.robot.model) == ("kinematic", False, "fr3")
    with pytest.raises(ConfigError, match="the driver franka is the fr3's; use simulated or kinematic for"):
        plan_of(LoopbackOptions(arm="humanoid", driver="franka"))
    with pytest.raises(ConfigError, match=r"driver\.options\.host: .* emulates the robot; leave the host out"):
        plan_of(LoopbackOptions(driver="franka", settings=("driver.options.host=172.16.0.2",)))


@pytest.mark.parametrize(
    ("text", "cure"),
    [
        (
            "",
            "an empty file does not show which site it is for; give it a table of the remote site (assist, control",
        ),
        ('cell = "lab"\n', "cell does not show which site"),
        ("[drvier]\nname = 1\n", "drvier does not show which site"),
        ("[driver]\n[tracking]\n", "driver is the remote site's, tracking the local site's; use a file for each"),
        ("[serve]\nport = 1\n", "is for the console; the loopback takes files of the remote and the local site"),
        ("listen = []\noperators = []\n", "is for the router"),
        ("[driver]\n[robto]\n", "did you mean robot?"),
        ('[operator]\nleft = "0"\nright = "1"\nrig = "r"\n', "use these cameras with: farhand local"),
        ('[driver]\nname = "c500c"\n[driver.options]\nport = "/dev/ttyUSB0"\n', "leave the port out"),
        ('[driver]\nname = "c500c"\nemulate = false\n', "never drives the real robot"),
        ('[simulation.motion]\nbegins = "at_once"\n', "leave simulation.motion.begins out"),
        ("[tracking]\n[simulation]\nmarkers = true\n", "leave simulation.markers out"),
        ("driver = 1\n", "must be a table: [driver]"),
        ("=", "not valid TOML"),
    ],
)
def test_a_file_that_does_not_fit_is_refused_with_its_cure(text: str, cure: str, file: Callable[..., Path]) -> None:
    with pytest.raises(ConfigError, match=re.escape(cure)):
        planned(configs=(file(text),))


@pytest.mark.parametrize(
    ("setting", "cure"),
    [
        ("links.control=tcp/127.0.0.1:7447", "the loopback connects both sites itself; leave it out"),
        ("links={}", "leave it out"),
        ("metrics.port=9100", "both sites have metrics; give it in the --config file of one"),
        ("drvier.name=kinematic", "no site has drvier; the remote site has assist, cell, control, driver"),
        ("driver.nme=kinematic", "did you mean name?"),
        ("driver", "write it as table.key=value"),
    ],
)
def test_a_setting_that_does_not_fit_is_refused_with_its_cure(setting: str, cure: str) -> None:
    with pytest.raises(ConfigError, match=re.escape(cure)):
        planned(setting)


def test_two_files_for_one_site_are_refused(file: Callable[..., Path]) -> None:
    paths = file("[driver]\n", "a.toml"), file("[robot]\n", "b.toml")
    with pytest.raises(ConfigError, match=r"b\.toml are both for the remote site; give one file for each site"):
        planned(configs=paths)


def test_two_cells_are_refused(file: Callable[..., Path]) -> None:
    paths = file('cell = "a"\n[driver]\n', "a.toml"), file('cell = "b"\n[tracking]\n', "b.toml")
    with pytest.raises(ConfigError, match=re.escape("different cells (a, b)")):
        planned(configs=paths)


def test_an_arm_beside_a_remote_sites_file_is_refused(file: Callable[..., Path]) -> None:
    with pytest.raises(ConfigError, match="leave it or --config out"):
        plan_of(LoopbackOptions(arm="humanoid", configs=(file("[driver]\n"),)))
