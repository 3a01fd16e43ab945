"""What the page says of a state: the bar's word and sentence, the next step, and the line that tells who operates."""

import json
from functools import partial
from typing import Any, NamedTuple

from msgspec.structs import replace

from common.clock import NS_PER_S
from common.messages.hand import HandArm
from common.messages.robot import LeaseState, Readiness, RobotState, SessionState
from lab.measure.page import scene
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.seat import Seat, Visitor
from local_site.console.model.situation import NewestMessages, situation_json
from tests.local_site.console.static.page_script import run

OPERATOR = "anna"
ENGAGED, DISENGAGED = SessionState.ENGAGED, SessionState.DISENGAGED
READY = partial(
    scene.state, DISENGAGED, "ready", "ready: waiting to be engaged", readiness=Readiness(True, "ready", "ready", False)
)
FOLLOWS = partial(scene.state, ENGAGED, "ok", "the arm follows the hand")
SCRIPT = """
  const [situation, whose, facts] = v;
  const [bar, step, people] = await Promise.all(["condition", "next_step", "operators"].map(load));
  const condition = bar.conditionOf(situation, whose, bar.saidOf(false));
  const operates = situation.seat.page === whose.page;
  const act = people.leaseAct(situation.robot?.lease ?? null, whose.operator);
  const said = step.stepOf(condition, situation, { ...whose, operates, mayOperate: true, act, down: false, ...facts });
  const seat = people.seatWords(situation.seat, situation.robot, { operates, ...whose });
  return { ...condition, step: said.words, next: said.next, seat };
"""


class Said(NamedTuple):
    """The bar's word, second line and sentence, the next step's words and button, and who operates."""

    word: str
    second: str
    sentence: str
    step: str
    next: str | None
    seat: str


def said(
    state: RobotState | None,
    *,
    page: int = 1,
    stopper: Visitor | None = None,
    hand: HandArm | None = None,
    silent_ns: int = 0,
    **facts: object,
) -> Said:
    """What this page says where page 1 has the controls; `stopper` has asked for a stop, `facts` are the step's own."""
    now_ns, history, seat = 100 * NS_PER_S, History(), Seat(open_=True)
    if state is not None:
        now_ns = state.t_ns
        if stopper is not None:
            history.stopper.ask(stopper, now_ns)
        history.add_state(state, now_ns)
    seat.take(Visitor(1, "127.0.0.1"), now_ns)
    seat.beat(Visitor(1, "127.0.0.1"), now_ns, now_ns, down=False)
    newest = NewestMessages(state, now_ns - silent_ns, hand or scene.hand(), now_ns)
    situation = json.loads(situation_json(now_ns, newest, None, None, seat, None, Latencies(), history))
    given = {"held": False, "stale": "", "back": ""} | facts
    found: dict[str, Any] = run(SCRIPT, situation, {"page": page, "operator": OPERATOR, "remote": ""}, given)
    return Said(*(found.get(name, "") for name in Said._fields))


def anothers(state: RobotState) -> RobotState:
    """The state under the lease of somebody else."""
    return replace(state, lease=LeaseState(6, "berta", 99, state.t_ns + 5 * NS_PER_S, None))


def halted(reason: str, state: SessionState = DISENGAGED, code: str = "stopped") -> RobotState:
    """A stop or a fault with this sentence."""
    return scene.state(state, code, reason, readiness=Readiness(False, code, reason, False))
