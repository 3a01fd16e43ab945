"""The guide's drivers are complete and short, pass every check, and need nothing of Farhand but `farhand.driver`."""

import ast
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import farhand.driver
from common.clock import NS_PER_MS, FakeClock
from common.errors import ConfigError, DriverError
from remote_site.drivers.checks_before_start import DECLARED
from remote_site.drivers.conformance.suite import run_checks
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.registry import DriverHost
from tests.contracts.driver_stands import CONFIG, SETUP
from tests.contracts.position_arms import BrakingArm

GUIDE = Path(__file__).parents[2] / "docs" / "writing-a-driver.md"
CLOCK = FakeClock(1000 * NS_PER_MS)
FARHAND = {"common", "local_site", "remote_site", "farhand", "lab"}


def sources() -> list[str]:
    """The guide's driver of three methods, its full one, and the test."""
    return re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)


def run(source: str) -> dict[str, Any]:
    namespace: dict[str, Any] = {}
    exec(compile(source, str(GUIDE), "exec"), namespace)  # noqa: S102  # the project's own document
    return namespace


class Arm(BrakingArm):
    """Stands for the manufacturer's library of the guide."""

    def __init__(self, address: str) -> None:
        super().__init__(CLOCK)
        self.configure(SETUP)
        assert address

    measured_positions, move_to, halt = BrakingArm.read, BrakingArm.write, BrakingArm.stop


@pytest.mark.slow
def test_the_three_methods_of_the_guide_pass_every_check(monkeypatch: pytest.MonkeyPatch) -> None:
    library = ModuleType("arm_library")
    vars(library)["Arm"] = Arm
    monkeypatch.setitem(sys.modules, "arm_library", library)
    driver, *_ = sources()
    assert len(driver.splitlines()) < 40
    made = run(driver)["my_arm"]
    stand = DriverStand(CLOCK, SETUP, lambda: made(DriverHost(CLOCK)), CONFIG.robot.start)
    lines: list[str] = []
    assert run_checks(stand, lines.append) == [], lines


@pytest.mark.slow
def test_the_driver_of_the_guide_passes_every_check() -> None:
    _, driver, _ = sources()
    assert len(driver.splitlines()) < 100
    host = DriverHost(FakeClock(1000 * NS_PER_MS))
    made = run(driver)["LibraryDriver"]
    stand = DriverStand(host.clock, SETUP, lambda: made(host), CONFIG.robot.start)
    lines: list[str] = []
    assert run_checks(stand, lines.append) == [], lines


@pytest.mark.slow
def test_the_test_of_the_guide_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    _, driver, test = sources()
    module = ModuleType("my_package.library_driver")
    vars(module).update(run(driver))
    monkeypatch.setitem(sys.modules, "my_package", ModuleType("my_package"))
    monkeypatch.setitem(sys.modules, "my_package.library_driver", module)
    run(test)["test_the_driver_conforms"]()


def test_the_guide_checks_the_drivers_options() -> None:
    made = run(sources()[1])["LibraryDriver"]
    with pytest.raises(ConfigError, match=r"driver\.options\.lag: is not a key here; did you mean lag_s\?"):
        made(DriverHost(FakeClock(0), {"lag": 0.1}))


def test_the_guides_driver_declares_what_it_checks_before_anything_starts() -> None:
    (check,) = getattr(run(sources()[1])["LibraryDriver"], DECLARED)
    check({"lag_s": 0.02}, SETUP)
    with pytest.raises(ConfigError, match="did you mean lag_s"):
        check({"lag": 0.1}, SETUP)
    with pytest.raises(DriverError, match="this arm has 6 joints, the model 5"):
        check({}, replace(SETUP, joint_names=SETUP.joint_names[:5]))


def test_the_guide_imports_nothing_else_of_farhand() -> None:
    nodes = [node for source in sources() for node in ast.walk(ast.parse(source))]
    modules = {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
    modules |= {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    assert {module for module in modules if module and module.partition(".")[0] in FARHAND} == {"farhand.driver"}
    assert not re.search(r"(common|remote_site|local_site)[./]", GUIDE.read_text(encoding="utf-8"))


def test_everything_of_the_facade_is_there_and_nothing_heavy_comes_with_it() -> None:
    assert all(hasattr(farhand.driver, name) for name in farhand.driver.__all__)
    heavy = "zenoh", "typer", "mujoco", "cv2", "numba", "farhand.cli", "local_site"
    program = f"import sys, farhand.driver; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert done.stdout == "[]\n"
