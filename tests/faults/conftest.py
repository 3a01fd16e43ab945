"""The pairs of sites on which the faults are played; rows with the same settings share one."""

import os
import platform
from collections.abc import Iterator
from pathlib import Path

import pytest

from lab.stage.network.namespaces import LinkedHosts, why_not
from tests.faults.cell_pair import CellPair
from tests.faults.fault_report import Report
from tests.faults.fault_rows import Row
from tests.faults.trial import Outcome

FOLDER = Path("faults")
PATIENT = ("safety.t_latch_ms=1000",)  # on a machine that is shared, hardly anything but the fault ends the engagement
ABOUT = "Each fault on both sites as processes of their own; every command that reached the driver is judged."


class Stage:
    """The pair that is up, the network between if the sites are on two hosts, and the report."""

    def __init__(self, network: LinkedHosts | None, report: Report, patience: tuple[str, ...] = ()) -> None:
        """`patience` are settings with which a machine that is late ends no engagement."""
        self.report = report
        self._network, self._patience = network, patience
        self._pair: CellPair | None = None
        self._settings: object = None

    def pair_for(self, row: Row) -> CellPair:
        """The pair that a row needs: the running one if its settings match."""
        if self._pair is None or self._settings != (row.settings, row.protocol):
            self.clear()
            self._pair, self._settings = CellPair(self._network, (*self._patience, *row.settings), row.protocol), None
            self._pair.start()
            self._settings = row.settings, row.protocol
        return self._pair

    def settle(self, outcome: Outcome) -> None:
        """Restore the link; a pair on which a row has failed is not used again."""
        if self._network is not None:
            self._network.impair()
        if outcome.failures:
            self.clear()

    def clear(self) -> None:
        """End the pair that is up."""
        if self._pair is not None:
            self._pair.close()
            self._pair = None


@pytest.fixture(scope="session")
def stage() -> Iterator[Stage]:
    missing = why_not()
    if missing:
        pytest.skip(f"no network of two hosts on this machine: {missing}")
    network = LinkedHosts()
    network.enter()
    about = f"{ABOUT} {os.cpu_count()} processors, Linux {platform.release()}."
    stage = Stage(network, Report(about, Path("faults.json"), FOLDER / "report.html"))
    yield stage
    stage.clear()
    network.close()


@pytest.fixture(scope="module")
def one_host() -> Iterator[Stage]:
    about = f"{ABOUT} Both sites on one host."
    stage = Stage(None, Report(about, FOLDER / "shortened.json", FOLDER / "shortened.html"), PATIENT)
    yield stage
    stage.clear()
