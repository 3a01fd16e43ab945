"""A page's WebSocket as the library has it, but for pings of a page that never reads the pongs."""

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol


class PageSocket(WebSocketsSansIOProtocol):
    """Leaves pings unanswered while the page has not read what it was sent; RFC 6455 asks for the newest pong alone.

    Reading goes on meanwhile: a stop, and that the page is there, must be heard over a link that is slow the other way.
    """

    def handle_ping(self) -> None:
        """Answer, unless too much waits to be read."""
        pongs = b"".join(self.conn.data_to_send())
        if self.writable.is_set():
            self.transport.write(pongs)
