"""Another distribution's `common`, found before Farhand's own, gives a sentence with a cure instead of a traceback."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]


def farhand(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Farhand with the packages of a folder before its own."""
    environment = os.environ | {"PYTHONPATH": f"{folder}:{PROJECT}"}
    command = [sys.executable, "-P", "-m", "farhand", *arguments]
    return subprocess.run(command, check=False, capture_output=True, text=True, timeout=60, env=environment)


@pytest.mark.parametrize("is_package", [True, False])
@pytest.mark.parametrize("name", ["common", "local_site", "remote_site"])
def test_a_foreign_package_is_refused_before_it_is_imported(name: str, is_package: bool, tmp_path: Path) -> None:
    (tmp_path / name).mkdir()
    if is_package:
        (tmp_path / name / "__init__.py").write_text("raise SystemExit('imported')\n")
        (tmp_path / name / "errors.py").touch()
    else:
        (tmp_path / f"{name}.py").write_text("raise SystemExit('imported')\n")
    done = farhand(tmp_path, "doctor")
    assert done.returncode == 1
    foreign = tmp_path / name if is_package else tmp_path / f"{name}.py"
    assert done.stderr.startswith(f"farhand: Python finds {name} at {foreign}, which is not Farhand's own at {PROJECT}")
    assert "environment of its own" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("command", ["local", "remote", "console", "router", "loopback"])
def test_every_start_of_a_site_looks(command: str, tmp_path: Path) -> None:
    (tmp_path / "common").mkdir()
    (tmp_path / "common" / "__init__.py").touch()
    done = farhand(tmp_path, command, "--help")
    assert (done.returncode, done.stdout) == (1, "")
    assert "which is not Farhand's own" in done.stderr


def test_a_missing_package_is_reported(tmp_path: Path) -> None:
    (tmp_path / "farhand").symlink_to(PROJECT / "farhand")
    program = (
        "import sys; sys.meta_path = [f for f in sys.meta_path if 'editable' not in repr(f).lower()]\n"
        "import farhand.__main__ as start; start.main()"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", program],
        check=False,
        capture_output=True,
        text=True,
        timeout=60,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
    )
    assert done.returncode == 1
    assert "the package common is missing" in done.stderr
    assert "install Farhand again" in done.stderr


@pytest.mark.slow
def test_farhands_own_packages_are_taken(tmp_path: Path) -> None:
    done = farhand(tmp_path, "config", "show", "local")
    assert (done.returncode, done.stderr) == (0, "")
