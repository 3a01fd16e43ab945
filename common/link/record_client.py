"""Sends one request to the recorders of both sites; it is done if at least one of them accepts it."""

from functools import partial

from common.link.channels import RECORD, RECORD_OWN
from common.link.request_client import RequestClient, answered
from common.messages.recording import EpisodeOutcome
from common.messages.requests import NO_RECORDER, SILENT, RecordAction, RecordRequest, Reply


class RecordClient:
    """`remote` asks the remote site, `local` the operator's own one; both for the same operator."""

    def __init__(self, remote: RequestClient, local: RequestClient) -> None:
        self._remote, self._local = remote, local

    def ask(
        self, action: RecordAction, task: str = "", outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN, note: str = ""
    ) -> Reply:
        """Ask both and combine their replies; a site that does not answer counts as a refusal with the code SILENT."""
        make = partial(RecordRequest, action=action, task=task, outcome=outcome, note=note)
        remote = answered(lambda: self._remote.ask(RECORD, make))
        return reply_of_both(remote, answered(lambda: self._local.ask(RECORD_OWN, make)))


def reply_of_both(remote: Reply, local: Reply) -> Reply:
    """Combine both replies: done if a site accepted it, else refused for the more telling reason."""
    done = [reply for reply in (remote, local) if reply.done]
    if len(done) == 1:
        return done[0]
    if done:
        return Reply(id=remote.id, done=True, code=remote.code, reason=f"{remote.reason}; {local.reason}")
    says_more = remote.code != NO_RECORDER or local.code in (NO_RECORDER, SILENT)
    return remote if says_more else local
