"""What is offered depends on the gripper: a closed one grasps nothing."""

import numpy as np
import pytest
from msgspec.structs import replace

from common.clock import NS_PER_MS
from common.geometry import transform
from common.messages.robot import AssistPhase
from remote_site.assist.assist import Assist
from remote_site.assist.config import AssistConfig
from remote_site.reasons import Code
from tests.remote_site.assist.sightings import BLOCK, seen

BASE_T_MARKER = transform(np.eye(3), np.array([0.5, 0.0, 0.3]))
SHELF = replace(BLOCK, name="shelf", kind="place", xyz_mm=(20.0, 0.0, 100.0))


def shown(targets, can_grasp):
    """The assist's state with the tool at the block's grasp."""
    assist, tool = Assist(AssistConfig(targets=targets)), BASE_T_MARKER @ BLOCK.marker_T_tool
    for k in range(1, 6):
        now_ns = k * 160 * NS_PER_MS
        assist.see((seen(now_ns, BASE_T_MARKER),))
        assist.step(np.zeros(3), now_ns, tool, tool, now_ns, can_grasp)
    return assist.state()


@pytest.mark.parametrize(("can_grasp", "offered"), [(True, "block"), (False, "shelf")])
def test_with_a_closed_gripper_the_nearest_place_is_offered_and_no_grasp(can_grasp, offered):
    state = shown((BLOCK, SHELF), can_grasp)
    assert state.phase is AssistPhase.OFFERED
    assert state.target.name == offered


def test_where_there_is_only_a_grasp_the_closed_gripper_is_told():
    state = shown((BLOCK,), can_grasp=False)
    assert (state.phase, state.code) == (AssistPhase.OFF, Code.ASSIST_CLOSED)
    assert state.reason == "'block' is to be grasped: open the gripper first"
