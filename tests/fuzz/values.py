"""Arguments as Python text, of three kinds: plausible, at the edge of a range, and hostile.

What a parameter is given depends on its name, else on its annotation, so that functions of tomorrow
are called sensibly too.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Any

import spheremap as sm
from spheremap import _core


def _each(text: str) -> tuple[str, ...]:
    return tuple(text.split())


# Made once: each call of the core makes all of it anew.
PARAMETERS = {entry["name"]: entry["parameters"] for entry in _core.registry()}
PROJECTIONS: list[str] = list(PARAMETERS)
CONVENTIONS: list[str] = [f"{row['kind']}:{row['name']}" for row in sm.conventions()]
FILTERS: list[str] = [entry["name"] for entry in _core.filters()]
FORMATS = ("pannellum", "marzipano", "photo-sphere-viewer", "deepzoom", "hips")
FLOATS = ("float32", "float64", "float16")
IMAGES = ("uint8", "uint16", *FLOATS)
OTHERS = ("bool", "int8", "int64", "uint64", ">f4", ">f8", "longdouble", "complex128", "object")

INTEGERS = _each(
    r"""
    0 1 2 3 4 7 8 16 -1 -2 True 2**15 2**16 2**24 2**29 2**31-1 2**31 2**32 2**40 2**53+1
    2**62 2**63 2**64 10**400 -2**63 -10**400 np.int64(3) np.uint8(255) 1.0 2.5
    """
)
REALS = _each(
    r"""
    0.0 -0.0 1.0 0.5 90.0 180.0 360.0 -1.0 1e-3 1e-9 5e-324 1e-40 1e9 1e300 1.8e308 nan inf
    -inf np.float32(2) 10**400 True 1j
    """
)
# What is no argument of anything.
OBJECTS = _each(
    r"""
    None '' 'x' '\0' '\ud800' 'é'*99 b'' object() {} () [] [[1],[1,2]] [None] ['a'] set() int
    ... np.ma.masked range(3) slice(1) np.array(None) np.nan memoryview(b'abc') type lambda:0
    np.timedelta64(3) np.datetime64('NaT') {'a':1} [[]] [[[[]]]] (1,2,3) iter([1])
    NotImplemented
    """
)
# Arrays that no image or list of vectors is.
ARRAYS = (
    "np.float64(1)",
    "np.array(3.0)",
    "np.empty((0,))",
    "np.empty((0, 3), 'f4')",
    "np.empty((3, 0))",
    "np.empty((0, 2**40, 3), 'f4')",
    "np.empty((2**40, 0, 3))",
    "np.empty((0, 3, 2**50), np.uint8)",
    "np.broadcast_to(np.float32(1), (2**40, 3))",
    "np.broadcast_to(np.float64(1), (2**20, 2**20))",
    "np.broadcast_to(np.uint8(1), (2**31, 2**30))",
    "np.broadcast_to(np.float32(1), (6, 2**20, 2**20, 3))",
    "np.broadcast_to(np.int64(1), 2**40)",
    "np.ones((1,) * 33 + (3,))",
    "np.ones((1,) * 64)",
    "np.zeros(4, [('a', 'f8'), ('b', 'f8')])",
    "np.zeros((4, 3), 'V8')",
    "np.zeros((4, 3), 'M8[s]')",
    "np.array([[1, 2, 'x']], object)",
    "np.array([[None] * 3])",
    "np.array(['a', 'b'])",
    "np.frombuffer(bytes(97), 'u1')[1:].view('f8').reshape(4, 3)",
    "np.lib.stride_tricks.as_strided(np.ones(100), (4, 3), (8, 8))",
    "np.matrix([[1.0, 2, 3]])",
    "np.full((4, 3), 2**64 - 1, 'u8')",
    "np.full((8, 16, 3), 1e308)",
    "np.full((8, 16, 3), 5e-324)",
    "np.random.default_rng(1).integers(0, 2**16, (8, 16, 3), 'u2').view('f2')",
    "np.random.default_rng(1).integers(0, 2**32, (8, 16, 3), 'u4').view('f4')",
    "np.random.default_rng(1).integers(0, 2**32, (300, 6), 'u4').view('f8')",
)
SHAPES = (
    "()",
    "(0,)",
    "(0, 0)",
    "(1, 1)",
    "(2, 3)",
    "(5, 7)",
    "(6, 2, 2)",
    "(12, 4, 4)",
    "(4, 8, 3)",
    "(-1, 4)",
    # Longer ones that fit into memory take minutes: owners of rims are looked for one by one.
    "(2**12, 2)",
    "(2, 2**12)",
    "(2**30, 2)",
    "(1, 2**40)",
    "(2**31, 2**31)",
    "(2**62, 4)",
    "(4.0, 8.0)",
    "('4', 8)",
    "np.array([4, 8])",
    "[4, 8]",
)
ROTATIONS = (
    "np.eye(3)",
    "sm.rotation(10, 20, 30)",
    "sm.rotation(90, 0, 0).astype('f4')",
    "-np.eye(3)",
    "np.zeros((3, 3))",
    "np.full((3, 3), nan)",
    "2 * np.eye(3)",
    "np.eye(4)",
    "np.eye(3, dtype=int)",
    "np.eye(3)[::-1]",
    "np.eye(3, dtype=complex)",
    "type('R', (), {'as_matrix': lambda self: np.eye(3)})()",
    "type('R', (), {'as_matrix': lambda self: 'x'})()",
    "type('R', (), {'as_matrix': 3})()",
)
SUN = (
    "sm.light.Sun(direction=np.{0}, solid_angle={1}, irradiance=np.{2}, surround=np.{2}, reach=0.1)"
)
PATHS = _each(
    r"""
    'a.exr' 'a.hdr' 'a.png' 'a.tif' 'a.jpg' 'a.dds' 'a.ktx2' 'b.EXR' 'junk.exr' 'junk.png'
    'junk.hdr' 'junk.tif' 'junk.jpg' 'a.mkv' 'a.mp4' 'sky.mkv' 'sky.mkv' 'junk.mp4' 'none.exr'
    'no/where.exr' '.' '..' '' 'a' '.exr' 'x'*5000+'.exr' '\0.exr' b'a.exr' 'folder.exr'
    '\ud800.png' 'a\nb.png'
    """
)


@dataclass
class Choice:
    """Makes the arguments of one call; what is chosen first decides what fits it."""

    random: Random
    # The projection whose images are plausible here.
    projection: str = "latlong"
    # Strings that some parameter of the library takes.
    words: Sequence[str] = ()
    made: dict[str, str] = field(default_factory=dict)

    def of(self, *options: str) -> str:
        return self.random.choice(options)

    def chance(self, p: float) -> bool:
        return self.random.random() < p

    def argument(self, name: str, annotation: str) -> str:
        """Return an argument: most are plausible, or no call would get far."""
        luck = self.random.random()
        if luck < 0.06:
            return self.hostile()
        maker = BY_NAME.get(name) or self._by_annotation(annotation)
        return maker(self)

    def hostile(self) -> str:
        """Return anything at all."""
        words = [repr(word) for word in self.words]
        pools = (OBJECTS, ARRAYS, INTEGERS, REALS, SHAPES, words or OBJECTS)
        return self.of(*self.random.choice(pools))

    def _by_annotation(self, annotation: str) -> Callable[[Choice], str]:
        literals = re.findall(r"'([^']*)'", annotation)
        if "Literal" in annotation and literals:
            return lambda choice: repr(choice.of(*literals, "", "nothing"))
        for pattern, maker in BY_ANNOTATION:
            if re.search(pattern, annotation):
                return maker
        return Choice.hostile


def projection(choice: Choice) -> str:
    """Return what is a projection, mostly the one that images here have."""
    if choice.chance(0.7):
        return repr(choice.projection)
    name = choice.of(*PROJECTIONS)
    return choice.of(
        repr(name),
        repr(choice.of(*CONVENTIONS)),
        f"sm.projection({name!r})",
        f"sm.projection({name!r}, axes={axes(choice)})",
        f"sm.projection({name!r}, layout={layout(choice)})",
        f"sm.projection({name!r}, grid='corners')",
        f"sm.projection({name!r}).turned({rotation(choice)})",
        f"sm.projection({name!r}, {parameter(choice, name)})",
        "'nothing'",
    )


def parameter(choice: Choice, name: str) -> str:
    """Return a parameter of a projection, at an end of its range or beyond."""
    known = PARAMETERS[name]
    if not known:
        return choice.of("fov=90", "x=1")
    row = choice.random.choice(known)
    low, high = row["minimum"], row["maximum"]
    value = choice.of(
        *map(repr, (low, high, (low + high) / 2, low * 1.0001 + 1e-9, high * 0.9999)), *REALS
    )
    return f"{row['name']}={value}"


def axes(choice: Choice) -> str:
    return repr(
        choice.of("+x -y -z", "-z -x +y", "+x +y +z", "+x +x +y", "x y z", "", "+x -y", "+x-y-z")
    )


def layout(choice: Choice) -> str:
    return repr(choice.of("faces", "strip", "column", "cross", "vertical_cross", "dice", "heap"))


def grid(choice: Choice) -> str:
    return repr(choice.of("centers", "corners", "corners-v", "edges"))


def rotation(choice: Choice) -> str:
    return choice.of(*ROTATIONS)


def size(choice: Choice) -> str:
    """Return a size: a small one, or one that nobody can want."""
    if choice.chance(0.6):
        return choice.of("1", "2", "3", "4", "8", "12", "(4, 8)", "(6, 2, 2)", "np.int32(4)")
    return choice.of(*SHAPES, *INTEGERS)


def integer(choice: Choice) -> str:
    return choice.of("1", "2", "3", "4") if choice.chance(0.5) else choice.of(*INTEGERS)


def real(choice: Choice) -> str:
    return choice.of("0.5", "1.0", "45.0") if choice.chance(0.4) else choice.of(*REALS)


def truth(choice: Choice) -> str:
    return choice.of("True", "False", "True", "False", "None", "'x'", "2", "np.ones(3)", "nan")


def word(choice: Choice) -> str:
    return repr(choice.of(*choice.words)) if choice.words else choice.hostile()


def array(choice: Choice, shape: Sequence[int], dtypes: Sequence[str] = FLOATS) -> str:
    """Return an array of a shape, in one of the ways in which arrays lie in memory."""
    dtype = choice.of(*(dtypes if choice.chance(0.85) else OTHERS))
    text = ", ".join(map(str, shape)) + ("," if len(shape) == 1 else "")
    seed = choice.random.randrange(9)
    values = choice.of(
        f"np.ones(({text}), {dtype!r})",
        f"np.zeros(({text}), {dtype!r})",
        f"np.random.default_rng({seed}).normal(size=({text})).astype({dtype!r})",
        f"np.random.default_rng({seed}).random(({text})).astype({dtype!r})",
        f"(255 * np.random.default_rng({seed}).random(({text}))).astype({dtype!r})",
        f"np.full(({text}), {choice.of('nan', 'inf', '-1', '1e30', '1e-30')}).astype('f4')",
        f"np.where(np.arange({_count(shape)}).reshape({text}) % 7, 1.0, nan).astype('f8')",
    )
    if choice.chance(0.6):
        return values
    return choice.of(
        f"{values}[::-1]",
        f"{values}[..., ::-1]",
        f"np.repeat({values}, 2, -1)[..., ::2]",
        f"np.asfortranarray({values})",
        f"np.ma.masked_array({values}, mask=True)",
        f"np.broadcast_to({values}, ({text}))",
        f"{values}.astype(object)",
        f"{values}.tolist()",
        f"{values}[:0]",
        f"{values}[None]",
        f"{values}.view(np.recarray)",
        f"{values}.T",
        f"memoryview({values})",
    )


def _count(shape: Sequence[int]) -> int:
    count = 1
    for n in shape:
        count *= n
    return count


def image(choice: Choice) -> str:
    """Return an image of the chosen projection, or what looks like one."""
    if choice.chance(0.1):
        return choice.of(*ARRAYS)
    name, n = choice.projection, choice.random.choice((1, 2, 4, 8, 8, 8, 12))
    shape = sm.projection(name).shape(n)
    channels: tuple[int, ...] = choice.random.choice([(), (1,), (2,), (3,), (3,), (4,), (0,), (9,)])
    return array(choice, (*shape, *channels), IMAGES)


def images(choice: Choice) -> str:
    return f"[{', '.join(image(choice) for _ in range(choice.random.randrange(4)))}]"


def photo(choice: Choice) -> str:
    side = choice.random.choice((1, 8, 24, 33))
    return array(choice, (side, side, 3), IMAGES)


def photos(choice: Choice) -> str:
    return f"[{', '.join(photo(choice) for _ in range(choice.random.randrange(3)))}]"


def vectors(choice: Choice, width: int = 3) -> str:
    """Return vectors, or what looks like them."""
    if choice.chance(0.15):
        return choice.of(*ARRAYS)
    lead = choice.random.choice([(), (1,), (4,), (4,), (5, 2), (0,), (65,), (2, 0)])
    # A wrong width now and then.
    wide = width if choice.chance(0.9) else choice.random.choice((0, 1, 2, 3, 4))
    return array(choice, (*lead, wide))


def numbers(choice: Choice) -> str:
    return vectors(choice, choice.random.choice((1, 3, 4, 9, 12, 48)))


def pixels(choice: Choice) -> str:
    """Return numbers of pixels, or places in an image."""
    if choice.chance(0.4):
        return f"{vectors(choice, 2)}"
    return choice.of(
        "[0, 1, 5]",
        "np.arange(12)",
        "np.arange(48, dtype='u8')",
        "-1",
        "2**62",
        "2**70",
        "np.array([2**64 - 1], 'u8')",
        "np.arange(12)[::-1]",
        "1.5",
        "[]",
        "np.zeros((3, 4), 'i2')",
        "np.empty((0, 2**40), int)",
        "np.broadcast_to(np.int64(1), 2**40)",
        "[[1], [2, 3]]",
    )


def codes(choice: Choice) -> str:
    dtype = choice.of("u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8", ">u4", "f4", "f8", "?", "O")
    shape = choice.of("(5,)", "()", "(4, 2)", "(4, 3)", "(4, 4)", "(0,)", "(0, 2)", "(7, 1)")
    whole = dtype[-2] in "ui" if len(dtype) > 1 else False
    values = f"np.random.default_rng(1).integers(0, 127, {shape}).astype({dtype!r})"
    bits = f"np.full({shape}, {choice.of('0', '1', '127')}, {dtype!r})"
    return choice.of(values, bits, f"~{bits}" if whole else values, *ARRAYS)


def packing(choice: Choice) -> str:
    names = sm.packing.packings()
    near = choice.of(*names)
    return repr(
        choice.of(*names, *names, near[:-1], near + "9", "oct0", "oct65", "oct-1", "oct", "")
    )


def nside(choice: Choice) -> str:
    return choice.of("1", "2", "4", "8", "3", *INTEGERS, "2**29", "2**30", "2**28")


def fill(choice: Choice) -> str:
    return choice.of(
        "0", "nan", "1.5", "[1, 2, 3]", "[1]", "-1", "256", "1e300", "[]", "[nan, 'x', 1]"
    )


def out(choice: Choice) -> str:
    """Return an array to write into: None, the input itself, or one that may not fit."""
    first = choice.made.get("first")
    mine = ("first", "first[..., :2]", "first[::-1]") if first else ()
    return choice.of(
        "None",
        *mine,
        "np.empty((4, 2))",
        "np.empty((4, 3), 'f4')",
        "np.empty((4, 2), 'f4')[::-1]",
        "np.broadcast_to(np.ones(2), (4, 2))",
        "np.empty((8, 16, 3), 'f4')",
        "np.empty((4, 2), 'i8')",
        "np.empty((4, 2), '>f8')",
        "np.lib.stride_tricks.as_strided(np.ones(8), (4, 2), (0, 8))",
        "np.empty(4, int)",
        "[[0, 0]]",
    )


def sun(choice: Choice) -> str:
    direction = choice.of("array([0, 1, 0.1])", "zeros(3)", "full(3, nan)", "ones(2)", "array('x')")
    light = choice.of("ones(3)", "full(3, -1)", "full(3, nan)", "ones(2)", "ones(1)", "array(2.0)")
    return SUN.format(direction, choice.of("6e-5", *REALS), light)


def lobe(choice: Choice) -> str:
    return choice.of(
        "'cosine'", "'cone'", "'phong'", "'vmf'", "'x'", "[1, 0.5, 0.2]", "np.ones(99)"
    )


def order(choice: Choice) -> str:
    return choice.of("0", "1", "2", "4", "9", *INTEGERS)


def path(choice: Choice) -> str:
    return choice.of(*PATHS)


def folder(choice: Choice) -> str:
    """Return where files can go, most of the time."""
    new = "__import__('tempfile').mkdtemp(dir='.')"
    return choice.of(new, new, new, path(choice))


def dtype(choice: Choice) -> str:
    return choice.of(
        "'f4'", "'f8'", "'f2'", "'>f4'", "'i4'", "'x'", "None", "complex", "object", "3"
    )


def pair(choice: Choice) -> str:
    return choice.of(
        "(12, 12)", "(0, 0)", "(nan, 1)", "(1, 2, 3)", "('a', 1)", "(1e300, 0)", "5", "[]"
    )


def optional_mask(choice: Choice) -> str:
    return choice.of(
        "None", "np.ones((24, 24), bool)", "np.zeros((24, 24))", "np.ones((3, 3))", "'x'"
    )


def ball(choice: Choice) -> str:
    return choice.of(
        "None", "[]", "[None]", "[sm.ball.Ball((12., 12.), (9., 9.), 0., 1.)]", "['x']"
    )


def cameras(choice: Choice) -> str:
    return choice.of(
        "'dual_fisheye(fov=200)'", "['angular(fov=200)'] * 2", "sm.cameras.rig(8, fov=100)[:2]",
        "['latlong', 'camera_pinhole']", "[]", "[None]", "'x'",
    )  # fmt: skip


def pictures(choice: Choice) -> str:
    """Return what two cameras see, most of them squares."""
    return choice.of(
        "[np.ones((8, 8, 3), 'f4')] * 2", "[np.zeros((8, 8), 'u1')] * 2",
        "np.ones((8, 16, 3), 'u2')",
        "np.full((2, 8, 8, 1), np.nan)", "[np.full((8, 8), np.inf), np.ones((4, 4))]",
        photos(choice), image(choice),
    )  # fmt: skip


BY_NAME: dict[str, Callable[[Choice], str]] = {
    "axes": axes,
    "balls": ball,
    "cameras": cameras,
    "center": pair,
    "codes": codes,
    "coefficients": numbers,
    "curve": lambda c: c.of("'none'", "'reinhard'", "'reinhard'", word(c)),
    "dtype": dtype,
    "feather": real,
    "fill": fill,
    "extension": lambda c: c.of("'jpg'", "'png'", "'fits'", "'exr'", "None"),
    "filter": lambda c: repr(c.of(*FILTERS, "nothing")),
    "folder": folder,
    "format": lambda c: c.of(*map(repr, FORMATS), word(c)),
    "frame": lambda c: c.of("'equatorial'", "'galactic'", word(c)),
    "grid": grid,
    "image": image,
    "image_a": image,
    "image_b": image,
    "images": pictures,
    "layout": layout,
    "levels": lambda c: c.of("None", images(c), integer(c)),
    "lobe": lobe,
    "mask": optional_mask,
    "masks": lambda c: c.of("None", "[None]", f"[{optional_mask(c)}]"),
    "nside": nside,
    "npix": lambda c: c.of("12", "48", "3072", *INTEGERS),
    "order": order,
    "out": out,
    "path": path,
    "photo": photo,
    "photos": photos,
    "pixels": pixels,
    "pose": rotation,
    "poses": lambda c: c.of("None", "[]", f"[{rotation(c)}]", f"[{rotation(c)}, {rotation(c)}]"),
    "principal": pair,
    "rotation": rotation,
    "size": size,
    "rig": lambda c: c.of("sm.cameras.rig(8, fov=100)", "sm.cameras.Rig(())", vectors(c)),
    "properties": lambda c: c.of("None", "{'obs_ack': 'x'}", "{'a=': 1}", "{1: 'x'}", "[]", "'x'"),
    "source_shape": lambda c: c.of("None", *SHAPES),
    "sun": sun,
    "uv": lambda c: vectors(c, 2),
    "xi": lambda c: vectors(c, 2),
    "values": numbers,
    "depth": image,
    "view": lambda c: c.of(image(c), vectors(c)),
    "reference": image,
    "matcap": image,
}
# What is not in the table, by the first of these that its annotation has.
BY_ANNOTATION: list[tuple[str, Callable[[Choice], str]]] = [
    (r"PathLike", path),
    (r"Packing", packing),
    (r"ProjectionLike|ProjectionName", projection),
    (r"LayoutName", layout),
    (r"Size", size),
    (r"ArrayLike|NDArray", vectors),
    (r"\bbool\b", truth),
    (r"\bint\b|SupportsIndex", integer),
    (r"\bfloat\b", real),
    (r"\bstr\b|Literal", word),
]


def literal_words(annotations: Sequence[Any]) -> list[str]:
    """Return the strings that annotations name."""
    return sorted({word for text in annotations for word in re.findall(r"'([^']*)'", str(text))})
