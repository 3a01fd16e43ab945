"""Refused messages in the log: the first of each reason, however many come."""

from structlog.testing import capture_logs

from common.errors import MessageError
from common.process.refusal_log import RefusalLog


def test_only_the_first_of_each_reason_is_told() -> None:
    refusals = RefusalLog("intent refused")
    with capture_logs() as log:
        for _ in range(30):
            refusals.note(MessageError("malformed", "no map"))
            refusals.note(MessageError("version", "6"))
    assert [(line["event"], line["log_level"]) for line in log] == [("intent refused", "warning")] * 2
    assert "no map" in log[0]["reason"]
