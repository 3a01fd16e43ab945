"""The operator's process has no way to the simulated cell: it imports neither site, nor is given anything of one."""

import json
import subprocess
import sys
from pathlib import Path

import msgspec

from lab.experiments.placing.live import trial
from lab.experiments.placing.live.plan import live_plan
from lab.experiments.placing.trial import Conditions
from lab.visual_operator.at_console.operator_process import OperatorSetup

FORBIDDEN = ("remote_site", "local_site", "mujoco", "zenoh", "common.link", "lab.experiments", "farhand.loopback")
IMPORTED = """
import json, sys
import lab.visual_operator.at_console.__main__
print(json.dumps(sorted(sys.modules)))
"""


def test_its_process_imports_neither_site_nor_the_links():
    done = subprocess.run([sys.executable, "-c", IMPORTED], capture_output=True, text=True, check=True)
    modules = json.loads(done.stdout)
    assert "lab.visual_operator.operator" in modules
    assert [name for name in modules if name.startswith(FORBIDDEN)] == []


def test_it_is_given_the_console_and_its_hand_and_nothing_of_the_remote_site():
    plan = live_plan(Conditions("silhouette", True, 9), (7001, 7002, 7003, 7004), Path("seen"))
    setup = msgspec.json.encode(plan.operator).decode()
    assert not any(str(port) in setup for port in (7001, 7002, 7003))
    settings = dict(setting.split("=", 1) for setting in plan.remote)
    assert settings["simulation.block.yaw_deg"] not in setup
    assert (
        set(msgspec.structs.asdict(plan.operator))
        == set(OperatorSetup.__struct_fields__)
        == {"port", "led_by", "notes", "roll_fixed", "seed", "page_ns", "most_s", "patience_s"}
    )


def test_its_process_gets_that_and_nothing_else(monkeypatch, tmp_path):
    told: list[list[str]] = []

    class Started:
        def __init__(self, name, command, environment):
            told.append([name, *command, *environment.values()])
            self.exit_code = 0

        def end(self):
            pass

    monkeypatch.setattr(trial, "SiteProcess", Started)
    plan = live_plan(Conditions("silhouette", True, 9), (7001, 7002, 7003, 7004), tmp_path / "seen")
    trial.operator_process(plan)
    name, *command = told[0]
    assert name == "operator"
    assert command[1:] == ["-P", "-m", trial.OPERATOR, msgspec.json.encode(plan.operator).decode()]
