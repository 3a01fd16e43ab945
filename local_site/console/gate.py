"""Access to the console: the right host, the right origin, the token; and what a page may load."""

import hmac
from collections.abc import Iterable
from urllib.parse import parse_qs

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from local_site.console.config import ServeConfig

COOKIE = "farhand_token"
HEADERS = {
    "content-security-policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-cache",
}
LOOPBACK_NAMES = ("127.0.0.1", "localhost", "[::1]")


class Gate:
    """Middleware before the application; a host name in the browser's address bar that is not ours is refused.

    That, and the origin of a WebSocket, keep other sites' pages out; the token keeps other people out.
    """

    def __init__(self, app: ASGIApp, serve: ServeConfig, port: int) -> None:
        self._app, self._serve = app, serve
        names = (*LOOPBACK_NAMES, *serve.names) if serve.is_loopback else (serve.host, *serve.names)
        self._hosts = frozenset(_with_ports(names, port))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass, or refuse it with the reason."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(HTTPConnection(scope))
        if refusal is None:
            await self._app(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            await WebSocketClose(1008, "refused")(scope, receive, send)
        else:
            await refusal(scope, receive, _with_headers(send))

    def _refusal(self, request: HTTPConnection) -> Response | None:
        host = request.headers.get("host", "")
        if host not in self._hosts:
            return PlainTextResponse(f"this console is not known as {host!r}; see serve.names\n", 421)
        origin = request.headers.get("origin")
        is_socket = request.scope["type"] == "websocket"
        if (is_socket or origin is not None) and origin != f"{self._serve.scheme}://{host}":
            return PlainTextResponse("another site's page may not use this console\n", 403)
        return self._ask_for_token(request) if self._serve.token else None

    def _ask_for_token(self, request: HTTPConnection) -> Response | None:
        """None with a valid cookie; a token in the address is moved to a cookie by a redirect."""
        if self._is_token(request.cookies.get(COOKIE, "")):
            return None
        given = parse_qs(request.url.query).get("token", [""])[0]
        if not self._is_token(given):
            return PlainTextResponse("the token is missing or wrong: open the page with /?token=TOKEN\n", 401)
        answer = RedirectResponse("/", 303)
        answer.set_cookie(COOKIE, given, secure=bool(self._serve.certificate), httponly=True, samesite="strict")
        return answer

    def _is_token(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), self._serve.token.encode())


def _with_ports(names: Iterable[str], port: int) -> set[str]:
    """Names as browsers send them: default ports are left out."""
    return {f"{name}:{port}" for name in names} | {name for name in names if port in (80, 443)}


def _with_headers(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers[name] = value
        await send(message)

    return send_with_headers
