"""The page of a report: words stay words, whatever they contain, and the first cell of a row is its heading."""

from html.parser import HTMLParser

from hypothesis import example, given
from hypothesis import strategies as st

from farhand.reports.page import files, heading, page, paragraph, picture, table

NASTY = '<b>"&'
SAFE = "&lt;b&gt;&quot;&amp;"


def test_words_never_become_markup() -> None:
    parts = [paragraph(NASTY), table([NASTY], [[NASTY, NASTY]]), picture(NASTY, NASTY, NASTY), files([NASTY])]
    made = page(NASTY, parts)
    assert NASTY not in made
    assert made.count(SAFE) == 2 + 1 + 3 + 4 + 2


def test_a_table_names_its_columns_and_rows() -> None:
    made = table(("point", "mm"), [("wrist", 1.5)])
    assert '<th scope="col">mm</th>' in made
    assert '<th scope="row">wrist</th><td>1.5</td>' in made


def test_a_picture_is_reached_by_keyboard_and_read_aloud() -> None:
    assert picture("a.png", "what it shows") == (
        '<figure><a href="a.png"><img src="a.png" alt="what it shows"></a></figure>'
    )


@given(st.text())
@example('"><script>alert(1)</script><img src=x onerror=alert(1)> \u2028 \x00')
def test_no_words_add_an_element_or_an_attribute(words: str) -> None:
    assert elements(words) == elements("plain")


def elements(words: str) -> list[tuple[str, list[str]]]:
    """Every element of a page about these words, with the names of its attributes."""
    found: list[tuple[str, list[str]]] = []
    parser = HTMLParser()
    parser.handle_starttag = lambda tag, attrs: found.append((tag, [name for name, _ in attrs]))  # type: ignore[method-assign]
    parts = [heading(words), paragraph(words), table([words], [[words]]), picture(words, words, f"c{words}")]
    parser.feed(page(words, [*parts, files([words])]))
    return found
