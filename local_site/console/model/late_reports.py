"""Reports that come late: where the remote site says that no page operates, though one of this console does; pure."""

from msgspec.structs import replace

from common.clock import NS_PER_MS
from common.link.channels import HAND
from common.messages.requests import Reply
from common.messages.robot import NO_PAGE, RobotState
from local_site.console.model.seat import BEAT_TIMEOUT_NS, MOST_AGE_NS, Seat

CURE = "close other programs on the page's host, then engage again"


def late_reports(seat: Seat, hand_ns: int | None, state: RobotState, now_ns: int) -> str:
    """The sentence for it, empty where no page operates; `hand_ns` is when the newest hand sample came."""
    if seat.occupant is None:
        return ""
    page = f"page {seat.occupant.number} operates, but"
    silent_ms, heard_ms = seat.silent_ns(now_ns) / NS_PER_MS, seat.heard_ago_ns(now_ns) / NS_PER_MS
    if seat.silent_ns(now_ns) > BEAT_TIMEOUT_NS:
        limit_ms = BEAT_TIMEOUT_NS / NS_PER_MS
        return f"{page} its last report came {silent_ms:.0f} ms ago (limit {limit_ms:.0f} ms): {CURE}"
    if seat.late(now_ns):
        limit_ms = MOST_AGE_NS / NS_PER_MS
        return f"{page} its reports come {heard_ms:.0f} ms late (limit {limit_ms:.0f} ms): {CURE}"
    if hand_ns is None or now_ns - hand_ns > 5 * HAND.stale_after_ns:
        return f"{page} the local site, which passes its reports on, is silent: start it (farhand local)"
    link = state.hand_link
    if link is not None and link.age_ms is not None and link.age_ms > state.age_limit_ms:
        return (
            f"{page} the hand samples that carry its reports reach the robot {link.age_ms:.0f} ms late "
            f"(limit {state.age_limit_ms:.0f} ms): see to the link"
        )
    return f"{page} its reports reach the local site too late: {CURE}"


def named(state: RobotState, words: str) -> RobotState:
    """The state with these words in place of the sentence that no page operates; as it is without words."""
    if not words or NO_PAGE not in state.reason + state.readiness.reason:
        return state
    ready = replace(state.readiness, reason=state.readiness.reason.replace(NO_PAGE, words))
    return replace(state, readiness=ready, reason=state.reason.replace(NO_PAGE, words))


def answered(reply: Reply, words: str) -> Reply:
    """The same for the answer to a request."""
    return replace(reply, reason=reply.reason.replace(NO_PAGE, words)) if words else reply
