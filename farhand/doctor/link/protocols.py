"""Measures the link of a local site's or a console's configuration by every protocol that can be tried."""

from collections.abc import Callable

from common.errors import RefusedError, TransportError
from common.link.config import LinkSecurity
from common.link.endpoints import Endpoint, check_endpoint
from farhand.doctor.findings import Finding, error, ok, warning
from farhand.doctor.link.advice import judge_links
from farhand.doctor.link.figures import LinkFigures
from farhand.doctor.link.probing import measure_link
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig

OperatorsConfig = LocalConfig | ConsoleConfig
Measure = Callable[[str, LinkSecurity, str, str], LinkFigures]


def examine_link(config: OperatorsConfig, measure: Measure = measure_link) -> list[Finding]:
    """Measure the link from this host to the remote site, and judge it."""
    links, cell = config.links, config.cell
    remote = config.links.remote if isinstance(config, LocalConfig) else config.links.control
    operator = config.authority.name if isinstance(config, LocalConfig) else config.name
    try:
        configured = check_endpoint(remote, links)
    except TransportError as refused:
        return [error("links", str(refused), "correct the table [links]")]
    measured, untried = [], []
    for endpoint in _endpoints(configured):
        try:
            measured.append(measure(str(endpoint), links, cell, operator))
        except (RefusedError, TransportError) as refused:
            untried.append(_not_measured(endpoint, configured, str(refused)))
    if not configured.is_secured:
        sentence = f"TLS and QUIC were not tried: {configured} is plain tcp, for which there are no certificates"
        untried.append(ok("link tls, quic", sentence))
    return judge_links(measured, untried, str(configured))


def _endpoints(configured: Endpoint) -> list[Endpoint]:
    """The endpoint by TLS and by QUIC, the configured one first; a listener for QUIC also listens for TLS."""
    if not configured.is_secured:
        return [configured]
    other = "tls" if configured.is_quic else "quic"
    return [configured, Endpoint(other, configured.host, configured.port)]


def _not_measured(endpoint: Endpoint, configured: Endpoint, why: str) -> Finding:
    check = f"link {endpoint.protocol}"
    if endpoint == configured:
        return error(check, why, "start the remote site, and let the endpoint through; then: farhand doctor --link")
    if endpoint.is_quic:
        sentence = (
            f"QUIC was tried and not measured: nothing answers by UDP at port {endpoint.port}; the remote site listens "
            'for TLS only (links.control = "tls/..."), or UDP is blocked on the way'
        )
        return ok(check, sentence)
    return warning(check, why, "see the remote site's log")
