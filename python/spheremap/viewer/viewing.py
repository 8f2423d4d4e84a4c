"""`view`, and what it returns."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .._arrays import as_image, spatial_axes, spatial_shape
from .._scalars import as_flag, as_items, as_text, as_whole
from ..io.images import STORED
from ..io.tonemap import Curve
from ..io.whole import as_path, write_bytes
from ..map.flat import flat
from ..map.images import channels_last, expect_aspect
from ..map.named import resolve
from ..map.variants import changed
from ..map.verbs import rotation as turned_by
from . import figures, page, shaders, still, stripes
from .answers import Shown
from .look import CHECKS, as_side, yaw_and_pitch
from .overlays import Overlays
from .reduction import reduced
from .texels import apart, shown_channels, texels
from .widget import widget

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .._projection import Projection
    from ..light.sources import Light, Lights, Sun
    from ..map.named import ProjectionLike

__all__ = ["Viewer", "view"]

# The longer side of what a notebook keeps with its text.
_IN_NOTEBOOKS = 2048
# And of what is seen first: a widget asks for more, and a page goes on reading.
_OVERVIEW = 1024
_AXES = ("+x", "+y", "+z", "-x", "-y", "-z")


class Viewer:
    """What `view` returns: images, and how they are looked at. A notebook shows it.

    Attributes
    ----------
    direction : tuple of float
        What is in the middle, in the world of the first image's projection.
    fov : float
        Degrees across, from 15 to 340: beyond 170 a perspective becomes a little planet.
    exposure : float
        In stops.
    curve : str
        As for `spheremap.io.tonemap`.
    screen : Projection
        What the picture plane is: a lens, or a flat map.
    false_color, isolines, clipping, axes : bool
    graticule : float
        Degrees between lines; 0 for none.
    valid, density, tissot, seams : bool

    Each is checked when it is set.
    """

    direction: tuple[float, float, float]
    fov: float
    exposure: float
    curve: str
    false_color: bool
    isolines: bool
    clipping: bool
    graticule: float
    axes: bool
    valid: bool
    density: bool
    tissot: bool
    seams: bool
    max_size: int
    screen: Projection

    def __init__(self, shown: Shown, max_size: int, look: dict[str, Any]) -> None:
        """Start with one image; `view` checks it."""
        self._images = [shown]
        self._overlays = Overlays()
        self.max_size = max_size
        for name, value in look.items():
            setattr(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        if name in CHECKS:
            value = CHECKS[name](value, name)
        elif name == "screen":
            value = _screen(value)
        elif name == "max_size":
            value = as_side(as_whole(value, name), name)
        elif not name.startswith("_"):
            known = ", ".join([*CHECKS, "screen", "max_size"])
            raise AttributeError(f"A viewer has no {name!r}; there are {known}.")
        super().__setattr__(name, value)

    def __repr__(self) -> str:
        images = ", ".join(f"{shown.name!r}" for shown in self._images)
        return f"<spheremap viewer of {images}: {self.screen.name}, fov={self.fov:g}>"

    def add(
        self,
        image: ArrayLike,
        /,
        projection: ProjectionLike,
        *,
        name: str | None = None,
        rotation: Any | None = None,
        any_aspect: bool = False,
        channels_first: bool = False,
    ) -> Viewer:
        """Add an image that is compared with the first, by one camera.

        The page shows both with a slider between them, their difference, or one after the other.

        Parameters
        ----------
        image, projection, name, rotation, any_aspect, channels_first
            As for `view`. The worlds of several projections are matched, as in `convert`.

        Returns
        -------
        Viewer
            This one.

        Raises
        ------
        ValueError, TypeError
            As for `view`.

        Examples
        --------
        >>> import numpy as np, spheremap as sm
        >>> sky = np.ones((32, 64, 3), np.float32)
        >>> cube = sm.convert(sky, "latlong", "cube", size=8)
        >>> sm.view(sky, "latlong").add(cube, "cube", name="small")
        <spheremap viewer of 'latlong', 'small': perspective, fov=90>
        """
        self._images.append(_shown(image, projection, name, rotation, any_aspect, channels_first))
        return self

    def mark(self, directions: ArrayLike, /, names: Sequence[str] | str | None = None) -> Viewer:
        """Mark directions: points of interest.

        Parameters
        ----------
        directions : array_like, shape (3,) or (N, 3)
            In the world of the first image's projection; of any length.
        names : str or sequence of str, optional
            What stands there; a dot where nothing is said.

        Returns
        -------
        Viewer
            This one.

        Raises
        ------
        ValueError, TypeError
            For what is no direction, for another number of names, and for more than 1024 marks.

        Examples
        --------
        >>> import numpy as np, spheremap as sm
        >>> sky = np.ones((16, 32))
        >>> v = sm.view(sky, "latlong").mark([0, 1, 0], "zenith")
        >>> v = v.mark([[1, 0, 0], [-1, 0, 0]])
        """
        self._overlays.mark(directions, names)
        return self

    def lights(self, lights: Lights | Light | Sun | Sequence[Light | Sun], /) -> Viewer:
        """Draw lights: disks as large and of the color that they are, and rings for suns.

        Parameters
        ----------
        lights : Lights, Light, Sun, or a sequence of these
            As `spheremap.light.lights` and `spheremap.light.sun` find them in the first image.

        Returns
        -------
        Viewer
            This one.

        Raises
        ------
        ValueError, TypeError
            For what is no light, and for more than 1024 lights.

        Examples
        --------
        >>> import numpy as np, spheremap as sm
        >>> sky = np.full((32, 64, 3), 0.2, np.float32)
        >>> sky[8, 20] = 500
        >>> v = sm.view(sky, "latlong").lights(sm.light.lights(sky, "latlong", count=8))
        >>> v = v.lights(sm.light.sun(sky, "latlong"))
        """
        self._overlays.light(lights)
        return self

    def box(self, box: Sequence[float], /, name: str = "", *, face: int | None = None) -> Viewer:
        """Draw the border of a rectangle of the first image, on the sphere.

        Parameters
        ----------
        box : (float, float, float, float)
            Left, top, right and bottom, in pixels of the image: x runs right and y down, from its
            upper left corner.
        name : str
            What stands at its upper left corner.
        face : int, optional
            Its face, of an array of faces.

        Returns
        -------
        Viewer
            This one.

        Raises
        ------
        ValueError, TypeError
            For what is no box, for one around which the image holds no sphere, and for more than
            1024 lines.

        Examples
        --------
        >>> import numpy as np, spheremap as sm
        >>> photo = np.zeros((64, 128, 3), np.uint8)
        >>> v = sm.view(photo, "latlong").box((60, 20, 80, 40), "car")
        """
        first = self._images[0]
        p = first.projection
        shape = first.pixels.shape[: spatial_axes(p)]
        self._overlays.box(box, name, face, p, shape)
        return self

    def outline(self, directions: ArrayLike, /, name: str = "", *, closed: bool = True) -> Viewer:
        """Draw a line through directions, by great circles.

        Parameters
        ----------
        directions : array_like, shape (N, 3)
            In the world of the first image's projection; of any length.
        name : str
            What stands at its start.
        closed : bool
            Whether it comes back to its start.

        Returns
        -------
        Viewer
            This one.

        Raises
        ------
        ValueError, TypeError
            For fewer than two directions, for two in a row that are opposite, and for more than
            1024 lines.

        Examples
        --------
        >>> import numpy as np, spheremap as sm
        >>> v = sm.view(np.zeros((16, 32)), "latlong")
        >>> v = v.outline([[1, 0, 0], [0, 1, 0], [0, 0, 1]], "an octant")
        """
        self._overlays.outline(directions, name, as_flag(closed, "closed"))
        return self

    def html(self) -> str:
        """Return a page that works offline and asks nothing of a server.

        It needs a browser with WebGL 2.

        Returns
        -------
        str
        """
        return self._page(self.max_size)

    def widget(self) -> Any:
        """Return a widget for notebooks, by anywidget: ``pip install spheremap[view]``.

        Its traits are both ways: ``w.direction = [1, 0, 0]`` turns the view, and ``w.fov`` is what
        the wheel has made of it. ``w.picked`` is what lies under the pointer and ``w.clicked`` what
        was clicked: dicts with ``image``, ``direction``, ``uv``, ``texel``, ``value`` and
        ``solid_angle``, and ``face`` of an array of faces. Values are those of the array itself.

        ``w.show(image)`` puts another image in the place of the first: of its projection, or of the
        one that is given, with the options of `view` that are about the image.

        Returns
        -------
        anywidget.AnyWidget
            With the settings of this viewer, but for `screen`, as traits. An overview of at most
            1024 texels along a side is sent first, and then what is seen, as sharp as it is.

        Raises
        ------
        ImportError
            If anywidget is missing.
        """
        return widget(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page of `html` to a file.

        Parameters
        ----------
        path : path
            As ``"look.html"``. It appears whole or not at all.

        Raises
        ------
        OSError
            Where it cannot be written.
        TypeError, ValueError
            For what is no path, and for the name of a picture, which `snapshot` returns.
        """
        ending = os.path.splitext(as_path(path))[1]
        if ending.lower() in STORED:
            raise ValueError(
                f"Expected `path` to be that of a page, as 'look.html', got {ending!r}: the "
                "picture is `snapshot()`, which `io.write` writes."
            )
        write_bytes(path, self.html().encode("utf-8"))

    def snapshot(self, size: tuple[int, int] = (720, 1280)) -> NDArray[np.uint8]:
        """Return what is seen of the first image, by `convert` and no browser.

        Parameters
        ----------
        size : (int, int)
            Rows and columns. A flat map is as large as it fits in. Of a little planet both are even
            or both odd.

        Returns
        -------
        picture : ndarray of uint8, shape (H, W, 3)
            Gray where nothing is known of the sphere, magenta where a value is NaN, and with what
            the page draws over images: of Tissot's circles the rims.

        Raises
        ------
        ImportError
            For lines, names and lights if matplotlib is missing: ``pip install spheremap[plot]``.
        ValueError, TypeError
            For a size that is none.

        Examples
        --------
        >>> import numpy as np, spheremap as sm
        >>> v = sm.view(np.ones((32, 64), np.float32), "latlong", fov=60)
        >>> v.snapshot((9, 16)).shape
        (9, 16, 3)
        """
        sides = [as_side(as_whole(n, "size"), "size") for n in as_items(size, "size", "two sides")]
        if len(sides) != 2:
            raise ValueError(f"Expected `size` to be rows and columns, got {len(sides)} numbers.")
        first = self._images[0]
        yaw, pitch = self._angles()
        name = self.screen.name if _is_lens(self.screen) else ""
        pose, sized = turned_by(yaw, pitch), (sides[0], sides[1])
        by = still.placed(self.screen, name, self.fov, pose, sized)
        directions = still.sights(*by)
        found, held = still.seen(first.pixels, first.projection, *by, directions)
        picture = still.toned(
            found, held, exposure=self.exposure, curve=self.curve, false_color=self.false_color
        )
        there = first.projection.in_world_of("latlong")
        asked = {name: getattr(self, name) for name in stripes.ASKED}
        if any(asked.values()):
            stripes.mark(picture, found, held, directions, there, asked, self.exposure, self.curve)
        return self._drawn_over(picture, figures.Frame(*by))

    def _repr_html_(self) -> str:
        return page.iframe(self._page(min(self.max_size, _IN_NOTEBOOKS)))

    def _page(self, max_size: int) -> str:
        held = [_held(shown, max_size) for shown in self._images]
        whole = [_record(shown, pixels) for shown, pixels in zip(self._images, held, strict=True)]
        if max(max(record["height"], record["width"]) for record in whole) <= 2 * _OVERVIEW:
            return page.page(self._scene_of(whole))
        first = [
            _record(shown, reduced(pixels, shown.projection, _OVERVIEW))
            for shown, pixels in zip(self._images, held, strict=True)
        ]
        return page.page(self._scene_of(first), whole)

    def _shown_in_widget(self) -> dict[str, Any]:
        scene = self._scene(min(self.max_size, _OVERVIEW))
        return scene | {"detail": shaders.detail()}

    def _screen_named(self, name: str) -> Projection:
        """Return a screen of the page."""
        own = self.screen
        return own if name in (own.name, repr(own)) else _screen(name)

    def _replace(self, image: ArrayLike, projection: ProjectionLike | None, options: Any) -> None:
        """Put an image in the place of the first."""
        before = self._images[0]
        settings: dict[str, Any] = {"name": before.name, "rotation": None}
        settings |= {"any_aspect": False, "channels_first": False} | options
        p = before.projection if projection is None else projection
        self._images[0] = _shown(image, p, **settings)

    def _drawn_over(self, picture: NDArray[np.uint8], frame: figures.Frame) -> NDArray[np.uint8]:
        """Return a still with what stands on the sphere."""
        world = _world(self._images[0].projection)
        records = self._overlays.records(world)
        if self.axes:
            ends = np.concatenate([np.eye(3), -np.eye(3)]) @ world
            named = [{"text": name, "direction": d} for name, d in zip(_AXES, ends, strict=True)]
            records["marks"] = named + records["marks"]
        thin = figures.graticule(self.graticule) if self.graticule else []
        circles = figures.circles() if self.tissot else []
        if not (thin or circles or any(records.values())):
            return picture
        return figures.over(picture, frame, thin=thin, circles=circles, records=records)

    def _angles(self) -> tuple[float, float]:
        return yaw_and_pitch(_world(self._images[0].projection).T @ np.array(self.direction))

    def _scene(self, max_size: int) -> dict[str, Any]:
        return self._scene_of([_record(shown, _held(shown, max_size)) for shown in self._images])

    def _scene_of(self, images: list[dict[str, Any]]) -> dict[str, Any]:
        screens, own = dict(shaders.screens()), self.screen
        name = own.name
        if name not in screens or own != _screen(name):
            # One with parameters, a convention or axes of its own.
            name = repr(own)
            screens[name] = shaders.screen(own)
        world = _world(self._images[0].projection)
        yaw, pitch = self._angles()
        look = {setting: getattr(self, setting) for setting in CHECKS if setting != "direction"}
        look |= {"yaw": yaw, "pitch": pitch, "screen": name}
        return page.scene(
            " and ".join(shown.name for shown in self._images),
            look,
            images,
            screens,
            world,
            self._overlays.records(world),
        )


def view(
    image: ArrayLike,
    /,
    projection: ProjectionLike,
    *,
    name: str | None = None,
    direction: ArrayLike | None = None,
    fov: float = 90.0,
    exposure: float = 0.0,
    curve: Curve | str | None = None,
    screen: ProjectionLike = "perspective",
    false_color: bool = False,
    isolines: bool = False,
    clipping: bool = False,
    graticule: float = 0.0,
    axes: bool = False,
    valid: bool = False,
    density: bool = False,
    tissot: bool = False,
    seams: bool = False,
    max_size: int = 4096,
    rotation: Any | None = None,
    any_aspect: bool = False,
    channels_first: bool = False,
) -> Viewer:
    """Look around in an image, in a notebook or a browser, with its full range of light.

    Drag to look around, wheel for the field of view; the page lists its keys. It shows the
    direction, (u, v), texel, value and solid angle under the pointer. Its shaders are those of
    `code`: what they show is what `convert` gives.

    Parameters
    ----------
    image : array_like, shape (H, W) or (H, W, C), or with faces (F, N, N) or (F, N, N, C)
        Floats are linear light; uint8 and uint16 are pictures of sRGB. Of two channels the first is
        shown, of more than three the first three.
    projection : Projection or str
        How the image maps the sphere.
    name : str, optional
        What the page calls it; the projection's name where nothing is said.
    direction : array_like, shape (3,), optional
        What is in the middle, in the world of `projection`. Where nothing is said, what is ahead,
        or what is in the middle of an image that does not hold that.
    fov : float
        Degrees across, from 15 to 340: beyond 170 a perspective becomes a little planet.
    exposure : float
        In stops.
    curve : {"reinhard", "none"}, optional
        As for `spheremap.io.tonemap`; by default ``"none"`` for integers.
    screen : Projection or str
        What the picture plane is: ``"perspective"``, ``"stereographic"``, or a flat map, as
        ``"latlong"`` or ``"mollweide"``. The page can switch to any other.
    false_color : bool
        Whether colors say how bright it is, in stops of luminance 1.
    isolines : bool
        Whether lines are drawn at whole stops.
    clipping : bool
        Whether stripes mark what is too bright for the curve, red, or negative, blue.
    graticule : float
        Degrees between parallels, and between meridians; 0 for none.
    axes : bool
        Whether ±x, ±y and ±z are named where they are, in the world of `projection`.
    valid : bool
        Whether stripes mark what the image does not hold.
    density : bool
        Whether colors say how much of the sphere a texel sees, beside the mean, in powers of two.
    tissot : bool
        Whether circles of 5 degrees are drawn every 30: what they become on a flat screen are
        Tissot's indicatrices.
    seams : bool
        Whether the edges of the image and of its faces are drawn.
    max_size : int
        The longer side of a face, in texels, that a page holds: a larger image is made smaller by
        `convert`. `snapshot` looks at the image itself.
    rotation : array_like, shape (3, 3), or an object with ``.as_matrix()``, optional
        As for `convert`: turns the image in the world.
    any_aspect, channels_first : bool
        As for `convert`.

    Returns
    -------
    Viewer
        It shows itself in a notebook, as a page of at most 2048 texels. ``save("look.html")``
        writes one, ``snapshot()`` is what is seen as an array, and ``add(image, projection)``
        compares.

    Raises
    ------
    ValueError, TypeError
        For an image that the projection cannot have, or that is empty; for settings that there are
        not.

    Notes
    -----
    Light is sent in half floats, scaled by a power of two, with a border that continues each face
    over its seams. At the rim of a disk, and of a map as ``"mollweide"``, what lies beyond counts
    for nothing, where `sample` looks across.

    Examples
    --------
    >>> import numpy as np, spheremap as sm
    >>> sky = np.ones((32, 64, 3), np.float32)
    >>> v = sm.view(sky, "latlong", direction=[1, 0, 0], graticule=15)
    >>> v.fov = 60
    >>> v
    <spheremap viewer of 'latlong': perspective, fov=60>
    >>> v.html().startswith("<!doctype html>")
    True
    """
    shown = _shown(image, projection, name, rotation, any_aspect, channels_first)
    if curve is None:
        curve = "reinhard" if shown.pixels.dtype.kind == "f" else "none"
    if direction is None:
        direction = _first(shown.projection)
    look = {
        "direction": direction,
        "fov": fov,
        "exposure": exposure,
        "curve": curve,
        "screen": screen,
        "false_color": false_color,
        "isolines": isolines,
        "clipping": clipping,
        "graticule": graticule,
        "axes": axes,
        "valid": valid,
        "density": density,
        "tissot": tissot,
        "seams": seams,
    }
    return Viewer(shown, max_size, look)


def _shown(
    image: ArrayLike,
    projection: ProjectionLike,
    name: str | None,
    rotation: Any | None,
    any_aspect: bool,
    channels_first: bool,
) -> Shown:
    p = resolve(projection, rotation=rotation)
    pixels = as_image(image, None)
    if as_flag(channels_first, "channels_first"):
        pixels = channels_last(pixels, spatial_axes(p))
    if 0 in pixels.shape:
        raise ValueError(f"Expected `image` to have texels, got shape {pixels.shape}.")
    expect_aspect(p, pixels.shape, any_aspect)
    spatial_shape(pixels, p, "image")
    return Shown(pixels, p, p.name if name is None else as_text(name, "name"))


def _screen(value: ProjectionLike) -> Projection:
    """Return a screen as one image."""
    p = resolve(value)
    if _is_lens(p):
        # Its field of view is the viewer's.
        return resolve(p.name)
    return p if p.faces == 1 else changed(p, layout=flat(p.name).layout)


def _is_lens(p: Projection) -> bool:
    return p.name in shaders.LENSES


def _world(p: Projection) -> NDArray[np.float64]:
    """Return the matrix from the page's directions, x right, y up, -z ahead, to those of a map."""
    columns = np.zeros((3, 3))
    for k, (word, sign) in enumerate(zip(p.world.split(), (1, 1, -1), strict=True)):
        columns["xyz".index(word[1]), k] = sign if word[0] == "+" else -sign
    return columns


def _first(p: Projection) -> NDArray[np.float64]:
    """Return what is ahead, or in the middle of an image that does not hold it."""
    ahead = -_world(p)[:, 2]
    middle = np.asarray(p.decode([0.5, 0.5] if p.faces == 1 else [0.5, 0.5, 0.0]), np.float64)
    return ahead if p.covers(ahead) or not np.isfinite(middle).all() else middle


def _held(shown: Shown, max_size: int) -> NDArray[Any]:
    """Return what is shown of an image, channels last, no larger than that."""
    p = shown.projection
    return reduced(shown_channels(shown.pixels, p), p, max_size)


def _record(shown: Shown, held: NDArray[Any]) -> dict[str, Any]:
    """Return what the page holds of an image: all of it, or a smaller one."""
    p = shown.projection
    shape = shown.pixels.shape[: spatial_axes(p)]
    sent = texels(apart(held, p), p)
    about = f"{p.name} of {' x '.join(map(str, shape))} texels"
    return {
        "name": shown.name,
        "about": about,
        "shape": (1, *shape) if p.faces == 1 else shape,
        "reduced": held.shape[: len(shape)] != shape,
        "mean_density": p.covered_solid_angle / (p.used_part * p.faces),
        "grid": p.grid,
        **shaders.image(p),
        **sent.record(),
    }
