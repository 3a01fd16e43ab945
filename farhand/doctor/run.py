"""The doctor's round: the machine first, then what the configuration names."""

import tomllib
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import msgspec

from common.config import load_config
from common.errors import ConfigError, TransportError
from common.link.config import LinkSecurity
from common.link.endpoints import check_endpoint
from common.link.roles import Identity, Role
from farhand.doctor import certificate_probing, certificates, machine, probing, site, site_probing
from farhand.doctor.findings import Finding, error, ok
from farhand.router import ROUTER, RouterConfig
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from remote_site.config import RemoteConfig
from remote_site.simulation.config import SIMULATED

Site = LocalConfig | RemoteConfig
Examined = Site | ConsoleConfig | RouterConfig
SITES: tuple[type[Site], ...] = (RemoteConfig, LocalConfig)
NAMES: dict[type[Examined], str] = {
    RemoteConfig: "remote site",
    LocalConfig: "local site",
    ConsoleConfig: "console",
    RouterConfig: "router",
}


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
        findings.append(ok("configuration", f"{name} of the {NAMES[kind]} is without mistakes"))
        findings += examine_config(config)
    return findings


def which_site(path: Path) -> list[type[Examined]]:
    """Whose configuration a file is, by the tables and keys in it; the sites' that it could be, where several fit."""
    try:
        told = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return [RemoteConfig]  # reading it again says what is wrong
    known = {kind: _known(told, kind) for kind in NAMES}
    likeliest = [kind for kind in NAMES if known[kind] == max(known.values())]
    return [kind for kind in likeliest if kind in SITES] or likeliest[:1]


def _known(told: dict[str, Any], kind: type[Any]) -> int:
    """How many of a file's keys, those of its tables included, are keys of this configuration."""
    types = {field.name: field.type for field in msgspec.structs.fields(kind)}
    tables = ((table, types[name]) for name, table in told.items() if name in types and isinstance(table, dict))
    return len(told.keys() & types.keys()) + sum(
        _known(table, t) for table, t in tables if hasattr(t, "__struct_fields__")
    )


def examine_config(config: Examined) -> list[Finding]:
    """What a configuration without mistakes names."""
    if isinstance(config, RemoteConfig):
        return examine_remote(config)
    if isinstance(config, LocalConfig):
        return examine_local(config)
    if isinstance(config, ConsoleConfig):
        return _examine_links(config.links, config.links.endpoints, *config.bearers)
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
