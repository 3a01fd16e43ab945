"""What a link's tap sees of hand samples: every one, and which are none."""

from types import SimpleNamespace

import pytest

from common.errors import MessageError
from common.link.channels import HAND
from common.link.pubsub import Latest
from common.messages.codec import encode
from tests.common.link.secured_cell import HAND_SAMPLE

KEY = HAND.key_for("cell", operator="ben")


@pytest.mark.parametrize(("payload", "refused"), [(encode(HAND_SAMPLE), False), (b"noise", True)])
def test_a_message_is_seen_byte_for_byte_and_as_refused_where_it_is_none(payload: bytes, refused: bool) -> None:
    seen = []
    sample = SimpleNamespace(key_expr=KEY, payload=SimpleNamespace(to_bytes=lambda: payload))
    subscriber = SimpleNamespace(try_recv=lambda: sample)
    hands = Latest(subscriber, HAND, lambda *given, **named: seen.append((*given, named)))  # type: ignore[arg-type]  # a stand-in
    try:
        hands.take()
    except MessageError:
        assert refused
    assert [(key, data, named.get("refused", False)) for key, data, named in seen] == [(KEY, payload, refused)]
