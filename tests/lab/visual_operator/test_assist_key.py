"""The operator holds A only for what the step wants, and as long as the page shows that the robot leads."""

import pytest

from common.messages.robot import AssistPhase, AssistState, AssistTarget, Pose
from lab.visual_operator.assist_key import PATIENCE_S, THERE, AssistKey, Led

REACTION_S, PAGE_S = 0.25, 0.1
AT = Pose(position=(0.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0))


def page(phase, name="block", code="code"):
    target = AssistTarget(
        name=name,
        kind="grasp",
        base_T_marker=AT,
        size=0.04,
        base_T_tool=AT,
        distance_mm=30.0,
        angle_deg=2.0,
        views=("front_high",),
    )
    return AssistState(phase=phase, code=code, reason="", target=target)


OFFERED, LEADING, ENDED = page(AssistPhase.OFFERED), page(AssistPhase.LEADING), page(AssistPhase.ENDED)
ARRIVED = page(AssistPhase.LEADING, code=THERE)


class Operator:
    """Looks at ten pages a second; `led` is how the tool moves after the last."""

    def __init__(self):
        self.key, self.t_s, self.led = AssistKey(REACTION_S), 10.0, Led.BY_HAND

    def looks(self, state, seconds, wanted="block"):
        for _ in range(round(seconds / PAGE_S)):
            self.t_s += PAGE_S
            self.led = self.key.see(state, wanted, self.t_s)
        return self.led


@pytest.fixture
def leads():
    operator = Operator()
    operator.looks(OFFERED, 0.5)
    assert operator.looks(LEADING, 2.0) is Led.BY_ROBOT
    assert operator.key.held == "block"
    return operator


def test_it_presses_a_reaction_after_the_offer():
    operator = Operator()
    operator.looks(OFFERED, 0.3)
    assert operator.key.held is None
    assert operator.looks(OFFERED, 0.1) is Led.BY_ROBOT
    assert operator.key.held == "block"


@pytest.mark.parametrize(
    ("state", "wanted"), [(OFFERED, "paper"), (OFFERED, None), (ENDED, "block"), (None, "block"), (None, None)]
)
def test_without_an_offer_of_what_is_wanted_the_hand_does_it(state, wanted):
    operator = Operator()
    assert operator.looks(state, 2.0, wanted) is Led.BY_HAND
    assert operator.key.held is None


def test_an_offer_that_flickers_is_not_taken():
    operator = Operator()
    for _ in range(5):
        operator.looks(OFFERED, 0.2)
        operator.looks(page(AssistPhase.OFF), 0.1)
    assert operator.key.held is None


def test_it_stays_down_while_the_tool_is_there_and_until_another_step(leads):
    assert leads.looks(ARRIVED, 3.0) is Led.THERE
    assert leads.key.held == "block"
    assert leads.looks(ARRIVED, 0.1, "paper") is Led.BY_HAND
    assert leads.key.held is None


def test_what_has_ended_is_let_go_and_not_pressed_at_once(leads):
    assert leads.looks(ENDED, 0.1) is Led.BY_HAND
    assert leads.key.held is None
    assert leads.looks(OFFERED, PATIENCE_S - PAGE_S) is Led.BY_HAND
    leads.looks(OFFERED, 0.5)
    assert leads.key.held == "block"


def test_a_press_that_begins_nothing_is_given_up():
    operator = Operator()
    operator.looks(OFFERED, 0.4)
    assert operator.looks(OFFERED, PATIENCE_S) is Led.BY_ROBOT
    assert operator.looks(OFFERED, 0.2) is Led.BY_HAND
