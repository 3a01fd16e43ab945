"""What the operator asks of the sites through the page."""

import threading
from functools import partial

from common.link.channels import JOINTS, OPERATE
from common.link.engagement_client import ask_engagement
from common.link.record_client import RecordClient
from common.link.request_client import RequestClient, answered
from common.link.transport import Link
from common.messages.recording import EpisodeOutcome
from common.messages.requests import (
    EngagementAction,
    JointsRequest,
    OperatorAction,
    OperatorRequest,
    PicturePoint,
    RecordAction,
    Reply,
)
from common.messages.robot import Asker
from local_site.console.cell_watch import CellWatch


class SiteRequests:
    """Asks and waits, so call it from a thread that may wait; a silent site gives a refusal with a sentence."""

    def __init__(self, link: Link, watch: CellWatch, cell: str, operator: str) -> None:
        self._remote = RequestClient(link, cell, watch.clock, operator=operator)
        self._local = RequestClient(link, cell, operator=operator)
        self._recorders = RecordClient(self._remote, self._local)

    def engagement(self, action: EngagementAction, seen_ns: int = 0, withdrawn: threading.Event | None = None) -> Reply:
        """The remote site's reply to who was shown the halt at `seen_ns`; once `withdrawn` is set it is not asked."""
        return answered(lambda: ask_engagement(self._remote, action, seen_ns, withdrawn=withdrawn))

    def lease(self, action: OperatorAction, to: Asker | None) -> Reply:
        """The local site's reply; `to` is whom the page has shown to ask for the lease."""
        return answered(lambda: self._local.ask(OPERATE, partial(OperatorRequest, action=action, to=to)))

    def record(self, action: RecordAction, outcome: EpisodeOutcome) -> Reply:
        """What both sites reply to what is asked of their recorders."""
        return self._recorders.ask(action, outcome=outcome)

    def joints(self, shoulder: PicturePoint, elbow: PicturePoint, wrist: PicturePoint) -> Reply:
        """The local site's reply to the positions of the joints that the operator has clicked."""
        make = partial(JointsRequest, shoulder=shoulder, elbow=elbow, wrist=wrist)
        return answered(lambda: self._local.ask(JOINTS, make))
