"""The wheel in a fresh environment outside the checkout: it runs, and brings all files that are no modules."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

from tests.loopback.undisturbed import PATIENT, undisturbed

PROJECT = Path(__file__).parents[2]
PACKAGES = ("common", "local_site", "remote_site", "farhand")
SOURCES = (*PACKAGES, "pyproject.toml", "README.md", "LICENSE")
# The libraries of this environment, without running its .pth files: one of them would find the checkout.
LIBRARIES = f"{sysconfig.get_paths()['purelib']}\nimport cmeel_pth\n"


def run(*command: str | Path, folder: Path) -> str:
    """Run a command as a user does, in a folder and without this environment's variables; its output."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    done = subprocess.run(
        command, check=False, capture_output=True, text=True, timeout=300, cwd=folder, env=environment
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of programs of an environment into which the wheel is installed."""
    folder = tmp_path_factory.mktemp("wheel")
    source, home = folder / "source", folder / "environment"
    source.mkdir()
    for name in SOURCES:
        copy = shutil.copytree if (PROJECT / name).is_dir() else shutil.copy
        copy(PROJECT / name, source / name)
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    run(*pip, "wheel", "--no-build-isolation", "--no-deps", "--wheel-dir", folder, source, folder=folder)
    shutil.rmtree(source)
    venv.create(home, with_pip=False)
    (wheel,) = folder.glob("farhand-*.whl")
    run(*pip, "--python", home / "bin/python", "install", "--no-deps", "--no-index", wheel, folder=folder)
    (packages,) = home.glob("lib/python3*/site-packages")
    (packages / "libraries.pth").write_text(LIBRARIES)
    return home / "bin"


@pytest.mark.slow
def test_nothing_comes_from_the_checkout(installed: Path, tmp_path: Path) -> None:
    program = f"import importlib; print(*(importlib.import_module(name).__file__ for name in {PACKAGES!r}))"
    found = run(installed / "python", "-c", program, folder=tmp_path).split()
    assert len(found) == len(PACKAGES)
    for path in map(Path, found):
        assert path.is_relative_to(installed.parent)
        assert path.with_name("py.typed").is_file()
    assert list(installed.parent.rglob("*.ts")) == []  # for the check of the page alone


@pytest.mark.slow
def test_it_brings_its_configurations_and_units(installed: Path, tmp_path: Path) -> None:
    shipped = PROJECT / "farhand/deployment"
    shown = run(installed / "farhand", "config", "show", "remote", folder=tmp_path)
    assert shown == (shipped / "sites/remote.toml").read_text()
    run(installed / "farhand", "config", "init", ".", folder=tmp_path)
    written = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    shipped_names = {path.name for room in ("sites", "systemd") for path in (shipped / room).iterdir()}
    assert written == shipped_names | {f"{name}.json" for name in ("local", "remote", "console", "router")}


def test_it_brings_the_pictures_of_the_cell(installed: Path, tmp_path: Path) -> None:
    shown = "from remote_site.simulation.dressing import PICTURES; print(*(each.name for each in PICTURES.iterdir()))"
    names = run(installed / "python", "-c", shown, folder=tmp_path).split()
    assert set(names) == {path.name for path in (PROJECT / "remote_site/simulation/pictures").iterdir()}


def test_it_brings_the_template_of_drivers(installed: Path, tmp_path: Path) -> None:
    run(installed / "farhand", "driver", "new", "my_arm", folder=tmp_path)
    template = PROJECT / "farhand/new_driver/template"
    sources = [path for path in template.rglob("*") if path.is_file() and path.suffix != ".pyc"]
    assert len([path for path in tmp_path.rglob("*") if path.is_file()]) == len(sources)


@pytest.mark.long
def test_the_loop_closes_from_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    options = ["--seconds", "5", "--headless", "--driver", "kinematic", "--tracker", "markers", "--report", "out.json"]
    command = "loopback", *options, *PATIENT
    report = undisturbed(lambda: run(installed / "farhand", *command, folder=tmp_path), tmp_path / "out.json")
    assert report["engagements"] == 1
    assert report["follow_mm"]["mean"] < 30.0
    assert [path.name for path in tmp_path.iterdir()] == ["out.json"]
