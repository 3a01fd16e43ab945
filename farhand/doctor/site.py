"""Needs of a configured site: ports, clocks, certificates; probes, and pure checks."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from common.cameras.camera import Source
from common.cameras.shown_source import hides_part, shown_source
from common.clock import NS_PER_S
from common.errors import ConfigError, RefusedError, TransportError
from common.link.config import NAME_OPERATORS, ON_THIS_HOST, LinkSecurity, OperatorLinks, TlsConfig
from common.link.credentials import TABLE, load_credentials
from common.link.endpoints import check_endpoint, check_free
from common.link.port_holders import is_ours, listener_on
from common.link.remote_clock import RemoteClock
from common.link.transport import open_link
from farhand.certificates.authorities import read_certificate
from farhand.doctor.findings import Finding, error, ok, warning

CLOCK_TIMEOUT_NS = 2 * NS_PER_S
ROUND_TRIPS = 20
ROUND_TRIP_PERIOD_S = 0.05
SECONDS_PER_DAY = 86400.0
PERMISSION_BITS = 0o777
UNCERTAIN_NS = 5_000_000
EXPIRES_SOON_DAYS = 30
GROUP, OTHERS = 0o070, 0o007
RENEW = "where the authority is kept: farhand certificates renew CELL; then copy the pair here and restart"


@dataclass(frozen=True, slots=True)
class PortFacts:
    """An endpoint to listen at: its purpose, whether it is free, else who listens there, or what is wrong."""

    purpose: str
    endpoint: str
    free: bool = False
    holder: str = ""
    problem: str = ""


def probe_port(purpose: str, endpoint: str, security: LinkSecurity) -> PortFacts:
    """Probe whether this host can listen on an endpoint, else which process already does."""
    try:
        check_endpoint(endpoint, security)
    except TransportError as wrong:
        return PortFacts(purpose, endpoint, problem=str(wrong))
    try:
        check_free(endpoint, security)
    except TransportError:
        return PortFacts(purpose, endpoint, holder=listener_on(int(endpoint.rpartition(":")[2])))
    return PortFacts(purpose, endpoint, free=True)


def check_port(facts: PortFacts) -> Finding:
    """The port is free, or the running site listens there."""
    check = f"port {facts.purpose}"
    if facts.problem:
        return error(check, facts.problem, "correct the table [links]")
    if facts.free:
        return ok(check, f"{facts.endpoint} is free")
    holder = facts.holder or "a program of another user"
    if is_ours(holder):
        return ok(check, f"{holder} listens at {facts.endpoint}")
    return error(check, f"{holder} listens at {facts.endpoint}", "stop that program, or configure another port")


@dataclass(frozen=True, slots=True)
class ClockFacts:
    """The other host's clock less ours, ns, with its uncertainty; None when that site does not answer.

    `silence` is what may keep it from answering, where the link is up.
    """

    endpoint: str
    offset_ns: int | None = None
    uncertainty_ns: int = 0
    problem: str = ""
    silence: str = ""


def probe_clock(cell: str, endpoint: str, security: LinkSecurity = ON_THIS_HOST) -> ClockFacts:
    """Estimate the remote clock's offset from ROUND_TRIPS replies, or those that come within CLOCK_TIMEOUT_NS."""
    try:
        with open_link(connect=(endpoint,), security=security) as link:
            clock, round_trips = RemoteClock(link, cell), 0
            deadline_ns = time.monotonic_ns() + CLOCK_TIMEOUT_NS
            while round_trips < ROUND_TRIPS and time.monotonic_ns() < deadline_ns:
                round_trips += clock.measure() is not None
                time.sleep(ROUND_TRIP_PERIOD_S)
            silence = link.why_silent()
    except RefusedError as wrong:
        return ClockFacts(endpoint, problem=str(wrong))
    except TransportError:
        return ClockFacts(endpoint)  # the check of the links reports what is wrong with the endpoint
    estimate = clock.estimate(time.monotonic_ns())
    if estimate is None:
        return ClockFacts(endpoint, silence=silence)
    return ClockFacts(endpoint, estimate.offset.offset_ns, estimate.offset.uncertainty_ns)


def check_clock(facts: ClockFacts) -> Finding:
    """The offset of the two hosts' clocks is known well enough."""
    if facts.problem:
        return error("clocks", facts.problem, "install the same release on both sites")
    if facts.offset_ns is None:
        sentence = f"the remote site does not answer at {facts.endpoint}, so the offset of its clock is unknown"
        if facts.silence:
            return warning("clocks", f"{sentence}; {facts.silence}", "add this operator to links.operators there")
        return warning("clocks", sentence, "start the remote site; then: farhand lease show")
    sentence = f"remote minus local {facts.offset_ns / 1e6:.3f} ms, uncertainty {facts.uncertainty_ns / 1e6:.3f} ms"
    if facts.uncertainty_ns > UNCERTAIN_NS:
        return warning("clocks", sentence, "the link is slow or busy: check it (ping, other traffic)")
    return ok("clocks", sentence)


@dataclass(frozen=True, slots=True)
class CertificateFacts:
    """A certificate's file, whom it names, days until it and its authority expire, its key's mode; or what is wrong."""

    path: str
    names: str = ""
    days_left: float = 0.0
    authority_days_left: float = 0.0
    key_mode: int = 0
    problem: str = ""


def probe_certificate(tls: TlsConfig, now: datetime, table: str = TABLE) -> CertificateFacts:
    """Load the files that a table names as a link would, then read the days left at `now` and the key file's mode."""
    try:
        identity = load_credentials(tls, table).identity
        certificates = read_certificate(Path(tls.certificate)), read_certificate(Path(tls.ca))
    except (TransportError, ConfigError) as wrong:
        return CertificateFacts(tls.certificate, problem=str(wrong))
    key_mode = Path(tls.key).stat().st_mode & PERMISSION_BITS
    days, authority_days = ((each.not_valid_after_utc - now).total_seconds() / SECONDS_PER_DAY for each in certificates)
    return CertificateFacts(tls.certificate, identity.common_name, days, authority_days, key_mode)


def check_certificate(facts: CertificateFacts, expected: str) -> list[Finding]:
    """It is valid now and for a while, it is for this site (`expected`), and no other user can read its key."""
    if facts.problem:
        sentence, _, cure = facts.problem.partition("; ")
        return [error("certificate", sentence, cure or RENEW)]
    findings = [_check_expiry("certificate", f"{facts.path} of {facts.names}", facts.days_left, RENEW)]
    if facts.authority_days_left < EXPIRES_SOON_DAYS:
        cure = "make a new authority in a new folder: farhand certificates create CELL --dir NEW, for all hosts at once"
        findings.append(_check_expiry("certificate authority", "it", facts.authority_days_left, cure))
    if facts.names != expected:
        sentence = f"{facts.path} is for {facts.names}, not for {expected}"
        findings.append(error("certificate", sentence, "give this site its own certificate in the table [links.tls]"))
    if facts.key_mode & (GROUP | OTHERS):
        judge = error if facts.key_mode & OTHERS else warning
        whose = "everybody on this host" if facts.key_mode & OTHERS else "its group"
        findings.append(judge("certificate key", f"{whose} can read the key of {facts.path}", "chmod 600 the key"))
    return findings


def check_token(path: Path, mode: int) -> Finding:
    """Not everybody can read the word that opens the page, in a file of this mode."""
    if mode & OTHERS:
        return error("page's token", f"everybody on this host can read it in {path}", f"chmod o= {path}")
    return ok("page's token", f"not everybody can read it in {path}")


def check_sources(path: Path, mode: int, sources: Sequence[Source]) -> list[Finding]:
    """Not everybody can read the URLs of cameras, in a file of this mode."""
    shown = [shown_source(source) for source in sources if hides_part(source)]
    if not shown or not mode & OTHERS:
        return []
    sentence = f"everybody on this host can read the whole URL of {', '.join(shown)} in {path}, which may hold one"
    return [warning("camera's password", sentence, f"chmod o= {path}")]


def check_operators(links: OperatorLinks) -> list[Finding]:
    """Check that somebody may operate, where there are certificates."""
    if not links.tls.is_given:
        return []
    if not links.operators:
        return [warning("operators", "nobody may operate: the list operators is empty", NAME_OPERATORS)]
    return [ok("operators", f"by their certificates: {', '.join(links.operators)}")]


def _check_expiry(check: str, what: str, days: float, cure: str) -> Finding:
    sentence = f"{what} expires in {days:.0f} days"
    return warning(check, sentence, cure) if days < EXPIRES_SOON_DAYS else ok(check, sentence)
