"""Who may ask the recorder for what."""

import pytest

from common.messages.requests import RecordAction
from remote_site.reasons import Code
from remote_site.runtime.recording_requests import refusal_of
from remote_site.session.lease import Holder, Lease
from tests.common.recording.recorder_states import ASKED, FIXED, FULL, IDLE

LEASE = Lease(41, Holder(7, "anna"), 10**9)


@pytest.mark.parametrize(
    ("action", "operator", "lease", "state", "code"),
    [
        (RecordAction.START, "anna", LEASE, IDLE, None),
        (RecordAction.STOP, "anna", LEASE, ASKED, None),
        (RecordAction.START, "ben", LEASE, IDLE, Code.NOT_HOLDER),
        (RecordAction.STOP, "ben", LEASE, ASKED, Code.NOT_HOLDER),
        (RecordAction.LABEL, "ben", LEASE, ASKED, Code.NOT_HOLDER),
        (RecordAction.START, "anna", None, IDLE, Code.NO_LEASE),
        (RecordAction.START, "anna", LEASE, None, Code.NO_RECORDER),
        (RecordAction.STOP, "anna", LEASE, FIXED, Code.RECORD_FIXED),
        (RecordAction.START, "anna", LEASE, FIXED, Code.RECORD_FIXED),
        (RecordAction.BEGIN, "anna", LEASE, FIXED, None),
        (RecordAction.BEGIN, "anna", LEASE, IDLE, Code.NOT_RECORDING),
        (RecordAction.BEGIN, "anna", LEASE, FULL, Code.TOO_MANY_EPISODES),
        (RecordAction.END, "anna", LEASE, FULL, None),
        (RecordAction.STOP, "anna", LEASE, FULL, None),
    ],
)
def test_only_the_holder_may_ask_and_only_for_what_can_be_done(action, operator, lease, state, code):
    refusal = refusal_of(action, operator, lease, state)
    assert (refusal.code if refusal is not None else None) is code
