"""The files of calibration programs, by their names and by what is in them."""

from __future__ import annotations

import os
from pathlib import Path, PureWindowsPath
from typing import TYPE_CHECKING, Literal, TypeAlias

from .._scalars import as_items, as_text
from . import colmap, nerfstudio, opencv, yaml_files
from .masking import expect_masks, write_mask
from .views import Rig, as_written, mask_path, picture_name

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

__all__ = ["read", "write"]

FileFormat: TypeAlias = Literal["opencv", "colmap", "kalibr", "ros", "nerfstudio"]
WrittenFormat: TypeAlias = Literal["colmap", "nerfstudio"]

READERS: dict[str, Callable[[Path], Rig]] = {
    "opencv": opencv.read,
    "colmap": colmap.read,
    "kalibr": yaml_files.read_kalibr,
    "ros": yaml_files.read_ros,
    "nerfstudio": nerfstudio.read,
}
WRITTEN = ("colmap", "nerfstudio")


def read(path: str | os.PathLike[str], /, *, format: FileFormat | None = None) -> Rig:
    """Return the cameras of a calibration program's file.

    Parameters
    ----------
    path : path
        OpenCV's YAML, XML or JSON, COLMAP's ``cameras.txt`` or ``.bin`` or the folder that holds it
        (poses come from ``images.txt`` or ``.bin`` beside it), Kalibr's camchain, ROS's
        CameraInfo as ``camera_calibration`` writes it or ``rostopic echo`` prints it, or
        nerfstudio's ``transforms.json`` or its folder, and those of NeRF's synthetic scenes,
        whose sizes are those of the pictures beside them.
        Kalibr's and ROS's need PyYAML.
    format : str, optional
        ``"opencv"``, ``"colmap"``, ``"kalibr"``, ``"ros"`` or ``"nerfstudio"``; by default it is
        told from the file.

    Returns
    -------
    Rig
        Views of COLMAP's and nerfstudio's are named as their pictures are. Poses and positions are
        in the world of OpenCV's cameras, where -y is up: COLMAP's as the file has them, a
        camchain's in the frame of its first camera. nerfstudio's, whose world has +z up, are
        turned: (x, y, z) there is (x, -z, y) here.

    Raises
    ------
    ValueError
        For a file that is none of these, and for a model or a coefficient that `camera` does not
        have, which is named.
    OSError
        If it cannot be read.
    ImportError
        Without PyYAML, for a file that needs it.

    Examples
    --------
    >>> import spheremap as sm, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sm.cameras.write(sm.cameras.rig(512, n=8), folder, format="colmap")
    ...     rig = sm.cameras.read(folder)
    >>> rig[0].camera.name, rig[0].size
    ('camera_pinhole', (512, 512))
    """
    place = _path(path)
    if format is None:
        format = _format(place)
    elif as_text(format, "format") not in READERS:
        raise ValueError(f"Expected `format` to be one of {', '.join(READERS)}, got {format!r}.")
    return READERS[format](place)


def write(
    rig: Rig,
    path: str | os.PathLike[str],
    /,
    *,
    format: WrittenFormat,
    frame: str | Sequence[str] | None = None,
    masks: Sequence[ArrayLike] | None = None,
) -> None:
    """Write a rig for structure from motion or splats.

    Parameters
    ----------
    rig : Rig
        The cameras, with their poses. Turns and axes of a `camera` itself go into the pose, and
        nerfstudio's world has +z up: `read` gives the same back.
    path : path
        A folder, which is made. COLMAP's gets ``cameras.txt``, ``images.txt``, an empty
        ``points3D.txt`` and ``rig_config.json``, nerfstudio's ``transforms.json``. The pictures
        belong into its folder ``images``, which is COLMAP's ``image_path``.
    format : {"colmap", "nerfstudio"}
        The program.
    frame : str or sequence of str, optional
        The file name of each view's picture, in a folder of the view's name:
        ``images/view00/0001.png``. By default that, but a view that has the name of a picture, as
        `read` gives it, keeps it. Several are of a rig that moved: where to is what COLMAP finds,
        so it gets ``rig_config.json`` alone; nerfstudio needs it known.
    masks : sequence of array_like of bool, optional
        A mask of each view, as `spheremap.cameras.masks` makes them. They are written as
        ``masks/view00/0001.png.png``, white where pixels count: ``masks`` is COLMAP's
        ``ImageReader.mask_path``, and nerfstudio's frames name them.

    Raises
    ------
    ValueError, TypeError
        For a view without a pose, a camera that mirrors or that the program has no model for,
        cameras of several models for nerfstudio, whose file has one, names that leave the folder,
        masks of other sizes, and several frames for nerfstudio.
    OSError
        If it cannot be written.

    Examples
    --------
    >>> import json, pathlib, tempfile
    >>> import spheremap as sm
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sm.cameras.write(sm.cameras.rig(512, n=8), folder, format="nerfstudio")
    ...     text = (pathlib.Path(folder) / "transforms.json").read_text()
    >>> json.loads(text)["frames"][0]["file_path"]
    'images/view00/0001.png'
    """
    if not isinstance(rig, Rig):
        raise TypeError(f"Expected `rig` to be a Rig, got {type(rig).__name__}.")
    if as_text(format, "format") not in WRITTEN:
        raise ValueError(f"Expected `format` to be one of {', '.join(WRITTEN)}, got {format!r}.")
    for view in rig:
        if view.pose is None:
            raise ValueError(
                f"Expected every view of `rig` to have a pose, {view.name!r} has none."
            )
    if len(rig) == 0:
        raise ValueError("Expected `rig` to have at least one view, got none.")
    frames = _frames(frame)
    # Of each frame, the picture of each view.
    names = [[picture_name(view, each) for view in rig] for each in frames]
    for each in names:
        for name in each:
            _expect_inside(name)
    if len(set(names[0])) < len(rig):
        raise ValueError("Expected the views of `rig` to have names of their own, got one twice.")
    if format == "nerfstudio" and len(frames) > 1:
        raise ValueError(
            "Expected one `frame` for nerfstudio, whose file says where each picture was taken, "
            f"got {len(frames)}."
        )
    folder = _path(path)
    shapes = None if masks is None else expect_masks(masks, rig)
    written = Rig(tuple(map(as_written, rig)))
    folder.mkdir(parents=True, exist_ok=True)
    if format == "colmap":
        colmap.write(written, folder, names)
    else:
        nerfstudio.write(written, folder, names[0], shapes is not None)
    if shapes is not None:
        for each in names:
            for name, mask in zip(each, shapes, strict=True):
                write_mask(folder / mask_path(name), mask)


def _frames(frame: str | Sequence[str] | None) -> list[str] | list[None]:
    if frame is None:
        return [None]
    given = [frame] if isinstance(frame, str) else as_items(frame, "frame", "file names")
    frames = [as_text(name, "frame") for name in given]
    if not frames:
        raise ValueError("Expected at least one file name in `frame`, got none.")
    return frames


def _expect_inside(name: str) -> None:
    """Raise for the name of a picture that leaves its folder or breaks a line of a file."""
    # Both kinds of slashes, drives too.
    path = PureWindowsPath(name)
    if path.anchor or ".." in path.parts or name.splitlines() != [name] or "\0" in name:
        raise ValueError(
            "Expected names of views and of `frame` that are of one line and stay in the folder, "
            f"got {name!r}."
        )


def _path(path: object) -> Path:
    if not isinstance(path, str | os.PathLike):
        raise TypeError(f"Expected `path` to be a path, got {type(path).__name__}.")
    text = os.fspath(path)
    if not isinstance(text, str) or "\0" in text:
        raise ValueError("Expected `path` to be a path in text, without a null character.")
    try:
        os.fsencode(text)
    except UnicodeEncodeError:
        raise ValueError("Expected `path` to be a path that this system can write.") from None
    return Path(text)


def _format(path: Path) -> FileFormat:
    if path.is_dir():
        is_colmap = any((path / name).is_file() for name in colmap.FILES)
        return "colmap" if is_colmap or not (path / nerfstudio.FILE).is_file() else "nerfstudio"
    if path.name in colmap.FILES:
        return "colmap"
    suffix = path.suffix.lower()
    if suffix == ".xml":
        return "opencv"
    start = path.read_bytes()[:65536].decode("utf-8", "replace")
    if "opencv-matrix" in start:
        return "opencv"
    if suffix == ".json":
        return "nerfstudio"
    if suffix in (".yaml", ".yml"):
        if "distortion_coeffs" in start and "camera_model" in start:
            return "kalibr"
        if "camera_matrix" in start or "distortion_model" in start:
            return "ros"
    if suffix == ".txt" and "CAMERA_ID" in start:
        return "colmap"
    raise ValueError(
        f"Expected a file of {', '.join(READERS)}, got {path.name!r}, which looks like none; "
        "`format` says which it is."
    )
