"""Runs all checks: the machine first, then what the configuration names."""

from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path

from common.config.loading import CURE_UNREAD, apply_setting, load_config, read_tables
from common.errors import ConfigError, ConfigFileError, TransportError
from common.link.config import LinkSecurity, TlsConfig, ViewersConfig
from common.link.credentials import TABLE, check_viewers
from common.link.endpoints import check_endpoint
from common.link.roles import Identity, Role
from farhand.deployment.kinds import KINDS, Configuration, likeliest
from farhand.doctor import arm, cameras, landmarks, machine, site
from farhand.doctor.findings import Finding, error, ok
from farhand.doctor.link.protocols import examine_link
from farhand.router import TLS_TABLE as ROUTERS_TLS
from farhand.router import VIEWERS_TABLE as ROUTERS_VIEWERS
from local_site.calibration.control_points import CAMERAS
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from remote_site.config import RemoteConfig
from remote_site.link_config import VIEWERS_TABLE
from remote_site.simulation.config import SIMULATED

Site = LocalConfig | RemoteConfig
SITES: tuple[type[Site], ...] = (RemoteConfig, LocalConfig)


def examine(path: Path | None, settings: Sequence[str]) -> list[Finding]:
    """All findings; without a file, those of both sites' default configurations."""
    state = machine.STATE if machine.STATE.is_dir() else Path.cwd()
    findings = [
        machine.check_python(*machine.probe_python()),
        machine.check_real_time(*machine.probe_real_time()),
        machine.check_congestion(*machine.probe_congestion()),
        machine.check_disk(*machine.probe_free_bytes(state)),
        machine.check_shared_memory(*machine.probe_free_bytes(machine.SHARED_MEMORY)),
    ]
    kinds = SITES if path is None else which_site(path)
    for kind in kinds:
        try:
            config = load_config(kind, path, [setting for setting in settings if kind in _sites_of(setting, kinds)])
        except ConfigError as wrong:
            findings += _mistakes(wrong)
            continue
        name = "the default" if path is None else str(path)
        findings.append(ok("configuration", f"{name} of the {KINDS[kind]} has no mistakes"))
        findings += examine_config(config)
        if path is not None:
            findings += _examine_secrets(path, config)
    return findings


def examine_link_of(path: Path | None, settings: Sequence[str]) -> list[Finding]:
    """The link from a local site's or a console's host; without a file, that of the local site's defaults."""
    try:
        read_tables(path)
        kinds: Sequence[type[Configuration]] = [LocalConfig] if path is None else which_site(path)
        if LocalConfig in kinds:
            return examine_link(load_config(LocalConfig, path, settings))
        if ConsoleConfig in kinds:
            return examine_link(load_config(ConsoleConfig, path, settings))
    except ConfigError as wrong:
        return _mistakes(wrong)
    cure = "give the file of a local site or a console there: --config /etc/farhand/local.toml"
    return [error("configuration", f"the link is measured from the operator's host, and {path} is not for it", cure)]


def _mistakes(wrong: ConfigError) -> list[Finding]:
    """A finding for each mistake of a configuration."""
    if isinstance(wrong, ConfigFileError):
        return [error("configuration", str(wrong).removesuffix(f"; {CURE_UNREAD}"), CURE_UNREAD)]
    return [error("configuration", line, "correct that line") for line in str(wrong).splitlines()]


def _sites_of(setting: str, kinds: Sequence[type[Configuration]]) -> list[type[Configuration]]:
    """Whose a setting is: of several sites, those that know its key, all where none does."""
    table: dict[str, object] = {}
    apply_setting(table, setting)
    return likeliest(table, kinds)


def which_site(path: Path) -> list[type[Configuration]]:
    """Whose configuration a file is, by its tables and keys; where several fit, those of the sites."""
    try:
        table = read_tables(path)
    except ConfigError:
        return [RemoteConfig]  # loading it reports what is wrong
    kinds = likeliest(table, tuple(KINDS))
    return [kind for kind in kinds if kind in SITES] or kinds[:1]


def examine_config(config: Configuration) -> list[Finding]:
    """Examine what a configuration without mistakes names."""
    if isinstance(config, RemoteConfig):
        return examine_remote(config)
    if isinstance(config, LocalConfig):
        return examine_local(config)
    if isinstance(config, ConsoleConfig):
        return _examine_links(config.links, config.links.endpoints, *config.bearers)
    findings = [*_examine_links(config, config.listen, config.bearer, table=ROUTERS_TLS), *site.check_operators(config)]
    return [*findings, *_examine_viewers(config.viewers, config.tls, config.bearer, ROUTERS_VIEWERS)]


def _examine_secrets(path: Path, config: Configuration) -> list[Finding]:
    """Who can read what a file's configuration has of secrets."""
    mode = path.stat().st_mode
    if isinstance(config, ConsoleConfig):
        return [site.check_token(path, mode)] if config.serve.token else []
    if isinstance(config, LocalConfig):
        return site.check_sources(path, mode, config.operator.sources)
    if isinstance(config, RemoteConfig):
        return site.check_sources(path, mode, [camera.source for camera in config.video.cameras])
    return []


def examine_remote(config: RemoteConfig) -> list[Finding]:
    """Certificate, robot, views and ports of the robot's side."""
    bearer = Identity(Role.REMOTE, config.cell)
    findings = _examine_links(config.links, config.links.endpoints, bearer)
    findings += site.check_operators(config.links)
    findings += _examine_viewers(config.links.viewers, config.links.tls, bearer, VIEWERS_TABLE)
    mistakes = arm.probe_robot(config)
    findings += arm.check_robot(config.robot.model, config.driver.name, mistakes)
    if not mistakes:
        findings += [arm.check_stops(arm.probe_stops(config)), arm.check_guard(arm.probe_unguarded(config))]
    if config.views_are_simulated:
        findings.append(machine.check_rendering(machine.probe_rendering()))
    real = {camera.name: camera.source for camera in config.video.cameras if camera.source != SIMULATED}
    findings += (cameras.check_camera(cameras.probe_camera(*camera, config.video.fps)) for camera in real.items())
    return [*findings, *_examine_ports(zip(("control", "video"), config.links.listened, strict=False), config)]


def examine_local(config: LocalConfig) -> list[Finding]:
    """Tracker, certificate, cameras, calibration, ports and clock of the operator's side."""
    links, operator = config.links, config.operator
    findings = [machine.check_cache(*machine.probe_cache())]
    if config.tracking.method == "learned":
        findings += landmarks.check_landmarks(landmarks.probe_landmarks())
    if config.tracking.method == "eye":
        findings.append(machine.check_networks(machine.probe_networks()))
    findings += _examine_links(links, (links.remote, links.listen), config.bearer)
    if not operator.is_simulated:
        rig = cameras.probe_rig(operator.rig, datetime.now(UTC))
        findings += [cameras.check_rig(rig), *_examine_cameras(rig, config)]
    findings += _examine_ports([("local", links.listen)], config)
    return [*findings, site.check_clock(site.probe_clock(config.cell, links.remote, links))]


def _examine_cameras(rig: cameras.RigFacts, config: LocalConfig) -> list[Finding]:
    """The operator's cameras with their settings; where no rig names them, by the names that a calibration gives."""
    sources = config.operator.sources
    known = rig.names[config.tracking.monocular.camera :][:1] if config.operator.alone else rig.names
    names = known if len(known) == len(sources) else CAMERAS[: len(sources)]
    try:
        settings = config.operator.settings_of(names)
    except ConfigError as wrong:
        return [error("configuration", str(wrong), "correct that name")]
    given = zip(names, sources, strict=True)
    probed = [cameras.probe_camera(name, source, config.operator.fps, settings[name]) for name, source in given]
    colours = cameras.check_colours(config.tracking.method, probed)
    return [*map(cameras.check_camera, probed), *cameras.check_sizes(rig, probed), *colours]


def _examine_links(
    links: LinkSecurity, endpoints: Sequence[str], *bearers: Identity, table: str = TABLE
) -> list[Finding]:
    """The endpoints, and the certificate where there is one: it must name one of the bearers."""
    findings = []
    for endpoint in endpoints:
        try:
            check_endpoint(endpoint, links)
        except TransportError as refused:
            findings.append(error("links", str(refused), "correct the table [links]"))
    if links.tls.is_given:
        facts = site.probe_certificate(links.tls, datetime.now(UTC), table)
        names = [bearer.common_name for bearer in bearers]
        findings += site.check_certificate(facts, facts.names if facts.names in names else names[0])
    return findings


def _examine_viewers(viewers: ViewersConfig, own: TlsConfig, bearer: Identity, table: str) -> list[Finding]:
    """The viewers' endpoint where there is one: its certificate, of an authority apart, and its port."""
    if not viewers.listen:
        return []
    facts = site.probe_certificate(viewers.tls, datetime.now(UTC), table)
    findings = site.check_certificate(facts, bearer.common_name)
    if not facts.problem:
        try:
            check_viewers(viewers, own, bearer, table)
        except ConfigError as refused:
            findings.append(error("viewers", str(refused), f"correct the table [{table}]"))
    return [*findings, site.check_port(site.probe_port("viewers", viewers.listen, viewers.security))]


def _examine_ports(endpoints: Iterable[tuple[str, str]], config: Site) -> list[Finding]:
    """The endpoints (purpose, endpoint) of a site, and that of its metrics."""
    metrics = [("metrics", config.metrics.endpoint)] if config.metrics.port else []
    facts = (site.probe_port(*endpoint, config.links) for endpoint in (*endpoints, *metrics))
    return [site.check_port(port) for port in facts]
