"""A robot is emulated for an arm of its own, and an address beside it is said not to be used."""

import pytest

from common.config.loading import load_config
from common.errors import ConfigError
from common.process.service import StopFlag
from remote_site.config import RemoteConfig
from remote_site.drivers.config import DRIVER_FILES, FRANKA
from remote_site.runtime import conformance
from remote_site.runtime.checks import check_driven_arm, find_mistakes
from remote_site.runtime.emulated_robot import unused_address

FR3_FILE, EMULATED = DRIVER_FILES[FRANKA], ["driver.emulate=true"]
FR3 = load_config(RemoteConfig, FR3_FILE, EMULATED)


@pytest.fixture(autouse=True)
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("listing", "franka.simulator"):  # none of it is used here
        monkeypatch.setattr(f"remote_site.drivers.{module}.find_spec", lambda name: name)


def configured(name: str, *settings: str) -> RemoteConfig:
    return load_config(RemoteConfig, DRIVER_FILES.get(name), [f"driver.name={name}", *settings])


def test_an_arm_of_its_own_is_emulated_without_an_address() -> None:
    assert find_mistakes(FR3) == []
    check_driven_arm(FR3)
    check_driven_arm(configured("c500c", "driver.emulate=true"))


@pytest.mark.parametrize(
    ("config", "sentence"),
    [
        (load_config(RemoteConfig, None, [*EMULATED, "driver.name=franka"]), "an FR3 has 7 joints, the model 6"),
        (load_config(RemoteConfig, FR3_FILE, [*EMULATED, "driver.name=c500c"]), "an A465 has 6 joints, the model 7"),
        (configured("franka", "driver.emulate=true", "driver.options.folow_ms=3"), "did you mean follow_ms"),
        (configured("franka"), "needs the robot's address: set driver.options.host, or start with --emulate"),
        (configured("c500c"), "needs its serial line: set driver.options.port, or start with --emulate"),
        (configured("nosuch"), "there is no driver 'nosuch'"),
    ],
)
def test_what_does_not_fit_is_refused_before_anything_starts(config: RemoteConfig, sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        check_driven_arm(config)
    mistakes = [mistake for mistake in find_mistakes(config) if mistake.part == "driver"]
    assert [sentence in mistake.sentence for mistake in mistakes] == [True]


def test_what_emulates_it_has_to_be_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("remote_site.drivers.franka.simulator.find_spec", lambda _: None)
    with pytest.raises(ConfigError, match=r"needs franky-sim: pip install 'farhand\[franka-sim\]'"):
        check_driven_arm(FR3)


@pytest.mark.parametrize(
    ("settings", "unused"),
    [
        (["driver.emulate=true", "driver.options.host=172.16.0.2"], "driver.options.host = '172.16.0.2'"),
        (["driver.emulate=true"], ""),
        (["driver.options.host=172.16.0.2"], ""),
    ],
)
def test_an_address_beside_an_emulated_robot_is_not_used(settings: list[str], unused: str) -> None:
    assert unused_address(configured("franka", *settings).driver) == unused


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        ([], "no driver.options.host is given, so this is the emulated robot"),
        (["driver.emulate=true"], ""),
        (
            ["driver.emulate=true", "driver.options.host=172.16.0.2"],
            "the robot is emulated, and driver.options.host = '172.16.0.2' is not used: set driver.emulate = false",
        ),
    ],
)
def test_the_suite_says_why_a_robot_is_emulated_where_it_was_not_just_asked_for(
    settings: list[str], line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines: list[str] = []
    begun = RuntimeError("the checks begin")

    def begin(config: RemoteConfig, children: object, should_stop: object) -> None:
        assert config.driver.emulate
        assert children
        assert should_stop
        raise begun

    monkeypatch.setattr(conformance, "_stand", begin)
    monkeypatch.setattr(conformance, "counts_pauses", lambda: True)
    with pytest.raises(RuntimeError, match="the checks begin"):
        conformance.test_driver(configured("franka", *settings), lines.append, StopFlag())
    assert len(lines) == bool(line)
    assert "".join(lines).startswith(line)
