"""The visual operator acts on what the page shows, and on nothing else."""

import dataclasses

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.geometry import rotation_from_vector, transform
from common.messages.hand import Locks
from common.messages.robot import GripperStatus, SessionState
from lab.visual_operator.hand import Motor, ScriptedHand
from lab.visual_operator.operator import REST_S, SETTLE_S, VisualOperator
from lab.visual_operator.sight.sight import Scene, Sight
from lab.visual_operator.task import PlacingTask
from tests.lab.visual_operator.page import config, page_of

PERIOD_NS = NS_PER_S // 10


@pytest.fixture(scope="module")
def page():
    return page_of(config())


@pytest.fixture
def operator(page):
    site, _ = page
    task = PlacingTask()
    return VisualOperator(task, Sight(task).see, site.description.mapping, ScriptedHand(Motor(), 1), Locks())


def watch(operator, shown, seconds, state=SessionState.ENGAGED, **changed):
    """Show the operator the same picture for a while, engaged unless said otherwise."""
    start_ns = shown.t_ns
    for k in range(round(10 * seconds)):
        t_ns = start_ns + k * PERIOD_NS
        views = {name: dataclasses.replace(view, capture_ns=t_ns) for name, view in shown.views.items()}
        operator.look(dataclasses.replace(shown, t_ns=t_ns, views=views, state=state, **changed), start_ns)


def dark(shown):
    views = {name: dataclasses.replace(v, picture=np.zeros_like(v.picture)) for name, v in shown.views.items()}
    return dataclasses.replace(shown, views=views)


def lying_at(monkeypatch, operator, block):
    monkeypatch.setattr(operator, "_see", lambda shown: Scene(shown.t_ns, block, None, None))


def test_it_presses_the_key_and_moves_towards_the_block(page, operator):
    watch(operator, page[1], 3)
    assert operator.intent.hold
    offset, _ = operator.hand.aim()
    assert np.linalg.norm(offset) > 0.01


def test_with_dark_pictures_it_does_not_move(page, operator):
    watch(operator, dark(page[1]), 5)
    assert operator.hand.aim()[0] == pytest.approx(np.zeros(3))
    assert not operator.hand.openings_s


def test_it_moves_no_sooner_than_its_reaction_after_a_picture(page, operator):
    watch(operator, page[1], 3)
    first_s = operator.hand._movement.start_s
    assert first_s >= REST_S + SETTLE_S + Motor().reaction_s - 1e-9


def test_where_the_arm_does_not_follow_it_lets_go_and_presses_again(page, operator):
    watch(operator, page[1], 12, state=SessionState.HOLDING)
    assert operator.notes.clutches >= 1
    assert not operator.hand.openings_s


def test_a_reason_that_the_arm_cannot_follow_makes_it_bring_the_hand_back(page, operator):
    watch(operator, page[1], 3, code="out_of_reach")
    assert operator.notes.clutches >= 1


def test_a_block_that_lies_is_given_up(monkeypatch, page, operator):
    lying = transform(rotation_from_vector(np.array([np.pi / 2, 0, 0])), np.array([0.5, 0, 0.583]))
    lying_at(monkeypatch, operator, lying)
    watch(operator, page[1], 3)
    assert operator.done
    assert operator.notes.gave_up
    assert not operator.intent.hold


@pytest.mark.parametrize("locked", [True, False])
def test_a_gripper_that_rolled_a_little_is_good_enough_where_its_roll_is_locked(monkeypatch, page, locked):
    (site, shown), task = page, PlacingTask()
    hand, locks = ScriptedHand(Motor(), 1), Locks(roll=locked)
    operator = VisualOperator(task, Sight(task).see, site.description.mapping, hand, locks)
    block = transform(np.eye(3), np.array([0.5, 0.0, task.table_z + 0.1]))
    above = task.grasp_of(block, 0.055, 0.1)
    above[:3, :3] = rotation_from_vector(np.radians(7) * above[:3, 2]) @ above[:3, :3]
    monkeypatch.setattr(operator, "_see", lambda shown: Scene(shown.t_ns, block, above, None))
    watch(operator, shown, 3)
    assert [step for _, step in operator.notes.steps] == (["above"] if locked else [])


def test_a_grasp_that_closed_on_nothing_is_done_again(monkeypatch, page, operator):
    task = PlacingTask()
    block = transform(np.eye(3), np.array([0.5, 0.0, task.table_z + 0.1]))
    scene = [Scene(0, block, task.grasp_of(block, back, up), None) for back, up in ((0.055, 0.1), (0.055, 0), (0, 0))]
    looks = iter(range(10_000))
    monkeypatch.setattr(
        operator,
        "_see",
        lambda shown: dataclasses.replace(scene[min(next(looks) // 15, 2)], t_ns=shown.t_ns),
    )
    watch(operator, page[1], 9, gripper=GripperStatus.CLOSED)
    assert operator.notes.misses >= 1
    assert len(operator.hand.openings_s) >= 2
