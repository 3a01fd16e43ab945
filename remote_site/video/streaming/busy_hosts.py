"""For how long the hosts of both sites keep pictures waiting for a processor: what of their age is no link's; pure."""

from enum import StrEnum

from common.clock import NS_PER_S

BUSY_MS = 80.0  # as late as a picture that has waited in a link
BUSY_NS = NS_PER_S  # for so long, until it is said: a moment's wait needs no cure
MOST_MS = 500.0  # that is believed: as long as the longest link
OPERATOR_THREADS = 3  # that a picture passes there, each of which may wait: the transport's, a listener's, the loop's


class Host(StrEnum):
    """Whose processor it is."""

    OPERATOR = "operator"
    CELL = "cell"


class BusyHosts:
    """The waits of both hosts; `waited_ms` is how much of a picture's age they may be. This host sets `of_cell_ms`."""

    def __init__(self) -> None:
        self.waited_ms = self.of_cell_ms = 0.0
        self._waits = dict.fromkeys(Host, 0.0)
        self._calm_ns = dict.fromkeys(Host, 0)

    def report(self, of_operator_ms: float, now_ns: int) -> None:
        """The console reports how long its host has made it wait of late, at most."""
        waits = {Host.OPERATOR: OPERATOR_THREADS * of_operator_ms, Host.CELL: self.of_cell_ms}
        self._waits = {host: min(waited_ms, MOST_MS) for host, waited_ms in waits.items()}
        self.waited_ms = min(sum(self._waits.values()), MOST_MS)
        for host, waited_ms in self._waits.items():
            if waited_ms < BUSY_MS or not self._calm_ns[host]:
                self._calm_ns[host] = now_ns

    def busy(self, now_ns: int) -> tuple[Host, float] | None:
        """The host that has long kept pictures waiting, and for how many ms lately; the one where it is longest."""
        host, waited_ms = max(self._waits.items(), key=lambda told: told[1])
        return (host, waited_ms) if waited_ms >= BUSY_MS and now_ns - self._calm_ns[host] >= BUSY_NS else None
