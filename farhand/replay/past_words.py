"""What was said to an operator, as it is told in a replay: what was so, without what was to be done; pure."""

import re
from collections.abc import Iterator

import msgspec

from common.messages.robot import RobotState

CURE = "Cure:"
CLAUSE = re.compile(r"(?<=[:;.])\s+")
ORDERS = (
    "activate|begin|bend|bring|calibrate|check|choose|clear|come|correct|engage|farhand|free|give|hold|install|keep|let|"
    "look|make|measure|move|open|press|print|put|read|release|relieve|repair|reset it|restart|roll|see|set|show|start|"
    "stop|switch|take|to operate|try|turn|unlock|use|wait|write"
)
ORDER = re.compile(rf"(?:then |and |please )?(?:{ORDERS})\b", re.IGNORECASE)


def past_words(sentence: str) -> str:
    """The sentence without the clauses that tell somebody what to do; of a sentence that only does that, nothing."""
    clauses = CLAUSE.split(sentence.partition(CURE)[0].strip())
    told = [clause for clause in clauses if ORDER.match(clause) is None]
    return " ".join(told).rstrip(" :;,.")


def past_state(state: RobotState) -> RobotState:
    """The state with what it says in past words."""
    told = past_words(state.reason) or state.code.replace("_", " ")
    return msgspec.structs.replace(state, reason=told, **dict(_parts(state)))


def _parts(state: RobotState) -> Iterator[tuple[str, object]]:
    """The parts of a state that have a reason of their own."""
    for name in ("readiness", "hand_link", "video_link", "assist"):
        part = getattr(state, name)
        if part is not None:
            yield name, msgspec.structs.replace(part, reason=past_words(part.reason))
