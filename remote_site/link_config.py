"""The endpoints of the remote site, or the router it is reached by."""

from typing import Annotated

from msgspec import Meta

from common.link.config import LinkSecurity


class RemoteLinksConfig(LinkSecurity, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the remote site listens."""

    control: Annotated[str, Meta(min_length=1, description="endpoint of hand, state and requests")] = (
        "tcp/127.0.0.1:7447"
    )
    video: Annotated[str, Meta(min_length=1, description="endpoint of the camera streams")] = "tcp/127.0.0.1:7448"
    router: Annotated[
        str, Meta(description="a router's endpoint, for a site that cannot be reached: then nothing listens here")
    ] = ""

    @property
    def control_endpoint(self) -> str:
        """The endpoint at which others reach hand, state and requests of this site."""
        return self.router or self.control

    @property
    def endpoints(self) -> tuple[str, ...]:
        """Every endpoint that this site uses."""
        return self.listened or (self.router,)

    @property
    def listened(self) -> tuple[str, ...]:
        """Where this site listens."""
        return () if self.router else (self.control, self.video)
