"""The meeting point for sites that cannot reach each other: a session in router mode, and zenohd's configuration."""

import json
from typing import Annotated, Any

import structlog
from msgspec import Meta

from common.link.channels import check_cell_name
from common.link.config import NAME_OPERATORS, OperatorLinks
from common.link.credentials import Credentials, check_links
from common.link.endpoints import check_endpoint
from common.link.roles import Identity, Role
from common.link.session_settings import Mode, Served, SessionEndpoints, session_settings
from common.link.transport import open_router
from common.process.log import LogFormat, log_end, start_log
from common.process.service import StopFlag, notify

BEAT_S = 0.2
EndpointName = Annotated[str, Meta(min_length=1)]


class RouterConfig(OperatorLinks, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All parameters of the router."""

    listen: Annotated[
        tuple[EndpointName, ...], Meta(min_length=1, max_length=8, description="endpoints for the sites of the cell")
    ] = ("tcp/127.0.0.1:7450",)
    cell: Annotated[str, Meta(description="the cell whose sites connect here")] = "cell"

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
    check_links(config.listen, config, config.bearer)
    if config.tls.is_given and not config.operators:
        structlog.get_logger().warning("nobody may operate: operators is empty", cure=NAME_OPERATORS)
    with open_router(listen=config.listen, security=config, operators=config.operators):
        notify("READY=1")
        structlog.get_logger().info("ready", cell=config.cell, listen=", ".join(config.listen))
        while not should_stop.wait(BEAT_S):
            notify("WATCHDOG=1")
        notify("STOPPING=1")
    log_end()


def zenohd_configuration(config: RouterConfig) -> str:
    """The same router for zenohd, as JSON5: the same caps, and the same roles by the names in certificates."""
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
