"""The tool's box and what the arm can reach: too long a box is refused, and sides that hold nothing back are said."""

import pytest

from common.errors import ConfigError
from remote_site.safety.config import SafetyConfig
from remote_site.safety.workspace_box import check_box, idle_sides
from tests.remote_site.remote_loop import arm

MODEL, _ = arm()
LEAST, MOST = (corner.tolist() for corner in MODEL.reach)
Row = tuple[float, float, float]


def box(axis: int, low: float, high: float) -> SafetyConfig:
    """The default's, with other ends along one axis."""
    lower, upper = (list(row) for row in (SafetyConfig().workspace_min_m, SafetyConfig().workspace_max_m))
    lower[axis], upper[axis] = low, high
    return SafetyConfig(workspace_min_m=_row(lower), workspace_max_m=_row(upper))


def _row(values: list[float]) -> Row:
    x, y, z = values
    return x, y, z


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("shift", [-3.0, -0.5, 0.0, 0.5])
def test_a_box_is_refused_where_it_is_longer_than_the_reach_wherever_it_lies(axis: int, shift: float) -> None:
    low, high = LEAST[axis] + shift, MOST[axis] + shift
    check_box(box(axis, low + 0.01, high), MODEL)
    with pytest.raises(ConfigError) as refused:
        check_box(box(axis, low - 0.01, high), MODEL)
    for words in (f"{high - low + 0.01:g} m along {'xyz'[axis]}", f"over {MOST[axis] - LEAST[axis]:.2f} m only"):
        assert words in str(refused.value)


def test_every_side_beyond_the_reach_is_told_and_no_other() -> None:
    assert idle_sides(SafetyConfig(), MODEL) == []
    for axis, name in enumerate("xyz"):
        low, high = LEAST[axis], MOST[axis]
        assert idle_sides(box(axis, low, high), MODEL) == []
        assert idle_sides(box(axis, low - 0.1, high - 0.1), MODEL) == [
            f"{name} from {low - 0.1:g} m (the tool reaches {low:.2f} m)"
        ]
        assert idle_sides(box(axis, low + 0.1, high + 0.1), MODEL) == [
            f"{name} up to {high + 0.1:g} m (the tool reaches {high:.2f} m)"
        ]
