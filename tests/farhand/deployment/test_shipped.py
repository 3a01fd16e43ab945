"""The shipped configurations and units: printed, written, and never over what exists."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from common.config.loading import load_config, read_tables
from common.errors import ConfigError
from farhand.cli import app
from farhand.deployment.kinds import Configuration
from farhand.deployment.shipped import HERE, NAMES
from farhand.router import RouterConfig
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from remote_site.config import RemoteConfig

KINDS: dict[str, type[Configuration]] = {
    "console": ConsoleConfig,
    "local": LocalConfig,
    "local-cameras": LocalConfig,
    "local-thesis": LocalConfig,
    "remote": RemoteConfig,
    "remote-assist": RemoteConfig,
    "remote-thesis": RemoteConfig,
    "router": RouterConfig,
}


@pytest.mark.parametrize("name", KINDS)
def test_a_shipped_configuration_is_printed_as_it_is_and_valid(name: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["config", "show", name])
    assert done.output == (HERE / "sites" / f"{name}.toml").read_text()
    printed = tmp_path / "printed.toml"
    printed.write_text(done.output)
    load_config(KINDS[name], printed)


@pytest.mark.parametrize("name", ["local", "local-cameras"])
@pytest.mark.parametrize("tracker", ["silhouette", "learned"])
def test_which_arm_is_tracked_stands_in_the_local_sites_files_with_its_default(name: str, tracker: str) -> None:
    given = read_tables(HERE / "sites" / f"{name}.toml")["tracking"][tracker]
    default = getattr(LocalConfig().tracking, tracker)
    assert given == {"right_arm": default.right_arm, "initial_pairs": default.initial_pairs}


def test_an_unknown_name_is_refused_with_those_there_are() -> None:
    assert tuple(KINDS) == NAMES
    result = CliRunner().invoke(app, ["config", "show", "remot"])
    assert isinstance(result.exception, ConfigError)
    assert f"choose one of: {', '.join(KINDS)}" in str(result.exception)


def test_everything_is_written_once_and_nothing_is_overwritten(tmp_path: Path) -> None:
    folder = tmp_path / "my" / "cell"
    first = CliRunner().invoke(app, ["config", "init", str(folder)])
    assert first.exit_code == 0
    named = {line.partition("\n")[0] for line in (path.read_text() for path in folder.glob("*.toml"))}
    assert named == {f"#:schema {path.relative_to(folder)}" for path in (folder / "schemas").iterdir()}
    written = {path.name: path.read_bytes() for path in folder.rglob("*") if path.suffix in (".toml", ".service")}
    shipped = {path.name: path.read_bytes() for room in ("sites", "systemd") for path in (HERE / room).iterdir()}
    assert written == shipped
    assert all(f"wrote {folder}" in line for line in first.output.splitlines()[:-1])
    (folder / "remote.toml").write_text('cell = "mine"\n')
    (folder / "local.toml").unlink()
    (folder / "local.toml").symlink_to(tmp_path / "nowhere")
    (folder / "systemd" / "farhand-remote.service").unlink()
    second = CliRunner().invoke(app, ["config", "init", str(folder)])
    assert f"kept {folder}/remote.toml: it exists" in second.output
    assert f"wrote {folder}/systemd/farhand-remote.service" in second.output
    assert second.output.count("wrote") == 1
    assert (folder / "remote.toml").read_text() == 'cell = "mine"\n'
    assert not (tmp_path / "nowhere").exists()


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    result = CliRunner().invoke(app, ["config", "init", str(tmp_path / "file")])
    assert isinstance(result.exception, ConfigError)
    assert "DIR" in str(result.exception)


def test_a_units_configuration_is_shipped() -> None:
    started = [path.read_text() for path in (HERE / "systemd").iterdir()]
    named = {re.findall(r"--config /etc/farhand/(\w+)\.toml", text)[0] for text in started}
    assert len(started) == 6
    assert named <= set(NAMES)


def test_a_hand_started_pairs_operator_waits_for_the_engagement() -> None:
    shipped = load_config(LocalConfig, HERE / "sites" / "local.toml")
    assert shipped.simulation.motion.begins == LocalConfig().simulation.motion.begins == "when_engaged"
