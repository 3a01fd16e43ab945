"""The endpoints of the remote site, or the router it is reached by."""

from typing import Annotated

from msgspec import Meta, field

from common.link.channels import ANY
from common.link.config import OperatorLinks, ViewersConfig
from common.link.endpoints import SECURED

VIEWERS_TABLE = "links.viewers.tls"


class RemoteLinksConfig(OperatorLinks, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the remote site listens."""

    control: Annotated[str, Meta(min_length=1, description="endpoint of hand, state and requests")] = (
        "tcp/127.0.0.1:7447"
    )
    video: Annotated[str, Meta(min_length=1, description="endpoint of the camera streams")] = "tcp/127.0.0.1:7448"
    router: Annotated[
        str, Meta(description="a router's endpoint, for a site that cannot be reached: then nothing listens here")
    ] = ""
    viewers: ViewersConfig = field(default_factory=ViewersConfig)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.router and self.viewers.listen:
            raise ValueError(
                "viewers: nothing listens here behind a router; viewers connect there: give the router's file this "
                "table, as [viewers], and leave it out here"
            )

    @property
    def control_endpoint(self) -> str:
        """The endpoint at which others reach hand, state and requests of this site."""
        return self.router or self.control

    @property
    def heard(self) -> tuple[str, ...]:
        """Whose keys this site listens to: the operators listed; without list and certificates anybody's."""
        is_secured = self.control_endpoint.partition("/")[0] in SECURED
        return self.operators or (() if is_secured else (ANY,))

    @property
    def endpoints(self) -> tuple[str, ...]:
        """Every endpoint that this site uses."""
        return self.listened or (self.router,)

    @property
    def listened(self) -> tuple[str, ...]:
        """The endpoints at which this site listens."""
        return () if self.router else (self.control, self.video)
