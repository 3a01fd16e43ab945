"""The dataset read by programs of others: every check of lerobot-doctor passes, Rerun and pandas read all of it."""

import json
import os
import re
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from tests.farhand.export.lerobot.made_dataset import export, info
from tests.farhand.export.made_session import MadeSession

READERS = Path(__file__).parents[4] / "build/dataset-readers/bin"
WITHOUT = pytest.mark.skipif(not (READERS / "rerun").exists(), reason="the readers are missing: make dataset-readers")
LONG = ((0.5, 4.2), (4.4, 8.9))  # doctor warns of episodes under 100 frames
pytestmark = WITHOUT


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    out = tmp_path_factory.mktemp("read") / "dataset"
    export([MadeSession("one", 9, LONG), MadeSession("two", 9, LONG, phase=1.0)], out)
    return out


def run(folder, *command):
    """Run a reader with settings of its own, which it may not send anywhere."""
    home = {"HOME": str(folder), "XDG_CONFIG_HOME": f"{folder}/config", "XDG_DATA_HOME": f"{folder}/data"}
    ended = subprocess.run(
        [READERS / command[0], *map(str, command[1:])],
        env={**os.environ, **home, "PYTHONPATH": "", "NO_COLOR": "1"},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr + ended.stdout
    return ended.stdout + ended.stderr


@pytest.mark.slow
def test_lerobot_doctor_passes_every_check(dataset, tmp_path):
    output = run(tmp_path, "lerobot-doctor", "check", dataset, "--verbose")
    assert output.count("[PASS]") == 11, output
    assert "[WARN]" not in output
    assert "[FAIL]" not in output


def test_rerun_reads_every_frame_of_every_stream(dataset, tmp_path):
    run(tmp_path, "rerun", "analytics", "disable")
    read = tmp_path / "read.rrd"
    output = run(tmp_path, "rerun", dataset, "--save", read, "--bind", "127.0.0.1", "--port", "auto")
    assert "WARN" not in output, output
    printed = run(tmp_path, "rerun", "rrd", "print", read)
    rows = Counter[str]()
    for count, entity in re.findall(
        r"with (\d+) rows .* - /(\S+) - data columns: \[(?:VideoStream:sample|Scalars)", printed
    ):
        rows[entity] += int(count)
    counted = {"timestamp", "frame_index", "episode_index", "index", "task_index"}
    streams = set(info(dataset)["features"]) - counted
    assert rows == dict.fromkeys(streams, info(dataset)["total_frames"]), printed


def test_pandas_finds_the_tasks_as_its_index(dataset, tmp_path):
    code = (
        "import json, sys, pandas; table = pandas.read_parquet(sys.argv[1]);"
        "print(json.dumps([table.index.name, list(table.index), list(table.task_index)]))"
    )
    output = run(tmp_path, "python", "-c", code, dataset / "meta/tasks.parquet")
    assert json.loads(output) == ["task", ["put the block on the mark", "öffne die Schublade"], [0, 1]]
