"""Who is let in: only our own names and origins, beyond this host only with the token; and what is served with it."""

import asyncio

import pytest
from starlette.types import Message, Receive, Scope, Send

from common.config.loading import load_config
from common.errors import ConfigError
from local_site.console.config import ConsoleConfig, ServeConfig
from local_site.console.gate import COOKIE, Gate

TOKEN = "0123456789abcdef"  # noqa: S105  # opens nothing but these tests
OPEN = ServeConfig()
GUARDED = ServeConfig(host="192.0.2.7", token=TOKEN, certificate="c.pem", key="k.pem", names=("lab.example",))


def ask(serve: ServeConfig, headers: dict[str, str], kind: str = "http", query: str = "") -> tuple[int, dict[str, str]]:
    """The status and headers of an answer; 200 and 101 come from the application behind the gate."""
    sent = []

    async def application(scope: Scope, _receive: Receive, send: Send) -> None:
        passed = {"type": "http.response.start", "status": 200, "headers": []}
        await send(passed if scope["type"] == "http" else {"type": "websocket.accept"})

    async def send(message: Message) -> None:
        sent.append(message)

    async def receive() -> Message:
        return {"type": "websocket.connect"}

    pairs = [(name.encode(), value.encode()) for name, value in headers.items()]
    scope = {"type": kind, "path": "/", "method": "GET", "query_string": query.encode(), "headers": pairs}
    asyncio.run(Gate(application, serve, 8470)(scope, receive, send))
    if kind == "websocket":
        return (101 if sent[0]["type"] == "websocket.accept" else sent[0]["code"]), {}
    return sent[0]["status"], {name.decode(): value.decode() for name, value in sent[0]["headers"]}


@pytest.mark.parametrize("host", ["127.0.0.1:8470", "localhost:8470", "[::1]:8470"])
def test_this_host_is_served_with_a_policy_that_loads_nothing_from_elsewhere(host: str) -> None:
    status, headers = ask(OPEN, {"host": host})
    assert status == 200
    assert "default-src 'none'" in headers["content-security-policy"]
    assert "http" not in headers["content-security-policy"]


@pytest.mark.parametrize("host", ["evil.example:8470", "127.0.0.1", "127.0.0.1:9", ""])
def test_another_name_is_refused(host: str) -> None:
    assert ask(OPEN, {"host": host})[0] == 421
    assert ask(OPEN, {"host": host, "origin": f"http://{host}"}, "websocket")[0] == 1008


@pytest.mark.parametrize("origin", [None, "http://evil.example", "https://127.0.0.1:8470", "null"])
def test_a_socket_of_another_page_is_refused(origin: str | None) -> None:
    headers = {"host": "127.0.0.1:8470"} | ({"origin": origin} if origin else {})
    assert ask(OPEN, headers, "websocket")[0] == 1008


def test_a_socket_of_our_own_page_is_accepted() -> None:
    headers = {"host": "127.0.0.1:8470", "origin": "http://127.0.0.1:8470"}
    assert ask(OPEN, headers, "websocket")[0] == 101


def test_beyond_this_host_the_token_opens_the_page_and_leaves_the_address() -> None:
    host = {"host": "lab.example:8470"}
    assert ask(GUARDED, host)[0] == 401
    assert ask(GUARDED, host, query="token=wrong")[0] == 401
    status, headers = ask(GUARDED, host, query=f"token={TOKEN}")
    assert (status, headers["location"]) == (303, "/")
    cookie = headers["set-cookie"]
    assert all(word in cookie for word in ("HttpOnly", "SameSite=strict", "Secure"))
    assert ask(GUARDED, host | {"cookie": f"{COOKIE}={TOKEN}"})[0] == 200


def test_beyond_this_host_a_socket_needs_the_token_too() -> None:
    headers = {"host": "192.0.2.7:8470", "origin": "https://192.0.2.7:8470"}
    assert ask(GUARDED, headers, "websocket")[0] == 1008
    assert ask(GUARDED, headers | {"cookie": f"{COOKIE}={TOKEN}"}, "websocket")[0] == 101


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["serve.host=0.0.0.0"], "needs token, certificate and key"),
        (["serve.host=0.0.0.0", f"serve.token={TOKEN}"], "needs token, certificate and key"),
        (["serve.host=lab.example", "serve.certificate=c", "serve.key=k"], "needs token"),
        (["serve.certificate=c"], "belong together"),
        (["serve.token=short"], "16 characters or more"),
    ],
)
def test_what_would_leave_the_page_open_is_refused_at_the_start(settings: list[str], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        load_config(ConsoleConfig, None, settings)
