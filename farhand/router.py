"""The meeting point for sites that cannot reach each other: a session in router mode, and zenohd's configuration."""

import json
from functools import partial
from typing import Annotated, Any

import structlog
from msgspec import Meta, field

from common.errors import ConfigError
from common.link.channels import check_cell_name
from common.link.config import NAME_OPERATORS, OperatorLinks, ViewersConfig
from common.link.credentials import Credentials, check_links, check_viewers
from common.link.endpoints import check_endpoint, check_free
from common.link.roles import Identity, Role
from common.link.session_settings import Mode, Served, SessionEndpoints, session_settings
from common.link.transport import open_router
from common.link.viewers import Site
from common.process.children import Children
from common.process.log import LogFormat, log_end, start_log
from common.process.service import StopFlag, notify
from common.process.viewers import run_viewers

BEAT_S = 0.2
TLS_TABLE, VIEWERS_TABLE = "tls", "viewers.tls"
EndpointName = Annotated[str, Meta(min_length=1)]


class RouterConfig(OperatorLinks, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All parameters of the router."""

    listen: Annotated[
        tuple[EndpointName, ...], Meta(min_length=1, max_length=8, description="endpoints for the sites of the cell")
    ] = ("tcp/127.0.0.1:7450",)
    cell: Annotated[str, Meta(description="the cell whose sites connect here")] = "cell"
    viewers: ViewersConfig = field(default_factory=ViewersConfig)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_cell_name(self.cell)

    @property
    def bearer(self) -> Identity:
        """Whose certificate the router uses."""
        return Identity(Role.ROUTER, self.cell)


def run_router(config: RouterConfig, should_stop: StopFlag, log_format: LogFormat = LogFormat.TEXT) -> None:
    """Pass on the sites' messages until asked to stop; TransportError or ConfigError when it cannot."""
    start_log("router", log_format)
    check_links(config.listen, config, config.bearer, table=TLS_TABLE)
    check_viewers(config.viewers, config.tls, config.bearer, VIEWERS_TABLE)
    if config.tls.is_given and not config.operators:
        structlog.get_logger().warning("nobody may operate: operators is empty", cure=NAME_OPERATORS)
    children = _start_viewers(config)
    try:
        with open_router(listen=config.listen, security=config, operators=config.operators):
            notify("READY=1")
            structlog.get_logger().info("ready", cell=config.cell, listen=", ".join(config.listen))
            while not should_stop.wait(BEAT_S):
                children.check()
                notify("WATCHDOG=1")
            notify("STOPPING=1")
    finally:
        children.end()
    log_end()


def _start_viewers(config: RouterConfig) -> Children:
    """The process that serves viewers, where they have an endpoint; forked before the router opens its session."""
    children, viewers = Children("router"), config.viewers
    if viewers.listen:
        check_free(viewers.listen, viewers.security)
        seen = Site(config.cell, config.listen[:1], config)
        children.start("viewers", partial(run_viewers, viewers, VIEWERS_TABLE, seen), vital=False)
    return children


def zenohd_configuration(config: RouterConfig) -> str:
    """The same router for zenohd, as JSON5: the same caps, and the same roles by the names in certificates.

    ConfigError where it serves viewers, which takes a process of Farhand.
    """
    if config.viewers.listen:
        raise ConfigError("viewers: zenohd serves none; run 'farhand router' instead, or leave [viewers] out")
    listening = tuple(check_endpoint(endpoint, config) for endpoint in config.listen)
    credentials = Credentials(config.tls, config.bearer) if config.tls.is_given else None
    served = Served(credentials, config.operators)
    nested: dict[str, Any] = {"adminspace": {"enabled": False}}
    for path, value in session_settings(SessionEndpoints(Mode.ROUTER, listening), served).items():
        *parents, leaf = path.split("/")
        table = nested
        for parent in parents:
            table = table.setdefault(parent, {})
        table[leaf] = value
    return json.dumps(nested, indent=2)
