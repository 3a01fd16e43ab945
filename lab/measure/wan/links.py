"""The links of the matrix and those that change under way; pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

DELAYS_MS = (0.0, 20.0, 40.0, 80.0, 120.0)
JITTERS = (0.0, 0.2)
LOSSES = (0.0, 0.01, 0.03)
RATES_MBIT_S = (100.0, 20.0, 5.0, 2.0)


@dataclass(frozen=True, slots=True, order=True)
class WanLink:
    """One link: delay each way, jitter as a fraction of it, fraction of packets lost, rate each way."""

    delay_ms: float
    jitter: float = 0.0
    loss: float = 0.0
    mbit_s: float = 100.0

    @property
    def impairment(self) -> dict[str, Any]:
        """The fields of the link's impairment (lab/stage/network)."""
        jitter_ms = self.jitter * self.delay_ms
        return {"delay_ms": self.delay_ms, "jitter_ms": jitter_ms, "loss": self.loss, "mbit_s": self.mbit_s}

    @property
    def name(self) -> str:
        """As in the names of figures: delay_jitter_loss_rate."""
        return f"{self.delay_ms:g}ms_{self.jitter:.0%}_{self.loss:.0%}_{self.mbit_s:g}mbit".replace("%", "pc")

    @property
    def calm(self) -> "WanLink":
        """The same delay and rate, without jitter and loss."""
        return WanLink(self.delay_ms, mbit_s=self.mbit_s)


MATRIX = tuple(
    WanLink(*values) for values in product(DELAYS_MS, JITTERS, LOSSES, RATES_MBIT_S) if values[0] or not values[1]
)
SUBSET = (
    WanLink(0),
    *(WanLink(delay_ms, mbit_s=5) for delay_ms in DELAYS_MS),
    *(WanLink(delay_ms, jitter=0.2, loss=0.03, mbit_s=5) for delay_ms in DELAYS_MS[1:]),
    WanLink(40, mbit_s=2),
    WanLink(40, loss=0.01, mbit_s=2),
    WanLink(40, loss=0.03, mbit_s=2),
)


@dataclass(frozen=True, slots=True)
class Change:
    """A link that changes under way, from `before`; for `seconds`, or for good (0). A cut passes nothing."""

    name: str
    to: WanLink | None
    seconds: float = 0.0
    before: WanLink = WanLink(20, mbit_s=20)

    @property
    def impairment(self) -> dict[str, Any]:
        """The fields of the link's impairment while it lasts."""
        return self.to.impairment if self.to is not None else self.before.impairment | {"cut": True}


CHANGES = (
    Change("cut of 300 ms", None, 0.3),
    Change("cut of 1 s", None, 1.0),
    Change("cut of 10 s", None, 10.0),
    Change("rate falls from 20 to 2 Mbit/s", WanLink(20, mbit_s=2)),
    Change("delay jumps from 20 to 120 ms", WanLink(120, mbit_s=20)),
)

FULL, LINKS = "--full", "--links="


def chosen(words: Sequence[str]) -> tuple[tuple[WanLink, ...], tuple[Change, ...]]:
    """Choose by the words of a command: the whole matrix, the links and changes named, else a part of the matrix.

    ValueError for a name that is neither a link's nor a change's.
    """
    named = next((word.removeprefix(LINKS).split(",") for word in words if word.startswith(LINKS)), None)
    if named is None:
        return (MATRIX if FULL in words else SUBSET), CHANGES
    links, changes = {link.name: link for link in MATRIX}, {change.name: change for change in CHANGES}
    unknown = [name for name in named if name not in links | changes]
    if unknown:
        raise ValueError(
            f"no link or change is called {', '.join(unknown)}: links are {SUBSET[0].name} and the like, as in "
            f"build/wan/report.json; changes are {', '.join(changes)}"
        )
    return tuple(links[n] for n in named if n in links), tuple(changes[n] for n in named if n in changes)
