"""What is learned of the operator's hand, and when it counts as open or closed."""

import numpy as np
import pytest

from local_site.tracking.silhouette.hand_model.habits import (
    APART,
    GRIPPER,
    GRIPPER_SIGMA,
    HABIT_SIGMA,
    Belief,
    Habits,
    near_last,
    posture_information,
    prior_information,
)
from local_site.tracking.silhouette.hand_model.skeleton import (
    MCP_CURL,
    PARAMETERS,
    PIP_CURL,
    POSE,
    SPREAD,
    STATE,
)

FRAMES = 300
PERSONS_POSTURE = GRIPPER + 0.8 * GRIPPER_SIGMA * np.array([1, -1, 1, 1, -1, 1, -1, 1, -1, 1])


def fitted(truth, information, prior):
    """The posture (10,) that fits best to the outlines of a truth, under a prior."""
    told = information @ truth + prior.information @ prior.posture
    return np.linalg.solve(information + prior.information, told)


def outlines(random, rank=PARAMETERS):
    """Information (10, 10) as from one frame, of a rank."""
    rows = random.normal(size=(rank, PARAMETERS)) / GRIPPER_SIGMA
    return rows.T @ rows


def learned(truth, prior_of, rank, noise=0.0, frames=FRAMES):
    habits, random = Habits(), np.random.default_rng(2)
    for _ in range(frames):
        information, prior = outlines(random, rank), prior_of(habits)
        seen = truth + noise * HABIT_SIGMA * random.normal(size=PARAMETERS)
        habits.learn(fitted(seen, information, prior), prior, information)
    return habits


@pytest.mark.parametrize("rank", [2, 5, 10])
def test_a_persons_posture_is_learned_from_fits_under_the_habits_themselves(rank):
    habits = learned(PERSONS_POSTURE, lambda h: h.closed, rank)
    off = np.abs(habits.closed.posture - PERSONS_POSTURE) / GRIPPER_SIGMA
    assert off.max() < 0.1
    assert habits.learned == FRAMES


def test_what_is_learned_does_not_depend_on_the_prior_of_the_fits():
    elsewhere = Belief(GRIPPER - 2 * GRIPPER_SIGMA, np.diag(9 / GRIPPER_SIGMA**2))
    plain = learned(PERSONS_POSTURE, lambda h: h.closed, 10)
    pulled = learned(PERSONS_POSTURE, lambda _: elsewhere, 10)
    np.testing.assert_allclose(plain.closed.posture, pulled.closed.posture, atol=1e-6)


def test_varying_grips_average_out():
    habits = learned(PERSONS_POSTURE, lambda h: h.closed, 10, noise=1.0)
    off = np.abs(habits.closed.posture - PERSONS_POSTURE) / HABIT_SIGMA
    assert off.max() < 0.6


def test_what_no_outline_shows_stays_an_average_hands():
    habits = Habits()
    information = np.zeros((PARAMETERS, PARAMETERS))
    information[MCP_CURL, MCP_CURL] = 100.0 / GRIPPER_SIGMA[MCP_CURL] ** 2
    for _ in range(50):
        prior = habits.closed
        habits.learn(fitted(PERSONS_POSTURE, information, prior), prior, information)
    others = np.arange(PARAMETERS) != MCP_CURL
    np.testing.assert_allclose(habits.closed.posture[others], GRIPPER[others], atol=1e-9)
    assert abs(habits.closed.posture[MCP_CURL] - PERSONS_POSTURE[MCP_CURL]) < 0.02


def test_the_habits_are_never_surer_than_a_grip_varies():
    habits = learned(PERSONS_POSTURE, lambda h: h.closed, 10)
    first, later = (np.sqrt(np.linalg.inv(h.closed.information).diagonal()) for h in (Habits(), habits))
    assert (later < first).all()
    assert (later >= HABIT_SIGMA * (1 - 1e-9)).all()


def test_a_habit_that_changes_is_learned_anew():
    habits, random = learned(PERSONS_POSTURE, lambda h: h.closed, 10), np.random.default_rng(8)
    for _ in range(1500):
        information, prior = outlines(random), habits.closed
        habits.learn(fitted(GRIPPER, information, prior), prior, information)
    off = np.abs(habits.closed.posture - GRIPPER) / np.abs(PERSONS_POSTURE - GRIPPER)
    assert off.max() < 0.15


@pytest.mark.parametrize("habits", [Habits(), learned(PERSONS_POSTURE, lambda h: h.closed, 10, frames=60)])
def test_open_and_closed_are_told_apart_with_room_between(habits):
    closed, opened = habits.closed.posture, habits.opened.posture
    assert habits.is_closed(closed)
    assert not habits.is_open(closed)
    assert habits.is_open(opened)
    assert not habits.is_closed(opened)
    between = closed.copy()
    between[[MCP_CURL, PIP_CURL]] *= 0.7
    assert not habits.is_open(between)
    assert habits.is_open(between, was_open=True)
    assert not habits.is_open(closed, was_open=True)
    assert not habits.is_closed(between)


@pytest.mark.parametrize("habits", [Habits(), learned(PERSONS_POSTURE, lambda h: h.closed, 10, frames=60)])
def test_fingers_are_apart_once_a_gap_shows_between_each_two_tips_and_until_it_is_half_closed(habits):
    opened, usual = habits.opened.posture, habits.own.posture.copy()
    assert not habits.are_apart(usual)
    usual[SPREAD] = min(usual[SPREAD], GRIPPER[SPREAD])
    assert habits.are_apart(opened)
    spread = usual.copy()
    spread[SPREAD] += 0.75 * APART
    assert not habits.are_apart(spread)
    assert habits.are_apart(spread, were_apart=True)
    assert not habits.are_apart(usual, were_apart=True)


def test_the_last_posture_holds_the_next_one_near():
    belief = Habits().closed
    last = GRIPPER + GRIPPER_SIGMA
    near = near_last(belief, last)
    assert (np.abs(near.posture - last) < 0.2 * np.abs(near.posture - GRIPPER)).all()
    assert np.linalg.eigvalsh(near.information - belief.information)[0] > 0


def test_a_prior_knows_the_wrist_and_only_on_demand_the_turn():
    covariance, posture = np.diag([1e-4, 4e-6, 9e-6]), np.diag(1 / GRIPPER_SIGMA**2)
    free, held = (prior_information(covariance, posture, known) for known in (False, True))
    np.testing.assert_allclose(free[:3, :3], np.linalg.inv(covariance))
    np.testing.assert_allclose(free[POSE:, POSE:], posture)
    assert not free[3:POSE].any()
    assert (held.diagonal()[3:POSE] > 0).all()


def test_what_is_left_for_the_posture_is_the_inverse_of_its_covariance():
    rows = np.random.default_rng(4).normal(size=(40, STATE))
    information = rows.T @ rows
    expected = np.linalg.inv(np.linalg.inv(information)[POSE:, POSE:])
    np.testing.assert_allclose(posture_information(information), expected, rtol=1e-9)
