"""Protection of a site's links: by certificates, or explicitly none."""

from typing import Annotated

import msgspec
from msgspec import Meta, field

from common.link.channels import check_cell_name

PLAIN_TEXT_WORDS = "i accept that anybody on this network can move the arm"

NAME_OPERATORS = (
    'name those who may operate, as in their certificates: operators = ["NAME"] (a key of [links], of a router '
    "of no table); then restart"
)


class TlsConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Certificates for endpoints that begin with tls/ or quic/, as 'farhand certificates create' writes them."""

    ca: Annotated[str, Meta(description="the authority's certificate, PEM file")] = ""
    certificate: Annotated[str, Meta(description="this site's own certificate, PEM file")] = ""
    key: Annotated[str, Meta(description="its private key, PEM file that only its owner can read")] = ""

    def __post_init__(self) -> None:
        if len({bool(self.ca), bool(self.certificate), bool(self.key)}) != 1:
            raise ValueError("ca, certificate and key belong together: give all three, or none")

    @property
    def is_given(self) -> bool:
        """Return whether certificates are configured."""
        return bool(self.ca)


class LinkSecurity(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The protection of links that leave this host."""

    tls: TlsConfig = field(default_factory=TlsConfig)
    plain_text_beyond_loopback: Annotated[
        str, Meta(description=f'tcp/ endpoints on other hosts without any protection: "{PLAIN_TEXT_WORDS}"')
    ] = ""

    def __post_init__(self) -> None:
        if self.plain_text_beyond_loopback not in ("", PLAIN_TEXT_WORDS):
            raise ValueError(f'plain_text_beyond_loopback: leave it out, or write "{PLAIN_TEXT_WORDS}"')


class ViewersConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The endpoint for viewers: with certificates of an authority that no other endpoint of the site trusts."""

    listen: Annotated[str, Meta(description="tls/ endpoint for those who only watch; empty: nobody is let watch")] = ""
    tls: TlsConfig = field(default_factory=TlsConfig)

    def __post_init__(self) -> None:
        if self.listen and not self.listen.startswith("tls/"):
            raise ValueError("listen: viewers connect by TLS alone; write it as tls/HOST:PORT")
        if bool(self.listen) != self.tls.is_given:
            raise ValueError(
                "listen and tls belong together: give both, or neither; 'farhand certificates create CELL' makes "
                "viewers-ca.pem and a pair for this listener"
            )

    @property
    def security(self) -> LinkSecurity:
        """The protection of the viewers' links."""
        return LinkSecurity(tls=self.tls)


class OperatorLinks(LinkSecurity, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Links to several operators, who are told apart by their certificates."""

    operators: Annotated[
        tuple[str, ...],
        Meta(
            max_length=32,
            description="who may operate, by the names in their certificates; a name taken off is refused after a "
            "restart. Empty: nobody; without certificates anybody on this host",
        ),
    ] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in self.operators:
            check_cell_name(name, "operators")
        if len(set(self.operators)) != len(self.operators):
            raise ValueError("operators: name everybody once")


ON_THIS_HOST = LinkSecurity()  # no certificates: only plain TCP on the loopback interface is allowed
