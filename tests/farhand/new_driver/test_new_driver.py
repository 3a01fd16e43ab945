"""The package that `farhand driver new` writes passes its own tests and the suite as it stands, and harms nothing."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from common.errors import ConfigError
from farhand.new_driver.package import class_name, next_steps, write_package
from remote_site.drivers.registry import GROUP

PROJECT = Path(__file__).parents[3]


def run(*command: str | Path, path: Path) -> subprocess.CompletedProcess[str]:
    """Run Python with a package on its path that is not installed."""
    environment = os.environ | {"PYTHONPATH": f"{PROJECT}{os.pathsep}{path}"}
    command = (sys.executable, *command)
    return subprocess.run(command, check=False, capture_output=True, text=True, timeout=400, env=environment, cwd=path)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """The folder of a new package, with what an installation of it would leave for the registry."""
    write_package("my_arm", tmp_path)
    project = tomllib.loads((tmp_path / "my_arm/pyproject.toml").read_text())["project"]
    info = tmp_path / "my_arm" / f"{project['name']}-{project['version']}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    points = "".join(f"{name} = {value}\n" for name, value in project["entry-points"][GROUP].items())
    (info / "entry_points.txt").write_text(f"[{GROUP}]\n{points}")
    return tmp_path / "my_arm"


@pytest.mark.slow
def test_its_own_tests_pass_in_a_checkout_of_farhand_too(package: Path) -> None:
    settings = "[tool.pytest.ini_options]\naddopts = '--import-mode=importlib'\n"
    (package.parent / "pyproject.toml").write_text(settings)
    done = run("-m", "pytest", "-q", "-p", "no:cacheprovider", "tests", path=package)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "3 passed" in done.stdout


def test_farhand_lists_it(package: Path) -> None:
    done = run("-m", "farhand", "driver", "list", path=package)
    assert "my_arm (from my_arm 0.1.0): The arm my_arm, simulated as yet.\n" in done.stdout, done.stderr


@pytest.mark.long
def test_farhand_finds_nothing_wrong_with_it(package: Path) -> None:
    done = run("-m", "farhand", "driver", "test", "my_arm", path=package)
    assert done.returncode in (0, 3), done.stdout + done.stderr  # 3 on a machine that is too busy to judge
    assert "FAILED" not in done.stdout


@pytest.mark.slow
def test_a_port_that_has_no_library_yet_is_named(package: Path) -> None:
    done = run("-m", "farhand", "driver", "test", "my_arm", "--set", "driver.options.port=/dev/ttyUSB0", path=package)
    assert done.returncode == 1
    assert "there is no library for the port /dev/ttyUSB0 yet" in done.stdout


def test_nothing_of_the_templates_names_is_left_and_what_is_to_be_replaced_is_marked(tmp_path: Path) -> None:
    written = write_package("lab2_arm", tmp_path)
    texts = {path: path.read_text() for path in written}
    assert not [path for path, text in texts.items() if "new_arm" in text + str(path) or "NewArm" in text]
    assert "class Lab2Arm(PositionArm)" in texts[tmp_path / "lab2_arm/lab2_arm/driver.py"]
    assert texts[tmp_path / "lab2_arm/lab2_arm/driver.py"].count("REPLACE") >= 8


def test_it_says_what_to_do_next() -> None:
    lines = next_steps("my_arm", Path("drivers"))
    assert f"{sys.executable} -m pip install --editable drivers/my_arm" in lines[1]
    assert "farhand driver test my_arm" in lines[2]


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "my_arm").mkdir()
    with pytest.raises(ConfigError, match="my_arm exists, and nothing is overwritten"):
        write_package("my_arm", tmp_path)
    assert list((tmp_path / "my_arm").iterdir()) == []


@pytest.mark.parametrize(
    "name", ["", "My_arm", "my-arm", "2arm", "_arm", "arm_", "a__b", "../arm", "arm.py", "ärm", "a" * 41]
)
def test_what_is_no_name_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="such as my_arm"):
        write_package(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["lambda", "tests", "position_arm", "driver", "simulated_library", "np"])
def test_a_word_that_the_package_needs_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="choose another"):
        write_package(name, tmp_path)


@pytest.mark.parametrize("name", ["numpy", "farhand", "json"])
def test_a_module_that_is_there_is_not_hidden(name: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="choose another"):
        write_package(name, tmp_path)


def test_a_driver_that_is_installed_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="installed already"):
        write_package("kinematic", tmp_path)


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="--out"):
        write_package("my_arm", tmp_path / "file")


def test_the_class_is_the_name_in_capitals() -> None:
    assert [class_name(name) for name in ("my_arm", "ur5", "lab_2_arm")] == ["MyArm", "Ur5", "Lab2Arm"]
