"""Networks to files that a runtime reads: ONNX, in whole precision or with weights and activations of 8 bits."""

from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from onnxruntime.quantization import CalibrationDataReader, CalibrationMethod, QuantFormat, QuantType, quantize_static
from onnxruntime.quantization.shape_inference import quant_pre_process
from torch import Tensor, nn

PICTURE = "picture"
OPSET = 18


class SeeingNetwork(nn.Module):
    """A network without what it was only needed to learn with."""

    def __init__(self, network: nn.Module, outputs: int) -> None:
        super().__init__()
        self.network = network
        self.outputs = outputs

    def forward(self, picture: Tensor) -> tuple[Tensor, ...]:
        """Look at pictures."""
        answer = self.network(picture)
        return (answer,) if isinstance(answer, Tensor) else tuple(answer[: self.outputs])


def export_network(network: nn.Module, size: tuple[int, int], outputs: list[str], path: Path) -> None:
    """Write a network for one picture of (height, width) px; normalisation is folded into the convolutions."""
    seeing = SeeingNetwork(network, len(outputs)).eval()
    example = torch.zeros(1, 3, *size)
    torch.onnx.export(
        seeing,
        (example,),
        str(path),
        input_names=[PICTURE],
        output_names=outputs,
        opset_version=OPSET,
        dynamo=True,
        external_data=False,
        verbose=False,
    )
    model = onnx.load(str(path))
    for node in model.graph.node:
        node.ClearField("metadata_props")  # where in which source each step was written, on this machine
    onnx.checker.check_model(model)
    onnx.save(model, str(path))


def quantise(whole: Path, pictures: list[NDArray[np.float32]], path: Path) -> None:
    """Write a network of 8 bits, each channel with its own scale, its ranges taken from pictures (1, 3, H, W).

    The convolutions at its ends stay in whole precision: a step of 8 bits in what they give moves points by pixels.
    """
    with TemporaryDirectory() as folder, redirect_stdout(StringIO()):  # the calibration tells of its every step
        prepared = Path(folder) / "prepared.onnx"
        quant_pre_process(str(whole), str(prepared), skip_symbolic_shape=True)
        quantize_static(
            str(prepared),
            str(path),
            _Pictures(pictures),
            quant_format=QuantFormat.QDQ,
            per_channel=True,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
            op_types_to_quantize=["Conv", "Add", "Resize", "Relu"],
            nodes_to_exclude=_convolutions_at_the_ends(onnx.load(str(prepared))),
            calibrate_method=CalibrationMethod.Entropy,  # by the runtime's 128 bins, the same ranges as MinMax
        )


def _convolutions_at_the_ends(model: onnx.ModelProto) -> list[str]:
    """Names of the convolutions that come first, and of those that no other follows."""
    nearest: dict[str, set[str]] = {}  # of each value, the convolutions that it comes from by no other one
    first: set[str] = set()
    last: set[str] = set()
    for node in model.graph.node:  # in the order in which they are computed
        before: set[str] = set().union(*(nearest.get(value, set()) for value in node.input))
        if node.op_type == "Conv":
            last -= before
            last.add(node.name)
            first |= set() if before else {node.name}
            before = {node.name}
        nearest.update(dict.fromkeys(node.output, before))
    return sorted(first | last)


class _Pictures(CalibrationDataReader):
    def __init__(self, pictures: list[NDArray[np.float32]]) -> None:
        self._pictures = iter(pictures)

    def get_next(self) -> dict[str, NDArray[np.float32]] | None:
        """Give the next picture, None after the last."""
        picture = next(self._pictures, None)
        return None if picture is None else {PICTURE: picture}
