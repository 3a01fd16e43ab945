"""Reports of trouble in the site's log: of each operator once a minute, whatever the others report."""

from collections import deque

from structlog.testing import capture_logs

from common.clock import NS_PER_S
from common.link.servers import Asked
from common.messages.requests import TroubleNoted, TroubleReport
from remote_site.runtime.request_server import TroubleReports


class Reports:
    """Stands for the link over which operators report; `answered` counts what they were answered."""

    def __init__(self) -> None:
        self._waiting: dict[str, deque[Asked[TroubleReport, TroubleNoted]]] = {}
        self.answered = 0

    def answer(self, _procedure: object, _cell: str, _refused: object, operator: str) -> "Source":
        self._waiting[operator] = deque()
        return Source(self._waiting[operator])

    def report(self, operator: str, reason: str) -> None:
        self._waiting[operator].append(Asked(operator, TroubleReport(reason=reason), self._note))

    def _note(self, _answer: TroubleNoted) -> None:
        self.answered += 1


class Source:
    """The reports of one operator."""

    def __init__(self, waiting: "deque[Asked[TroubleReport, TroubleNoted]]") -> None:
        self._waiting = waiting

    def take(self) -> Asked[TroubleReport, TroubleNoted] | None:
        return self._waiting.popleft() if self._waiting else None


def test_an_operators_reports_hide_none_of_anothers() -> None:
    link, operators = Reports(), ("anna", "ben")
    troubles = TroubleReports(link, "cell", operators, print)  # type: ignore[arg-type]  # a stand-in
    with capture_logs() as lines:
        for second in range(600):
            if second % 20 == 0:
                link.report("ben", "x")
            if second % 60 == 5:
                link.report("anna", "UDP is blocked")
            troubles.poll(second * NS_PER_S)
    said = [line["operator"] for line in lines]
    assert (said.count("anna"), said.count("ben")) == (10, 10)
    assert {line["reason"] for line in lines if line["operator"] == "anna"} == {"UDP is blocked"}
    assert link.answered == 40
