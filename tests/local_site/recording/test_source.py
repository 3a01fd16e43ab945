"""What the operator's recorder hears over a real link: its orders, and the views only while it wants them."""

import time
from collections.abc import Iterator

import pytest

import tests.common.messages.golden_examples as golden
from common.link.channels import HAND, PREVIEW, RECORD_ORDER
from common.link.transport import Link, open_link
from common.messages.requests import RecordAction, RecordRequest
from common.recording.config import OperatorRecordConfig
from farhand.loopback.site_process import free_ports
from lab.stage.waiting import until
from local_site.authority.config import AuthorityConfig
from local_site.config import LocalConfig, LocalLinksConfig
from local_site.recording.source import OperatorSource

PATIENCE_S = 10.0
CELL, NAME = "cell", "anna"


@pytest.fixture
def config() -> LocalConfig:
    remote, listen = (f"tcp/127.0.0.1:{port}" for port in free_ports(2))
    return LocalConfig(
        cell=CELL,
        links=LocalLinksConfig(remote=remote, listen=listen),
        authority=AuthorityConfig(operator=NAME),
        record=OperatorRecordConfig(operator_pictures=True),
    )


@pytest.fixture
def site(config: LocalConfig) -> Iterator[Link]:
    """The local site's end."""
    with open_link(listen=(config.links.listen,)) as link:
        yield link


def test_orders_and_messages_come_each_once(config: LocalConfig, site: Link) -> None:
    hands, orders = site.publisher(HAND, CELL, operator=NAME), site.publisher(RECORD_ORDER, CELL, operator=NAME)
    start = RecordRequest(id=7, deadline_ns=1, action=RecordAction.START)
    with OperatorSource(config) as source:
        until(lambda: hands.has_listener and orders.has_listener, "the recorder")
        hands.put(golden.HAND)
        orders.put(start)
        taken: list[RecordRequest] = []
        until(lambda: bool(taken.extend(source.orders()) or taken), "the order")
        assert taken == [start]
        keys: set[str] = set()
        until(lambda: bool(keys.update(m.key for m in source.take() if m.sent) or len(keys) == 2), "both messages")
        assert keys == {HAND.key_for(CELL, operator=NAME), RECORD_ORDER.key_for(CELL, operator=NAME)}
        assert list(source.orders()) == []


def test_the_views_are_heard_only_while_they_are_wanted(config: LocalConfig, site: Link) -> None:
    view = site.publisher(PREVIEW, CELL, "left", operator=NAME)
    with OperatorSource(config) as source:
        hands = site.publisher(HAND, CELL, operator=NAME)
        until(lambda: hands.has_listener, "the recorder")
        assert not view.has_listener
        source.hear_views(wanted=True)
        until(lambda: view.has_listener, "a listener")
        began = time.monotonic()
        source.hear_views(wanted=False)
        assert time.monotonic() - began < 0.4, "its threads did not notice"
        until(lambda: not view.has_listener, "no listener")
        source.hear_views(wanted=True)
        until(lambda: view.has_listener, "a listener again")
