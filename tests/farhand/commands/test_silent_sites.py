"""Every command that asks a site names the endpoint at which none answers, and ends."""

import re
from typing import Any

import pytest
from typer.testing import CliRunner

from common.clock import NS_PER_MS
from common.errors import TransportError
from farhand.cli import app
from tests.farhand.commands.parser_walk import options_of, walk

ASKS = {"--remote": "tcp/127.0.0.1:9", "--local": "tcp/127.0.0.1:11"}
ASKING = [
    pytest.param(words, options_of(command) & set(ASKS), id=" ".join(words))
    for words, command in walk()
    if options_of(command) & set(ASKS)
]


@pytest.mark.slow
@pytest.mark.parametrize(("words", "options"), ASKING)
def test_the_endpoint_that_does_not_answer_is_named(
    words: tuple[str, ...], options: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for patience in ("common.link.request_client", "farhand.authority.asking"):
        monkeypatch.setattr(f"{patience}.PATIENCE_NS", 100 * NS_PER_MS)
    monkeypatch.setattr("farhand.authority.record.LOCAL_PATIENCE_NS", 100 * NS_PER_MS)
    monkeypatch.setattr("farhand.status.watch.PATIENCE_S", 0.1)
    asker = ["ben"] if words == ("lease", "give") else []
    given = [part for option in options for part in (option, ASKS[option])]
    done: Any = CliRunner().invoke(app, [*words, *asker, *given])
    assert isinstance(done.exception, TransportError)
    told = str(done.exception)
    asked = re.findall(r"tcp/127\.0\.0\.1:\d+", told)
    assert asked
    assert set(asked) <= {ASKS[option] for option in options}
    assert "answers at" in told
    assert "runs there" in told
