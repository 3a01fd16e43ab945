"""A track as a folder of pictures, one for each pair."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from common.cameras.images import write_image
from farhand.tracking.results.tracked_pair import Take


@contextmanager
def annotated_pictures(folder: Path) -> Iterator[Take]:
    """A folder with NUMBER.png for each pair, made with the first."""
    yield lambda pair: write_image(folder, f"{pair.line.frame:06d}", pair.picture)
