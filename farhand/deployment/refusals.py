"""What a start refuses of a configuration whose keys and values are right: endpoints, cameras, the simulated operator.

Ports, certificates and cameras themselves are not looked at.
"""

from collections.abc import Callable, Iterator
from itertools import combinations
from typing import NamedTuple

from common.config.loading import ConfigMistake
from common.config.places import KeyPath
from common.errors import FarhandError, TransportError
from common.link.config import LinkSecurity
from common.link.endpoints import EVERYWHERE, Endpoint, check_endpoint
from common.link.session_settings import PICTURES_SEND_BUFFER_BYTES, Mode, SessionEndpoints
from farhand.deployment.kinds import Configuration
from farhand.router import RouterConfig
from local_site.acquisition.same_source import refuse_same
from local_site.calibration.control_points import CAMERAS
from local_site.config import LocalConfig
from local_site.simulation.cameras import calibrate_simulated
from local_site.simulation.operator import make_operator
from remote_site.config import RemoteConfig


class _Used(NamedTuple):
    """An endpoint, the key that it stands at, and how it is protected and used."""

    key: KeyPath
    endpoint: str
    security: LinkSecurity
    is_heard: bool = True
    has_pictures: bool = False


def links_table(config: Configuration) -> KeyPath:
    """The table of a configuration that has its endpoints and certificates."""
    return () if isinstance(config, RouterConfig) else ("links",)


def refused_links(config: Configuration) -> Iterator[ConfigMistake]:
    """Each endpoint that is not allowed, or at which another one of the file listens already."""
    heard: list[tuple[KeyPath, Endpoint]] = []
    for used in _endpoints(config):
        try:
            endpoint = check_endpoint(used.endpoint, used.security)
            if used.has_pictures:
                SessionEndpoints(Mode.PEER, (endpoint,), send_buffer_bytes=PICTURES_SEND_BUFFER_BYTES)
        except TransportError as error:
            yield ConfigMistake(used.key, str(error))
            continue
        heard += [(used.key, endpoint)] if used.is_heard else []
    for (first, one), (second, other) in combinations(heard, 2):
        if one.port == other.port and (one.host == other.host or {one.host, other.host} & EVERYWHERE.keys()):
            yield ConfigMistake(second, f"port {other.port} is taken by {'.'.join(first)}; give each a port of its own")


def refused_operator(config: LocalConfig) -> Iterator[ConfigMistake]:
    """Cameras that are the same, or a simulated operator who cannot move or be filmed so."""
    operator, simulation = config.operator, config.simulation
    if not operator.is_simulated:
        yield from _told(("operator",), lambda: refuse_same(dict(zip(CAMERAS, operator.sources, strict=False))))
        return
    yield from _told(("simulation", "motion"), lambda: make_operator(simulation))
    if not simulation.textured:
        yield from _told(("simulation", "stereo"), lambda: calibrate_simulated(simulation))


def _told(table: KeyPath, use: Callable[[], object]) -> Iterator[ConfigMistake]:
    try:
        use()
    except FarhandError as error:
        yield ConfigMistake(table, " ".join(str(error).split()))


def _endpoints(config: Configuration) -> Iterator[_Used]:
    """The endpoints that a start checks, in its order."""
    if isinstance(config, RouterConfig):
        yield from (_Used(("listen",), endpoint, config) for endpoint in config.listen)
    elif isinstance(config, RemoteConfig) and config.links.router:
        yield _Used(("links", "router"), config.links.router, config.links, is_heard=False, has_pictures=True)
    elif isinstance(config, RemoteConfig):
        yield _Used(("links", "control"), config.links.control, config.links)
        yield _Used(("links", "video"), config.links.video, config.links, has_pictures=True)
    elif isinstance(config, LocalConfig):
        yield _Used(("links", "remote"), config.links.remote, config.links, is_heard=False)
        yield _Used(("links", "listen"), config.links.listen, config.links)
    else:
        for key in ("control", "video", "local"):
            yield _Used(("links", key), getattr(config.links, key), config.links, is_heard=False)
    if isinstance(config, RemoteConfig | LocalConfig) and config.metrics.port:
        yield _Used(("metrics", "port"), config.metrics.endpoint, config.links)
    if isinstance(config, RemoteConfig | RouterConfig):
        viewers = config.viewers if isinstance(config, RouterConfig) else config.links.viewers
        if viewers.listen:
            yield _Used((*links_table(config), "viewers", "listen"), viewers.listen, viewers.security)
