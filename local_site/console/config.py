"""The console's parameters: type, default, unit, bound and meaning of each."""

import ipaddress
from typing import Annotated

import msgspec
from msgspec import Meta, field

from common.link.channels import check_cell_name
from common.link.config import LinkSecurity
from common.link.roles import Identity, Role
from local_site.authority.config import host_operator

LEAST_TOKEN = 16


class ConsoleLinksConfig(LinkSecurity, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The endpoints of both sites."""

    control: Annotated[str, Meta(min_length=1, description="the remote site's control endpoint")] = "tcp/127.0.0.1:7447"
    video: Annotated[str, Meta(min_length=1, description="the remote site's video endpoint")] = "tcp/127.0.0.1:7448"
    local: Annotated[str, Meta(min_length=1, description="the local site's endpoint on this host")] = (
        "tcp/127.0.0.1:7457"
    )

    @property
    def endpoints(self) -> tuple[str, ...]:
        """Every endpoint that the console uses."""
        return self.control, self.video, self.local


class ServeConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the page is served; beyond this host only with token and TLS."""

    host: Annotated[str, Meta(min_length=1, description="address to listen at")] = "127.0.0.1"
    port: Annotated[int, Meta(ge=0, le=65535, description="port to listen at; 0 takes a free one")] = 8470
    names: Annotated[
        tuple[str, ...], Meta(max_length=16, description="further host names under which browsers may ask for the page")
    ] = ()
    token: Annotated[str, Meta(description="word that opens the page; required beyond this host")] = ""
    certificate: Annotated[str, Meta(description="TLS certificate, PEM file; required beyond this host")] = ""
    key: Annotated[str, Meta(description="the certificate's key, PEM file")] = ""

    def __post_init__(self) -> None:
        if bool(self.certificate) != bool(self.key):
            raise ValueError("certificate and key belong together: give both, or neither")
        if self.token and len(self.token) < LEAST_TOKEN:
            raise ValueError(f"token: {LEAST_TOKEN} characters or more; make one with: openssl rand -hex 16")
        if not self.is_loopback and not (self.token and self.certificate):
            raise ValueError(
                f"host {self.host} can be reached from other machines: that needs token, certificate and key; "
                "or keep host = '127.0.0.1'"
            )

    @property
    def is_loopback(self) -> bool:
        """Return whether only programs of this host can reach the page."""
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return self.host == "localhost"

    @property
    def scheme(self) -> str:
        """http or https."""
        return "https" if self.certificate else "http"


class ConsoleConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Every setting of the console."""

    cell: Annotated[str, Meta(description="name of the cell; all sites must agree on it")] = "cell"
    operator: Annotated[str, Meta(description="the local site's operator; empty: this host's name")] = ""
    operate: Annotated[bool, Meta(description="whether a page may operate; otherwise all only watch")] = True
    links: ConsoleLinksConfig = field(default_factory=ConsoleLinksConfig)
    serve: ServeConfig = field(default_factory=ServeConfig)

    def __post_init__(self) -> None:
        check_cell_name(self.cell)
        check_cell_name(self.name, "operator")

    @property
    def bearers(self) -> tuple[Identity, ...]:
        """Whose certificates the console may use; any that may watch, where no page operates."""
        operator = Identity(Role.OPERATOR, self.cell, self.name)
        watching = () if self.operate else (Role.VIEWER, Role.MAINTENANCE)
        return operator, *(Identity(role, self.cell) for role in watching)

    @property
    def name(self) -> str:
        """The operator's name."""
        return self.operator or host_operator()
