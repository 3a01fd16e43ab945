"""A page of a PDF: black rectangles and lines of text, at exact places in mm."""

from collections.abc import Sequence
from dataclasses import dataclass, field

POINTS_PER_MM = 72 / 25.4


@dataclass(frozen=True, slots=True)
class BlackRectangle:
    """A black rectangle: its upper left corner from the page's, its width and height, mm."""

    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class PrintedWords:
    """A line of text: the left end of its baseline from the page's upper left corner, the size of its letters, mm."""

    x: float
    y: float
    size: float
    text: str


@dataclass(frozen=True, slots=True)
class PrintedPage:
    """A page of this width and height in mm, and what is on it."""

    width: float
    height: float
    rectangles: Sequence[BlackRectangle] = field(default=())
    words: Sequence[PrintedWords] = field(default=())


def pdf_of(page: PrintedPage) -> bytes:
    """The page as a PDF file; the same page gives the same bytes."""
    content = _content(page).encode("latin-1")
    box = f"[0 0 {_points(page.width)} {_points(page.height)}]"
    objects = [
        # A viewer that obeys this does not offer to fit the page to the paper.
        b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox {box} /Contents 4 0 R "
        "/Resources << /Font << /F1 5 0 R >> >> >>".encode("latin-1"),
        b"<< /Length %d >>\nstream\n%b\nendstream" % (len(content), content),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
    ]
    return _file(objects)


def _file(objects: Sequence[bytes]) -> bytes:
    """The objects, numbered from 1, with the table of where each begins."""
    written, begins = b"%PDF-1.4\n", []
    for number, body in enumerate(objects, start=1):
        begins.append(len(written))
        written += b"%d 0 obj\n%b\nendobj\n" % (number, body)
    table = b"".join(b"%010d 00000 n \n" % begin for begin in begins)
    count = len(objects) + 1
    end = b"trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (count, len(written))
    return written + b"xref\n0 %d\n0000000000 65535 f \n%b%b" % (count, table, end)


def _content(page: PrintedPage) -> str:
    """The page's drawing: PDF counts from the lower left corner, in points."""
    # One fill for all: rectangles that touch leave no seam between them, whatever draws them.
    lines = ["0 g"]
    for r in page.rectangles:
        left, bottom = r.x, page.height - r.y - r.height
        lines.append(f"{_points(left)} {_points(bottom)} {_points(r.width)} {_points(r.height)} re")
    lines.append("f" if page.rectangles else "n")
    for w in page.words:
        text = w.text.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
        place = f"{_points(w.x)} {_points(page.height - w.y)}"
        lines.append(f"BT /F1 {_points(w.size)} Tf {place} Td ({text}) Tj ET")
    return "\n".join(lines)


def _points(mm: float) -> str:
    return f"{mm * POINTS_PER_MM:.4f}"
