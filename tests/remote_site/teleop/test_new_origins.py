"""New origins through the whole pipeline: taken in full motion, the target does not jump by 0.01 mm."""

from functools import partial

import numpy as np
import pytest

from common.messages.hand import Intent, Locks, OperatorSettings
from tests.remote_site.remote_loop import RemoteLoop, assert_within_limits


def swaying(t_ns):
    t = t_ns / 1e9
    return (0.08 * np.sin(2.5 * t), 0.05 * np.sin(4 * t), 0.3 + 0.06 * np.sin(3 * t))


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"scale": 0.3},
        {"rotation_scale": 0.0},
        {"revision": 3, "scale": 2.0, "locks": Locks(x=True, roll=True)},
    ],
)
def test_a_change_of_steering_in_motion_is_no_jump_of_the_target(changes):
    loop = RemoteLoop()
    intent = Intent(settings=OperatorSettings(**{"lease": loop.lease, "revision": 1} | changes))
    loop.run(600, swaying)
    held = loop.snapshot.target.copy()
    loop.run(1, swaying, intent=intent)
    assert loop.newest is loop.pipeline._aimed
    assert loop.snapshot.settings == intent.settings
    jump_mm = np.linalg.norm(loop.snapshot.target[:3, 3] - held[:3, 3]) * 1e3
    assert jump_mm <= 0.01
    loop.run(300, swaying, intent=intent)
    assert_within_limits(loop)


def test_with_new_origins_at_every_sample_the_arm_keeps_its_place():
    loop = RemoteLoop()
    loop.run(400, lambda _t_ns: (0.0, 0.0, 0.3))
    loop.run(400, lambda _t_ns: (0.0, -0.05, 0.3))
    before = loop.model.forward(loop.sent.q)[:3, 3]
    for count in range(1, 20):
        intent = Intent(settings=OperatorSettings(lease=loop.lease, revision=count))
        loop.run(8, partial(lambda k, _t_ns: (0.0, -0.05 + 0.002 * k, 0.3), count), intent=intent)
    assert np.linalg.norm(loop.model.forward(loop.sent.q)[:3, 3] - before) * 1e3 < 0.01
