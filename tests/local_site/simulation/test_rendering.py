"""The simulated pictures: exact outlines, a lens that distorts, blur, noise, and repeatability."""

import cv2
import numpy as np
import pytest

from local_site.simulation.body import Part, Solid
from local_site.simulation.cameras import stereo_pair
from local_site.simulation.config import MotionConfig, PictureConfig, SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.rendering import Renderer

SHARP = PictureConfig(blur_sigma_px=0.0, noise_sigma=0.0)
MOVING_S = 8.9


def operator(picture=SHARP, seed=1, motion="pick_and_place", **stereo):
    return SimulatedOperator(
        SimulationConfig(picture=picture, seed=seed, motion=MotionConfig(name=motion), stereo=StereoConfig(**stereo))
    )


def cone_renderer(camera, picture=SHARP):
    """Draws a single limb between two balls."""
    parts = (Part("cone", (np.array([0, 1]),)),)
    return Renderer(camera, parts, StereoConfig(), picture, seed=1)


def cone(centres, radii):
    # The rim belongs to the body's sleeve; here it is a point inside the first ball.
    return Solid(np.array(centres), np.array(radii), np.tile(centres[0], (32, 1)))


def seen_by_ray(camera, solid, subdivision):
    """Fraction of each pixel's rays (H, W) that meet the hull of two balls: the truth, found without any outline."""
    size = np.arange(0.0, 1.0, 1.0 / subdivision) + 0.5 / subdivision - 0.5
    u, v = np.meshgrid((np.arange(240, 400)[:, None] + size).ravel(), (np.arange(160, 320)[:, None] + size).ravel())
    slopes = (np.stack([u, v], axis=-1) - camera.principal_px) / camera.focal_px
    rays = np.concatenate([slopes, np.ones((*u.shape, 1))], axis=-1)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    hit = np.zeros(u.shape, bool)
    (start, end), (r0, r1) = camera.to_camera(solid.centres), solid.radii
    for share in np.linspace(0.0, 1.0, 60):
        centre, radius = start + share * (end - start), r0 + share * (r1 - r0)
        along = rays @ centre
        hit |= centre @ centre - along**2 < radius**2
    return hit.reshape(160, subdivision, 160, subdivision).mean(axis=(1, 3))


@pytest.mark.parametrize("view", [0, 1])
def test_the_outline_is_where_lines_of_sight_touch_the_skin(view):
    camera = stereo_pair(StereoConfig())[view]
    solid = cone([[0.44, 0.42, 0.47], [0.57, 0.47, 0.54]], [0.022, 0.047])
    # Small grey levels of coverage would drown in shading, so compare what is at least half covered.
    picture = cone_renderer(camera).render([solid])[160:320, 240:400]
    exact = seen_by_ray(camera, solid, subdivision=4)
    drawn = picture > 9 + 96 / 2
    assert np.count_nonzero(drawn) == pytest.approx(exact.sum(), rel=0.01)
    differing = drawn != (exact > 0.5)
    assert np.abs(exact[differing] - 0.5).max(initial=0.0) < 0.3


def overlap(a, b):
    """Intersection over union of what is brighter than the background."""
    return np.count_nonzero((a > 55) & (b > 55)) / np.count_nonzero((a > 55) | (b > 55))


def test_a_distorting_lens_moves_the_outline_as_it_moves_points():
    k1 = -0.2
    plain_camera, bent_camera = (stereo_pair(StereoConfig(k1=k))[0] for k in (0.0, k1))
    corner = plain_camera.centre + np.array([0.45, 0.25, 1.5]) @ plain_camera.camera_R_operator
    solid = cone([corner, corner - 0.3 * plain_camera.camera_R_operator[0]], [0.03, 0.05])
    plain, bent = (cone_renderer(camera).render([solid]) for camera in (plain_camera, bent_camera))
    distorted = (np.stack(np.meshgrid(np.arange(640.0), np.arange(480.0)), axis=-1) - [319.5, 239.5]) / 800.0
    slopes = distorted
    for _ in range(20):
        slopes = distorted / (1.0 + k1 * np.sum(slopes**2, axis=-1, keepdims=True))
    columns, rows = np.moveaxis((800.0 * slopes + [319.5, 239.5]).astype(np.float32), -1, 0)
    expected = cv2.remap(plain, columns, rows, cv2.INTER_LINEAR)
    assert overlap(plain, bent) < 0.9
    assert overlap(expected, bent) > 0.985


def test_the_same_seed_gives_the_same_pictures():
    noisy = PictureConfig()
    first, again, other = operator(noisy, 1), operator(noisy, 1), operator(noisy, 2)
    for t_s in (0.0, 3.3):
        pictures = [np.stack(o.render(t_s)) for o in (first, again, other)]
        assert np.array_equal(pictures[0], pictures[1])
        assert not np.array_equal(pictures[0], pictures[2])


def test_successive_noisy_pictures_of_a_still_arm_differ():
    still = operator(PictureConfig(), motion="hold")
    assert not np.array_equal(still.render(0.0)[0], still.render(0.1)[0])


def test_noise_has_the_asked_strength_and_no_bias():
    clean = operator(SHARP, motion="hold").render(0.0)[0].astype(float)
    noisy = operator(PictureConfig(blur_sigma_px=0.0, noise_sigma=3.0), motion="hold").render(0.0)[0].astype(float)
    arm = clean > 150
    assert (noisy - clean)[arm].std() == pytest.approx(3.0, rel=0.05)
    assert abs((noisy - clean)[arm].mean()) < 0.1


def test_motion_blur_softens_the_moving_edge_only():
    def edge_width(picture, t_s):
        image = operator(picture).render(t_s)[0]
        return np.count_nonzero((image > 25) & (image < 85))

    blurred = PictureConfig(blur_sigma_px=0.0, noise_sigma=0.0, shutter_ms=30.0)
    assert edge_width(blurred, 0.0) == pytest.approx(edge_width(SHARP, 0.0), rel=0.02)
    assert edge_width(blurred, MOVING_S) > 1.3 * edge_width(SHARP, MOVING_S)


def test_an_arm_out_of_view_leaves_the_background():
    camera = stereo_pair(StereoConfig())[0]
    renderer = cone_renderer(camera)
    away = camera.centre + 2.0 * camera.camera_R_operator[2] + 3.0 * camera.camera_R_operator[0]
    empty = renderer.render([cone([away, away + 0.1], [0.02, 0.02])])
    assert empty.max() < 20


def test_an_arm_is_cut_by_the_border_of_the_picture():
    camera = stereo_pair(StereoConfig())[0]
    edge = camera.centre + 1.5 * (camera.camera_R_operator[2] + 0.4 * camera.camera_R_operator[0])
    image = cone_renderer(camera).render([cone([edge, edge - 0.2 * camera.camera_R_operator[0]], [0.04, 0.04])])
    assert image[:, -1].max() > 80


def test_pictures_are_dark_with_a_bright_arm_as_wide_as_arms_are():
    for image in operator(PictureConfig()).render(0.0):
        assert image.shape == (480, 640)
        assert image.dtype == np.uint8
        threshold, mask = cv2.threshold(image, 0, 255, cv2.THRESH_OTSU)
        assert 30 < threshold < 150
        assert 0.015 < np.count_nonzero(mask) / mask.size < 0.1
