"""Tables as Markdown, and the figures in them."""

from collections.abc import Iterable, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """The lines of a table."""
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]


def figure(value: float) -> str:
    """Three digits, more before the point."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"
