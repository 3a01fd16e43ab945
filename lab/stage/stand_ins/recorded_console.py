"""Runs 'farhand console' and keeps every picture message that it receives of the cell.

python -m lab.stage.stand_ins.recorded_console SOCKET --set ...

A command on the socket names the file: {"file": PATH}; without one nothing is kept.
"""

import sys
import time
from pathlib import Path
from unittest.mock import patch

from common.messages.video import VideoFrame
from farhand.__main__ import main
from lab.stage.network.command_socket import CommandSocket
from lab.stage.stand_ins.pictures import PictureLog
from local_site.console.hub import Hub


class Keeper:
    """Keeps pictures in the file of the last command."""

    def __init__(self, commands: CommandSocket) -> None:
        self._commands = commands
        self._log: PictureLog | None = None

    def keep(self, frame: VideoFrame) -> None:
        """Keep a message, unless there is no file."""
        while fields := self._commands.take():
            if self._log is not None:
                self._log.close()
            self._log = PictureLog(Path(fields["file"])) if fields["file"] else None
        if self._log is not None:
            self._log.add(frame, time.monotonic_ns())


def run() -> None:
    """The command line of Farhand, with a console that keeps its pictures."""
    keeper, receive = Keeper(CommandSocket(sys.argv.pop(1))), Hub.camera

    def camera(hub: Hub, frame: VideoFrame) -> None:
        keeper.keep(frame)
        receive(hub, frame)

    sys.argv.insert(1, "console")
    with patch.object(Hub, "camera", camera):
        main()


if __name__ == "__main__":
    run()
