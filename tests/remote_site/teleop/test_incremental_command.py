"""The incremental command through the whole pipeline: how far it drifts, and that it never runs away."""

import numpy as np
import pytest

from tests.remote_site.arms_followed import (
    A465,
    SEVEN_AXES,
    Followed,
    pick_and_place,
    scaled,
)
from tests.remote_site.remote_loop import assert_within_limits

SECONDS = 3.0


def down_and_rest(t):
    """The first leg, 100 mm down, then rest."""
    return pick_and_place(min(t, 1.6))


@pytest.mark.slow
@pytest.mark.parametrize("config", [A465, SEVEN_AXES], ids=["a465", "seven axes"])
def test_it_drifts_where_the_relative_command_does_not(config):
    ends_mm = {}
    for command in ("relative", "incremental"):
        followed = Followed(scaled(config, command=command), down_and_rest, SECONDS)
        off = followed.tools[:, :3, 3] - followed.start[:3, 3] - followed.hands
        ends_mm[command] = 1e3 * np.linalg.norm(off[-1])
        still = followed.tools[-100:, :3, 3]
        assert np.ptp(still, axis=0).max() < 1e-3
        assert_within_limits(followed.loop)
    assert ends_mm["relative"] < 1.0
    assert 10.0 < ends_mm["incremental"] < 100.0
