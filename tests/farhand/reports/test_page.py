"""The page of a report: words stay words, whatever they contain, and the first cell of a row is its heading."""

from farhand.reports.page import files, page, paragraph, picture, table

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
