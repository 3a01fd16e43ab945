"""The operator's sight in a process of its own: while it looks, key and hand stay in time."""

import multiprocessing
from multiprocessing.connection import Connection

import cv2

from common.errors import ProcessError
from lab.visual_operator.shown import ShownPage
from lab.visual_operator.sight.sight import Scene, Sight
from lab.visual_operator.task import PlacingTask

END_S = 2.0


class SightProcess:
    """Looks at one page after the other, as `Sight` does; close it at the end."""

    def __init__(self, task: PlacingTask) -> None:
        spawn = multiprocessing.get_context("spawn")
        self._pipe, theirs = spawn.Pipe()
        self._process = spawn.Process(target=_see_for_ever, args=(theirs, task), name="sight", daemon=True)
        self._process.start()
        theirs.close()

    def see(self, shown: ShownPage) -> Scene:
        """Return what is on a page; ProcessError once the process has died."""
        try:
            self._pipe.send(shown)
            scene: Scene = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise ProcessError("the process of the operator's sight has died; see the lines above for why") from error
        return scene

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.join(END_S)


def _see_for_ever(pipe: Connection, task: PlacingTask) -> None:
    """The body of the process: it ends with the pipe."""
    cv2.setNumThreads(1)
    sight = Sight(task)
    while True:
        try:
            pipe.send(sight.see(pipe.recv()))
        except EOFError:
            return
