"""The pairs of sites on which the faults are played: one for all rows that can share it."""

import os
from collections.abc import Iterator

import numpy as np
import pytest
from cell_pair import CellPair
from fault_report import FOLDER, Report
from fault_rows import Row
from namespaces import Network, why_not
from trial import Trial

ABOUT = "Each fault on both sites as processes of their own; every command that reached the driver is judged."


class Stage:
    """The pair that is up, the network between, and the report."""

    def __init__(self) -> None:
        self.report = Report(f"{ABOUT} {os.cpu_count()} processors.")
        self._network: Network | None = None
        self._pair: CellPair | None = None
        self._settings: object = None

    def pair_for(self, row: Row) -> CellPair:
        """The pair that a row needs: the one that is up if it will do."""
        if self._pair is None or self._settings != row.settings:
            self.clear()
            self._pair, self._settings = CellPair(self._hosts(), row.settings), row.settings
            self._pair.start()
        return self._pair

    def settle(self, trial: Trial) -> None:
        """Good weather again; a pair on which a row has failed is not used any more, its record is kept."""
        if self._network is not None:
            self._network.weather()
        if trial.outcome.failures:
            np.save(FOLDER / "failed.npy", trial.pair.log(trial.begun_ns).records)
            self.clear()

    def clear(self) -> None:
        """End the pair that is up."""
        if self._network is not None:
            self._network.weather()
        if self._pair is not None:
            self._pair.close()
            self._pair = None

    def close(self) -> None:
        """End everything."""
        self.clear()
        if self._network is not None:
            self._network.close()

    def _hosts(self) -> Network:
        if self._network is None:
            missing = why_not()
            if missing:
                pytest.skip(f"no network of two hosts on this machine: {missing}")
            self._network = Network()
            self._network.enter()
        return self._network


@pytest.fixture(scope="session")
def stage() -> Iterator[Stage]:
    stage = Stage()
    yield stage
    stage.close()
