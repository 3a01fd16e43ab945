"""A report as one page of HTML: headings, tables and pictures from its own folder; nothing from elsewhere."""

import html
from collections.abc import Iterable, Sequence

STYLE = (
    "body{font:15px/1.5 sans-serif;max-width:1620px;margin:2em auto;padding:0 1em;color:#222}"
    "img{max-width:100%}figure{margin:1em 0}a:focus-visible{outline:3px solid #1558b0}"
    "table{border-collapse:collapse;margin:1em 0}td,th{padding:.2em 1em;border-bottom:1px solid #ddd;"
    "text-align:right}td:first-child,th:first-child{text-align:left;font-weight:normal}"
    "thead th:first-child{font-weight:bold}"
)


def page(title: str, body: Iterable[str]) -> str:
    """The page with its title as heading above parts that the other functions here made."""
    name = html.escape(title)
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{name}</title><style>{STYLE}</style><main><h1>{name}</h1>{''.join(body)}</main></html>\n"
    )


def heading(text: str) -> str:
    """The heading of a section."""
    return f"<h2>{html.escape(text)}</h2>"


def paragraph(text: str) -> str:
    """A paragraph of plain text."""
    return f"<p>{html.escape(text)}</p>"


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table; the first cell of a row says what the row is about."""
    columns = "".join(f'<th scope="col">{html.escape(name)}</th>' for name in head)
    lines = "".join(f"<tr>{_row(row)}</tr>" for row in rows)
    return f"<table><thead><tr>{columns}</tr></thead><tbody>{lines}</tbody></table>"


def _row(row: Sequence[object]) -> str:
    first, *others = (html.escape(str(cell)) for cell in row)
    return f'<th scope="row">{first}</th>' + "".join(f"<td>{cell}</td>" for cell in others)


def picture(file: str, alt: str, caption: str = "") -> str:
    """A picture in the page's folder, which opens in its full size by a click or by the Enter key."""
    name, words = html.escape(file), html.escape(alt)
    below = f"<figcaption>{html.escape(caption)}</figcaption>" if caption else ""
    return f'<figure><a href="{name}"><img src="{name}" alt="{words}"></a>{below}</figure>'


def files(names: Iterable[str]) -> str:
    """Links to files in the page's folder."""
    links = ", ".join(f'<a href="{html.escape(name)}">{html.escape(name)}</a>' for name in names)
    return f"<p>Files: {links}</p>"
