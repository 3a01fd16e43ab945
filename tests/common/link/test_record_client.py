"""What is asked of the recorders of both sites: one answer of two."""

import threading
from typing import Any

import pytest

from common.errors import TransportError
from common.link.channels import RECORD, RECORD_OWN
from common.link.record_client import RecordClient
from common.link.request_client import RequestClient
from common.messages.recording import EpisodeOutcome
from common.messages.requests import RecordAction, Reply


class Site(RequestClient):
    """A site that takes everything, refuses with a code, or is silent where that is None."""

    def __init__(self, name: str, code: str | None) -> None:
        self._name, self._code = name, code
        self.asked: list[tuple[Any, Any]] = []

    def ask(self, procedure: Any, make: Any, _withdrawn: threading.Event | None = None) -> Any:
        self.asked.append((procedure, make(id=1, deadline_ns=2)))
        if self._code is None:
            raise TransportError(f"nobody answered at {self._name}")
        return Reply(id=1, done=self._code == "ok", code=self._code, reason=f"{self._name}: {self._code}")


@pytest.mark.parametrize(
    ("remote", "local", "done", "said"),
    [
        ("ok", "ok", True, "remote: ok; local: ok"),
        ("ok", "no_recorder", True, "remote: ok"),
        ("ok", None, True, "remote: ok"),
        ("no_recorder", "ok", True, "local: ok"),
        (None, "ok", True, "local: ok"),
        ("not_holder", "no_lease", False, "remote: not_holder"),
        ("no_recorder", "record_fixed", False, "local: record_fixed"),
        ("no_recorder", "no_recorder", False, "remote: no_recorder"),
        ("no_recorder", None, False, "remote: no_recorder"),
        (None, "no_recorder", False, "nobody answered at remote"),
    ],
)
def test_what_one_site_takes_is_done_and_the_more_telling_refusal_is_said(remote, local, done, said):
    reply = RecordClient(Site("remote", remote), Site("local", local)).ask(RecordAction.START)
    assert (reply.done, reply.reason) == (done, said)


def test_both_are_asked_the_same():
    remote, local = Site("remote", "ok"), Site("local", "ok")
    RecordClient(remote, local).ask(RecordAction.LABEL, "push", EpisodeOutcome.FAILURE, "slipped")
    ((procedure, request),), ((own, same),) = remote.asked, local.asked
    assert (procedure, own) == (RECORD, RECORD_OWN)
    assert request == same
    assert (request.task, request.outcome, request.note) == ("push", EpisodeOutcome.FAILURE, "slipped")
