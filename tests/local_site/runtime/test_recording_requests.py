"""Which requests to record the operator's side are granted."""

import pytest

from common.messages.requests import RecordAction, RecordRequest
from local_site.runtime.recorder_relay import answer
from tests.common.recording.recorder_states import ASKED, FIXED, FULL, IDLE


@pytest.mark.parametrize(
    ("action", "state", "holds_lease", "code"),
    [
        (RecordAction.START, IDLE, True, "record_asked"),
        (RecordAction.START, IDLE, False, "no_lease"),
        (RecordAction.STOP, ASKED, True, "record_asked"),
        (RecordAction.STOP, ASKED, False, "record_asked"),  # who is recorded may always end it
        (RecordAction.START, None, True, "no_recorder"),
        (RecordAction.START, FIXED, True, "record_fixed"),
        (RecordAction.STOP, FIXED, True, "record_fixed"),
        (RecordAction.BEGIN, FIXED, True, "record_asked"),
        (RecordAction.LABEL, FIXED, False, "no_lease"),
        (RecordAction.LABEL, IDLE, True, "not_recording"),
        (RecordAction.BEGIN, FULL, True, "too_many_episodes"),
        (RecordAction.END, FULL, True, "record_asked"),
        (RecordAction.STOP, FULL, True, "record_asked"),
    ],
)
def test_the_leases_holder_may_ask_for_what_can_be_done(action, state, holds_lease, code):
    reply = answer(RecordRequest(id=7, deadline_ns=1, action=action), state, holds_lease=holds_lease)
    assert (reply.id, reply.code, reply.done) == (7, code, code == "record_asked")
