"""What a file says besides its texels: windows, parts, orientation, words that travel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import spheremap as sm
from other_files import oiio, put, put_panorama, put_parts
from spheremap import io
from spheremap.io.images import write_copy

WORDS = {
    "Artist": "Ada",
    "Copyright": "© Ada",
    "ImageDescription": "a sky",
    "DateTime": "2020:01:02 03:04:05",
}


def numbered(height: int, width: int, dtype: str = "float32") -> np.ndarray:
    rows, columns = np.mgrid[:height, :width]
    return np.stack([rows, columns, rows + columns], -1).astype(dtype)


def test_a_small_data_window_is_placed(tmp_path: Path) -> None:
    image = numbered(3, 4)
    windows = {"x": 2, "y": 1, "full_x": 0, "full_y": 0, "full_width": 16, "full_height": 8}
    put(tmp_path / "a.exr", image, **windows)
    read = io.read(tmp_path / "a.exr", fill=-1)
    assert read.shape == (8, 16, 3)
    assert np.array_equal(read[1:4, 2:6], image)
    assert np.count_nonzero(read == -1) == 3 * (8 * 16 - 3 * 4)
    assert io.header(tmp_path / "a.exr").window == (1, 2, 4, 6)


def test_a_filling_is_one_that_the_image_holds(tmp_path: Path) -> None:
    windows = {"x": 2, "y": 1, "full_x": 0, "full_y": 0, "full_width": 16, "full_height": 8}
    put(tmp_path / "a.exr", numbered(3, 4), **windows)
    assert np.array_equal(io.read(tmp_path / "a.exr", fill=[1, 2, 3])[0, 0], [1, 2, 3])
    with pytest.raises(ValueError, match=r"`fill` to be one number or 3, got shape \(2,\)"):
        io.read(tmp_path / "a.exr", fill=[1, 2])
    for wrong in ("x", object()):
        with pytest.raises((TypeError, ValueError), match="`fill`"):
            io.read(tmp_path / "a.exr", fill=wrong)


@pytest.mark.parametrize("fill", [300, -1, np.nan])
def test_integers_are_not_filled_with_what_they_do_not_hold(fill: float, tmp_path: Path) -> None:
    windows = {"x": 2, "y": 1, "full_x": 0, "full_y": 0, "full_width": 16, "full_height": 8}
    put(tmp_path / "a.tif", numbered(3, 4, "uint8"), **windows)
    if io.header(tmp_path / "a.tif").window == (0, 0, 3, 4):
        pytest.skip("this OpenImageIO writes no windows into .tif")
    with pytest.raises(ValueError, match="is no value of uint8"):
        io.read(tmp_path / "a.tif", fill=fill)


def test_overscan_is_cropped(tmp_path: Path) -> None:
    image = numbered(12, 20)
    windows = {"x": -2, "y": -2, "full_x": 0, "full_y": 0, "full_width": 16, "full_height": 8}
    put(tmp_path / "a.exr", image, **windows)
    assert np.array_equal(io.read(tmp_path / "a.exr"), image[2:10, 2:18])


def test_a_data_window_beside_the_display_window_is_nothing(tmp_path: Path) -> None:
    windows = {"x": 40, "y": 0, "full_x": 0, "full_y": 0, "full_width": 16, "full_height": 8}
    put(tmp_path / "a.exr", numbered(3, 4), **windows)
    assert np.all(io.read(tmp_path / "a.exr", fill=7) == 7)


def test_a_part_is_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "parts.exr"
    put_parts(path, {"left": 0, "right": 1})
    with pytest.raises(ValueError, match=r"2 parts: 0 \(left\), 1 \(right\)"):
        io.read(path)
    for part in ("right", 1, "1"):
        assert np.all(io.read(path, part=part) == 1)
    assert np.all(io.read(path, part="left") == 0)
    assert io.header(path, part=0).parts == ("left", "right")
    with pytest.raises(ValueError, match="no part array"):
        io.read(path, part=np.empty((3, 0)))
    with pytest.raises(ValueError, match="no part 'middle'"):
        io.read(path, part="middle")


def test_a_deep_image_says_so(tmp_path: Path) -> None:
    path = tmp_path / "deep.exr"
    spec = oiio.ImageSpec(2, 2, 2, "float")
    spec.channelnames = ("A", "Z")
    spec.deep = True
    deep = oiio.DeepData()
    deep.init(4, 2, ("float", "float"), ("A", "Z"))
    for k in range(4):
        deep.set_samples(k, 1)
    sink = oiio.ImageOutput.create(str(path))
    assert sink.open(str(path), spec) and sink.write_deep_image(deep) and sink.close()
    with pytest.raises(OSError, match="several depths"):
        io.read(path)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_orientation_is_applied(orientation: int, tmp_path: Path) -> None:
    image = numbered(4, 6, "uint8")
    put(tmp_path / "a.tif", image, Orientation=orientation)
    # EXIF 2.3: the sides of the image as seen that are the stored one's first row and column.
    rows = {
        1: "top",
        2: "top",
        3: "bottom",
        4: "bottom",
        5: "left",
        6: "right",
        7: "right",
        8: "left",
    }
    columns = {
        1: "left",
        2: "right",
        3: "right",
        4: "left",
        5: "top",
        6: "top",
        7: "bottom",
        8: "bottom",
    }
    read = io.read(tmp_path / "a.tif")
    sides = {"top": read[0], "bottom": read[-1], "left": read[:, 0], "right": read[:, -1]}
    assert np.all(sides[rows[orientation]][:, 0] == 0)
    assert np.all(sides[columns[orientation]][:, 1] == 0)
    assert read.shape[:2] == ((4, 6) if orientation < 5 else (6, 4))


@pytest.mark.parametrize("suffix", ["exr", "tif", "jpg", "png"])
def test_words_travel(suffix: str, tmp_path: Path) -> None:
    path, copy = tmp_path / f"a.{suffix}", tmp_path / f"b.{suffix}"
    put(path, numbered(8, 16, "float32" if suffix == "exr" else "uint8"), **WORDS)
    head = io.header(path)
    assert {name: head.metadata[name] for name in WORDS} == WORDS
    io.write(copy, io.read(path), metadata=head.metadata)
    assert {name: io.header(copy).metadata[name] for name in WORDS} == WORDS


def test_numbers_travel(tmp_path: Path) -> None:
    numbers = (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329)
    words = {"chromaticities": numbers, "whiteLuminance": 203.0}
    io.write(tmp_path / "a.exr", numbered(4, 8), metadata=words)
    found = io.header(tmp_path / "a.exr").metadata
    # They are stored as float32.
    assert found["chromaticities"] == pytest.approx(numbers, rel=1e-6)
    assert found["whiteLuminance"] == 203.0


@pytest.mark.parametrize(
    ("suffix", "name"), [("jpg", "latlong"), ("png", "latlong"), ("exr", "latlong")]
)
def test_a_projection_is_noted(suffix: str, name: str, tmp_path: Path) -> None:
    image = numbered(8, 16, "float32" if suffix == "exr" else "uint8")
    io.write(tmp_path / f"a.{suffix}", image, projection=name)
    assert io.header(tmp_path / f"a.{suffix}").projection == name
    if suffix == "png":
        assert np.array_equal(io.read(tmp_path / "a.png"), image)
    if suffix != "exr":
        spec = oiio.ImageInput.open(str(tmp_path / f"a.{suffix}")).spec()
        assert spec.get_string_attribute("GPano:ProjectionType") == "equirectangular"
        assert spec.get_int_attribute("GPano:FullPanoWidthPixels") == 16


@pytest.mark.parametrize(
    ("projection", "name"),
    [
        (sm.projection("latlong"), "latlong"),
        (sm.projection("latlong:blender"), "latlong:blender"),
        (sm.projection("angular", fov=200), "angular(fov=200.0)"),
        (sm.projection("angular(fov=180):openimageio"), "angular(fov=180.0):openimageio"),
        (sm.projection("cube", layout="cross"), "cube"),
        (sm.projection("cube:openexr"), "cube:openexr"),
        ("angular(fov=200)", "angular(fov=200)"),
    ],
)
def test_a_projection_is_noted_by_its_name(projection, name: str, tmp_path: Path) -> None:
    io.write(tmp_path / "a.exr", numbered(8, 8), projection=projection)
    assert io.header(tmp_path / "a.exr").projection == name


def test_what_is_no_projection_is_not_noted(tmp_path: Path) -> None:
    place = tmp_path / "a.exr"
    with pytest.raises(ValueError, match="did you mean 'latlong'"):
        io.write(place, numbered(8, 16), projection="latlog")
    turned = sm.projection("latlong").turned(sm.rotation(10))
    with pytest.raises(ValueError, match="`projection` to be a map that has a name, got proj"):
        io.write(place, numbered(8, 16), projection=turned)
    # Of its aspect a cross is read.
    with pytest.raises(ValueError, match=r"a map that has a name, got .*tee"):
        io.write(place, numbered(6, 8), projection=sm.projection("cube", layout="tee"))
    with pytest.raises(TypeError, match="name of one, got int"):
        io.write(place, numbered(8, 16), projection=3)
    with pytest.raises(ValueError, match="did you mean 'latlong'"):
        io.write(tmp_path / "b.exr", numbered(8, 16))
        io.convert_file(tmp_path / "b.exr", place, "latlong", "latlong", noted="latlog")
    assert not place.exists()


def test_color_spaces_are_those_that_are_known(tmp_path: Path) -> None:
    place = tmp_path / "a.exr"
    with pytest.raises(ValueError, match="unknown color space 'nonsense'"):
        io.write(place, numbered(8, 16), color_space="nonsense")
    with pytest.raises(TypeError, match="`color_space` to be a str, got int"):
        io.write(place, numbered(8, 16), color_space=3)
    assert not place.exists()
    for name in ("sRGB", "ACEScg", "lin_rec709_scene", "Linear Rec.2020"):
        io.write(place, numbered(8, 16), color_space=name)
    # A copy of a file says what that says.
    write_copy(place, numbered(8, 16), compression=None, color_space="KodakLog")


@pytest.mark.parametrize(
    ("name", "said"), [("latlong:openexr", "LatLong"), ("cube:openexr", "CubeFace")]
)
def test_envmap_is_written_and_read(name: str, said: str, tmp_path: Path) -> None:
    p = sm.projection(name)
    io.write(tmp_path / "a.exr", np.zeros((*p.shape(8), 3), np.float32), projection=name)
    spec = oiio.ImageInput.open(str(tmp_path / "a.exr")).spec()
    assert spec.get_string_attribute("textureformat") == f"{said} Environment"
    put(tmp_path / "b.exr", numbered(8, 16), textureformat=f"{said} Environment")
    assert io.header(tmp_path / "b.exr").projection == name


def test_openexr_own_files_say_what_they_are(data_folder: Path) -> None:
    assert io.header(data_folder / "OrientationLatLong.exr").projection == "latlong:openexr"
    assert io.header(data_folder / "OrientationCube.exr").projection == "cube:openexr"


def test_a_part_of_a_panorama_is_placed(tmp_path: Path) -> None:
    image = numbered(3, 5, "uint8") + np.uint8(1)
    put_panorama(
        tmp_path / "a.png",
        image,
        FullPanoWidthPixels=16,
        FullPanoHeightPixels=8,
        CroppedAreaLeftPixels=4,
        CroppedAreaTopPixels=2,
    )
    read = io.read(tmp_path / "a.png")
    assert read.shape == (8, 16, 3) and np.array_equal(read[2:5, 4:9], image)
    assert np.count_nonzero(read) == image.size
    assert io.header(tmp_path / "a.png").projection == "latlong"


def test_a_panorama_that_was_resized_is_the_whole_still(tmp_path: Path) -> None:
    image = numbered(8, 16, "uint8") + np.uint8(1)
    before = {
        "FullPanoWidthPixels": 64,
        "FullPanoHeightPixels": 32,
        "CroppedAreaImageWidthPixels": 64,
        "CroppedAreaImageHeightPixels": 32,
    }
    put_panorama(tmp_path / "a.png", image, **before)
    assert np.array_equal(io.read(tmp_path / "a.png"), image)


@pytest.mark.parametrize("factor", [1, 4, 0.5])
def test_a_resized_part_of_a_panorama_is_placed(factor: float, tmp_path: Path) -> None:
    image = numbered(4, 6, "uint8") + np.uint8(1)
    before = {
        "FullPanoWidthPixels": 16,
        "FullPanoHeightPixels": 8,
        "CroppedAreaLeftPixels": 4,
        "CroppedAreaTopPixels": 2,
        "CroppedAreaImageWidthPixels": 6,
        "CroppedAreaImageHeightPixels": 4,
    }
    sizes = {name: int(length * factor) for name, length in before.items()}
    put_panorama(tmp_path / "a.png", image, **sizes)
    head = io.header(tmp_path / "a.png")
    assert (head.height, head.width) == (8, 16) and head.window == (2, 4, 6, 10)


def test_a_cylinder_goes_all_around_and_is_as_high_as_it_is(tmp_path: Path) -> None:
    put_panorama(tmp_path / "a.png", numbered(50, 128, "uint8"), ProjectionType="cylindrical")
    assert io.header(tmp_path / "a.png").projection == "cylindrical(aspect=64/25)"
    whole = {"FullPanoWidthPixels": 16, "FullPanoHeightPixels": 4, "CroppedAreaLeftPixels": 4}
    image = numbered(4, 6, "uint8")
    put_panorama(tmp_path / "b.png", image, ProjectionType="cylindrical", **whole)
    head = io.header(tmp_path / "b.png")
    assert (head.projection, head.window) == ("cylindrical(aspect=4)", (0, 4, 4, 10))
    # A cylinder of radius 1 whose circumference is the width: square pixels, unrolled.
    v, u = (np.mgrid[:50, :128] + 0.5) / 128
    longitude, y = 2 * np.pi * (u - 0.5), 2 * np.pi * (25 / 128 - v)
    d = np.stack([np.sin(longitude), y, -np.cos(longitude)], -1)
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    # Some roundings of float64.
    np.testing.assert_allclose(sm.directions("cylindrical(aspect=64/25)", (50, 128)), d, atol=1e-14)


def test_a_tilted_camera_is_told(tmp_path: Path) -> None:
    put_panorama(tmp_path / "a.png", numbered(8, 16, "uint8"))
    assert io.header(tmp_path / "a.png").tilt == (0, 0)
    pose = {"PoseHeadingDegrees": 90, "PosePitchDegrees": "10.5", "PoseRollDegrees": -5}
    put_panorama(tmp_path / "a.png", numbered(8, 16, "uint8"), **pose)
    assert io.header(tmp_path / "a.png").tilt == (10.5, -5)
    put_panorama(tmp_path / "a.png", numbered(8, 16, "uint8"), PosePitchDegrees="nan")
    assert io.header(tmp_path / "a.png").tilt == (0, 0)


def test_a_tiled_cube_has_all_its_faces(tmp_path: Path) -> None:
    image = np.repeat(np.arange(6, dtype=np.float32), 64)[:, None, None] + np.zeros((64, 3))
    tiles = {"tile_width": 64, "tile_height": 64, "full_width": 64, "full_height": 64}
    words = {"textureformat": "CubeFace Environment"}
    put(tmp_path / "a.exr", image.astype(np.float32), **tiles, **words)
    assert io.header(tmp_path / "a.exr").window == (0, 0, 384, 64)
    assert np.array_equal(io.read(tmp_path / "a.exr"), image)


def test_openexr_own_cube_is_read_whole(data_folder: Path) -> None:
    path = data_folder / "OrientationCube.exr"
    head = io.header(path)
    assert io.read(path).shape[:2] == (head.height, head.width) == (3072, 512)


@pytest.mark.parametrize(("suffix", "name"), [("tx", "openimageio"), ("exr", "openexr")])
def test_maketx_says_where_texels_lie(suffix: str, name: str, tmp_path: Path) -> None:
    path = str(tmp_path / f"a.{suffix}")
    image = oiio.ImageBuf(numbered(8, 16))
    assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxEnvLatl, image, path)
    assert io.header(path).projection == f"latlong:{name}"


@pytest.mark.parametrize(
    ("numbers", "name"),
    [
        ((0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329), "lin_rec709_scene"),
        ((0.7347, 0.2653, 0, 1, 0.0001, -0.077, 0.32168, 0.33767), "lin_ap0_scene"),
        ((0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767), "lin_ap1_scene"),
        ((0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329), "lin_rec2020_scene"),
        ((0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329), "lin_p3d65_scene"),
    ],
)
def test_chromaticities_are_a_color_space(
    numbers: tuple[float, ...], name: str, tmp_path: Path
) -> None:
    io.write(tmp_path / "a.exr", numbered(8, 16), metadata={"chromaticities": numbers})
    assert io.header(tmp_path / "a.exr").color_space == name
    io.write(
        tmp_path / "a.exr",
        numbered(8, 16),
        metadata={"chromaticities": numbers},
        color_space="lin_rec709_scene",
    )
    assert io.header(tmp_path / "a.exr").color_space == "lin_rec709_scene"
    # White is white, to the digits that white points are given to.
    assert io.to_linear(np.ones((1, 1, 3)), color_space=name) == pytest.approx(1, abs=1e-3)


def test_a_jpeg_that_ends_early_is_no_image(tmp_path: Path) -> None:
    path = tmp_path / "a.jpg"
    noise = np.random.default_rng(5).integers(0, 255, (64, 128, 3), np.uint8)
    io.write(path, noise)
    io.read(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(OSError, match=r"cannot read .*a\.jpg': JPEG error: Premature end"):
        io.read(path)
    with pytest.raises(OSError, match="Premature end"):
        io.convert_file(path, tmp_path / "b.png", "latlong", "latlong", memory=1 << 28)
    assert not (tmp_path / "b.png").exists()


def test_formats_of_textures_are_named_where_they_are_written(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"use one of .*\.jpeg, \.ktx2, \.dds$"):
        io.check_target(tmp_path / "a.xyz")
    with pytest.raises(OSError, match=r"use one of .*\.jpeg$"):
        io.write(tmp_path / "a.xyz", numbered(8, 16))


@pytest.mark.parametrize("name", ["cube.ktx2", "cube.dds"])
def test_our_own_textures_are_not_read(name: str) -> None:
    path = Path(__file__).parents[1] / "data" / name
    for call in (io.read, io.header):
        with pytest.raises(OSError, match=r"cube.*: textures are written and not read \("):
            call(path)


def test_headers_are_hashable(tmp_path: Path) -> None:
    io.write(tmp_path / "a.png", numbered(4, 8, "uint8"))
    header = io.header(tmp_path / "a.png")
    assert len({header, io.header(tmp_path / "a.png")}) == 1
