"""The mapping: relative, scaled, locked, and never a jump of the tool."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.errors import ConfigError
from common.geometry import rotation_from_vector, transform, vector_from_rotation
from common.mapping.relative_mapping import RelativeMapping
from common.messages.hand import Locks, OperatorSettings
from remote_site.teleop.config import LocksConfig, MappingConfig
from remote_site.teleop.mapping import (
    make_mapping,
    thesis_angles,
)
from tests.remote_site.remote_loop import hand as hand_sample

TOOL = transform(rotation_from_vector(np.array([0.3, 1.2, -0.4])), np.array([0.45, 0.02, 0.85]))
WRIST = np.array([0.1, -0.2, 0.3])
FACING = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])

vectors = st.tuples(*(st.floats(-1, 1) for _ in range(3))).map(np.array)
turns = vectors.map(lambda v: rotation_from_vector(1.5 * v))


def engaged(hand=None, tool=TOOL, **config):
    mapping = RelativeMapping(MappingConfig(**config))
    mapping.engage(WRIST, hand, tool)
    return mapping


@settings(max_examples=50, deadline=None, derandomize=True)
@given(turns, turns)
def test_engaging_never_moves_the_tool(hand, orientation):
    tool = transform(orientation, TOOL[:3, 3])
    for locks in (LocksConfig(), LocksConfig(roll=True), LocksConfig(x=True, pitch=True)):
        assert np.abs(engaged(hand, tool, locks=locks).target(WRIST, hand) - tool).max() < 1e-12
    assert np.abs(engaged(None, tool).target(WRIST, hand) - tool).max() < 1e-12


def test_forward_of_the_operator_is_forward_of_the_robot():
    toward_the_cameras = WRIST + np.array([0.0, -0.1, 0.0])
    moved = engaged().target(toward_the_cameras, None)[:3, 3] - TOOL[:3, 3]
    assert moved == pytest.approx([0.1, 0.0, 0.0])


def test_translation_is_scaled_and_locked_in_the_bases_axes():
    mapping = engaged(scale=0.5, locks=LocksConfig(y=True))
    moved = mapping.target(WRIST + np.array([0.2, -0.4, 0.6]), None)[:3, 3] - TOOL[:3, 3]
    assert moved == pytest.approx([0.2, 0.0, 0.3])


@settings(max_examples=50, deadline=None, derandomize=True)
@given(turns, turns)
def test_rotation_applies_in_the_robots_world_axes(reference, turn):
    target = engaged(reference).target(WRIST, turn @ reference)
    assert np.abs(target[:3, :3] - FACING @ turn @ FACING.T @ TOOL[:3, :3]).max() < 1e-9


@settings(max_examples=50, deadline=None, derandomize=True)
@given(turns, turns, vectors, turns, vectors)
def test_moving_the_operator_moves_nothing_else(first, second, step, frame, shift):
    """Rigid equivariance: another operator frame, with its own base_R_operator, gives the same target."""
    plain = engaged(first).target(WRIST + step, second)
    turned = FACING @ frame.T
    x, y, z = ((a, b, c) for a, b, c in turned.tolist())
    mapping = RelativeMapping(MappingConfig(base_R_operator=(x, y, z)))
    mapping.engage(frame @ WRIST + shift, frame @ first, TOOL)
    assert np.abs(mapping.target(frame @ (WRIST + step) + shift, frame @ second) - plain).max() < 1e-9


@settings(max_examples=50, deadline=None, derandomize=True)
@given(turns, turns, turns, turns)
def test_a_hidden_orientation_holds_the_tool_and_returns_without_a_swing(first, second, returned, last):
    mapping = engaged(first)
    held = mapping.target(WRIST, second)
    moved = mapping.target(WRIST + 0.1, None)
    assert np.array_equal(moved[:3, :3], held[:3, :3])
    assert np.abs(mapping.target(WRIST, returned)[:3, :3] - held[:3, :3]).max() < 1e-12
    onward = mapping.target(WRIST, last)[:3, :3]
    assert np.abs(onward - FACING @ last @ returned.T @ FACING.T @ held[:3, :3]).max() < 1e-9


def tool_turn(mapping, hand_turn):
    """The tool's rotation vector in its own axes for a turn of the hand in the robot's axes."""
    target = mapping.target(WRIST, FACING.T @ hand_turn @ FACING)
    return vector_from_rotation(TOOL[:3, :3].T @ target[:3, :3])


@pytest.mark.parametrize(("lock", "axis"), [("yaw", 0), ("pitch", 1), ("roll", 2)])
def test_each_lock_takes_out_its_axis_of_the_tool_and_leaves_the_others(lock, axis):
    for other in range(3):
        turn = 0.7 * np.eye(3)[other]
        in_world = TOOL[:3, :3] @ rotation_from_vector(turn) @ TOOL[:3, :3].T
        result = tool_turn(engaged(np.eye(3), locks=LocksConfig(**{lock: True})), in_world)
        assert result == pytest.approx(np.zeros(3) if other == axis else turn, abs=1e-9)


def test_locked_roll_leaves_the_direction_of_the_tool_alone():
    rng = np.random.default_rng(1)
    for _ in range(50):
        turn = rotation_from_vector(rng.uniform(-1, 1, 3))
        free = engaged(np.eye(3)).target(WRIST, turn)
        locked = engaged(np.eye(3), locks=LocksConfig(roll=True)).target(WRIST, turn)
        assert np.abs(free[:3, 2] - locked[:3, 2]).max() < 1e-9
        swing = vector_from_rotation(TOOL[:3, :3].T @ locked[:3, :3])
        assert abs(swing[2]) < 1e-9


def test_all_locks_hold_the_tool_still():
    everything = LocksConfig(x=True, y=True, z=True, roll=True, pitch=True, yaw=True)
    target = engaged(np.eye(3), locks=everything).target(WRIST + 0.3, rotation_from_vector(np.array([0.5, 1.0, -0.8])))
    assert np.abs(target - TOOL).max() < 1e-12


@pytest.mark.parametrize(
    "rows",
    [
        ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)),
        ((1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 1.0)),
        ((1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        ((np.nan, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    ],
)
def test_an_improper_rotation_is_refused(rows):
    with pytest.raises(ConfigError, match="base_R_operator"):
        RelativeMapping(MappingConfig(base_R_operator=rows))


@pytest.mark.parametrize(("scale", "in_force"), [(0.1, 0.5), (0.5, 0.5), (1.0, 1.0), (1.5, 1.5), (9.0, 1.5)])
def test_the_operators_scale_times_the_configured_one_stays_in_the_range(scale, in_force):
    mapping = RelativeMapping(MappingConfig(scale=2.0, scale_range=(1.0, 3.0)))
    asked = OperatorSettings(lease=3, revision=4, scale=scale)
    assert mapping.bounded(asked) == OperatorSettings(lease=3, revision=4, scale=in_force)


def test_the_angles_of_the_thesis():
    wrist = np.array([0.1, 0.2, 0.3])
    ahead, across = np.array([0.1, 0.0, 0.0]), np.array([0.0, 0.03, 0.0])
    for k, expected in ((2, (0.4, 0.0, 0.4)), (1, (0.0, -0.4, 0.0))):
        turn = rotation_from_vector(0.4 * np.eye(3)[k])
        angles = thesis_angles(wrist, wrist + turn @ (ahead + across), wrist + turn @ (ahead - across))
        assert angles[:2] == pytest.approx(expected[:2])
    turn = rotation_from_vector(np.array([0.4, 0.0, 0.0]))
    angles = thesis_angles(wrist, wrist + turn @ (ahead + across), wrist + turn @ (ahead - across))
    assert angles == pytest.approx((0.0, 0.0, 0.4))


def steered(mapping, wrist, hand, held, **changes):
    mapping.steer(OperatorSettings(**changes), wrist, hand, held)
    return mapping.target(wrist, hand)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(turns, turns, vectors, st.floats(0.05, 5), st.floats(0, 2), st.integers(1, 9), st.booleans(), st.booleans())
def test_whatever_the_operator_steers_the_target_does_not_jump(first, second, step, scale, turning, new, lock, roll):
    """Scale, locks and new origins take effect from where the target is: 0.01 mm is allowed, rounding is left."""
    mapping, wrist = engaged(first), WRIST + step
    held = mapping.target(wrist, second)
    locks = Locks(x=lock, roll=roll)
    after = steered(mapping, wrist, second, held, revision=new, scale=scale, rotation_scale=turning, locks=locks)
    assert np.abs(after - held).max() < 1e-9


def test_new_origins_take_the_hand_anew_and_the_tool_from_where_it_is_held():
    mapping = engaged(np.eye(3))
    saturated = transform(TOOL[:3, :3], TOOL[:3, 3] + [0.1, 0.0, 0.0])
    far = WRIST + np.array([0.0, -2.0, 0.0])
    assert steered(mapping, far, np.eye(3), saturated, revision=1) == pytest.approx(saturated)
    onward = steered(mapping, far + np.array([0.0, -0.05, 0.0]), np.eye(3), saturated, revision=1)
    assert onward[:3, 3] - saturated[:3, 3] == pytest.approx([0.05, 0.0, 0.0])


def test_scales_at_run_time_multiply_the_configured_one():
    mapping = engaged(np.eye(3), scale=0.5)
    start = mapping.target(WRIST, np.eye(3))
    steered(mapping, WRIST, np.eye(3), start, scale=0.4, rotation_scale=0.5)
    turn = rotation_from_vector(np.array([0.0, 0.0, 0.8]))
    target = mapping.target(WRIST + np.array([0.0, -1.0, 0.0]), turn)
    assert target[:3, 3] - start[:3, 3] == pytest.approx([0.2, 0.0, 0.0])
    assert vector_from_rotation(target[:3, :3] @ start[:3, :3].T) == pytest.approx([0.0, 0.0, 0.4])


def test_a_scaled_turn_goes_on_beyond_half_a_turn():
    mapping = engaged(np.eye(3))
    start = mapping.target(WRIST, np.eye(3))
    steered(mapping, WRIST, np.eye(3), start, rotation_scale=0.5)
    for angle in np.linspace(0, 3.6, 40):
        target = mapping.target(WRIST, rotation_from_vector(np.array([0.0, 0.0, angle])))
        assert vector_from_rotation(target[:3, :3] @ start[:3, :3].T) == pytest.approx([0.0, 0.0, angle / 2], abs=1e-9)


def test_locks_at_run_time_add_to_the_configured_ones_and_can_be_taken_back():
    mapping = engaged(None, locks=LocksConfig(y=True))
    start = mapping.target(WRIST, None)
    steered(mapping, WRIST, None, start, locks=Locks(x=True))
    moved = mapping.target(WRIST + np.array([0.1, -0.1, 0.1]), None)
    assert moved[:3, 3] - start[:3, 3] == pytest.approx([0.0, 0.0, 0.1])
    steered(mapping, WRIST, None, start)
    moved = mapping.target(WRIST + np.array([0.1, -0.1, 0.1]), None)
    assert moved[:3, 3] - start[:3, 3] == pytest.approx([0.1, 0.0, 0.1])


def test_the_elbow_comes_from_the_wrist_in_the_bases_axes():
    mapping = engaged()
    assert mapping.elbow(WRIST, (0.1, 0.05, 0.3)) == pytest.approx([-0.25, 0.0, 0.0])
    assert mapping.elbow(WRIST, None) is None


def incremental(tool=TOOL, **config):
    mapping = make_mapping(MappingConfig(command="incremental", **config))
    mapping.engage(WRIST, np.eye(3), tool)
    return mapping


def driven(mapping, places, share, tool=TOOL):
    """Where a tool ends that has gone only a fraction of its path when the next sample comes."""
    here = tool.copy()
    for place in places:
        mapping.read(here)
        target = mapping.target(place, np.eye(3))
        here = transform(target[:3, :3], here[:3, 3] + share * (target[:3, 3] - here[:3, 3]))
    return here


PLACES = WRIST + np.cumsum(np.random.default_rng(3).normal(0.0, 0.01, (40, 3)), axis=0)


def test_a_tool_that_arrives_before_the_next_sample_makes_both_commands_one():
    relative = engaged(np.eye(3), scale=0.8).target(PLACES[-1], np.eye(3))
    assert driven(incremental(scale=0.8), PLACES, 1.0) == pytest.approx(relative)
    assert driven(incremental(scale=0.8), [*PLACES[::7], PLACES[-1]], 1.0) == pytest.approx(relative)


def test_what_the_tool_had_left_to_go_is_lost_to_the_incremental_command():
    wanted = engaged(np.eye(3)).target(PLACES[-1], np.eye(3))[:3, 3] - TOOL[:3, 3]
    reached = driven(incremental(), PLACES, 0.6)[:3, 3] - TOOL[:3, 3]
    assert reached == pytest.approx(0.6 * wanted)


def test_an_incremental_target_never_jumps_and_its_turn_counts_from_the_reference():
    mapping = incremental(locks=LocksConfig(z=True))
    pushed = transform(TOOL[:3, :3], TOOL[:3, 3] + 0.2)
    mapping.read(pushed)
    assert mapping.target(WRIST, np.eye(3)) == pytest.approx(pushed)
    turn = rotation_from_vector(np.array([0.0, 0.0, 0.4]))
    for step in (0.01, 0.02):
        target = mapping.target(WRIST + np.array([0.0, 0.0, step]), turn)
        assert target[:3, 3] == pytest.approx(pushed[:3, 3])
        assert target[:3, :3] == pytest.approx(FACING @ turn @ FACING.T @ TOOL[:3, :3])


@pytest.mark.parametrize("settings", [OperatorSettings(), OperatorSettings(rotation_scale=0.5, locks=Locks(roll=True))])
def test_a_mapping_restored_from_a_reference_goes_on_as_the_one_that_gave_it(settings):
    first, then = (rotation_from_vector(np.array(turn)) for turn in ([0.2, -0.1, 0.3], [0.5, 0.4, -0.2]))
    given, restored = engaged(first), RelativeMapping(MappingConfig())
    given.steer(settings, WRIST, first, TOOL)
    given.target(WRIST, first)
    restored.restore(given.reference(hand_sample(1, 0), np.eye(3)), settings)
    assert restored.target(WRIST + 0.1, then) == pytest.approx(given.target(WRIST + 0.1, then), abs=1e-9)


@pytest.mark.parametrize("settings", [OperatorSettings(), OperatorSettings(rotation_scale=0.5, locks=Locks(roll=True))])
def test_a_mapping_restored_while_the_tool_lags_behind_the_hand_goes_on_with_the_same_lag(settings):
    first, shown, then = (rotation_from_vector(np.array(v)) for v in ([0.2, 0, 0.3], [0.5, 0.4, 0], [0.1, 0.6, 0.1]))
    lag = rotation_from_vector(np.array([0.3, -0.1, 0.05]))
    given, restored = engaged(first), RelativeMapping(MappingConfig())
    given.steer(settings, WRIST, first, TOOL)
    given.target(WRIST, shown @ lag)
    restored.restore(given.reference(hand_sample(1, 0), lag), settings)
    assert restored.target(WRIST, then) == pytest.approx(given.target(WRIST, then @ lag), abs=1e-9)


def test_a_mapping_restored_while_the_hand_is_withheld_follows_from_the_next_orientation():
    given, restored = engaged(np.eye(3)), RelativeMapping(MappingConfig())
    kept = given.target(WRIST, rotation_from_vector(np.array([0.0, 0.2, 0.0])))
    restored.restore(given.reference(hand_sample(1, 0), None), OperatorSettings())
    assert restored.target(WRIST, rotation_from_vector(np.array([0.5, 0.0, 0.0]))) == pytest.approx(kept, abs=1e-9)
