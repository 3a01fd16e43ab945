"""The rows of a status as a table, for a terminal that is redrawn or for a file."""

from collections.abc import Sequence

from rich.table import Table
from rich.text import Text

from common.text import escaped
from farhand.status.words import Mood, Row

STYLES = {Mood.GOOD: "green", Mood.PLAIN: "", Mood.WORTH_A_LOOK: "yellow", Mood.WRONG: "bold red"}


def screen(rows: Sequence[Row], title: str) -> Table:
    """The rows as a table; what another site says in them does nothing to the terminal."""
    table = Table(title=title, show_header=False, title_justify="left", expand=True, box=None)  # 24 lines are few
    table.add_column(no_wrap=True)
    table.add_column(ratio=1)
    for row in rows:
        table.add_row(Text(escaped(row.name)), Text(escaped(row.words), style=STYLES[row.mood]))
    return table


def as_lines(rows: Sequence[Row]) -> list[str]:
    """The same as one line for each row, for what is no terminal."""
    return [f"{row.name}: {row.words}" for row in rows]
