"""A program's runs: what they need is asked again for each session of the remote site."""

import numpy as np
import pytest
from msgspec.structs import replace

from common.errors import RefusedError
from common.messages.hand import TrackingStatus
from common.messages.requests import Description
from local_site.programmed.path_progress import PathProgress
from local_site.programmed.path_runs import UNKNOWN, PathProgram, PathRuns
from local_site.programmed.tool_trajectory import ToolTrajectory
from tests.common.messages.golden_examples import DESCRIPTION, STATE
from tests.present import present

HELD = replace(DESCRIPTION, held=True)
OURS = present(STATE.lease).session
LINE = ToolTrajectory(np.array([0.0, 1.0]), np.zeros((2, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (2, 1)))


class Cell:
    """A remote site that counts how often it is asked what it is."""

    def __init__(self):
        self.description: Description | None = HELD
        self.asked, self.checked, self.refused = 0, 0, ""
        progress = PathProgress(LINE, 1.0, stepwise=False)
        program = PathProgram("taught", "a line", progress, None, True, self.check, tuple)
        self.runs = PathRuns(program, OURS, self.describe)
        self.now_ns = 0

    def check(self, _cell):
        self.checked += 1
        if self.refused:
            raise RefusedError(self.refused)

    def describe(self):
        self.asked += 1
        return self.description

    def hand(self, session):
        """The hand after a state of this session of the remote site, None for silence."""
        self.now_ns += 10**7
        return self.runs.hand(self.now_ns, replace(STATE, session=session) if session is not None else None)


def test_each_session_is_asked_once_and_silence_asks_nothing():
    cell = Cell()
    for session in (None, 5, 5, None, 5, 6, 6, 5):
        cell.hand(session)
    assert cell.asked == cell.checked == 3


def test_as_long_as_a_cell_does_not_say_what_it_is_no_hand_is_shown_and_it_is_asked_again():
    cell = Cell()
    cell.hand(5)
    cell.description = None
    for count in (2, 3):
        hand = cell.hand(6)
        assert (hand.status, hand.reason, cell.asked) == (TrackingStatus.INITIALISING, UNKNOWN, count)
    cell.description = HELD
    assert cell.hand(6).reason != UNKNOWN
    assert cell.asked == 4


def test_a_later_session_in_another_mode_is_refused_as_often_as_it_is_asked():
    cell = Cell()
    cell.hand(5)
    cell.description = replace(HELD, held=False)
    for _ in range(2):
        with pytest.raises(RefusedError, match="would move without a person at the key"):
            cell.hand(6)


def test_a_later_session_with_another_arm_is_refused():
    cell = Cell()
    cell.hand(5)
    cell.refused = "another arm"
    with pytest.raises(RefusedError, match="another arm"):
        cell.hand(6)
