from collections.abc import Callable, Sequence
from typing import Any, Literal, Self, TypeAlias, TypeVar, final, overload

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray
from typing_extensions import disjoint_base

__all__ = [
    "Distribution",
    "Halving",
    "Packer",
    "Projection",
    "__version__",
    "_rebuild",
    "add_layer",
    "add_sheets",
    "add_sun",
    "all_finite",
    "check_word",
    "code",
    "code_languages",
    "code_verbs",
    "compare",
    "convention_table",
    "convert",
    "convert_depth",
    "convert_levels",
    "dfg",
    "directions_to_lonlat",
    "divide_layer",
    "encode_gradient",
    "energy",
    "energy_from",
    "filters",
    "get_num_threads",
    "healpix_ang2pix",
    "healpix_arrange",
    "healpix_interpolation",
    "healpix_neighbors",
    "healpix_pix2ang",
    "healpix_pix2vec",
    "healpix_reorder",
    "healpix_runs",
    "healpix_vec2pix",
    "helpers",
    "integrals",
    "level_shapes",
    "lights",
    "lit_of",
    "lobe",
    "lobe_from",
    "lobe_of",
    "lonlat_to_directions",
    "luminances",
    "matching_size",
    "mipmaps",
    "moments",
    "moments_of",
    "pack_frames",
    "packing_table",
    "pad",
    "planes_of_texels",
    "prefilter",
    "reflect",
    "registry",
    "remove_sun",
    "rotation",
    "sample_adjoint",
    "sample_slopes",
    "sample_uv",
    "set_num_threads",
    "set_simd_level",
    "sh_code",
    "sh_convention_table",
    "sh_convert",
    "sh_evaluate",
    "sh_from",
    "sh_lobe",
    "sh_of",
    "sh_project",
    "sh_project_adjoint",
    "sh_rotate",
    "sh_scale_degrees",
    "sh_storage",
    "sh_window",
    "sheets",
    "simd_level",
    "simd_levels",
    "sums_of_planes",
    "sun",
    "sun_from",
    "survey_of",
    "tell_progress",
    "texel_weights",
    "texels_held",
    "texels_of_planes",
    "tiles_of_window",
    "unpack_frames",
    "weigh",
    "weighted_mean",
    "weights",
    "worlds",
]

__version__: str

_Float = TypeVar("_Float", bound=np.floating[Any])

@disjoint_base
class Projection:
    @overload
    def __new__(cls, name: str, /, **parameters: float) -> Self: ...
    @overload
    def __new__(
        cls,
        name: str,
        /,
        *,
        convention: str | None = None,
        axes: str | None = None,
        grid: str | None = None,
        layout: str | None = None,
        world: str | None = None,
        pose: Any | None = None,
        **parameters: float,
    ) -> Self: ...
    @property
    def name(self) -> str: ...
    @property
    def convention(self) -> str | None: ...
    @property
    def axes(self) -> str: ...
    @property
    def world(self) -> str: ...
    @property
    def grid(self) -> str: ...
    @property
    def layout(self) -> str | None: ...
    @property
    def faces(self) -> int: ...
    @property
    def parameters(self) -> dict[str, float]: ...
    @property
    def coverage(self) -> str: ...
    @property
    def seam(self) -> str: ...
    @property
    def covered_solid_angle(self) -> float: ...
    @property
    def used_part(self) -> float: ...
    @property
    def equal_area(self) -> bool: ...
    @property
    def conformal(self) -> bool: ...
    @property
    def density_range(self) -> tuple[float, float]: ...
    @property
    def title(self) -> str: ...
    @property
    def source(self) -> str: ...
    @property
    def summary(self) -> str: ...
    @property
    def singular(self) -> str: ...
    @property
    def mirrored(self) -> bool: ...
    def encode(
        self, directions: ArrayLike, out: NDArray[Any] | None = None, /
    ) -> NDArray[np.floating[Any]]: ...
    def decode(
        self, uv: ArrayLike, out: NDArray[Any] | None = None, /
    ) -> NDArray[np.floating[Any]]: ...
    def jacobian(
        self, uv: ArrayLike, out: NDArray[Any] | None = None, /
    ) -> NDArray[np.floating[Any]]: ...
    def density(
        self, uv: ArrayLike, out: NDArray[Any] | None = None, /
    ) -> NDArray[np.floating[Any]]: ...
    def valid(self, uv: ArrayLike, /) -> NDArray[np.bool_]: ...
    def covers(self, directions: ArrayLike, /) -> NDArray[np.bool_]: ...
    def solid_angle(self, size: int | tuple[int, ...], /) -> NDArray[np.float64]: ...
    def directions(
        self,
        size: int | tuple[int, ...],
        /,
        *,
        dtype: DTypeLike,
    ) -> NDArray[np.floating[Any]]: ...
    def shape(self, size: int | tuple[int, ...], /) -> tuple[int, ...]: ...
    def sample(
        self,
        image: ArrayLike,
        directions: ArrayLike,
        /,
        *,
        filter: str | None,
        fill: float | Sequence[float],
        out: NDArray[Any] | None = None,
        alpha: int | None = None,
        skipna: bool = False,
        lod: ArrayLike | None = None,
        derivatives: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> NDArray[Any]: ...
    def turned(self, pose: Any, /) -> Self: ...
    def in_world_of(self, other: Any, /) -> Self: ...
    def _turned(self, rotation: Any, name: str, /) -> Self: ...
    @property
    def pose(self) -> NDArray[np.float64] | None: ...
    def explain(self) -> None: ...
    def explanation(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Distribution:
    def __new__(
        cls,
        projection: Projection,
        luminance: NDArray[np.float64],
        radiance: NDArray[np.floating[Any]],
        /,
    ) -> Distribution: ...
    @property
    def integral(self) -> float: ...
    def pdf(
        self,
        directions: ArrayLike,
        /,
        *,
        out: NDArray[Any] | None = None,
    ) -> NDArray[np.floating[Any]]: ...
    def sample(
        self,
        xi: NDArray[np.floating[Any]],
        /,
        *,
        weights: bool = False,
        out: tuple[Any, Any, Any] | None = None,
    ) -> tuple[NDArray[np.floating[Any]], ...]: ...

def texel_weights(
    projection: Projection, shape: int | tuple[int, ...], /
) -> NDArray[np.float64]: ...
def texels_held(projection: Projection, shape: int | tuple[int, ...], /) -> NDArray[np.uint8]: ...

@final
class Halving:
    def __new__(cls, projection: Projection, shape: tuple[int, ...], /) -> Halving: ...
    def needs(self, window: tuple[int, int, int, int], /) -> list[int]: ...
    def window(
        self,
        texels: ArrayLike,
        part: Sequence[int],
        window: tuple[int, int, int, int],
        /,
    ) -> NDArray[Any]: ...

@final
class Packer:
    def __new__(cls, name: str, /) -> Packer: ...
    def about(self) -> dict[str, Any]: ...
    def pack(
        self,
        directions: ArrayLike,
        /,
        rounding: str,
        invalid: str,
        out: NDArray[Any] | None = None,
    ) -> NDArray[Any]: ...
    def unpack(
        self, codes: NDArray[Any], /, single: bool, out: NDArray[Any] | None = None
    ) -> NDArray[np.floating[Any]]: ...
    def code(
        self,
        language: str,
        /,
        *,
        verbs: Sequence[str],
        rounding: str,
        name: str | None,
        native: bool,
        double: bool,
    ) -> str: ...
    def canonical(self, codes: NDArray[Any], /) -> NDArray[Any]: ...

def packing_table() -> list[tuple[str, str, int, str, int | None]]: ...
def pack_frames(
    normals: NDArray[np.float64], tangents: NDArray[np.float64], name: str, /
) -> tuple[NDArray[np.uint64], int | None]: ...
def unpack_frames(codes: NDArray[np.uint64], name: str, /) -> NDArray[np.float64]: ...
def _rebuild(class_: type[Any], name: str, options: dict[str, Any], /) -> Any: ...
def convert(
    image: ArrayLike,
    src: Projection,
    dst: Projection,
    shape: tuple[int, ...],
    /,
    *,
    rotation: Any | None = None,
    filter: str = "bilinear",
    fill: ArrayLike | None = None,
    out: NDArray[Any] | None = None,
    skipna: bool = False,
    antialias: bool = True,
    alpha: int | None = None,
    world: str = "match",
    window: tuple[int, int, int, int] | None = None,
) -> NDArray[Any]: ...
def level_shapes(projection: Projection, shape: tuple[int, ...], /) -> list[list[int]]: ...
def convert_levels(
    image: ArrayLike,
    levels: Sequence[NDArray[Any]],
    src: Projection,
    dst: Projection,
    shape: tuple[int, ...],
    tile: tuple[int, int],
    /,
    *,
    filter: str,
    fill: float | Sequence[float],
    world: str,
    window: tuple[int, int, int, int],
) -> tuple[NDArray[Any], list[list[int]]]: ...
def tiles_of_window(
    src: Projection,
    source_shape: tuple[int, ...],
    levels: int,
    dst: Projection,
    shape: tuple[int, ...],
    tile: tuple[int, int],
    every: int,
    /,
    *,
    filter: str,
    world: str,
    window: tuple[int, int, int, int],
) -> list[list[int]]: ...
def matching_size(shape: int | tuple[int, ...], src: Projection, dst: Projection, /) -> int: ...
def filters() -> list[dict[str, Any]]: ...
def pad(image: ArrayLike, projection: Projection, n: int, filter: str, /) -> NDArray[Any]: ...
def code(
    projection: Projection,
    language: str,
    /,
    *,
    verbs: list[str],
    name: str | None,
    native: bool,
    double: bool,
) -> str: ...
def code_languages() -> list[dict[str, Any]]: ...
def code_verbs() -> list[str]: ...
def compare(
    a: Projection, b: Projection, /
) -> tuple[list[list[int]] | None, bool | None, list[str]]: ...
def worlds(src: Projection, dst: Projection, /) -> str | None: ...
def convert_depth(
    array: NDArray[np.floating[Any]],
    projection: Projection,
    shape: tuple[int, ...],
    target: str,
    /,
) -> None: ...
def lights(
    object: ArrayLike,
    projection: Projection,
    luminance: NDArray[np.float64],
    n: int,
    method: str,
    /,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...

_Sun: TypeAlias = tuple[list[float], float, NDArray[np.float64], NDArray[np.float64], float]

def sun(
    object: ArrayLike,
    projection: Projection,
    luminance: NDArray[np.float64],
    /,
) -> _Sun | None: ...
def remove_sun(
    object: ArrayLike,
    projection: Projection,
    luminance: NDArray[np.float64],
    /,
) -> tuple[NDArray[np.floating[Any]], _Sun | None]: ...
def add_sun(
    object: ArrayLike,
    projection: Projection,
    direction: tuple[float, ...],
    solid_angle: float,
    irradiance: list[float],
    /,
) -> NDArray[np.floating[Any]]: ...
def energy(
    object: ArrayLike,
    projection: Projection,
    luminance: NDArray[np.float64],
    /,
) -> tuple[float, NDArray[np.float64], float, float, list[float], float, int, _Sun | None]: ...
def directions_to_lonlat(
    directions: ArrayLike, world: str, half_turn: float, /
) -> NDArray[np.floating[Any]]: ...
def lonlat_to_directions(
    lonlat: ArrayLike, world: str, half_turn: float, /
) -> NDArray[np.floating[Any]]: ...
def mipmaps(image: ArrayLike, projection: Projection, /) -> list[NDArray[Any]]: ...
def sample_uv(
    image: ArrayLike,
    uv: ArrayLike,
    /,
    *,
    filter: str | None,
    address: tuple[str, str],
    fill: float | Sequence[float],
    lod: ArrayLike | None,
    derivatives: tuple[ArrayLike, ArrayLike] | None,
    out: NDArray[Any] | None,
) -> NDArray[Any]: ...
def reflect(
    view: ArrayLike, normal: ArrayLike, /, *, out: NDArray[Any] | None = None
) -> NDArray[np.floating[Any]]: ...
def rotation(yaw: float, pitch: float, roll: float) -> NDArray[np.float64]: ...
def registry() -> list[dict[str, Any]]: ...
def convention_table() -> list[dict[str, Any]]: ...
def set_num_threads(n: int, /) -> None: ...
def helpers() -> list[str]: ...
def check_word(what: str, word: str, known: list[str], /) -> None: ...
def get_num_threads() -> int: ...
def simd_level() -> str: ...
def tell_progress(tell: Callable[[float], object] | None, /) -> None: ...
def simd_levels() -> list[str]: ...
def set_simd_level(name: str | None, /) -> None: ...
def all_finite(object: ArrayLike, /) -> bool: ...
def luminances(object: ArrayLike, weights: NDArray[np.float64], /) -> NDArray[np.float64]: ...
def integrals(object: ArrayLike, projection: Projection, /) -> NDArray[np.float64]: ...
def moments(object: ArrayLike, projection: Projection, /) -> NDArray[np.float64]: ...
def lobe(
    object: ArrayLike,
    projection: Projection,
    normals: NDArray[np.float64],
    name: str,
    parameter: float,
    /,
) -> NDArray[np.float64]: ...
def survey_of(
    object: ArrayLike,
    projection: Projection,
    number: int,
    luminance: NDArray[np.float64],
    /,
) -> NDArray[np.float64]: ...
def energy_from(
    parts: NDArray[np.float64], projection: Projection, shape: Sequence[int], /
) -> tuple[float, NDArray[np.float64], float, float, list[float], float, int, float | None]: ...
def lit_of(
    object: ArrayLike,
    projection: Projection,
    number: int,
    luminance: NDArray[np.float64],
    direction: Sequence[float],
    angle: float | None,
    block: int,
    /,
) -> NDArray[np.float64]: ...
def sun_from(texels: NDArray[np.float64], /) -> _Sun | None: ...
def weights(
    object: ArrayLike, channels: int, alpha: int | None, skipna: bool, /
) -> tuple[int, bool] | None: ...
def weigh(
    object: ArrayLike, channels: int, alpha: int | None, width: int, holes: bool, /
) -> NDArray[Any]: ...
def weighted_mean(
    like: ArrayLike,
    channels: int,
    alpha: int | None,
    width: int,
    holes: bool,
    seen: NDArray[Any],
    near: NDArray[Any] | None,
    fill: float | Sequence[float],
    /,
) -> NDArray[Any]: ...
def texels_of_planes(planes: NDArray[Any], /) -> NDArray[Any]: ...
def planes_of_texels(texels: NDArray[Any], planes: NDArray[Any], /) -> None: ...
def add_layer(total: NDArray[Any], layer: NDArray[Any], nearest: bool, /) -> None: ...
def divide_layer(total: NDArray[Any], like: NDArray[Any], /) -> NDArray[Any]: ...
def sheets(projection: Projection, shape: Sequence[int], /) -> list[list[int]]: ...
def moments_of(
    object: ArrayLike, projection: Projection, number: int, with_directions: bool, /
) -> NDArray[np.float64]: ...
def add_sheets(parts: NDArray[np.float64], /) -> NDArray[np.float64]: ...
def lobe_of(
    object: ArrayLike,
    projection: Projection,
    number: int,
    normals: NDArray[np.float64],
    name: str,
    parameter: float,
    /,
) -> NDArray[np.float64]: ...
def lobe_from(
    sums: NDArray[np.float64], projection: Projection, name: str, parameter: float, /
) -> NDArray[np.float64]: ...
def sh_of(
    object: ArrayLike, projection: Projection, number: int, order: int, points: bool, /
) -> NDArray[np.float64]: ...
def sh_from(
    parts: NDArray[np.float64],
    projection: Projection,
    shape: Sequence[int],
    channels: int,
    order: int,
    points: bool,
    /,
) -> NDArray[np.float64]: ...
def sh_project(
    object: ArrayLike, projection: Projection, order: int, points: bool, /
) -> NDArray[np.float64]: ...
def sample_adjoint(
    projection: Projection,
    shape: Sequence[int],
    filter: str,
    directions: NDArray[_Float],
    gradient: NDArray[_Float],
    /,
) -> NDArray[_Float]: ...
def sample_slopes(
    projection: Projection,
    image: NDArray[_Float],
    directions: NDArray[_Float],
    gradient: NDArray[_Float],
    /,
) -> NDArray[_Float]: ...
def encode_gradient(
    projection: Projection, directions: NDArray[_Float], gradient: NDArray[_Float], /
) -> NDArray[_Float]: ...
def sums_of_planes(
    ends: NDArray[np.int32],
    columns: NDArray[np.int32],
    weights: NDArray[_Float],
    source: NDArray[_Float],
    faces: int,
    /,
) -> NDArray[_Float]: ...
def sh_project_adjoint(
    array: NDArray[np.float64], projection: Projection, shape: Sequence[int], points: bool, /
) -> NDArray[np.float64]: ...
def sh_code(array: NDArray[np.float64], language: str, name: str, double: bool, /) -> str: ...
def sh_evaluate(
    array: NDArray[np.float64], points: NDArray[np.float64], /
) -> NDArray[np.float64]: ...
def sh_rotate(
    array: NDArray[np.float64], matrix: NDArray[np.float64], /
) -> NDArray[np.float64]: ...
def sh_scale_degrees(
    array: NDArray[np.float64], factors: NDArray[np.float64], /
) -> NDArray[np.float64]: ...
def sh_lobe(name: str, parameter: float, order: int, /) -> NDArray[np.float64]: ...
def sh_window(name: str, width: float | None, order: int, /) -> NDArray[np.float64]: ...
def sh_convention_table() -> list[tuple[str, str, str]]: ...
def sh_storage(name: str, /) -> Literal["rows", "squares", "complex"]: ...
def sh_convert(array: NDArray[np.float64], src: str, dst: str, /) -> NDArray[np.float64]: ...
def prefilter(
    object: ArrayLike,
    projection: Projection,
    target: Projection,
    shapes: list[tuple[int, ...]],
    alphas: list[float],
    name: str,
    samples: int,
    /,
) -> list[NDArray[np.float32]]: ...
def dfg(name: str, size: int, /) -> NDArray[np.float64]: ...
def healpix_vec2pix(
    nside: int,
    directions: ArrayLike,
    /,
    *,
    nest: bool = False,
    out: NDArray[np.int64] | None = None,
) -> NDArray[np.int64]: ...
def healpix_pix2vec(
    nside: int,
    pixels: ArrayLike,
    /,
    *,
    nest: bool = False,
    out: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]: ...
def healpix_ang2pix(
    nside: int,
    angles: NDArray[np.float64],
    /,
    *,
    nest: bool = False,
    lonlat: bool = False,
    out: NDArray[np.int64] | None = None,
) -> NDArray[np.int64]: ...
def healpix_pix2ang(
    nside: int,
    pixels: ArrayLike,
    /,
    *,
    nest: bool = False,
    lonlat: bool = False,
) -> NDArray[np.float64]: ...
def healpix_neighbors(
    nside: int, pixels: ArrayLike, /, *, nest: bool = False
) -> NDArray[np.int64]: ...
def healpix_interpolation(
    nside: int,
    angles: NDArray[np.float64],
    /,
    *,
    nest: bool = False,
    lonlat: bool = False,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]: ...
def healpix_runs(starts: NDArray[np.int64], lengths: NDArray[np.int64], /) -> NDArray[np.int64]: ...
def healpix_arrange(
    nside: int,
    bytes: int,
    source: NDArray[np.uint8],
    was: str,
    target: NDArray[np.uint8],
    becomes: str,
    unseen: int,
    /,
) -> None: ...
def healpix_reorder(
    nside: int,
    pixels: ArrayLike,
    /,
    *,
    nest: bool,
    out: NDArray[np.int64] | None = None,
) -> NDArray[np.int64]: ...
