"""Plan of a loopback: each site's file and settings, those that the loopback itself needs included.

Later ones win: the loopback's preferences, a site's file, `--set`, the options `--driver`, `--motion` and `--tracker`.
A file or a setting that contradicts what the loopback needs is refused. Only the table `links` of a file is replaced,
which is reported: the file describes where its site runs elsewhere, and the loopback connects both sites here.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Generic, TypeVar

import msgspec

from common.config.loading import apply_setting, load_config, read_tables
from common.errors import ConfigError
from farhand.deployment.kinds import KINDS, Configuration, known_keys, likeliest
from farhand.loopback.page_port import page_port
from farhand.loopback.scenario import arm_file, arm_settings, check_scenario, operator_settings, operator_wishes
from farhand.loopback.site_process import free_ports, options_of
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from remote_site.config import RemoteConfig
from remote_site.drivers.config import ADDRESS_OPTIONS
from remote_site.drivers.registry import check_driver
from remote_site.session.config import EngagementMode

CELL = "loopback"
REMOTE_TABLES, LOCAL_TABLES = frozenset(RemoteConfig.__struct_fields__), frozenset(LocalConfig.__struct_fields__)

S = TypeVar("S", bound=msgspec.Struct)


@dataclass(frozen=True, slots=True)
class LoopbackOptions:
    """The options of the command line; `configs` and `settings` are those of both sites, `port` is the page's."""

    seconds: float = 30.0
    report: Path | None = None
    driver: str | None = None
    motion: str | None = None
    tracker: str | None = None
    arm: str | None = None
    save_views: Path | None = None
    headless: bool = False
    port: int | None = None
    record: Path | None = None
    configs: tuple[Path, ...] = ()
    settings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SitePlan(Generic[S]):
    """The configuration of one process: its kind, its file and the settings that override it."""

    kind: type[S]
    path: Path | None
    settings: tuple[str, ...]

    def load(self) -> S:
        """The configuration; ConfigError names every mistake."""
        return load_config(self.kind, self.path, self.settings)

    @property
    def arguments(self) -> list[str]:
        """The same for a command line."""
        file = ["--config", str(self.path)] if self.path is not None else []
        return [*file, *options_of(self.settings)]

    def gives(self, key: str) -> bool:
        """Return whether the file or a setting gives this key a value."""
        value = read_tables(self.path)
        for setting in self.settings:
            apply_setting(value, setting)
        for part in key.split("."):
            if not isinstance(value, dict) or part not in value:
                return False
            value = value[part]
        return True

    def setting(self, *settings: str) -> "SitePlan[S]":
        """With these settings above all others."""
        return replace(self, settings=(*self.settings, *settings))

    def preferring(self, setting: str) -> "SitePlan[S]":
        """With this setting where nothing else gives the key."""
        return self if self.gives(setting.partition("=")[0]) else self.setting(setting)

    def needing(self, setting: str, reason: str) -> "SitePlan[S]":
        """With this setting; ConfigError when the key is given another value."""
        key, needed = setting.partition("=")[0], self.setting(setting)
        if self.gives(key) and needed.load() != self.load():
            raise ConfigError(f"{key}: the loopback needs {setting}, {reason}; leave {key} out")
        return needed


@dataclass(frozen=True, slots=True)
class Plan:
    """The configurations of both sites and the console, and what the user should know about them."""

    remote: SitePlan[RemoteConfig]
    local: SitePlan[LocalConfig]
    console: SitePlan[ConsoleConfig]
    notes: tuple[str, ...]


def plan_of(options: LoopbackOptions) -> Plan:
    """The plan on free ports of this host; ConfigError for options, files and settings that do not fit together."""
    given_remote, given_local = _given(options)
    given_local = _local_needs(given_local)
    given_remote = _remote_needs(given_remote, given_local.load().tracking.method)
    local, remote = given_local.load(), given_remote.load()
    check_scenario(local.tracking.method, options.arm, local.simulation.motion.name, remote.driver.name)
    control, video, listen = (f"tcp/127.0.0.1:{port}" for port in free_ports(3))
    page, note = (0, "") if options.headless else page_port(options.port)
    cells = {site.load().cell for site in (given_remote, given_local) if site.gives("cell")}
    if len(cells) > 1:
        raise ConfigError(f"cell: the sites' files name different cells ({_list(cells)}); both sites must agree on it")
    cell = cells.pop() if cells else CELL
    links = f"links.control={control}", f"links.video={video}", f"links.local={listen}", f"serve.port={page}"
    return Plan(
        remote=given_remote.setting(f"cell={cell}", f'links={{control="{control}", video="{video}"}}'),
        local=given_local.setting(f"cell={cell}", f'links={{remote="{control}", listen="{listen}"}}'),
        console=SitePlan(ConsoleConfig, None, (f"cell={cell}", f"operator={local.authority.name}", *links)),
        notes=(*_unused_links(options.configs), *([note] if note else ())),
    )


def _unused_links(paths: Iterable[Path]) -> list[str]:
    words = "its table [links] is not used; the loopback connects both sites itself"
    return [f"{path}: {words}" for path in paths if "links" in read_tables(path)]


def _given(options: LoopbackOptions) -> tuple[SitePlan[RemoteConfig], SitePlan[LocalConfig]]:
    """Collect what the user gives each site."""
    files: dict[type[Configuration], Path] = {}
    for path in options.configs:
        kind = _kind_of(path)
        if kind in files:
            raise ConfigError(f"{files[kind]} and {path} are both for the {KINDS[kind]}; give one file for each site")
        files[kind] = path
    settings = _settings(options.settings)
    if options.arm is not None and RemoteConfig in files:
        raise ConfigError(f"--arm {options.arm} is a configuration of its own; leave it or --config out")
    driver = [f"driver.name={options.driver}"] if options.driver else []
    operator = [f"simulation.motion.name={options.motion}"] if options.motion else []
    operator += [f"tracking.method={options.tracker}"] if options.tracker else []
    return (
        SitePlan(
            RemoteConfig,
            files.get(RemoteConfig, arm_file(options.arm, options.driver)),
            (*settings[RemoteConfig], *driver),
        ),
        SitePlan(LocalConfig, files.get(LocalConfig), (*settings[LocalConfig], *operator)),
    )


def _kind_of(path: Path) -> type[Configuration]:
    """Which site a file is for; ConfigError when that is not clear."""
    table = read_tables(path)
    only_remote, only_local = REMOTE_TABLES - LOCAL_TABLES, LOCAL_TABLES - REMOTE_TABLES
    remote, local = _list(table.keys() & only_remote), _list(table.keys() & only_local)
    if remote and local:
        raise ConfigError(f"{path}: {remote} is the remote site's, {local} the local site's; use a file for each")
    kinds = likeliest(table, tuple(KINDS))
    if len(kinds) > 1:
        raise ConfigError(
            f"{path}: {_list(table) or 'an empty file'} does not show which site it is for; give it a table of the "
            f"remote site ({_list(only_remote)}) or of the local site ({_list(only_local)})"
        )
    if kinds[0] not in (RemoteConfig, LocalConfig):
        raise ConfigError(
            f"{path} is for the {KINDS[kinds[0]]}; the loopback takes files of the remote and the local site"
        )
    return kinds[0]


def _settings(settings: Sequence[str]) -> dict[type[Configuration], list[str]]:
    """The settings of each site; the cell is both's. ConfigError when it is not clear whose one is."""
    sites: dict[type[Configuration], list[str]] = {RemoteConfig: [], LocalConfig: []}
    for setting in settings:
        table: dict[str, object] = {}
        table_name, *_ = apply_setting(table, setting)
        if table_name == "links":
            raise ConfigError(f"--set {setting}: the loopback connects both sites itself; leave it out")
        kinds = likeliest(table, (RemoteConfig, LocalConfig))
        if not known_keys(table, kinds[0]):
            raise ConfigError(
                f"--set {setting}: no site has {table_name}; the remote site has {_list(REMOTE_TABLES)}, "
                f"the local site {_list(LOCAL_TABLES)}"
            )
        if len(kinds) > 1 and table_name != "cell":
            raise ConfigError(f"--set {setting}: both sites have {table_name}; give it in the --config file of one")
        for kind in kinds:
            sites[kind].append(setting)
    return sites


def _remote_needs(remote: SitePlan[RemoteConfig], tracker: str) -> SitePlan[RemoteConfig]:
    remote = remote.preferring("video.calibrated=true")
    driver = remote.load().driver.name
    check_driver(driver)
    if driver in ADDRESS_OPTIONS:
        address = ADDRESS_OPTIONS[driver]
        if remote.gives(f"driver.options.{address}"):
            raise ConfigError(f"driver.options.{address}: the loopback emulates the robot; leave the {address} out")
        remote = remote.needing("driver.emulate=true", "since it never drives the real robot")
    remote = remote.preferring(f"engagement.mode={EngagementMode.AUTOMATIC}")  # nobody is there to engage
    for setting in arm_settings(tracker):
        remote = remote.needing(setting, f"since the {tracker} tracker's camera sees the palm from the right")
    return remote


def _local_needs(local: SitePlan[LocalConfig]) -> SitePlan[LocalConfig]:
    config = local.load()
    if not config.operator.is_simulated:
        raise ConfigError(
            "operator.left: the loopback measures against the simulated operator; leave the table [operator] out, "
            "or use these cameras with: farhand local"
        )
    tracker = config.tracking.method
    for setting in operator_settings(tracker):
        local = local.needing(setting, f"for an operator whom the {tracker} tracker can follow from the engagement on")
    for setting in operator_wishes(tracker):
        local = local.preferring(setting)
    return local


def _list(names: Iterable[str]) -> str:
    return ", ".join(sorted(names))
