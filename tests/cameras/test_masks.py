"""Which pixels of a rig count, and the files that say so."""

from __future__ import annotations

import json

import numpy as np
import pycolmap
import pytest
import spheremap as sm
from conftest import random_directions


def test_each_direction_counts_in_the_view_with_the_nearest_axis_alone():
    rig = sm.cameras.rig((96, 128), n=10)
    masks = sm.cameras.masks(rig)
    axes = np.stack([view.pose[:, 2] for view in rig])
    d = random_directions(20_000, 520)
    angles = d @ axes.T
    best, second = np.sort(angles, axis=-1)[:, -1:-3:-1].T
    nearest = angles.argmax(axis=-1)
    # Half the diagonal of a pixel from where two are as near: 170 degrees in 96 pixels at most.
    clear = best - second > 0.03
    assert clear.mean() > 0.9
    for k, (view, mask) in enumerate(zip(rig, masks, strict=True)):
        assert mask.shape == view.size and mask.dtype == bool
        xy = np.nan_to_num(sm.directions_to_pixels(d, view.projection, view.size), nan=-1)
        inside = xy[:, 0] >= 0
        x, y = (np.minimum(xy[:, i].astype(int), n - 1) for i, n in ((0, 128), (1, 96)))
        counts = inside & mask[y, x]
        assert np.array_equal(counts[clear], (nearest == k)[clear])


def test_together_they_see_the_sphere_once():
    rig = sm.cameras.rig(128, fov=90)
    masks = sm.cameras.masks(rig)
    seen = sum(
        view.camera.solid_angle(view.size)[mask].sum()
        for view, mask in zip(rig, masks, strict=True)
    )
    # A border of some 60 radians is drawn with pixels of 1/80 radian, to either side.
    assert seen == pytest.approx(4 * np.pi, rel=0.01)


def test_nothing_counts_below_the_photographer():
    rig = sm.cameras.rig(128, fov=90)
    whole = sm.cameras.masks(rig, nearest=False)
    assert all(mask.all() for mask in whole)
    masks = sm.cameras.masks(rig, nearest=False, photographer=35)
    for view, mask in zip(rig, masks, strict=True):
        # The world of a rig is OpenCV's: +y is down.
        angle = np.degrees(np.arccos(view.projection.directions(view.size)[..., 1]))
        assert np.array_equal(mask, angle > 35)
    aside = sm.cameras.masks(rig, nearest=False, photographer=35, down=(5, 0, 0))
    for view, mask in zip(rig, aside, strict=True):
        angle = np.degrees(np.arccos(view.projection.directions(view.size)[..., 0]))
        assert np.array_equal(mask, angle > 35)


def test_a_stitch_without_the_photographer_does_not_see_it():
    rig = sm.cameras.rig(96, fov=90)
    panorama = np.ones((128, 256), np.float32)
    panorama[-20:] = 100
    views = rig.convert(panorama, "latlong")
    masks = sm.cameras.masks(rig, nearest=False, photographer=40)
    got = sm.cameras.stitch(views, rig, "latlong", size=64, masks=masks)
    assert got.max() == 1
    # 40 of 180 degrees below, but for what a texel sees of the next pixel: half of each.
    assert 0 < 64 * 40 / 180 - 64 * (got == 0).mean() < 1


@pytest.mark.parametrize("format", ["colmap", "nerfstudio"])
def test_masks_are_written_beside_the_pictures(format, tmp_path):
    rig = sm.cameras.rig((30, 44), n=8)
    masks = sm.cameras.masks(rig, photographer=30)
    sm.cameras.write(rig, tmp_path, format=format, masks=masks)
    for view, mask in zip(rig, masks, strict=True):
        # COLMAP's name of the picture, and .png.
        file = tmp_path / "masks" / view.name / "0001.png.png"
        theirs = pycolmap.Bitmap.read(str(file), as_rgb=False).to_array()
        assert theirs.shape == mask.shape
        assert np.array_equal(theirs, np.where(mask, 255, 0))
    if format == "nerfstudio":
        frames = json.loads((tmp_path / "transforms.json").read_text())["frames"]
        assert [(tmp_path / frame["mask_path"]).is_file() for frame in frames] == [True] * len(rig)
    sm.cameras.write(rig, tmp_path / "plain", format=format)
    assert not (tmp_path / "plain" / "masks").exists()


def test_colmap_finds_no_features_where_masks_are_black(tmp_path):
    rig = sm.cameras.rig((160, 200), fov=90, overlap=0.2)[:2]
    masks = sm.cameras.masks(rig, photographer=60)
    masks[0][:, :100] = False
    noise = np.random.default_rng(521).integers(0, 256, (20, 25), np.uint8)
    picture = np.repeat(np.repeat(noise, 8, 0), 8, 1)
    for view in rig:
        folder = tmp_path / "images" / view.name
        folder.mkdir(parents=True)
        pycolmap.Bitmap.from_array(np.stack([picture] * 3, -1)).write(str(folder / "0001.png"))
    sm.cameras.write(rig, tmp_path, format="colmap", masks=masks)
    reader = pycolmap.ImageReaderOptions(mask_path=str(tmp_path / "masks"))
    database = tmp_path / "database.db"
    pycolmap.extract_features(
        database, tmp_path / "images", reader_options=reader, device=pycolmap.Device.cpu
    )
    opened = pycolmap.Database.open(database)
    found = {
        image.name: opened.read_keypoints(image.image_id) for image in opened.read_all_images()
    }
    for view, mask in zip(rig, masks, strict=True):
        points = np.asarray(found[f"{view.name}/0001.png"])
        assert len(points) > 20
        # COLMAP counts the center of the first pixel (½, ½), as masks are looked up.
        assert mask[points[:, 1].astype(int), points[:, 0].astype(int)].all()


def test_keypoints_go_to_the_panorama_and_back():
    rig = sm.cameras.rig(800, fov=90)
    world = sm.projection("latlong").in_world_of(rig[0].projection)
    size = (2048, 4096)
    rng = np.random.default_rng(522)
    points = rng.uniform(0, 1, (1000, 2)) * [size[1], size[0]]
    d = sm.pixels_to_directions(points, world, size)
    seen = np.zeros(len(points), int)
    for view in rig:
        xy = sm.directions_to_pixels(d, view.projection, view.size)
        held = ~np.isnan(xy[:, 0])
        seen += held
        again = sm.pixels_to_directions(xy[held], view.projection, view.size)
        back = sm.directions_to_pixels(again, world, size)
        # A dozen roundings of pixels up to 4096, at the poles divided by the sine of a pixel.
        assert np.abs(back - points[held]).max() < 1e-8
    assert seen.min() >= 1 and seen.max() > 1


RIG = sm.cameras.rig(16, fov=90, overlap=0)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"photographer": 0}, r"in \(0, 180\)"),
        ({"photographer": 20, "down": (0, 0, 0)}, "without a length"),
        ({"down": (0, 1)}, r"shape \(3,\)"),
    ],
)
def test_what_is_wrong_is_told(options, text):
    with pytest.raises(ValueError, match=text):
        sm.cameras.masks(RIG, **options)


def test_masks_of_other_rigs_are_refused(tmp_path):
    masks = sm.cameras.masks(RIG)
    for wrong, text in ((masks[:2], "one for each of 6"), ([m[:4] for m in masks], "shape")):
        with pytest.raises(ValueError, match=text):
            sm.cameras.write(RIG, tmp_path / "none", format="colmap", masks=wrong)
    with pytest.raises(TypeError, match="bool"):
        wrong = [mask.astype(int) for mask in masks]
        sm.cameras.write(RIG, tmp_path / "none", format="colmap", masks=wrong)
    # Nothing is written before it is known what.
    assert not (tmp_path / "none").exists()
    with pytest.raises(TypeError, match="a Rig"):
        sm.cameras.masks(list(RIG))
    with pytest.raises(ValueError, match="at least one view"):
        sm.cameras.masks(sm.cameras.Rig(()))


def test_masked_masks_are_refused(tmp_path):
    rig = sm.cameras.rig(16, n=8)
    masks = [np.ma.masked_array(mask, mask) for mask in sm.cameras.masks(rig)]
    with pytest.raises(TypeError, match="`masks` has masked elements"):
        sm.cameras.write(rig, tmp_path, format="colmap", masks=masks)
