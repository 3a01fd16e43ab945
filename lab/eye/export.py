"""Networks to files that a runtime reads: ONNX, in whole precision or with weights and activations of 8 bits."""

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
OPSET = 17


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
        seeing, (example,), str(path), input_names=[PICTURE], output_names=outputs, opset_version=OPSET, dynamo=False
    )
    onnx.checker.check_model(onnx.load(str(path)))


def quantise(whole: Path, pictures: list[NDArray[np.float32]], path: Path) -> None:
    """Write a network with 8 bits, its ranges taken from pictures (1, 3, H, W), each channel's weights by themselves."""
    with TemporaryDirectory() as folder:
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
            calibrate_method=CalibrationMethod.MinMax,
        )


class _Pictures(CalibrationDataReader):  # type: ignore[misc]
    def __init__(self, pictures: list[NDArray[np.float32]]) -> None:
        self._pictures = iter(pictures)

    def get_next(self) -> dict[str, NDArray[np.float32]] | None:
        """Give the next picture, None after the last."""
        picture = next(self._pictures, None)
        return None if picture is None else {PICTURE: picture}
