"""Causes that keep pairs from being tracked, counted: a reason may name several, and one in several cameras."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence

from local_site.tracking.tracker import TrackingReason


class Causes:
    """The number of pairs that each cause was named in, by whichever of the cameras (their names)."""

    def __init__(self, cameras: Sequence[str]) -> None:
        names = "|".join(map(re.escape, cameras))
        self._camera = re.compile(rf"({names}): (?P<cause>.*)" if names else r"(?!)", re.DOTALL)
        begins = [f"(?:{names}): "] if names else []
        # A sentence may hold a semicolon of its own, so only what is known to begin another one parts two.
        self._parting = re.compile(
            "; (?=" + "|".join([*begins, *(re.escape(str(sentence)) for sentence in TrackingReason)]) + ")"
        )
        self._pairs: Counter[str] = Counter()
        self._cameras: dict[str, dict[str, None]] = {}

    def add(self, reason: str) -> None:
        """Count the causes of one pair, each once."""
        found: dict[str, None] = {}
        for cause, camera in self._causes(reason):
            found[cause] = None
            named = self._cameras.setdefault(cause, {})
            if camera:
                named[camera] = None
        self._pairs.update(list(found))

    def _causes(self, reason: str) -> Iterator[tuple[str, str]]:
        """Each cause with the camera that it is named for, if any."""
        for part in self._parting.split(reason):
            named = self._camera.fullmatch(part)
            yield (named["cause"], named[1]) if named else (part, "")

    @property
    def commonest(self) -> str:
        """The cause of the most pairs after the names of its cameras; empty without any pair."""
        if not self._pairs:
            return ""
        ((cause, _),) = self._pairs.most_common(1)
        named = " and ".join(self._cameras[cause])
        return f"{named}: {cause}" if named else cause
