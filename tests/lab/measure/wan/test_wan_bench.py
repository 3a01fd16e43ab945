"""The whole bench over one good link: real sites, certificates, pictures, report; and what is measured again."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from lab.measure.wan import wan_bench
from lab.stage.network.namespaces import why_not
from lab.stage.processes import ROOT
from lab.stage.stolen_time import StolenTime

SHORT = """
from pathlib import Path
from lab.measure.wan import wan_bench
from lab.measure.wan.links import WanLink
wan_bench.FOLDER = Path({folder!r})
wan_bench.SETTLES_S, wan_bench.WATCHED_S = 3.0, 4.0
wan_bench.run((WanLink(2, mbit_s=100),), ())
"""


@pytest.mark.long
@pytest.mark.skipif(bool(why_not()), reason="no right to network namespaces")
def test_a_good_link_is_followed_and_its_pictures_arrive(tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-c", SHORT.format(folder=str(tmp_path))], check=True, cwd=ROOT, timeout=150)
    (figures,) = json.loads((tmp_path / "report.json").read_text())["links"].values()
    assert figures["followed"] > 0.5
    assert figures["fps"] > 10
    assert 2 < figures["age_p50_ms"] < 300
    assert figures["ssim"] > 0.9
    assert "| 2 | 0% | 0% | 100 |" in (tmp_path / "networks.md").read_text()
    assert (tmp_path / "networks.png").stat().st_size > 10_000


def test_a_run_from_which_the_host_took_much_is_measured_again_whatever_its_result(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shares, runs = iter([0.5, 0.31, 0.1]), []

    class _Stolen(StolenTime):
        def __init__(self, cores: int) -> None:
            super().__init__(cores, lambda: 0.0)
            self.worst = next(shares)

    monkeypatch.setattr(wan_bench, "StolenTime", _Stolen)

    def measure() -> dict[str, float]:
        runs.append(1)
        return {"followed": len(runs) / 3}

    assert wan_bench.undisturbed(measure) == {"followed": 1.0, "stolen": 0.1, "runs": 3}
    shares = iter([0.9] * 5)
    assert wan_bench.undisturbed(measure)["runs"] == wan_bench.MOST_RUNS
