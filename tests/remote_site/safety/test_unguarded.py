"""What is said not to be guarded: all that a configuration leaves out, and nothing that it guards."""

import pytest

from common.config.loading import load_config
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import MODELS, CapsuleConfig, RobotConfig
from remote_site.kinematics.limits import load_arm
from remote_site.safety.config import CollisionConfig, SafetyConfig
from remote_site.safety.unguarded import in_one_line, unguarded

POLE = CapsuleConfig(link="wrist_pitch", start_m=(0.0, 0.0, 0.0), end_m=(0.0, 0.0, 0.1), radius_m=0.02)


def of(robot=None, **safety):
    robot = robot or RobotConfig()
    return unguarded(robot, SafetyConfig(**safety), load_arm(robot)[0])


def test_the_shipped_cell_leaves_out_what_always_is():
    assert of() == ()
    assert in_one_line(()) == "people, cables, and whatever is no box in safety.collision.fixtures"


@pytest.mark.parametrize(
    ("robot", "safety", "said"),
    [
        (RobotConfig(), {"collision": CollisionConfig(fixtures=())}, "the cell (safety.collision.fixtures is empty)"),
        (RobotConfig(capsules=()), {}, "the tool (robot.capsules is empty)"),
        (
            RobotConfig(),
            {"collision": CollisionConfig(ignored_pairs=(("upper_arm", "table"),))},
            "upper_arm against table (safety.collision.ignored_pairs)",
        ),
        (
            RobotConfig(),
            {"workspace_max_m": (0.8, 0.55, 1.25)},
            "the box's side z up to 1.25 m (the tool reaches 1.18 m)",
        ),
        (
            RobotConfig(),
            {"workspace_min_m": (0.15, -0.86, 0.25)},
            "the box's side y from -0.86 m (the tool reaches -0.85 m)",
        ),
    ],
)
def test_what_is_left_out_is_said(robot, safety, said):
    parts = of(robot, **safety)
    assert said in parts
    assert in_one_line(parts) == "; ".join([*parts, in_one_line(())])


def test_links_without_a_shape_are_named_unless_something_else_covers_them():
    assert "links without a shape: wrist_yaw" in of(RobotConfig(capsules=(POLE,)))
    config = load_config(RemoteConfig, MODELS / "humanoid" / "humanoid.toml")
    (links,) = unguarded(config.robot, config.safety, load_arm(config.robot)[0])
    assert links == "links without a shape: shoulder, upper_arm_root, wrist_root, wrist"
