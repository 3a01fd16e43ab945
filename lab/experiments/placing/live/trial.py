"""One trial in wall-clock time: the processes started, the operator at its page until it is done, all ended, judged."""

import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import TypeVar

import msgspec

from common.errors import ProcessError
from common.link.transport import open_link
from farhand.loopback.recorder import Recorder
from farhand.loopback.site_process import SiteProcess, free_ports, listens, module_command
from lab.experiments.placing.live.judgement import TrialJudgement
from lab.experiments.placing.live.pace import LiveResult, live_result
from lab.experiments.placing.live.plan import CELL, LivePlan, live_plan
from lab.experiments.placing.trial import Conditions
from lab.stage.staged_sites import StagedSites
from lab.visual_operator.at_console.operator_process import TrialNotes

LIVE = "lab.experiments.placing.live."
JUDGED_REMOTE, LED_LOCAL, OPERATOR = LIVE + "judged_remote", LIVE + "led_local", "lab.visual_operator.at_console"
START_TIMEOUT_S, MARGIN_S = 60.0, 20.0

T = TypeVar("T")


def run_live(conditions: Conditions) -> LiveResult:
    """Run a trial to its end; ProcessError when a process fails, or the page never has all that the operator needs.

    The simulated cell's process alone knows where the block is, and tells it once it ends, after the operator has left.
    """
    with tempfile.TemporaryDirectory() as seen, tempfile.TemporaryDirectory() as hidden:
        plan, judgement = live_plan(conditions, free_ports(4), Path(seen)), Path(hidden) / "end"
        sites = StagedSites({"STATE_DIRECTORY": hidden})
        try:
            _play(plan, judgement, sites)
        finally:
            sites.end()
        notes = _read(Path(plan.operator.notes), TrialNotes, sites)
        return live_result(notes, _read(judgement, TrialJudgement, sites), sites.record, sites.events)


def operator_process(plan: LivePlan) -> SiteProcess:
    """The operator's, which is given the console's port and its hand's socket, and of both sites nothing."""
    return SiteProcess("operator", module_command(OPERATOR, msgspec.json.encode(plan.operator).decode()), {})


def _play(plan: LivePlan, judgement: Path, sites: StagedSites) -> None:
    """Start everything, and return when the operator has left; the links are closed then."""
    with ExitStack() as stack:
        sites.start("remote", module_command(JUDGED_REMOTE, str(judgement), "remote"), plan.remote)
        control = stack.enter_context(open_link(connect=(plan.control, plan.listen)))
        sites.listen(Recorder(control, control, CELL, ()))
        sites.start("local", module_command(LED_LOCAL, plan.operator.led_by, "local"), plan.local)
        sites.start("console", module_command("farhand", "console"), plan.console)
        sites.wait("the console", lambda: listens(plan.operator.port), START_TIMEOUT_S)
        operator = operator_process(plan)
        stack.callback(operator.end)
        most_s = plan.operator.patience_s + plan.operator.most_s + MARGIN_S
        sites.wait("the operator", lambda: operator.exit_code is not None, most_s)
        if operator.exit_code:
            raise ProcessError(f"the operator left its page: {operator.last_error()}; {sites.last_errors()}")


def _read(path: Path, kind: type[T], sites: StagedSites) -> T:
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except OSError as error:
        raise ProcessError(f"a trial has left no {kind.__name__}: {sites.last_errors()}") from error
