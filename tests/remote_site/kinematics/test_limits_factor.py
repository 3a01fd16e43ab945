"""One factor tightens every joint's speed, acceleration and jerk: stops take as long, on a way in proportion."""

import msgspec
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from common.config.loading import load_config
from common.errors import ConfigError
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.limits import JointLimits, load_arm
from remote_site.runtime.driver_process import setup_of
from remote_site.safety.stop_bound import longest_stops
from remote_site.safety.stop_figures import rising_stop, steady_stop
from remote_site.safety.stopping import joint_stop
from tests.remote_site.arms_followed import A465, OFFSET_WRIST, SEVEN_AXES, Followed, figure_of_eight

MODEL, FULL = load_arm(RobotConfig())
FACTOR = 0.1


def with_factor(config: RobotConfig, factor: float = FACTOR) -> RobotConfig:
    return msgspec.structs.replace(config, limits_factor=factor)


def dynamics(limits: JointLimits) -> np.ndarray:
    return np.array([limits.velocity, limits.acceleration, limits.jerk])


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    factor=st.floats(0.01, 1),
    speed=st.floats(0.05, 1),
    acceleration=st.floats(1, 12),
    jerk=st.floats(40, 1000),
)
@example(factor=1.0, speed=1.0, acceleration=10.0, jerk=1000.0)
def test_it_multiplies_all_three_after_the_other_keys(factor, speed, acceleration, jerk):
    config = RobotConfig(speed=speed, acceleration_rad_s2=(acceleration,), jerk_rad_s3=jerk)
    without = JointLimits.from_model(MODEL, config)
    limits = JointLimits.from_model(MODEL, with_factor(config, factor))
    assert dynamics(limits) == pytest.approx(factor * dynamics(without), rel=1e-12)
    assert (limits.lower == without.lower).all()
    assert (limits.upper == without.upper).all()
    assert longest_stops(limits) == pytest.approx(longest_stops(without), rel=1e-6)
    for stop in (steady_stop, rising_stop):
        full, reduced = (stop(bounds, MODEL.tcp_levers, float(bounds.velocity.max())) for bounds in (without, limits))
        assert reduced.seconds == pytest.approx(full.seconds, rel=1e-6)
        assert reduced[1:] == pytest.approx((factor * full.by_one_m, factor * full.by_all_m), rel=1e-6)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(
    factor=st.floats(0.01, 1),
    speed=st.floats(-1, 1),
    rise=st.floats(-1, 1),
    joint=st.integers(0, 5),
)
def test_whatever_a_joint_does_at_a_fraction_its_stop_takes_as_long(factor, speed, rise, joint):
    velocity, acceleration, jerk = dynamics(FULL)[:, joint].tolist()
    full = joint_stop((0.0, speed * velocity, rise * acceleration), acceleration, jerk)
    begin = (0.0, factor * speed * velocity, factor * rise * acceleration)
    reduced = joint_stop(begin, factor * acceleration, factor * jerk)
    assert reduced.duration == pytest.approx(full.duration, rel=1e-6, abs=1e-9)
    assert reduced.end == pytest.approx(factor * full.end, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("factor", [1.001, 0.009, 0.0, -0.5, "nan"])
def test_it_never_widens_and_is_a_hundredth_at_least(factor):
    with pytest.raises(ConfigError, match=r"robot\.limits_factor"):
        load_config(RemoteConfig, None, [f"robot.limits_factor={factor}"])


def test_it_is_no_way_to_more_than_the_arms_own():
    excess = RobotConfig(acceleration_rad_s2=(13.0,), limits_factor=0.5)
    with pytest.raises(ConfigError, match="13 for joint_1 is above the robot's own"):
        JointLimits.from_model(MODEL, excess)


def test_the_driver_is_set_up_with_it_and_may_measure_what_the_joints_can():
    setup = setup_of(RemoteConfig(robot=RobotConfig(limits_factor=FACTOR)))
    assert dynamics(setup.limits) == pytest.approx(FACTOR * dynamics(FULL))
    assert setup.joint_range.velocity == pytest.approx(MODEL.velocity)


@pytest.mark.slow
@pytest.mark.parametrize("config", [A465, OFFSET_WRIST, SEVEN_AXES], ids=["a465", "offset wrist", "seven axes"])
def test_no_command_exceeds_it_whichever_way_it_was_made(config):
    _, whole = load_arm(config.robot)
    reduced = msgspec.structs.replace(config, robot=with_factor(config.robot))
    loop = Followed(reduced, figure_of_eight, 4.0).loop
    _, dq, ddq = loop.arrays()
    jerks = np.diff(ddq, axis=0) / 0.004
    used = [np.abs(a).max(axis=0) / (FACTOR * most) for a, most in zip((dq, ddq, jerks), dynamics(whole), strict=True)]
    assert np.max(used) <= 1.00001
    assert [use.max() > 0.5 for use in used] == [True, True, True]
