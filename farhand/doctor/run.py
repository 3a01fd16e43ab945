"""The doctor's round: the machine first, then what the configuration names."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from common.config import load_config, read_tables
from common.errors import ConfigError, TransportError
from common.link.config import LinkSecurity
from common.link.endpoints import check_endpoint
from common.link.roles import Identity, Role
from farhand.deployment.kinds import KINDS, Configuration, likeliest
from farhand.doctor import certificate_probing, certificates, machine, probing, site, site_probing
from farhand.doctor.findings import Finding, error, ok
from farhand.router import ROUTER
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from remote_site.config import RemoteConfig
from remote_site.simulation.config import SIMULATED

Site = LocalConfig | RemoteConfig
SITES: tuple[type[Site], ...] = (RemoteConfig, LocalConfig)


def examine(path: Path | None, settings: Sequence[str]) -> list[Finding]:
    """All findings; without a file those for both sites as they are by default."""
    findings = examine_machine()
    for kind in SITES if path is None else which_site(path):
        try:
            config = load_config(kind, path, settings)
        except ConfigError as wrong:
            findings += [error("configuration", line, "correct that line") for line in str(wrong).splitlines()]
            continue
        name = str(path) if path is not None else "the default"
        findings.append(ok("configuration", f"{name} of the {KINDS[kind]} is without mistakes"))
        findings += examine_config(config)
    return findings


def which_site(path: Path) -> list[type[Configuration]]:
    """Whose configuration a file is, by the tables and keys in it; the sites' that it could be, where several fit."""
    try:
        table = read_tables(path)
    except ConfigError:
        return [RemoteConfig]  # reading it again says what is wrong
    kinds = likeliest(table, tuple(KINDS))
    return [kind for kind in kinds if kind in SITES] or kinds[:1]


def examine_config(config: Configuration) -> list[Finding]:
    """What a configuration without mistakes names."""
    if isinstance(config, RemoteConfig):
        return examine_remote(config)
    if isinstance(config, LocalConfig):
        return examine_local(config)
    if isinstance(config, ConsoleConfig):
        return _examine_links(config.links, config.links.places, *config.bearers)
    return _examine_links(config, config.listen, ROUTER)


def examine_machine() -> list[Finding]:
    """What concerns every site."""
    return [
        machine.check_python(probing.probe_python()),
        machine.check_real_time(probing.probe_real_time()),
        machine.check_congestion(probing.probe_congestion()),
        machine.check_disk(probing.probe_disk()),
        machine.check_shared_memory(probing.probe_shared_memory()),
    ]


def examine_remote(config: RemoteConfig) -> list[Finding]:
    """Certificate, robot, views and ports of the robot's side."""
    own = Identity(Role.REMOTE, config.cell)
    findings = [
        *_examine_links(config.links, config.links.places, own),
        *site.check_robot(site_probing.probe_robot(config)),
    ]
    if config.views_are_simulated:
        findings.append(machine.check_rendering(probing.probe_rendering()))
    video = config.video
    real = [camera for camera in video.cameras if camera.source != SIMULATED]
    cameras = [site_probing.probe_camera(camera.name, camera.source, video.fps) for camera in real]
    listening = [*zip(("control", "video"), config.links.listened, strict=False), *_metrics(config)]
    return [
        *findings,
        *map(site.check_camera, cameras),
        *map(site.check_port, site_probing.probe_ports(listening, config.links)),
    ]


def examine_local(config: LocalConfig) -> list[Finding]:
    """Certificate, cameras, calibration, ports and clock of the operator's side."""
    places, own = (config.links.remote, config.links.listen), Identity(Role.OPERATOR, config.cell)
    findings = [machine.check_cache(probing.probe_cache()), *_examine_links(config.links, places, own)]
    if not config.operator.is_simulated:
        findings += _examine_cameras(config)
    listening = [("local", config.links.listen), *_metrics(config)]
    findings += map(site.check_port, site_probing.probe_ports(listening, config.links))
    findings.append(site.check_clock(site_probing.probe_clock(config.cell, config.links.remote, config.links)))
    return findings


def _examine_links(links: LinkSecurity, places: Sequence[str], *bearers: Identity) -> list[Finding]:
    """The endpoints, and the certificate where there is one: of the first bearer or another that will do."""
    findings = []
    for place in places:
        try:
            check_endpoint(place, links)
        except TransportError as refused:
            findings.append(error("links", str(refused), "correct the table [links]"))
    if links.tls.is_given:
        facts = certificate_probing.probe_certificate(links.tls, datetime.now(UTC))
        names = [bearer.common_name for bearer in bearers]
        findings += certificates.check_certificate(facts, facts.names if facts.names in names else names[0])
    return findings


def _examine_cameras(config: LocalConfig) -> list[Finding]:
    operator = config.operator
    rig = site_probing.probe_rig(operator.rig, datetime.now(UTC))
    names = ("left", "right", "third", "fourth")
    cameras = tuple(
        site_probing.probe_camera(name, source, operator.fps)
        for name, source in zip(names, operator.sources, strict=False)
    )
    return [site.check_rig(rig), *map(site.check_camera, cameras), *site.check_sizes(rig, cameras)]


def _metrics(config: Site) -> list[tuple[str, str]]:
    return [("metrics", config.metrics.endpoint)] if config.metrics.port else []
