"""The doctor's round: the machine first, then what the configuration names."""

import tomllib
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from common.config import load_config
from common.errors import ConfigError
from common.roles import Identity, Role
from farhand.doctor import certificate_probing, certificates, machine, probing, site, site_probing
from farhand.doctor.findings import Finding, error, ok
from local_site.config import LocalConfig
from remote_site.config import RemoteConfig
from remote_site.video.config import SIMULATED

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
        findings.append(ok("configuration", f"{name} of the {_name(kind)} site is without mistakes"))
        findings += examine_remote(config) if isinstance(config, RemoteConfig) else examine_local(config)
    return findings


def which_site(path: Path) -> list[type[Site]]:
    """Whose configuration a file is, by the tables in it; both sites' where it has none of either's own."""
    try:
        told = set(tomllib.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return [RemoteConfig]  # reading it again says what is wrong
    known = {kind: len(told & set(kind.__struct_fields__)) for kind in SITES}
    return [kind for kind in SITES if known[kind] == max(known.values())]


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
    findings = [*_examine_certificate(config, Role.REMOTE), *site.check_robot(site_probing.probe_robot(config))]
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
    findings = [machine.check_cache(probing.probe_cache()), *_examine_certificate(config, Role.OPERATOR)]
    if not config.operator.is_simulated:
        findings += _examine_cameras(config)
    listening = [("local", config.links.listen), *_metrics(config)]
    findings += map(site.check_port, site_probing.probe_ports(listening, config.links))
    findings.append(site.check_clock(site_probing.probe_clock(config.cell, config.links.remote, config.links)))
    return findings


def _examine_certificate(config: Site, role: Role) -> list[Finding]:
    tls = config.links.tls
    if not tls.is_given:
        return []
    facts = certificate_probing.probe_certificate(tls, datetime.now(UTC))
    return certificates.check_certificate(facts, Identity(role, config.cell).common_name)


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


def _name(kind: type[Site]) -> str:
    return "remote" if kind is RemoteConfig else "local"
