"""The port of a run's page, the same in each run where it is free, and a browser that shows the page."""

import os
import webbrowser

from common.errors import TransportError
from common.link.config import ON_THIS_HOST
from common.link.endpoints import check_free
from common.link.port_holders import listener_on
from farhand.loopback.site_process import free_ports
from local_site.console.config import ServeConfig

USUAL_PORT = ServeConfig().port
SCREENS = "DISPLAY", "WAYLAND_DISPLAY"


def page_port(wanted: int | None) -> tuple[int, str]:
    """The port that a run's page gets, and what to say where it is another than usual.

    `wanted` is the port asked for, 0 for a free one, None for the usual one, in place of which a free one is taken.
    TransportError, with the program that has it, where the port that was asked for is taken.
    """
    if wanted == 0:
        return free_ports(1)[0], ""
    port = USUAL_PORT if wanted is None else wanted
    try:
        check_free(f"tcp/127.0.0.1:{port}", ON_THIS_HOST)
    except TransportError:
        if wanted is not None:
            raise
        holder = listener_on(port) or "another user's program"
        return free_ports(1)[0], f"port {port} is taken by {holder}, so the page has another this time"
    return port, ""


def show_page(url: str) -> str:
    """Open the page in this desktop's browser; what to do instead where that is not possible, else nothing."""
    if any(map(os.environ.get, SCREENS)) and webbrowser.open(url):
        return ""
    return f"no browser can be opened from here: open {url} yourself"
