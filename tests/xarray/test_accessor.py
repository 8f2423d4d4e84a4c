"""Images with names: what they say, what becomes of it, and what files keep."""

import subprocess
import sys

import dask.array as da
import numpy as np
import pytest
import spheremap as sm
import spheremap.xarray
import xarray as xr

rng = np.random.default_rng(8)
texels = rng.random((16, 32, 3)).astype(np.float32)


def sky(data=texels):
    coords = {"band": ["red", "green", "blue"], "band_width": ("band", [1, 2, 3]), "day": 7}
    return xr.DataArray(
        data, dims=("y", "x", "band"), coords=coords, name="sky", attrs={"units": "W"}
    ).sphere.assign("latlong:blender")


def test_a_conversion_is_that_of_the_array():
    options = {"size": 8, "rotation": sm.rotation(20), "filter": "lanczos3"}
    cube = sky().sphere.convert("cube:unity", **options)
    np.testing.assert_array_equal(
        cube.values, sm.convert(texels, "latlong:blender", "cube:unity", **options)
    )
    assert cube.dims == ("face", "v", "u", "band")
    assert cube.name == "sky" and cube.attrs["units"] == "W"
    assert cube.attrs["projection"] == "cube" and cube.attrs["convention"] == "unity"
    assert cube.band.values.tolist() == ["red", "green", "blue"] and cube.day == 7
    assert cube.band_width.values.tolist() == [1, 2, 3]


def test_coordinates_are_those_of_texels():
    image = sky().sphere.convert("octahedral", size=9)
    d = sm.directions("octahedral", 9)
    u, v = np.meshgrid(image.u, image.v)
    # Two roundings of a coordinate.
    np.testing.assert_allclose(sm.decode(np.stack([u, v], -1), "octahedral"), d, atol=1e-15)


def test_own_coordinates_stay():
    image = xr.DataArray(texels[..., 0], dims=("lat", "lon"), coords={"lat": np.arange(16)})
    said = image.sphere.assign("latlong")
    assert said.lat.values.tolist() == list(range(16))
    assert said.lon.values.tolist() == ((np.arange(32) + 0.5) / 32).tolist()
    assert "projection" not in image.attrs


POSED = sm.projection("perspective", fov=70.5, aspect=2).turned(sm.rotation(10, 20, 30))


@pytest.mark.parametrize(
    "p",
    ["cube:filament", "latlong:openexr", "healpix", POSED, sm.projection("cube", axes="+z -x +y")],
)
def test_attributes_say_the_projection(p):
    p = sm.projection(p) if isinstance(p, str) else p
    image = xr.DataArray(np.zeros(p.shape(16)), attrs={"pose": [1.0], "layout": "cross"})
    assert image.sphere.assign(p).sphere.projection == p


def test_arrays_in_chunks_stay_in_chunks():
    lazy = sky(da.from_array(texels, chunks=5)).sphere.convert("cube", size=8, chunks=3)
    assert lazy.chunks[1] == (3, 3, 2)
    np.testing.assert_array_equal(
        lazy.compute(scheduler="synchronous"), sky().sphere.convert("cube", size=8)
    )


SUMS = {
    "integrate": lambda image, p: sm.light.integrate(image, p),
    "mean": lambda image, p: sm.light.mean(image, p),
    "irradiance": lambda image, p: sm.light.irradiance(image, p, "cube", size=4),
    "sh": lambda image, p: sm.sh.project(image, p, order=2),
}
TAKES = {"irradiance": (["cube"], {"size": 4}), "sh": ([], {"order": 2})}


@pytest.mark.parametrize("chunks", [None, 5])
@pytest.mark.parametrize("verb", SUMS)
def test_sums_are_those_of_the_array(verb, chunks):
    words, options = TAKES.get(verb, ([], {}))
    image = sky() if chunks is None else sky(da.from_array(texels, chunks=chunks))
    found = getattr(image.sphere, verb)(*words, **options)
    assert (found.chunks is None) == (chunks is None)
    np.testing.assert_array_equal(found.values, SUMS[verb](texels, "latlong:blender"))
    assert found.dims[-1] == "band" and found.name == "sky"
    assert found.band.values.tolist() == ["red", "green", "blue"] and found.day == 7
    assert ("units" in found.attrs) == (verb == "mean")
    assert ("projection" in found.attrs) == (verb == "irradiance")
    gray = image.isel(band=0)
    found = getattr(gray.sphere, verb)(*words, **options)
    np.testing.assert_array_equal(found.values, SUMS[verb](texels[..., 0], "latlong:blender"))


def test_coefficients_have_degrees():
    found = sky().sphere.sh(order=2)
    assert found.dims == ("coefficient", "band")
    degrees = list(zip(found.l.values.tolist(), found.m.values.tolist(), strict=True))
    assert degrees == [(n, m) for n in range(3) for m in range(-n, n + 1)]


def test_options_of_sums_are_handed_on():
    broken = texels.copy()
    broken[3, 5] = np.nan
    with pytest.raises(ValueError, match="skipna"):
        sky(broken).sphere.integrate()
    np.testing.assert_array_equal(
        sky(broken).sphere.mean(skipna=True), sm.light.mean(broken, "latlong:blender", skipna=True)
    )
    turned = {"rotation": sm.rotation(20)}
    np.testing.assert_array_equal(
        sky().sphere.irradiance("octahedral", size=8, method="sh", order=2, **turned),
        sm.light.irradiance(
            texels, "latlong:blender", "octahedral", size=8, method="sh", order=2, **turned
        ),
    )
    np.testing.assert_array_equal(
        sky().sphere.sh(order=1, texels="points", **turned),
        sm.sh.project(texels, "latlong:blender", order=1, texels="points", **turned),
    )


@pytest.mark.parametrize("chunks", [None, 5])
def test_energy_is_that_of_the_array(chunks):
    image = sky() if chunks is None else sky(da.from_array(texels, chunks=chunks))
    found = image.sphere.energy(luminance=[0, 1, 0])
    expected = sm.light.energy(texels, "latlong:blender", luminance=[0, 1, 0])
    np.testing.assert_equal(vars(found), vars(expected))


@pytest.mark.parametrize("chunks", [None, 3])
def test_lookups_are_those_of_the_array(chunks):
    d = rng.normal(size=(2, 7, 3))
    expected = sm.sample(texels, d, "latlong:blender", filter="lanczos3")
    stars = xr.DataArray(
        d if chunks is None else da.from_array(d, chunks=chunks),
        dims=("night", "star", "xyz"),
        coords={"star": list("abcdefg"), "xyz": list("xyz")},
    )
    found = sky().sphere.sample(stars, filter="lanczos3")
    assert found.dims == ("night", "star", "band") and "xyz" not in found.coords
    assert found.star.values.tolist() == list("abcdefg") and found.day == 7
    assert (found.chunks is None) == (chunks is None)
    np.testing.assert_array_equal(found, expected)
    lazy = sky(da.from_array(texels, chunks=5)).sphere.sample(d, filter="lanczos3")
    np.testing.assert_array_equal(lazy, expected)
    with pytest.raises(ValueError, match=r"\(\.\.\., 3\)"):
        sky().sphere.sample(stars[..., :2])


# zarr warns of names that no other program reads, and of its own plans.
@pytest.mark.filterwarnings("ignore::Warning")
@pytest.mark.parametrize("p", ["cube:unreal", POSED], ids=str)
def test_zarr_keeps_it(tmp_path, p):
    pytest.importorskip("zarr")
    sky().sphere.convert(p, size=(12, 24) if p is POSED else 8).to_zarr(tmp_path / "sky.zarr")
    read = xr.open_zarr(tmp_path / "sky.zarr", chunks={})["sky"]
    assert read.chunks is not None
    assert read.sphere.projection == (p if p is POSED else sm.projection(p))
    back = read.sphere.convert("latlong", size=8, chunks=5)
    back.to_zarr(tmp_path / "back.zarr")
    found = xr.open_zarr(tmp_path / "back.zarr", chunks=None)["sky"]
    expected = sky().sphere.convert(p, size=(12, 24) if p is POSED else 8)
    np.testing.assert_array_equal(found, expected.sphere.convert("latlong", size=8))
    xr.testing.assert_identical(found.u, expected.sphere.convert("latlong", size=8).u)


def test_errors_say_what_to_do():
    bare = xr.DataArray(texels)
    with pytest.raises(ValueError, match="assign"):
        bare.sphere.convert("cube")
    with pytest.raises(ValueError, match="twice as wide"):
        xr.DataArray(texels[:, :9]).sphere.assign("latlong")
    with pytest.raises(ValueError, match="isel"):
        xr.DataArray(texels[None, None]).sphere.assign("latlong")
    with pytest.raises(ValueError, match="octahedral"):
        bare.sphere.assign("octahedrel")


@pytest.mark.parametrize("chunks", [None, 8])
def test_conversions_that_names_do_not_fit(chunks):
    image = sky() if chunks is None else sky(da.from_array(texels, chunks=chunks))
    with pytest.raises(ValueError, match="Expected no `window`"):
        image.sphere.convert("latlong", size=8, window=(slice(0, 4), slice(0, 4)))
    with pytest.raises(ValueError, match="Expected no `channels_first`"):
        image.sphere.convert("cube", size=4, channels_first=True)
    plain = image.sphere.convert("cube", size=4, window=None, channels_first=False)
    xr.testing.assert_identical(plain, image.sphere.convert("cube", size=4))
    first = plain.transpose("face", "band", "v", "u")
    with pytest.raises(ValueError, match=r"\.transpose\('face', 'v', 'u', \.\.\.\)"):
        first.sphere.convert("latlong", size=8, channels_first=True)


def test_axes_have_names_of_their_own():
    for name in ("v", "u"):
        with pytest.raises(ValueError, match=f"another name than '{name}'"):
            sky().rename(band=name).sphere.convert("cube", size=4)
    with pytest.raises(ValueError, match="another name than 'face'"):
        sky().rename(band="face").sphere.convert("cube", size=4)
    with pytest.raises(ValueError, match="another name than 'l'"):
        sky().rename(band="l").sphere.sh(order=1)
    with pytest.raises(ValueError, match="another name than 'band'"):
        sky().sphere.sample(xr.DataArray(np.eye(3), dims=("band", "xyz")))
    assert sky().rename(band="face").sphere.convert("angular", size=4).dims == ("v", "u", "face")


ROTATED = {
    "convert": (["cube"], {"size": 4}),
    "sample": ([np.eye(3)], {}),
    "irradiance": (["cube"], {"size": 4}),
    "sh": ([], {"order": 1}),
    "energy": ([], {}),
}


@pytest.mark.parametrize("chunks", [None, 8])
@pytest.mark.parametrize("verb", ROTATED)
def test_one_rotation(verb, chunks):
    words, options = ROTATED[verb]
    image = sky() if chunks is None else sky(da.from_array(texels, chunks=chunks))
    several = np.stack([sm.rotation(10), sm.rotation(20)])
    with pytest.raises(ValueError, match=r"`rotation` to be one rotation.*\(2, 3, 3\)"):
        getattr(image.sphere, verb)(*words, rotation=several, **options)


def test_a_face_is_no_image():
    cube = sky().sphere.convert("cube", size=4)
    for face in (cube.isel(face=2), cube.isel(face=2, band=0)):
        with pytest.raises(ValueError, match="a face by itself"):
            face.sphere.mean()


TURNED = {
    "v": lambda image: image.isel(v=slice(None, None, -1)),
    "u": lambda image: image.roll(u=3, roll_coords=True),
    "face": lambda image: image.isel(face=[1, 0, 2, 3, 4, 5]),
}


@pytest.mark.parametrize("axis", TURNED)
def test_coordinates_that_contradict_the_image(axis):
    cube = sky().sphere.convert("cube", size=4)
    turned = TURNED[axis](cube)
    for verb, (words, options) in ROTATED.items():
        with pytest.raises(ValueError, match=f"Expected `{axis}` to be the coordinates"):
            getattr(turned.sphere, verb)(*words, **options)
    xr.testing.assert_identical(turned.sortby(axis).sphere.mean(), cube.sphere.mean())
    kept = cube.assign_coords(face=list("abcdef"), v=cube.v.astype(np.float32))
    np.testing.assert_array_equal(kept.sphere.mean(), cube.sphere.mean())
    np.testing.assert_array_equal(
        turned.drop_vars(axis).sphere.mean(), sm.light.mean(turned.values, cube.sphere.projection)
    )


def test_coarser_texels_have_their_coordinates():
    fine = sky().sphere.convert("latlong", size=8)
    coarse = fine.coarsen(v=2, u=2).mean(keep_attrs=True)
    np.testing.assert_array_equal(coarse.sphere.mean(), sm.light.mean(coarse.values, "latlong"))


def test_assigned_coordinates_are_those_of_the_grid():
    image = xr.DataArray(texels[..., 0], dims=("v", "u")).sphere.assign("latlong")
    assert image.v[0] == 0.5 / 16
    again = image.sphere.assign("latlong:mitsuba")
    assert again.v[0] == 0 and again.v[-1] == 1 and again.u[0] == 0.5 / 32
    np.testing.assert_array_equal(
        again.sphere.mean(), sm.light.mean(texels[..., 0], "latlong:mitsuba")
    )
    numbered = image.assign_coords(v=np.arange(16))
    xr.testing.assert_identical(numbered.sphere.assign("latlong"), image)
    with pytest.raises(ValueError, match="`v` to rise"):
        image.isel(v=slice(None, None, -1)).sphere.assign("latlong")
    with pytest.raises(ValueError, match=r"transpose\('v', 'u', \.\.\.\)"):
        image.transpose("u", "v").sphere.assign("latlong", any_aspect=True)


@pytest.mark.parametrize("dims", [("lat", "lon"), ("y", "x")])
def test_latitudes_fall(dims):
    falling = (dims[0], np.linspace(88, -88, 16).astype(np.int8))
    image = xr.DataArray(texels[..., 0], dims=dims, coords={"lat": falling})
    upside_down = image.isel({dims[0]: slice(None, None, -1)})
    way = rf"from north to south, got -88 to 88; \.isel\({dims[0]}="
    with pytest.raises(ValueError, match=way):
        upside_down.sphere.assign("latlong:blender")
    with pytest.raises(ValueError, match=way):
        image.sphere.assign("latlong").isel({dims[0]: slice(None, None, -1)}).sphere.mean()
    # A map whose first row is the lowest, by its axes.
    below = sm.projection("latlong", axes="+x +y -z", world="+x +y -z")
    assert sm.decode([0.5, 0.0], below)[1] == -1
    assert upside_down.sphere.assign(below).lat[0] == -88
    with pytest.raises(ValueError, match="from south to north"):
        image.sphere.assign(below)


def test_xarray_is_imported_by_its_own_module_alone():
    everything = (
        "import sys; sys.modules['xarray'] = None; import spheremap as sm\n"
        "for name in sm.__all__: getattr(sm, name)\n"
        "try: import spheremap.xarray\n"
        "except ImportError as error: print(error.name, error)"
    )
    command = [sys.executable, "-c", everything]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == (
        "xarray `spheremap.xarray` needs xarray: pip install spheremap[xarray]"
    )


def test_an_array_of_numpy_needs_no_dask():
    code = (
        "import sys; sys.modules['dask'] = None; import numpy as np, xarray as xr\n"
        "import spheremap.xarray\n"
        "a = xr.DataArray(np.ones((8, 16))).sphere.assign('latlong')\n"
        "print(float(a.sphere.convert('cube', size=4).min()))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "1.0"
