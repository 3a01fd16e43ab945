"""What must be right before the remote site starts any process: limits, start posture, mapping, reach."""

import math

from common.errors import ConfigError, ModelError
from remote_site.config import MODELS, RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.mapping import Mapping
from remote_site.pursuit import choose_pursuit


def check_robot(config: RemoteConfig) -> None:
    """ModelError or ConfigError when the arm cannot be built, or cannot start where it is told to."""
    robot = config.robot
    if not robot.urdf.is_file():
        built_in = ", ".join(sorted(path.name for path in MODELS.iterdir() if path.is_dir()))
        raise ModelError(f"robot.model {robot.model!r} is neither a built-in model ({built_in}) nor the file of a URDF")
    model = ArmModel.from_urdf(robot.urdf, robot.tool_frame, robot.tool_T_tcp)
    limits = JointLimits.from_model(model, robot)
    Mapping(config.mapping)
    if len(robot.start_deg) != len(limits.names):
        raise ConfigError(f"robot.start_deg has {len(robot.start_deg)} angles for {len(limits.names)} joints")
    outside = [
        f"robot.start_deg: {name} at {q_deg:g} deg is outside {math.degrees(low):.1f} to {math.degrees(high):.1f} deg"
        for name, q_deg, low, high in zip(limits.names, robot.start_deg, limits.lower, limits.upper, strict=True)
        if not math.degrees(low) <= q_deg <= math.degrees(high)
    ]
    if outside:
        raise ConfigError("\n".join(outside))
    choose_pursuit(config, model, limits)
