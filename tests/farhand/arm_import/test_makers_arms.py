"""Arms as their makers publish them, where example-robot-data is installed: imported, and followed on stepped time."""

import sysconfig
from pathlib import Path

import numpy as np
import pytest

from common.config.loading import load_config
from farhand.arm_import.import_arm import ImportRequest, import_arm
from local_site.simulation.motion import PATHS
from remote_site.config import RemoteConfig
from tests.farhand.arm_import.published import unseen
from tests.remote_site.arms_followed import Followed

ROBOTS = Path(sysconfig.get_path("purelib")) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
ARMS = {
    "ur5": ("ur_description/urdf/ur5_robot.urdf", None),
    "panda": ("panda_description/urdf/panda.urdf", "panda_hand_tcp"),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", None),
}


@pytest.mark.long
@pytest.mark.skipif(not ROBOTS.is_dir(), reason="the makers' files are not here; make arms")
@pytest.mark.parametrize("name", ARMS)
def test_an_arm_follows_the_hand_as_it_was_imported(name, tmp_path):
    file, tool = ARMS[name]
    import_arm(ImportRequest(ROBOTS / file, tmp_path / "arm.toml", tool), unseen)
    config = load_config(RemoteConfig, tmp_path / "arm.toml")
    followed = Followed(config, lambda t: PATHS["pick_and_place"].at(t)[:2], 14.0)
    moved = config.mapping.scale * followed.hands
    off_mm = 1e3 * np.linalg.norm(followed.tools[:, :3, 3] - followed.start[:3, 3] - moved, axis=1)
    assert off_mm.mean() < 1.0
    assert followed.loop.refusals == 0
