"""`farhand record` knows whose configuration it is given, and refuses what it must not write over."""

from pathlib import Path

import pytest

from common.errors import ConfigError
from common.process.service import StopFlag
from farhand.deployment.shipped import HERE
from farhand.recording.site_recorder import FOLDERS, load_site, run_recorder
from local_site.config import LocalConfig
from remote_site.config import RemoteConfig

SITES = HERE / "sites"


@pytest.mark.parametrize(
    ("name", "settings", "kind"),
    [
        ("remote", (), RemoteConfig),
        ("remote-thesis", (), RemoteConfig),
        ("local", (), LocalConfig),
        ("local-cameras", (), LocalConfig),
        (None, (), RemoteConfig),
        (None, ("links.control=tcp/127.0.0.1:7500",), RemoteConfig),
        (None, ("links.listen=tcp/127.0.0.1:7500", "record.operator_pictures=true"), LocalConfig),
    ],
)
def test_a_configuration_is_known_by_its_tables(
    name: str | None, settings: tuple[str, ...], kind: type[RemoteConfig | LocalConfig]
) -> None:
    path = SITES / f"{name}.toml" if name is not None else None
    assert isinstance(load_site(path, settings), kind)


def test_an_existing_file_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "kept.mcap").write_bytes(b"kept")
    with pytest.raises(ConfigError, match="exists already"):
        run_recorder(None, (), None, tmp_path / "kept.mcap", lambda: pytest.fail("no date is needed"), StopFlag())
    assert (tmp_path / "kept.mcap").read_bytes() == b"kept"


@pytest.mark.parametrize("out", ["afile", "afile/within", "/proc/x"])
def test_a_folder_that_cannot_be_is_refused_once_and_before_anything_begins(
    out: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "afile").touch()
    with pytest.raises(ConfigError, match=r"no recording can be kept in .*; give another --out"):
        run_recorder(None, (), tmp_path / out, None, lambda: pytest.fail("no date is needed"), StopFlag())
    assert capfd.readouterr().err == ""  # the command line says it


def test_the_recorders_of_two_sites_on_one_host_keep_apart() -> None:
    """They begin in the same second and name their files alike, and each removes what is too much in its own folder."""
    assert set(FOLDERS) == {RemoteConfig, LocalConfig}
    assert len(set(FOLDERS.values())) == 2
