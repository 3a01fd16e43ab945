"""The installer in a scratch root: it may run again, keeps what is edited, and takes away what is its own.

A stand-in for Python makes the environment, so that nothing is downloaded.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]
INSTALLER = PROJECT / "deploy" / "install.sh"
STAND_IN = """#!/bin/sh
if [ "$1" = -I ]; then shift; fi
case "$1 $2" in
  "-m venv") mkdir -p "$4/bin" && cp "$0" "$4/bin/python" ;;
  "-m pip") for source in "$@"; do :; done
    test -f "${source%\\[sim,video,learned]}/pyproject.toml" || exit 1
    folder=$(dirname "$0") && printf '#!%s/python\\n' "$folder" > "$folder/farhand" && echo pip >> "$folder/../calls" ;;
  "-m farhand") test "$3 $4 $5" = "config schema --out" && mkdir -p "$6" && echo '{}' > "$6/remote.json" ;;
esac
"""


class Scratch:
    """A root to install below, and a release to install from."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "root"
        self.python = folder / "python"
        self.python.write_text(STAND_IN)
        self.python.chmod(0o755)
        self.home, self.configuration = self.root / "opt/farhand", self.root / "etc/farhand"

    def run(self, *arguments: str) -> str:
        done = subprocess.run(
            [INSTALLER, "--root", self.root, *arguments],
            check=True,
            capture_output=True,
            text=True,
            env=os.environ | {"PYTHON": str(self.python)},
        )
        return done.stdout

    def files(self) -> dict[str, bytes]:
        """Every file below the root by its path; links by where they lead."""
        found = sorted(path for path in self.root.rglob("*") if path.is_symlink() or path.is_file())
        return {
            str(path.relative_to(self.root)): str(path.readlink()).encode() if path.is_symlink() else path.read_bytes()
            for path in found
        }


@pytest.fixture
def scratch(tmp_path: Path) -> Scratch:
    return Scratch(tmp_path)


def test_it_installs_what_the_units_call(scratch: Scratch) -> None:
    scratch.run()
    files = scratch.files()
    units = [path for path in files if path.startswith("usr/local/lib/systemd/system/farhand-")]
    assert {"farhand-remote.service", "farhand-local.service", "farhand-record-local.service"} <= {
        Path(path).name for path in units
    }
    for path in units:
        unit = files[path].decode()
        command = next(line for line in unit.splitlines() if line.startswith("ExecStart=")).partition("=")[2].split()
        assert command[0].removeprefix("/") in files
        assert command[-1].removeprefix("/") in files
    assert files["usr/local/bin/farhand"] == b"/opt/farhand/.venv/bin/farhand"
    assert files["opt/farhand/.venv/bin/farhand"] == b"#!/opt/farhand/.venv/bin/python\n"


def test_a_second_run_changes_nothing_but_installs_again(scratch: Scratch) -> None:
    scratch.run()
    once = scratch.files()
    scratch.run()
    twice = scratch.files()
    calls = "opt/farhand/.venv/calls"
    assert (once.pop(calls), twice.pop(calls)) == (b"pip\n", b"pip\npip\n")
    assert twice == once


def test_a_dry_run_touches_nothing_and_says_what_it_would_do(scratch: Scratch) -> None:
    told = scratch.run("--dry-run")
    assert not scratch.root.exists()
    assert f"would run: cp {PROJECT}/farhand/deployment/sites/remote.toml {scratch.configuration}/remote.toml" in told
    scratch.run()
    before = scratch.files()
    assert f"would run: rm -rf {scratch.home}" in scratch.run("--uninstall", "--dry-run")
    assert scratch.files() == before


def test_an_edited_configuration_is_kept_and_a_newer_one_laid_beside_it(scratch: Scratch) -> None:
    scratch.run()
    edited, untouched = scratch.configuration / "remote.toml", scratch.configuration / "local.toml"
    edited.write_text('cell = "mine"\n')
    assert "kept" not in scratch.run(), "this release brings nothing new"
    for name in (edited.name, untouched.name):
        (scratch.home / "configuration" / name).write_text("# an older release\n")
    untouched.write_text("# an older release\n")
    assert f"kept: {edited} is edited" in scratch.run()
    assert edited.read_text() == 'cell = "mine"\n'
    assert (scratch.configuration / "remote.toml.new").read_bytes() == (
        PROJECT / "farhand/deployment/sites/remote.toml"
    ).read_bytes()
    assert untouched.read_bytes() == (PROJECT / "farhand/deployment/sites/local.toml").read_bytes()


def test_nobody_else_reads_the_file_for_the_consoles_token(scratch: Scratch) -> None:
    scratch.run()
    console = scratch.configuration / "console.toml"
    assert console.stat().st_mode & 0o777 == 0o640
    console.write_text('[serve]\ntoken = "0123456789abcdef"\n')
    console.chmod(0o644)  # as an older release has left it
    told = scratch.run()
    assert console.stat().st_mode & 0o777 == 0o640
    assert "chgrp farhand /etc/farhand/console.toml" in told, "below a root there is no user yet"


def test_nothing_is_left_but_what_is_edited_or_not_ours(scratch: Scratch) -> None:
    scratch.run()
    state = scratch.root / "var/lib/farhand"
    (state / "unfinished" / "cell").mkdir(parents=True)  # as a remote site has left it that did not end in order
    (state / "unfinished" / "cell" / "999").touch()
    (state / "recording.mcap").touch()
    (scratch.configuration / "remote.toml").write_text('cell = "mine"\n')
    (scratch.configuration / "rig.json").write_text("{}\n")
    told = scratch.run("--uninstall")
    assert sorted(scratch.files()) == [
        "etc/farhand/remote.toml",
        "etc/farhand/rig.json",
        "var/lib/farhand/recording.mcap",
    ]
    assert f"left: {scratch.configuration} holds remote.toml rig.json" in told
    assert f"left: {state} holds recording.mcap" in told


def test_nothing_at_all_is_left_of_an_installation_that_nobody_touched(scratch: Scratch) -> None:
    scratch.run()
    assert "left" not in scratch.run("--uninstall")
    assert scratch.files() == {}
    scratch.run("--uninstall")


def test_an_unknown_option_is_refused() -> None:
    done = subprocess.run([INSTALLER, "--purge"], check=False, capture_output=True, text=True)
    assert done.returncode == 2
    assert "usage: deploy/install.sh" in done.stderr


def test_nothing_of_the_working_folder_is_run(tmp_path: Path) -> None:
    """As root, in a folder of somebody else's; a dry run asks Python, and prints how it would call it."""
    for name in ("ensurepip", "pip", "venv"):
        (tmp_path / f"{name}.py").write_text("import pathlib; pathlib.Path('ran').touch()")
    done = subprocess.run(
        [INSTALLER, "--root", tmp_path / "root", "--dry-run"], check=True, capture_output=True, text=True, cwd=tmp_path,
        env=os.environ | {"PYTHON": sys.executable},
    )  # fmt: skip
    assert not (tmp_path / "ran").exists()
    calls = [line.partition(" -m ") for line in done.stdout.splitlines() if " -m " in line]
    assert [after.split()[0] for _, _, after in calls] == ["venv", "pip", "farhand"]
    assert all(before.endswith(" -I") for before, _, _ in calls)
