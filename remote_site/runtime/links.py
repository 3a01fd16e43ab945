"""Opens the remote site's sessions: listening at its own endpoints, or connected to a router."""

from collections.abc import Callable

from common.link.channels import ChannelSession
from common.link.tap import MessageTap, untapped
from common.link.transport import Link, open_link
from remote_site.link_config import RemoteLinksConfig


def open_site_link(
    links: RemoteLinksConfig,
    session: ChannelSession,
    should_stop: Callable[[], bool],
    send_buffer_bytes: int | None = None,
    tap: MessageTap = untapped,
) -> Link:
    """One of the site's two sessions, listening at its endpoint unless there is a router; errors as `open_link`."""
    if links.router:
        return open_link(
            connect=(links.router,),
            security=links,
            sessions=[session],
            operators=links.operators,
            send_buffer_bytes=send_buffer_bytes,
            through_router=True,
            should_stop=should_stop,
            tap=tap,
        )
    endpoint = links.video if session is ChannelSession.VIDEO else links.control
    return open_link(
        listen=(endpoint,),
        security=links,
        sessions=[session],
        operators=links.operators,
        send_buffer_bytes=send_buffer_bytes,
        tap=tap,
    )
