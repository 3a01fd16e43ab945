"""Takes the reports of operators' sites about trouble of their links, and logs them: of each operator once a minute."""

from collections.abc import Callable, Sequence

from common.errors import MessageError
from common.link.channels import TROUBLE
from common.link.transport import Link
from common.messages.requests import TroubleNoted
from common.process.link_log import TroubleLog

REPORTED_EVENT = "an operator's site reports trouble of the link"


class TroubleReports:
    """Polled by the control loop; no operator's reports keep another's out of the log."""

    def __init__(
        self, link: Link, cell: str, operators: Sequence[str], refused: Callable[[MessageError], None]
    ) -> None:
        self._sources = [
            (link.answer(TROUBLE, cell, refused, operator=operator), TroubleLog(REPORTED_EVENT))
            for operator in operators
        ]

    def poll(self, now_ns: int) -> None:
        """Note one waiting report of each operator."""
        for server, log in self._sources:
            if (told := server.take()) is not None:
                log.note("reported", told.question.reason, now_ns, operator=told.operator)
                told.reply(TroubleNoted())
