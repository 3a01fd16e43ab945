"""The delay between hand and eye, and the scale suggested for it."""

import pytest

from local_site.console.model.situation import loop_delay_ms, suggested_scale


def test_the_way_back_counts_once() -> None:
    assert loop_delay_ms(180.0, 160.0) == 260.0
    assert loop_delay_ms(None, 160.0) is None
    assert loop_delay_ms(180.0, None) is None


@pytest.mark.parametrize(
    ("loop_ms", "scale"),
    [(None, 1.0), (0.0, 1.0), (200.0, 1.0), (210.0, 0.95), (300.0, 0.65), (400.0, 0.5), (1000.0, 0.2), (9000.0, 0.1)],
)
def test_the_scale_falls_as_the_delay_grows_beyond_a_mild_one(loop_ms: float | None, scale: float) -> None:
    assert suggested_scale(loop_ms) == scale


def test_a_tool_goes_no_further_unseen_than_after_a_mild_delay() -> None:
    for loop_ms in range(210, 1500, 10):
        assert suggested_scale(loop_ms) * loop_ms == pytest.approx(200.0, abs=0.03 * loop_ms)
