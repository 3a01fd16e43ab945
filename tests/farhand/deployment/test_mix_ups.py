"""A file of one site given to the command of another is told by its own command; mistakes stay mistakes."""

from pathlib import Path

import pytest

from common.config.loading import load_config
from common.errors import ConfigError
from farhand.commands.options import console_config, load_own
from farhand.deployment.kinds import KINDS, Configuration
from farhand.deployment.mix_ups import COMMANDS, mix_up
from farhand.deployment.shipped import HERE, NAMES
from farhand.recording.site_recorder import load_site
from farhand.router import RouterConfig
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from remote_site.config import RemoteConfig

SITES = HERE / "sites"
PREFIXES: dict[str, type[Configuration]] = {
    "remote": RemoteConfig,
    "local": LocalConfig,
    "console": ConsoleConfig,
    "router": RouterConfig,
}


def kind_of(name: str) -> type[Configuration]:
    return PREFIXES[name.partition("-")[0]]


@pytest.mark.parametrize("name", NAMES)
def test_every_shipped_file_is_told_from_every_other_kind(name: str) -> None:
    path, own = SITES / f"{name}.toml", kind_of(name)
    load_config(own, path)
    for kind in KINDS:
        assert bool(mix_up(path, kind)) == (kind is not own)
    for kind in set(KINDS) - {own}:
        with pytest.raises(ConfigError) as refused:
            load_own(kind, path)  # type: ignore[type-var]  # each of the kinds
        assert str(refused.value).splitlines() == [
            f"{path} is a file of the {KINDS[own]}; this command takes one of the {KINDS[kind]}",
            f"for this file: farhand {COMMANDS[own]} --config {path}",
            f"for this command: a file as 'farhand config show {COMMANDS[kind]}' prints it",
        ]


@pytest.mark.parametrize("name", ["console", "router"])
def test_the_recorder_takes_the_file_of_either_site_and_no_other(name: str) -> None:
    with pytest.raises(ConfigError, match="takes one of the remote site or local site") as refused:
        load_site(SITES / f"{name}.toml", ())
    assert str(refused.value).endswith("'farhand config show remote' or 'farhand config show local' prints it")


def test_a_request_to_a_site_takes_the_consoles_file() -> None:
    with pytest.raises(ConfigError, match="takes one of the console"):
        console_config(SITES / "remote.toml", cell="", control="")


@pytest.mark.parametrize(
    ("text", "settings", "mistake"),
    [
        ("[driver]\nname = 'kinematic'\n[safety]\nt_sofft_ms = 100\n", (), "did you mean t_soft_ms"),
        ("nonsense = 1\n", (), "nonsense: is not a key here"),
        ("cell = 'lab'\n", ("driver.nme=x",), "did you mean name"),
        ("cell = \n", (), "not valid TOML"),
    ],
)
def test_a_mistake_in_the_right_file_is_named_as_such(
    text: str, settings: tuple[str, ...], mistake: str, tmp_path: Path
) -> None:
    file = tmp_path / "site.toml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=mistake):
        load_own(RemoteConfig, file, settings)
