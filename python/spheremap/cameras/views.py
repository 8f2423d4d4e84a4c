"""Cameras with names, sizes and poses."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from .._arrays import as_doubles, as_rotation
from .._scalars import as_items, as_text
from ..map import directions_to_pixels, pixels_to_directions
from ..map.images import fits
from ..map.named import made, projection, resolve
from ..resample import convert
from .weights import along

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike, NDArray

    from .._arrays import Size
    from .._projection import Projection
    from ..map.named import ProjectionLike

__all__ = [
    "LATLONG",
    "Rig",
    "View",
    "as_written",
    "mask_path",
    "picture_name",
    "picture_path",
    "unrounded",
    "where",
]

# A panorama in the axes and in the world of OpenCV's cameras.
LATLONG = "latlong:colmap"
# What names of pictures end on: other names are of cameras, with a folder of pictures each.
PICTURES = (".bmp", ".exr", ".hdr", ".jpeg", ".jpg", ".png", ".tif", ".tiff", ".webp")
FRAME = "0001.png"
# Programs write three digits and more. A scale or a shear that anybody means is larger.
ROUNDED = 1e-3
# A rotation that has all of its digits keeps them.
WHOLE = 1e-12


@dataclass(frozen=True, eq=False)
class View:
    """A camera of a rig.

    Parameters
    ----------
    name : str
        As in a file; `write` makes folders of it.
    camera : Projection
        The camera in its own frame, as `spheremap.camera` gives it.
    size : tuple of int
        Height and width of its images, of the camera's aspect.
    pose : ndarray, shape (3, 3), or None
        The rotation from the camera's frame to the world; None where a file has none.
    position : ndarray, shape (3,), or None
        Where the camera is in the world, in the file's unit.

    Raises
    ------
    ValueError, TypeError
        For a size of another aspect, a pose that is no rotation, and a position that is not finite.

    Examples
    --------
    >>> import spheremap as sm
    >>> view = sm.cameras.rig(512, fov=90, overlap=0)[0]
    >>> view.size
    (512, 512)
    """

    name: str
    camera: Projection
    size: tuple[int, int]
    pose: NDArray[np.float64] | None = None
    position: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        as_text(self.name, "name")
        object.__setattr__(self, "camera", resolve(self.camera))
        size = tuple(as_items(self.size, "size", "whole numbers"))
        shape = self.camera.shape(size)
        if not fits(self.camera, shape):
            raise ValueError(
                "Expected `size` to be the height and the width of images of `camera`, "
                f"{self.camera!r}, each within a texel of its aspect, got {shape}."
            )
        object.__setattr__(self, "size", (int(shape[-2]), int(shape[-1])))
        if self.pose is not None:
            pose = as_rotation(self.pose, "pose")
            # The core says what is no rotation.
            self.camera.turned(pose)
            object.__setattr__(self, "pose", pose)
        if self.position is not None:
            position = as_doubles(self.position, "position")
            if position.shape != (3,):
                raise ValueError(f"Expected `position` to have shape (3,), got {position.shape}.")
            if not np.isfinite(position).all():
                raise ValueError(f"Expected `position` to be finite, got {position.tolist()}.")
            object.__setattr__(self, "position", position)

    @property
    def projection(self) -> Projection:
        """The camera with its pose: its directions are those of the rig's world."""
        return self.camera if self.pose is None else self.camera.turned(self.pose)

    def pixels_from(
        self,
        xy: ArrayLike,
        /,
        src: ProjectionLike,
        size: Size,
        *,
        centers: Literal["half", "integer"] = "half",
    ) -> NDArray[np.floating[Any]]:
        """Return where this view sees what lies at pixels of another image.

        Parameters
        ----------
        xy : array_like, shape (..., 2)
            Pixels of the other image, such as keypoints: x to the right, y down.
        src : Projection or str
            Its projection: a panorama's, or another view's `projection`. Worlds are matched, as
            `convert` does.
        size : int or tuple of int
            Its size, as for `spheremap.convert`.
        centers : {"half", "integer"}
            Whether the center of the first pixel counts (0.5, 0.5), as COLMAP has it, or (0, 0),
            as OpenCV has it: in `xy` and in the result.

        Returns
        -------
        ndarray of float64, shape (..., 2)
            Pixels of this view, NaN for what it does not see. Everything is far away.

        Raises
        ------
        ValueError, TypeError
            As `spheremap.pixels_to_directions`.

        See Also
        --------
        View.pixels_to : The way back.

        Examples
        --------
        >>> import spheremap as sm
        >>> rig = sm.cameras.rig(400, fov=90)
        >>> xy = rig[4].pixels_from([300.0, 100.0], "latlong", (256, 512))
        >>> xy.round(2).tolist()
        [319.88, 116.57]
        >>> rig[4].pixels_to(xy, "latlong", (256, 512)).round(9).tolist()
        [300.0, 100.0]
        """
        other = resolve(src).in_world_of(self.projection)
        d = pixels_to_directions(_places(xy), other, size, centers=centers)
        return directions_to_pixels(d, self.projection, self.size, centers=centers)

    def pixels_to(
        self,
        xy: ArrayLike,
        /,
        dst: ProjectionLike,
        size: Size,
        *,
        centers: Literal["half", "integer"] = "half",
    ) -> NDArray[np.floating[Any]]:
        """Return where another image has what lies at pixels of this view.

        Parameters
        ----------
        xy : array_like, shape (..., 2)
            Pixels of this view, such as keypoints: x to the right, y down.
        dst, size, centers
            The other image, as for `pixels_from`.

        Returns
        -------
        ndarray of float64, shape (..., 2), or (..., 3) for an array of faces
            Pixels of the other image, NaN for what it does not show.

        Raises
        ------
        ValueError, TypeError
            As `spheremap.pixels_to_directions`.

        Examples
        --------
        >>> import spheremap as sm
        >>> view = sm.cameras.rig(400, fov=90, overlap=0)[1]
        >>> view.pixels_to([200.0, 200.0], "latlong", (256, 512)).round(9).tolist()
        [256.0, 128.0]
        """
        other = resolve(dst).in_world_of(self.projection)
        d = pixels_to_directions(_places(xy), self.projection, self.size, centers=centers)
        return directions_to_pixels(d, other, size, centers=centers)


@dataclass(frozen=True, eq=False)
class Rig:
    """Several cameras in a row: it has a length, is iterated and indexed.

    Parameters
    ----------
    views : sequence of View
        The cameras.

    Examples
    --------
    >>> import numpy as np
    >>> import spheremap as sm
    >>> rig = sm.cameras.rig(64, fov=90, overlap=0)
    >>> [view.name for view in rig][:3]
    ['view00', 'view01', 'view02']
    >>> pictures = rig.convert(np.ones((64, 128)), "latlong")
    >>> len(pictures) == len(rig), pictures[0].shape
    (True, (64, 64))
    """

    views: tuple[View, ...] = field()

    def __post_init__(self) -> None:
        views = tuple(as_items(self.views, "views", "views"))
        for view in views:
            if not isinstance(view, View):
                raise TypeError(f"Expected `views` to be of View, got {type(view).__name__}.")
        object.__setattr__(self, "views", views)

    def __len__(self) -> int:
        return len(self.views)

    def __iter__(self) -> Iterator[View]:
        return iter(self.views)

    @overload
    def __getitem__(self, index: int) -> View: ...
    @overload
    def __getitem__(self, index: slice) -> Rig: ...
    def __getitem__(self, index: int | slice) -> View | Rig:
        return Rig(self.views[index]) if isinstance(index, slice) else self.views[index]

    def __repr__(self) -> str:
        names = [view.name for view in self.views]
        shown = ", ".join(names[:4]) + (", ..." if len(names) > 4 else "")
        return f"Rig({len(self)} views: {shown})"

    def convert(self, image: ArrayLike, /, src: ProjectionLike, **options: Any) -> list[Any]:
        """Return what each camera sees of a panorama.

        Parameters
        ----------
        image : array_like, shape (H, W) or (H, W, C)
            As for `spheremap.convert`.
        src : Projection or str
            The projection of `image`.
        **options
            Those of `spheremap.convert`, but `size`, which is each camera's own.

        Returns
        -------
        list of ndarray
            A picture for each view.

        Raises
        ------
        ValueError, TypeError
            As `spheremap.convert`.

        Examples
        --------
        >>> import numpy as np
        >>> import spheremap as sm
        >>> rig = sm.cameras.rig(32, n=6)
        >>> [picture.shape for picture in rig.convert(np.ones((32, 64, 3)), "latlong")][0]
        (32, 32, 3)
        """
        if "size" in options or "out" in options:
            raise TypeError("Expected no `size` and no `out`: every view has a size of its own.")
        return [
            convert(image, src, view.projection, size=view.size, **options) for view in self.views
        ]


def _places(xy: ArrayLike) -> NDArray[np.float64]:
    """Return pixels in float64: in float32, as OpenCV has keypoints, they would lose digits."""
    found = as_doubles(xy, "xy")
    if found.ndim == 0 or found.shape[-1] != 2:
        raise ValueError(f"Expected `xy` to have shape (..., 2), got {found.shape}.")
    return found


@contextmanager
def where(place: str) -> Iterator[None]:
    """Say of an error in which part of a file it is."""
    try:
        yield
    except (TypeError, ValueError) as error:
        raise ValueError(f"{place}: {error}") from error


def unrounded(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation that a matrix of a few digits stands for, or the matrix if it is none."""
    if not np.isfinite(matrix).all():
        return matrix
    left, _, right = np.linalg.svd(matrix)
    nearest: NDArray[np.float64] = left @ right
    off = np.abs(nearest - matrix).max()
    return nearest if WHOLE < off < ROUNDED else matrix


def as_written(view: View) -> View:
    """Return a view as files have it: a camera in OpenCV's axes, with its pose in OpenCV's world.

    Axes and a turn of the camera itself become part of the pose.
    """
    whole = view.projection.in_world_of(LATLONG)
    pose = _frame(whole.axes) if whole.pose is None else whole.pose @ _frame(whole.axes)
    if np.linalg.det(pose) < 0 or whole.grid != "centers":
        raise ValueError(
            "Expected cameras that mirror nothing, with grid 'centers', "
            f"got {view.name!r} with {view.camera!r}."
        )
    if whole.name == "latlong":
        camera = projection(LATLONG)
    else:
        camera = made(whole.name, axes="+x +y +z", world=whole.world, **whole.parameters)
    position = np.zeros(3) if view.position is None else view.position
    turn = _frame(whole.world) @ _frame(view.camera.world).T
    return View(view.name, camera, view.size, pose, turn @ position)


def _frame(axes: str) -> NDArray[np.float64]:
    """Return axes or a world as columns."""
    return np.stack([along(axes, place) for place in range(3)], axis=-1)


def picture_name(view: View, frame: str | None) -> str:
    """Return where a picture of the view lies in the folder of all pictures: COLMAP's name of it.

    A view of a file is named as its picture is, nerfstudio's with the folder.
    """
    name = view.name.removeprefix("./")
    if frame is None and name.lower().endswith(PICTURES):
        return name.removeprefix("images/")
    return f"{name}/{frame or FRAME}"


def picture_path(name: str) -> str:
    """Return where a picture lies in a folder that holds COLMAP's or nerfstudio's files."""
    return f"images/{name}"


def mask_path(name: str) -> str:
    """Return where the mask of a picture lies: its name, and .png, as COLMAP wants it."""
    return f"masks/{name}.png"
