"""The benchmark of many cells, in short: what is sent arrives, and the router's load is told."""

from bench.cells import run


def test_two_cells_meet_at_a_router() -> None:
    figures = run(2, 0.7)
    assert figures["hands_arrived"] > 0.9
    assert figures["pictures_arrived"] > 0.5
    assert figures["hand_p50_ms"] > 0
    assert figures["router_mb"] > 1
