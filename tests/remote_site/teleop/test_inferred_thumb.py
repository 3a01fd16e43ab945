"""An inferred thumb turns the tool through the whole pipeline: never fast, never by a wrong one, and without drift."""

from dataclasses import replace

import numpy as np
import pytest

from common.mapping.shown_hand import shown_orientation
from common.messages.hand import PointCovariances
from common.messages.robot import GripperCommand
from remote_site.safety.config import SafetyConfig
from remote_site.teleop import sample_validator
from remote_site.teleop.followed_orientation import FollowedOrientation
from tests.remote_site.remote_loop import START_NS, RemoteLoop
from tests.remote_site.teleop.turning_hand import followed, is_hidden

INFERRED_DEG_S = SafetyConfig().inferred_turn_deg_s
OF_FLOAT = 1e-4
STILL = (0.0, 0.0, 0.3)
SEEN = {name: 1e-6 * np.eye(3) for name in ("elbow", "wrist", "index", "thumb")}


def hidden(found):
    return [one for one in found if one.hidden]


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["rotate_x", "rotate_z"])
def test_over_a_minute_of_turning_with_the_thumb_hidden_a_third_of_the_time_no_drift_is_left(motion):
    found = followed(motion, 60.0, seed=1)
    turning = [one for one in found if one.t_s > 0]
    assert len(hidden(turning)) / len(turning) == pytest.approx(1 / 3, abs=0.01)
    assert turning[-1].error_deg <= 2.0
    assert np.median([one.error_deg for one in turning if not one.hidden]) <= 0.1
    assert max(one.error_deg for one in turning) <= 25.0
    assert max(one.tool_deg_s for one in hidden(turning)) <= INFERRED_DEG_S + OF_FLOAT


@pytest.mark.slow
def test_where_an_inferred_thumb_turns_nothing_and_the_reference_is_taken_anew_the_tool_drifts(monkeypatch):
    """So the operator who turns the hand is one with whom drift would show."""
    seen_only = lambda sample: None if sample.thumb_inferred else shown_orientation(sample)  # noqa: E731
    monkeypatch.setattr(sample_validator, "shown_orientation", seen_only)
    monkeypatch.setattr(FollowedOrientation, "_made_up", lambda _self, lag, *_: lag)
    assert followed("rotate_x", 60.0, seed=1)[-1].error_deg > 5.0


@pytest.mark.slow
def test_a_thumb_that_is_inferred_all_the_time_still_turns_the_tool():
    off = np.array([0.004, -0.004, 0.004])
    found = followed("rotate_x", 12.0, 1, lambda e: replace(e, thumb=e.thumb + off, thumb_inferred=True))
    assert np.median([one.error_deg for one in found]) < 6.0
    assert max(one.tool_deg_s for one in found) <= INFERRED_DEG_S + OF_FLOAT


@pytest.mark.slow
@pytest.mark.parametrize("sigma_m", [0.5, 10.0, None])
def test_an_inferred_thumb_that_is_hardly_known_or_nobody_knows_how_well_leaves_the_tool_as_it_is(sigma_m):
    known = SEEN | {"thumb": sigma_m**2 * np.eye(3)} if sigma_m is not None else {}

    def unsure(estimate):
        return replace(estimate, thumb_inferred=True, covariances=known)

    assert max(one.tool_deg_s for one in followed("rotate_z", 4.0, 1, unsure)) == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("inferred", [False, True])
def test_a_thumb_on_the_wrong_side_never_swings_the_tool_and_leaves_no_drift(inferred):
    """Index and thumb are taken for each other, again and again: half a turn of the hand's frame."""

    def swapped(estimate):
        t_s = (estimate.t_ns - START_NS) / 1e9
        known = replace(estimate, thumb_inferred=False, covariances=SEEN)
        if not is_hidden(t_s) or t_s > 10.0:
            return known
        return replace(known, index=estimate.thumb, thumb=estimate.index, thumb_inferred=inferred)

    found = followed("rotate_z", 15.9, 1, swapped)
    assert max(one.error_deg for one in found) <= 30.0
    assert found[-1].error_deg <= 0.1


def test_a_toggle_counts_while_the_thumb_is_inferred():
    known = PointCovariances(**dict.fromkeys(("wrist", "index", "thumb"), (1e-5, 0.0, 0.0, 1e-5, 0.0, 1e-5)))
    loop = RemoteLoop()
    loop.run(400, lambda _: STILL)
    loop.run(40, lambda _: STILL, thumb_inferred=True, covariance=known)
    loop.run(40, lambda _: STILL, thumb_inferred=True, covariance=known, gripper_toggles=1)
    assert loop.gripper is GripperCommand.CLOSED
