"""The board's page: a valid PDF whose rectangles have the exact size, found as the same board by OpenCV."""

import re

import numpy as np
import pytest

from farhand.setup.board_page import BOARD, PAPERS, RULER_MM, board_page
from farhand.setup.pdf import BlackRectangle, PrintedPage, PrintedWords, pdf_of
from local_site.calibration.boards import BoardFinder
from tests.present import present

POINTS_PER_MM = 72 / 25.4
PX_PER_MM = 4
SUPERSAMPLED = 4
RECTANGLE = re.compile(rb"([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) re")
TEXT = re.compile(rb"BT /F1 ([\d.]+) Tf ([\d.]+) ([\d.]+) Td \((.*)\) Tj ET")


def written(paper):
    return pdf_of(board_page(BOARD, PAPERS[paper]))


def rectangles_mm(pdf):
    """The rectangles as written (N, 4): left, bottom, width, height, mm from the lower left corner."""
    return np.array([[float(value) for value in found] for found in RECTANGLE.findall(pdf)]) / POINTS_PER_MM


def rendered(pdf, paper):
    """The page in grey, by the area of each pixel that is black."""
    width, height = PAPERS[paper]
    scale = PX_PER_MM * SUPERSAMPLED
    page = np.full((round(height * scale), round(width * scale)), 255, np.uint8)
    for left, bottom, wide, high in rectangles_mm(pdf):
        top = height - bottom - high
        page[round(top * scale) : round((top + high) * scale), round(left * scale) : round((left + wide) * scale)] = 0
    rows, columns = page.shape[0] // SUPERSAMPLED, page.shape[1] // SUPERSAMPLED
    cropped = page[: rows * SUPERSAMPLED, : columns * SUPERSAMPLED]
    return cropped.reshape(rows, SUPERSAMPLED, columns, SUPERSAMPLED).mean(axis=(1, 3)).astype(np.uint8)


@pytest.mark.parametrize("paper", PAPERS)
def test_the_file_is_a_valid_pdf_of_the_papers_size(paper):
    pdf = written(paper)
    assert pdf.startswith(b"%PDF-1.4\n")
    assert pdf.endswith(b"%%EOF\n")
    assert b"/Type /Page /Parent 2 0 R" in pdf
    begin = int(present(re.search(rb"startxref\n(\d+)\n", pdf))[1])
    table = pdf[begin:].split(b"trailer")[0].splitlines()
    assert table[:2] == [b"xref", b"0 6"]
    assert all(len(line) == 19 for line in table[2:]), "entries have 20 bytes with their end of line"
    for number, line in enumerate(table[3:], start=1):
        assert pdf[int(line[:10]) :].startswith(b"%d 0 obj\n" % number)
    length, content = present(re.search(rb"/Length (\d+) >>\nstream\n(.*?)\nendstream", pdf, re.DOTALL)).groups()
    assert int(length) == len(content)
    box = present(re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)).groups()
    assert [float(value) for value in box] == pytest.approx([POINTS_PER_MM * mm for mm in PAPERS[paper]], abs=1e-3)


@pytest.mark.parametrize("paper", PAPERS)
def test_squares_markers_and_rulers_have_their_exact_size(paper):
    found = rectangles_mm(written(paper))
    squares = found[np.isclose(found[:, 2], 30, atol=1e-4) & np.isclose(found[:, 3], 30, atol=1e-4)]
    assert len(squares) == BOARD.columns * BOARD.rows // 2
    assert np.ptp(squares[:, 0]) == pytest.approx(7 * 30, abs=1e-3)
    assert np.ptp(squares[:, 1]) == pytest.approx(5 * 30, abs=1e-3)
    assert np.sum(np.isclose(found[:, 2], 22, atol=1e-4)) >= 2 * len(squares), "each marker has a whole black edge"
    line = found[np.argmax(found[:, 2])][3]
    ticks = found[np.isclose(found[:, 2], line, atol=1e-6)]
    for length, count in ((RULER_MM, 11), (4 * 25.4, 9)):
        ruler = found[np.isclose(found[:, 2], length + line, atol=1e-3)]
        assert len(ruler) == 1, "the ruler's line ends with its ticks"
        left = ruler[0, 0]
        own = ticks[(ticks[:, 0] >= left - 1e-3) & (ticks[:, 0] <= left + length + 1e-3)]
        assert len(own) == count
        assert np.ptp(own[:, 0]) == pytest.approx(length, abs=1e-3)


@pytest.mark.parametrize("paper", PAPERS)
def test_everything_is_within_what_printers_print(paper):
    pdf = written(paper)
    found, (width, height) = rectangles_mm(pdf), PAPERS[paper]
    assert found[:, :2].min() > 5
    assert (found[:, 0] + found[:, 2]).max() < width - 5
    assert (found[:, 1] + found[:, 3]).max() < height - 5
    for size, left, baseline, text in TEXT.findall(pdf):
        wide = (
            0.56 * float(size) * len(text)
        )  # Helvetica's digits are 0.556 wide, its other letters narrower on average
        assert float(left) + wide < (width - 5) * POINTS_PER_MM
        assert float(baseline) > 5 * POINTS_PER_MM


@pytest.mark.parametrize("paper", PAPERS)
def test_opencv_finds_all_corners_where_the_page_has_them(paper):
    pdf = written(paper)
    view = present(BoardFinder(BOARD).find(rendered(pdf, paper)))
    assert view.ids.tolist() == list(range(len(BOARD.corners)))
    left = (PAPERS[paper][0] - 1000 * BOARD.square * BOARD.columns) / 2
    expected = PX_PER_MM * (1000 * BOARD.corners[:, :2] + (left, 8.0)) - 0.5
    assert view.pixels == pytest.approx(expected, abs=0.2)


def test_the_page_says_how_to_print_it_and_what_it_is():
    words = b" ".join(text for *_, text in TEXT.findall(written("A4")))
    for said in (
        b"Print at 100 %",
        b"measure the ruler",
        b"8 x 6 squares of 30 mm",
        b"markers 22 mm",
        b"100 mm",
        b"4 in",
    ):
        assert said in words


def test_brackets_in_words_do_not_end_them():
    pdf = pdf_of(PrintedPage(100, 50, (BlackRectangle(0, 0, 1, 1),), (PrintedWords(1, 1, 2, r"a (b) \c"),)))
    assert rb"(a \(b\) \\c) Tj" in pdf
