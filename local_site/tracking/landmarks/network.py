"""Runs one landmark model on the processor: a picture in, its outputs."""

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from common.errors import ModelError, NotInstalledError

Tensor = NDArray[np.float32]
RUNTIME = "ai-edge-litert"
CURE = "pip install 'farhand[learned]'"


class LandmarkNetwork:
    """A model with one picture as its input; NotInstalledError without the runtime, ModelError when that refuses it."""

    def __init__(self, content: bytes, outputs: int) -> None:
        try:
            from ai_edge_litert.interpreter import Interpreter  # noqa: PLC0415  # an extra
        except ImportError as error:
            raise NotInstalledError(f"the tracker 'learned' needs its runtime: {CURE}") from error
        try:
            with _silenced():
                self._interpreter: Any = Interpreter(model_content=content, num_threads=1)
                self._interpreter.allocate_tensors()
        except (ValueError, RuntimeError) as error:
            raise ModelError(f"the runtime cannot read a landmark model: {error}") from error
        given = self._interpreter.get_input_details()[0]
        self._input: int = given["index"]
        self._outputs: list[int] = [output["index"] for output in self._interpreter.get_output_details()[:outputs]]
        self.side_px = int(given["shape"][1])

    def run(self, picture: Tensor) -> Sequence[Tensor]:
        """Compute the outputs for a square RGB picture (side, side, 3) from 0 to 1, without their batch axis."""
        self._interpreter.set_tensor(self._input, picture[None])
        self._interpreter.invoke()
        return [self._interpreter.get_tensor(index)[0] for index in self._outputs]


@contextmanager
def _silenced() -> Iterator[None]:
    """Discard standard error meanwhile: the runtime prints there what it does, and has no switch for it."""
    sys.stderr.flush()
    kept = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    os.close(nowhere)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
