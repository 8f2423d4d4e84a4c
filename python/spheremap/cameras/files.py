"""The files of calibration programs, by their names and by what is in them."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from .._scalars import as_items, as_text
from . import colmap, nerfstudio, opencv, yaml_files
from .masking import expect_masks, write_mask
from .views import Rig, mask_path

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
        OpenCV's YAML or XML, COLMAP's ``cameras.txt`` or ``.bin`` or the folder that holds it
        (poses come from ``images.txt`` or ``.bin`` beside it), Kalibr's camchain, ROS's
        CameraInfo as ``camera_calibration`` writes it or ``rostopic echo`` prints it, or
        nerfstudio's ``transforms.json``.
        Kalibr's and ROS's need PyYAML.
    format : str, optional
        ``"opencv"``, ``"colmap"``, ``"kalibr"``, ``"ros"`` or ``"nerfstudio"``; by default it is
        told from the file.

    Returns
    -------
    Rig
        Poses and positions are those of the file: of COLMAP's and nerfstudio's world, or of the
        first camera of a camchain.

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
    frame: str | Sequence[str] = "0001.png",
    masks: Sequence[ArrayLike] | None = None,
) -> None:
    """Write a rig for structure from motion or splats.

    Parameters
    ----------
    rig : Rig
        The cameras, with their poses.
    path : path
        A folder, which is made. COLMAP's gets ``cameras.txt``, ``images.txt``, an empty
        ``points3D.txt`` and ``rig_config.json``, nerfstudio's ``transforms.json``. The pictures
        belong into its folder ``images``, which is COLMAP's ``image_path``.
    format : {"colmap", "nerfstudio"}
        The program.
    frame : str or sequence of str, optional
        The file name of each view's picture, in a folder of the view's name:
        ``images/view00/0001.png``. Several are of a rig that moved: where to is what COLMAP finds,
        so it gets ``rig_config.json`` alone; nerfstudio needs it known.
    masks : sequence of array_like of bool, optional
        A mask of each view, as `spheremap.cameras.masks` makes them. They are written as
        ``masks/view00/0001.png.png``, white where pixels count: ``masks`` is COLMAP's
        ``ImageReader.mask_path``, and nerfstudio's frames name them.

    Raises
    ------
    ValueError, TypeError
        For a view without a pose, a camera that the program has no model for, masks of other
        sizes, and several frames for nerfstudio.
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
    names = [view.name for view in rig]
    if len(set(names)) < len(names):
        raise ValueError("Expected the views of `rig` to have names of their own, got one twice.")
    frames = [frame] if isinstance(frame, str) else as_items(frame, "frame", "file names")
    frames = [as_text(name, "frame") for name in frames]
    if not frames:
        raise ValueError("Expected at least one file name in `frame`, got none.")
    if format == "nerfstudio" and len(frames) > 1:
        raise ValueError(
            "Expected one `frame` for nerfstudio, whose file says where each picture was taken, "
            f"got {len(frames)}."
        )
    folder = _path(path)
    shapes = None if masks is None else expect_masks(masks, rig)
    folder.mkdir(parents=True, exist_ok=True)
    if format == "colmap":
        colmap.write(rig, folder, frames)
    else:
        nerfstudio.write(rig, folder, frames[0], shapes is not None)
    if shapes is not None:
        for view, mask in zip(rig, shapes, strict=True):
            for name in frames:
                write_mask(folder / mask_path(view, name), mask)


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
    if path.is_dir() or path.name in ("cameras.txt", "cameras.bin"):
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
