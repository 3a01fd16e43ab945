"""Budget of each sender in a recording, beside the holder's hand samples: the rest is left out, counted; pure."""

from dataclasses import dataclass

from common.clock import NS_PER_S
from common.link.channels import CHANNELS, HAND, OPERATOR_CHUNK, PROCEDURES, STATE
from common.link.roles import CELL_NAME
from remote_site.recording.records import LeftOut, PassedMessage

KEPT_BYTES_PER_S = 32 << 10  # an operator's hand samples, 60 a second, and requests take half of it
HEAD_BYTES = 64  # of each message in the file, beside what it says
BURST_NS = NS_PER_S
MOST_SENDERS = 64  # with a budget of their own: a list has 32 at most, and without one anybody invents names
FIRST_SAID_NS, SAID_AGAIN_NS = NS_PER_S, 60 * NS_PER_S
OTHERS = ""  # share a budget: whose key names no operator, and names beyond MOST_SENDERS


def _kind(key: str) -> str:
    """A key without the cell's name: `state`, `hand/anna`."""
    return key.split("/", 2)[-1]


BY_OPERATOR = frozenset(
    _kind(keyed.key).removesuffix(f"/{OPERATOR_CHUNK}")
    for keyed in (*CHANNELS, *PROCEDURES)
    if keyed.key.endswith(f"/{OPERATOR_CHUNK}")
)
HANDS, STATES = _kind(HAND.key).removesuffix(f"/{OPERATOR_CHUNK}"), _kind(STATE.key)


@dataclass
class _Sender:
    """The budget is used up until `due_ns`; messages and bytes are those left out since it was last said."""

    due_ns: int = 0
    messages: int = 0
    size: int = 0
    say_ns: int = 0


class MessageBudget:
    """Every operator has a budget of bytes a second; times are ns of this host's clock."""

    def __init__(self) -> None:
        self._senders: dict[str, _Sender] = {}

    def keeps(self, message: PassedMessage, holder: str, *, refused: bool = False) -> bool:
        """Return whether a message is recorded; always the state and the holder's hand samples, unless `refused`."""
        kind, _, name = _kind(message.key).rpartition("/")
        operator = name if kind in BY_OPERATOR and CELL_NAME.fullmatch(name) is not None else OTHERS
        if message.sent and name == STATES and not kind:
            return True
        if kind == HANDS and operator == holder != OTHERS and not refused:
            return True
        return self._admits(operator, len(message.payload), message.t_ns)

    def take_left_out(self, now_ns: int) -> list[LeftOut]:
        """Take what was left out since it was last said, of each sender once a minute; soon where it is the first."""
        due = {name: sender for name, sender in self._senders.items() if sender.messages and now_ns >= sender.say_ns}
        told = [LeftOut(now_ns, name, sender.messages, sender.size) for name, sender in due.items()]
        for sender in due.values():
            sender.messages, sender.size, sender.say_ns = 0, 0, now_ns + SAID_AGAIN_NS
        return told

    def _admits(self, name: str, size: int, now_ns: int) -> bool:
        if name not in self._senders:
            name = name if len(self._senders) < MOST_SENDERS else OTHERS
        sender = self._senders.setdefault(name, _Sender())
        if sender.due_ns - now_ns <= BURST_NS:
            sender.due_ns = max(sender.due_ns, now_ns) + (size + HEAD_BYTES) * NS_PER_S // KEPT_BYTES_PER_S
            return True
        if not sender.messages:
            sender.say_ns = max(sender.say_ns, now_ns + FIRST_SAID_NS)
        sender.messages, sender.size = sender.messages + 1, sender.size + size
        return False
