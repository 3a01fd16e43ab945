"""Drawn pictures: skin where a second rasteriser sees it, parts that add up, cameras as they are."""

# ruff: noqa: E402
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lab.eye.arms.poses import PoseStore

torch = pytest.importorskip("torch", reason="the eye's training needs torch: make eye")

from torch import Generator, Tensor

from lab.eye.arms.rendering import SkinRaster, SkinRenderer
from lab.eye.arms.surface import skin_attributes
from lab.eye.arms.views import random_views
from lab.eye.pictures.backgrounds import Rooms, room_tiles
from lab.eye.pictures.hands_in_rooms import HEIGHT, WIDTH, FinderSource
from lab.eye.pictures.painting import CLASSES, FINER, SIZE, ArmPainter
from lab.eye.pictures.random_tensors import Draw
from lab.eye.pictures.samples import SampleSource
from lab.eye.pictures.sensor import blurred, compressed, filmed, moved
from lab.films.arm.arm_mesh import load_arm_mesh
from local_site.kernels.rasterising import rasterise
from tests.present import present

CPU = torch.device("cpu")
Tiles = NDArray[np.uint8]


def _generator(seed: int = 1) -> Generator:
    return torch.Generator().manual_seed(seed)


@pytest.fixture(scope="module")
def painter(few_poses: PoseStore) -> ArmPainter:
    return ArmPainter(few_poses, "arm", CPU)


def test_skin_is_where_the_films_rasteriser_sees_it(few_poses: PoseStore) -> None:
    renderer, size = SkinRenderer("arm", CPU), SIZE * FINER
    pose = torch.tensor([3, 250])
    rest = torch.from_numpy(few_poses.vertices)[torch.from_numpy(few_poses.body)[pose].long()]
    vertices = renderer.vertices(
        rest, torch.from_numpy(few_poses.rotations)[pose], torch.from_numpy(few_poses.offsets)[pose]
    )
    view = random_views(torch.from_numpy(few_poses.points)[pose], "arm", _generator(4))
    triangles = load_arm_mesh("average").triangles
    ours, seen = renderer.raster(vertices, view, size), view.project(vertices).double().numpy()
    for k in range(2):
        outside, inside = (
            rasterise(seen[k, :, :2] * size - 0.5, seen[k, :, 2], np.ascontiguousarray(each), size, size).inverse_depth
            for each in (triangles, triangles[:, ::-1])
        )
        theirs = np.maximum(outside, inside)
        drawn = ours.covered[k].numpy()
        true = (theirs > 0.0) & (_along_seen(renderer, ours)[k].numpy() > 0.3)  # beyond where our arm begins
        both, grown = drawn & true, cv2.dilate((theirs > 0.0).astype(np.uint8), np.ones((3, 3), np.uint8))
        assert both.sum() > 0.995 * true.sum()
        assert (drawn & (grown == 0)).sum() < 0.01 * drawn.sum()  # gaps between fingers that are closed
        assert np.median(np.abs(ours.depth[k].numpy()[both] - 1.0 / theirs[both])) < 0.004


def _along_seen(renderer: SkinRenderer, raster: SkinRaster) -> Tensor:
    along = torch.from_numpy(skin_attributes().along).float()[None, :, None].expand(2, -1, -1)
    return renderer.pixels(raster, along)[..., 0]


def test_a_crop_shows_the_hand_upright_and_of_its_metric_size(few_poses: PoseStore) -> None:
    points = torch.from_numpy(few_poses.points)
    view = random_views(points, "hand", _generator())
    seen = view.project(points)
    up = seen[:, 10] - seen[:, 1]
    angle = torch.rad2deg(torch.atan2(up[:, 0], -up[:, 1]))
    assert angle.median().abs() < 4.0
    assert angle.abs().quantile(0.75) < 35.0
    assert (seen[:, [6, 10, 18], :2].mean(dim=1) - 0.5).abs().mean() < 0.12
    across = (view.rotation.transpose(1, 2) @ torch.tensor([0.1, 0.0, 0.0]))[:, None]
    beside = view.project(points[:, 1:2] + across) - seen[:, 1:2]
    torch.testing.assert_close(beside[:, 0, :2].norm(dim=1), 0.1 / view.metres, rtol=1e-3, atol=1e-4)


def test_parts_add_up_and_points_lie_on_them(painter: ArmPainter) -> None:
    layer = painter.paint(Draw(12, _generator(2)))
    torch.testing.assert_close(layer.parts.sum(dim=1), torch.ones(12, 192, 192))
    assert (layer.colour.amax(dim=1, keepdim=True) > 0.0).logical_and(layer.coverage == 0.0).sum() == 0
    inside = layer.seen[:, 2:]
    at = (layer.points[:, 2:, :2] * 192).long().clamp(0, 191)
    on_arm = layer.coverage[torch.arange(12)[:, None], 0, at[..., 1], at[..., 0]] > 0.3
    assert (on_arm & inside).sum() > 0.95 * inside.sum()


def test_the_same_seed_makes_the_same_samples(few_poses: PoseStore, few_tiles: Tiles) -> None:
    one, other = (SampleSource(few_poses, few_tiles, "arm", CPU, seed=3).batch(4) for _ in range(2))
    torch.testing.assert_close(one.picture, other.picture, rtol=0.0, atol=0.0)
    assert one.picture.shape == (4, 3, 192, 192)
    assert one.parts.shape == (4, CLASSES, 96, 96)
    assert one.picture.min() >= -1.0
    assert one.picture.max() <= 1.0


def test_of_left_arms_no_point_is_asked_for(few_poses: PoseStore, few_tiles: Tiles) -> None:
    source = SampleSource(few_poses, few_tiles, "arm", CPU, seed=8)
    samples = [source.batch(8) for _ in range(4)]
    left = torch.cat([~sample.right for sample in samples])
    assert 0 < left.sum() < 16
    assert not torch.cat([sample.asked for sample in samples])[left].any()


def test_a_whole_picture_tells_where_its_hands_are(few_poses: PoseStore, few_tiles: Tiles) -> None:
    sample = FinderSource(few_poses, few_tiles, CPU, seed=2).batch(16)
    assert sample.picture.shape == (16, 3, HEIGHT, WIDTH)
    found = sample.found
    assert found.any()
    assert not (found & sample.unclear).any()
    middle = sample.middle[found]
    assert ((middle > -3.0) & (middle < torch.tensor([51.0, 39.0]))).all()
    torch.testing.assert_close(sample.direction[found].norm(dim=1), torch.ones(int(found.sum())))


def test_compression_is_that_of_jpeg() -> None:
    y, x = np.mgrid[0:64, 0:64]
    noise = np.random.default_rng(1).normal(0, 12, (64, 64, 3))
    picture = np.clip(np.stack([3 * x, 2 * y + x, 255 - 3 * y], 2) + noise, 0, 255).astype(np.uint8)
    flags = [cv2.IMWRITE_JPEG_QUALITY, 50, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420]
    theirs = present(cv2.imdecode(cv2.imencode(".jpg", picture[:, :, ::-1], flags)[1], cv2.IMREAD_COLOR))[:, :, ::-1]
    tensor = torch.from_numpy(picture).float().permute(2, 0, 1)[None] / 255.0
    ours = 255.0 * compressed(tensor, torch.tensor([50.0]))[0].permute(1, 2, 0).numpy()
    lost = np.abs(theirs.astype(float) - picture).mean()
    assert np.abs(ours - theirs).mean() < 0.4 * lost


def test_blur_and_motion_keep_the_light() -> None:
    picture = torch.rand(3, 3, 64, 64, generator=_generator())
    for soft in (blurred(picture, torch.tensor([0.5, 1.5, 3.0])), moved(picture, Draw(3, _generator(2)), 6.0)):
        torch.testing.assert_close(soft.mean(dim=(2, 3)), picture.mean(dim=(2, 3)), rtol=0.05, atol=0.0)
        assert (soft.std(dim=(2, 3)) < picture.std(dim=(2, 3))).all()


def test_a_film_is_between_black_and_white(few_tiles: Tiles) -> None:
    draw = Draw(8, _generator(6))
    film = filmed(Rooms(few_tiles, CPU).backgrounds(64, draw), draw)
    assert film.min() >= 0.0
    assert film.max() <= 1.0
    assert film.std() > 0.05


def test_rooms_are_made_without_photographs() -> None:
    tiles = room_tiles([], seed=1)
    assert len(tiles) > 100
    assert tiles.std(axis=(1, 2, 3)).mean() > 10.0
