"""The guide's driver is complete and short, passes its own test, and needs nothing of Farhand but `farhand.driver`."""

import ast
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import farhand.driver
from common.clock import NS_PER_MS, FakeClock
from common.errors import ConfigError
from remote_site.drivers.conformance.suite import run_checks
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.registry import DriverHost
from tests.contracts.driver_stands import CONFIG, SETUP

GUIDE = Path(__file__).parents[2] / "docs" / "writing-a-driver.md"
FARHAND = {"common", "local_site", "remote_site", "farhand", "bench"}


def sources() -> list[str]:
    """The guide's driver and its test."""
    return re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)


def run(source: str) -> dict[str, Any]:
    namespace: dict[str, Any] = {}
    exec(compile(source, str(GUIDE), "exec"), namespace)  # noqa: S102  # the project's own document
    return namespace


def test_the_driver_of_the_guide_passes_every_check() -> None:
    driver, _ = sources()
    assert len(driver.splitlines()) < 100
    host = DriverHost(FakeClock(1000 * NS_PER_MS))
    made = run(driver)["LibraryDriver"]
    stand = DriverStand(host.clock, SETUP, lambda: made(host), CONFIG.robot.start)
    lines: list[str] = []
    assert run_checks(stand, lines.append) == [], lines


def test_the_test_of_the_guide_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    driver, test = sources()
    module = ModuleType("my_package.library_driver")
    vars(module).update(run(driver))
    monkeypatch.setitem(sys.modules, "my_package", ModuleType("my_package"))
    monkeypatch.setitem(sys.modules, "my_package.library_driver", module)
    run(test)["test_the_driver_conforms"]()


def test_the_guide_checks_the_drivers_options() -> None:
    made = run(sources()[0])["LibraryDriver"]
    with pytest.raises(ConfigError, match=r"driver\.options\.lag: is not a key here; did you mean lag_s\?"):
        made(DriverHost(FakeClock(0), {"lag": 0.1}))


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
