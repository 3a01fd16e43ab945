"""Opens the remote site's sessions: listening at its own endpoints, or connected to a router."""

from collections.abc import Callable

from common.link.transport import Link, open_link
from remote_site.link_config import RemoteLinksConfig


def open_site_link(
    links: RemoteLinksConfig, endpoint: str, given_up: Callable[[], bool], send_buffer_bytes: int | None = None
) -> Link:
    """One of the site's two sessions, which listens at its endpoint unless there is a router; errors as `open_link`."""
    if links.router:
        return open_link(
            connect=(links.router,),
            security=links,
            send_buffer_bytes=send_buffer_bytes,
            through_router=True,
            given_up=given_up,
        )
    return open_link(listen=(endpoint,), security=links, send_buffer_bytes=send_buffer_bytes)
