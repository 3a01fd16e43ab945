"""Learning: what is right costs least, a training falls and goes on where it was, a file says what the network says."""

# ruff: noqa: E402
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lab.eye.arms.poses import PoseStore

torch = pytest.importorskip("torch", reason="the eye's training needs torch: make eye")
pytest.importorskip("onnx", reason="the eye's export needs onnx: make eye")

from torch import Tensor

from lab.eye.arms.surface import CropKind
from lab.eye.export import export_network, quantise
from lab.eye.exporting import EYE_OUTPUTS, MODELS, moved_middles, moved_points, told_by_file
from lab.eye.judging import judge
from lab.eye.judging_finder import judge_finder
from lab.eye.learning import eye_losses, surprise, whitened
from lab.eye.learning_to_find import finder_losses
from lab.eye.network import EyeNetwork, FinderNetwork
from lab.eye.pictures.hands_in_rooms import FinderSample, FinderSource
from lab.eye.pictures.samples import Sample, SampleSource
from lab.eye.trained import trained_finder, trained_networks
from lab.eye.training import Training

CPU = torch.device("cpu")
Tiles = NDArray[np.uint8]


@pytest.fixture(scope="module")
def source(few_poses: PoseStore, few_tiles: Tiles) -> SampleSource:
    return SampleSource(few_poses, few_tiles, "hand", CPU, seed=1)


@pytest.fixture(scope="module")
def sample(source: SampleSource) -> Sample:
    return source.batch(8)


class _Answering(EyeNetwork):
    """Answers what is true, its points off by a share of the crop."""

    def __init__(self, sample: Sample, off: float) -> None:
        super().__init__(4)
        parts = torch.logit(sample.parts.clamp(0.001, 0.999))
        points = torch.zeros(8, 22, 8)
        points[..., :2] = sample.points[..., :2] + off
        points[..., 5] = sample.points[..., 2] + off
        points[..., 7] = torch.where(sample.seen, 6.0, -6.0)
        square = ((self.grid - points[:, :, None, :2]) ** 2).sum(dim=3)
        whole = torch.stack([torch.where(sample.bare, 6.0, -6.0), torch.where(sample.right, 6.0, -6.0)], dim=1)
        self.answer = parts, points, whole, -0.5 * square * 48.0**2

    def forward(self, _picture: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        return self.answer


def test_what_is_right_costs_less_than_what_is_a_little_off(sample: Sample) -> None:
    right, near, far = (eye_losses(_Answering(sample, off), sample) for off in (0.0, 0.02, 0.1))
    for name in ("points", "heat", "depth"):
        assert right[name] < near[name] < far[name]
    assert right["points"] == 0.0
    assert right["whole"] < 0.01


def test_a_covariance_costs_least_where_it_is_true() -> None:
    off = torch.randn(20000, 2, generator=torch.Generator().manual_seed(1)) * torch.tensor([0.01, 0.03])
    true = torch.tensor([np.log(1 / 0.01), 0.0, np.log(1 / 0.03)], dtype=torch.float32)
    assert whitened(off, true).std(dim=0) == pytest.approx(np.ones(2), abs=0.02)
    costs = [float(surprise(off, true + torch.tensor([d, 0.0, d])).mean()) for d in (-1.0, 0.15, 1.0)]
    assert costs[1] < min(costs[0], costs[2])


def test_a_finder_that_is_right_costs_less(few_poses: PoseStore, few_tiles: Tiles) -> None:
    sample = FinderSource(few_poses, few_tiles, CPU, seed=2).batch(16)
    right, wrong = (finder_losses(_AnsweringFinder(sample, off), sample) for off in (0.0, 5.0))
    assert right["heat"] < wrong["heat"]
    assert right["side"] < wrong["side"]
    assert right["lies"] < wrong["lies"]


class _AnsweringFinder(FinderNetwork):
    """Answers what is true, with hands that are off by some cells."""

    def __init__(self, sample: FinderSample, off: float) -> None:
        super().__init__(4)
        self.answer = _finder_answer(sample, off)

    def forward(self, _picture: Tensor) -> Tensor:
        return self.answer


def _finder_answer(sample: FinderSample, off: float) -> Tensor:
    answer = torch.zeros(len(sample.middle), 7, 36, 48)
    answer[:, :1] = -6.0
    for b, k in sample.found.nonzero().tolist():
        x, y = (sample.middle[b, k] + off).tolist()
        column, row = min(max(int(x), 0), 47), min(max(int(y), 0), 35)
        answer[b, 0, row, column] = 6.0
        ys, xs = torch.meshgrid(torch.arange(36) + 0.5, torch.arange(48) + 0.5, indexing="ij")
        near = ((xs - x) ** 2 + (ys - y) ** 2) < 4.0
        answer[b, 1][near] = 6.0 if sample.right[b, k] else -6.0
        answer[b, 2][near], answer[b, 3][near] = (x - xs)[near], (y - ys)[near]
        answer[b, 4:6, near] = sample.direction[b, k][:, None]
        answer[b, 6][near] = sample.size[b, k]
    return answer


def test_the_loss_falls(source: SampleSource, sample: Sample, tmp_path: Path) -> None:
    torch.manual_seed(0)
    training = Training(EyeNetwork(4), lambda _: sample, eye_losses, tmp_path / "hand.pt", CPU)
    told = [training.step(sample, 0.3) for _ in range(40)]
    sums = [float(sum(losses.values())) for losses in told]
    assert np.mean(sums[-5:]) < 0.75 * np.mean(sums[:5])
    judged = judge(training.averaged, source, "hand", batches=1, size=8)
    assert judged.samples == 8
    assert '"scale_95"' in judged.text()


def test_a_training_goes_on_where_it_was(sample: Sample, tmp_path: Path) -> None:
    path = tmp_path / "eye" / "hand.pt"
    first = Training(EyeNetwork(4), lambda _: sample, eye_losses, path, CPU)
    first.run(seconds=1e-9, batch=2)
    again = Training(EyeNetwork(4), lambda _: sample, eye_losses, path, CPU)
    assert again.progress == first.progress
    assert again.progress.images == 8
    for one, other in zip(first.network.parameters(), again.network.parameters(), strict=True):
        torch.testing.assert_close(one, other)
    path.unlink()
    from_weights = Training(EyeNetwork(4), lambda _: sample, eye_losses, path, CPU)
    from_weights.begin_with(path.with_suffix(".weights.pt"))
    assert from_weights.progress.images == 0
    for one, other in zip(first.averaged.parameters(), from_weights.network.parameters(), strict=True):
        torch.testing.assert_close(one, other)


def test_a_step_that_is_not_a_number_spoils_nothing(sample: Sample, tmp_path: Path) -> None:
    training = Training(EyeNetwork(4), lambda _: sample, eye_losses, tmp_path / "hand.pt", CPU)
    before = [parameter.clone() for parameter in training.network.parameters()]
    training.step(replace(sample, points=sample.points * torch.nan), 0.5)
    for one, other in zip(before, training.network.parameters(), strict=True):
        torch.testing.assert_close(one, other)


def test_a_finder_is_judged(few_poses: PoseStore, few_tiles: Tiles) -> None:
    source = FinderSource(few_poses, few_tiles, CPU, seed=2)
    judged = judge_finder(FinderNetwork(4), source, batches=1, size=16)
    assert judged.hands > 0
    assert judged.found == 0.0  # it has learned nothing


@pytest.mark.filterwarnings("ignore::FutureWarning", "ignore::DeprecationWarning")  # of the exporter's own
def test_a_file_says_what_the_network_says(sample: Sample, tmp_path: Path) -> None:
    network = trained_networks()["arm"]  # the points of one that has learned nothing are all in the middle
    path, small = tmp_path / "arm.onnx", tmp_path / "arm.int8.onnx"
    export_network(network, (192, 192), EYE_OUTPUTS, path)
    with torch.no_grad():
        expected = network(sample.picture)
    for output, other in zip(EYE_OUTPUTS, expected[:3], strict=True):
        np.testing.assert_allclose(told_by_file(path, sample.picture, output), other.numpy(), atol=5e-4)
    quantise(path, [picture[None].numpy() for picture in sample.picture], small)
    assert small.stat().st_size < 0.4 * path.stat().st_size
    assert 0.0 < moved_points(network, small, sample).median() < 0.6  # 1.4 with all convolutions of 8 bits


@pytest.mark.parametrize("kind", ["arm", "hand"])
def test_the_tracker_has_the_networks_as_they_were_trained(kind: CropKind, sample: Sample) -> None:
    assert moved_points(trained_networks()[kind], MODELS / f"{kind}.onnx", sample).median() < 1.0


def test_the_tracker_has_the_finder_as_it_was_trained(few_poses: PoseStore, few_tiles: Tiles) -> None:
    sample = FinderSource(few_poses, few_tiles, CPU, seed=2).batch(16)
    assert moved_middles(trained_finder(), MODELS / "finder.onnx", sample).median() < 1.0
