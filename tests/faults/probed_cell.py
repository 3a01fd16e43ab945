"""A cell's probe server beyond a bad link, and the doctor that measures the link: prints its findings as JSON.

Run it as a process of its own: it leaves this machine's network for good.
"""

import json
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from datetime import UTC, datetime
from pathlib import Path

from common.host_clock import MonotonicClock
from common.link.channels import STATE
from common.link.transport import open_link
from common.messages.robot import SessionState
from farhand.certificates.folder import CertificateOrder, create
from farhand.loopback.site_process import options_of
from lab.stage.cell_certificates import CellCertificates
from lab.stage.network.namespaces import LinkedHosts
from remote_site.runtime.probe_server import ProbeServer
from tests.common.messages.golden_examples import STATE as SOME_STATE

CELL, OPERATOR, PORT = "lab", "anna", 7447
TICK_S = 0.004
PATIENCE_S = 60.0


def serve(folder: Path, protocol: str, stop: threading.Event, *, engaged: bool) -> None:
    """Echo probes at control's rate, and publish the state of an arm at rest or engaged."""
    word = SessionState.ENGAGED if engaged else SessionState.DISENGAGED
    fields = {name: getattr(SOME_STATE, name) for name in SOME_STATE.__struct_fields__}
    state = type(SOME_STATE)(**fields | {"state": word, "hand_link": None})
    security = CellCertificates(folder, CELL).security_of("remote")
    with open_link(listen=(f"{protocol}/localhost:{PORT}",), security=security, operators=(OPERATOR,)) as link:
        server = ProbeServer(link, CELL, (OPERATOR,), MonotonicClock(), print)
        states = link.publisher(STATE, CELL)
        ticks = 0
        while not stop.wait(TICK_S):
            server.poll(engaged=engaged)
            ticks += 1
            if ticks % 5 == 0:
                states.put(state)


def settings(folder: Path, protocol: str) -> list[str]:
    """The settings of the local site that the doctor examines."""
    given = f"cell={CELL}", f"authority.operator={OPERATOR}", f"links.remote={protocol}/localhost:{PORT}"
    return options_of([*given, *CellCertificates(folder, CELL).settings_of(f"operator.{OPERATOR}")])


def main(protocol: str, impairment: dict[str, float], *, engaged: bool) -> None:
    """Measure a link of this protocol and impairment."""
    folder, network, stop = Path(tempfile.mkdtemp(prefix="farhand-probed-")), LinkedHosts(), threading.Event()
    create(folder, CertificateOrder(CELL, ("localhost",), 1, (OPERATOR,)), datetime.now(UTC))
    network.enter()
    serving = threading.Thread(target=serve, args=(folder, protocol, stop), kwargs={"engaged": engaged})
    serving.start()
    try:
        _impair(network, impairment)
        command = [sys.executable, "-m", "farhand", "doctor", "--link", "--json", *settings(folder, protocol)]
        subprocess.run([*network.beyond, *command], check=False)
    finally:
        stop.set()
        serving.join()
        network.close()
        shutil.rmtree(folder)


def _impair(network: LinkedHosts, impairment: dict[str, float]) -> None:
    """Impair the link as soon as its process has started."""
    deadline_s = time.monotonic() + PATIENCE_S
    while True:
        try:
            network.impair(**impairment)
        except OSError:
            if time.monotonic() > deadline_s:
                raise
            time.sleep(0.05)
        else:
            return


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]), engaged=len(sys.argv) > 3)
