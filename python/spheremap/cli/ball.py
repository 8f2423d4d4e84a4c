"""The subcommand `spheremap ball`: photos of mirrored balls into one panorama."""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

import spheremap as sm
from spheremap import io
from spheremap.cli import exif, files, picture
from spheremap.cli.options import ColorSpace, Part, as_options, finite
from spheremap.cli.picture import Picture
from spheremap.cli.terminal import UsageError, as_usage, check_projection, progress
from spheremap.io.images import STORED, TEXTURES
from spheremap.map.flat import flat

if TYPE_CHECKING:
    from numpy.typing import NDArray

# Rows of the photos in the preview.
_HEIGHT = 480
_RIM = (255, 64, 32)


def ball(
    context: typer.Context,
    photos: Annotated[list[Path], typer.Argument(metavar="PHOTO...", help="Photos of one ball.")],
    target: Annotated[Path, typer.Option("--output", "-o", metavar="OUT", help="The panorama.")],
    to: Annotated[str, typer.Option("--to", metavar="NAME", help="Its projection.")] = "latlong",
    size: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Height of a latlong, side of a square or face."),
    ] = None,
    fov: Annotated[
        float | None,
        typer.Option(metavar="DEG", help="Horizontal angle of the photos; else of Exif."),
    ] = None,
    distance: Annotated[
        float | None,
        typer.Option(metavar="R", help="Of the camera from the ball's center, in ball radii."),
    ] = None,
    rim: Annotated[
        list[str] | None,
        typer.Option(metavar="X,Y,R", help="The rim in pixels, one for each photo; not searched."),
    ] = None,
    mask: Annotated[
        list[Path] | None,
        typer.Option(metavar="FILE", help="One for each photo; black does not count."),
    ] = None,
    photographer: Annotated[
        float, typer.Option(min=0, metavar="DEG", help="Cone around the camera left to others.")
    ] = 6.0,
    metal: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of the ball: Ag, Al, Au, Cr or Cu.")
    ] = None,
    part: Part = None,
    colorspace: ColorSpace = None,
    preview: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Show the rims that were found.")
    ] = None,
    exposure: Annotated[
        float | None,
        typer.Option(
            metavar="STOPS",
            callback=finite,
            help="Of the preview, and of OUT as .png or .jpg. [by default automatic, and 0]",
        ),
    ] = None,
) -> None:
    """Join photos of a mirrored ball into one map of the sphere.

    It is in the frame of the first camera, which looks ahead: along -z, or along +y of a --to like
    latlong:blender, whose up is up. Without --fov and --distance the angle is that of Exif, if all
    photos have it; else two photos or more tell how far the camera was, and one is taken to be from
    infinitely far away, with a warning. --distance inf means it.

    Light is joined: integers are decoded, as --colorspace or the file says, else as sRGB.
    """
    check_projection(to)
    for given, name in ((rim, "--rim"), (mask, "--mask")):
        if given and len(given) != len(photos):
            raise UsageError(f"{name} is needed once for each of {len(photos)} photos")
    if preview is not None and STORED.get(preview.suffix.lower(), ("",))[0] != "uint8":
        raise UsageError(f"--preview is a .png or .jpg, got {str(preview)!r}")
    _check_places(target, preview, [*photos, *(mask or ())])
    rims: list[sm.ball.Ball] = [_parsed(text, UsageError) for text in rim or ()]
    with as_usage():
        dst = flat(to)
    for place in (target, preview):
        if place is not None:
            io.check_target(place)
    start = time.perf_counter()
    with progress() as step:
        step("reading")
        loaded = [_light(picture.load(path, part=part, color_space=colorspace)) for path in photos]
        images = [photo.pixels for photo in loaded]
        masks = [picture.without_alpha(picture.load(path)).pixels.mean(-1) for path in mask or ()]
        # Integers are fractions of their largest.
        masks = [m / max(float(m.max()), 1.0) for m in masks]
        if not rims:
            for path, image, counts in zip(
                photos, images, masks or [None] * len(images), strict=True
            ):
                step(f"looking for the ball in {path.name}")
                try:
                    with step.listening():
                        rims.append(sm.ball.find(image, mask=counts))
                except ValueError as error:
                    _draw(preview, images, [], None, exposure)
                    text = str(error).replace(": give `center` and `radius`", "; give its --rim")
                    raise ValueError(f"{path}: {text}") from None
        _draw(preview, images, rims, None, exposure)
        said = fov is not None or distance is not None
        angles = [] if said else [exif.fov(path) for path in photos]
        told = [angle for angle in angles if angle is not None]
        known = told if len(told) == len(photos) else fov
        step("joining")
        with warnings.catch_warnings(record=True) as doubts, step.listening():
            warnings.simplefilter("always", UserWarning)
            try:
                merged = sm.ball.merge(
                    images,
                    balls=rims,
                    fov=known,
                    distance=distance,
                    masks=masks or None,
                    photographer=photographer if len(images) > 1 else 0,
                    metal=metal,
                    dst=dst,
                    size=size,
                )
            except ValueError as error:
                text = str(error).replace("look at `center` and `radius`", "look at its --rim")
                raise ValueError(text) from None
        step(f"writing {target.name}")
        image = merged.image
        _write(target, replace(loaded[0], pixels=image), exposure or 0.0, files.noted(to, dst))
        _draw(preview, images, list(merged.balls), image, exposure)
    for doubt in doubts:
        words = as_options(str(doubt.message), context.command.params)
        print(f"warning: {words}", file=sys.stderr)
    for k, (path, found) in enumerate(zip(photos, merged.balls, strict=True)):
        x, y = found.center
        words = f"ball at {x:.1f}, {y:.1f}, radii {found.radii[0]:.1f} and {found.radii[1]:.1f}"
        words += f", confidence {found.confidence:.2f}"
        if merged.fov is not None:
            words += f"; camera {merged.distances[k]:.2f} radii away"
        if k:
            gains = " ".join(f"{g:.3g}" for g in merged.exposures[k])
            words += f"; turned by {merged.angle(k):.2f}°, brightness x {gains}"
        print(f"{path}: {words}")
    if merged.fov is not None and not said:
        whence = "from Exif" if known else f"estimated, rims to {merged.doubt:.1f}° (1 sigma)"
        print(f"the first photo spans {merged.fov:.1f}°: {whence}")
    height, width = image.shape[:2]
    # A single photo differs from no other.
    residual = f"residual {merged.residual:.2f} stops; " if len(images) > 1 else ""
    print(
        f"{target}: {files.described(dst)}, {width} x {height}, covers {merged.coverage:.1%}; "
        f"{residual}{time.perf_counter() - start:.1f} s"
    )


def _parsed(text: str, error: Callable[[str], Exception]) -> sm.ball.Ball:
    try:
        x, y, r = (float(word) for word in text.split(","))
        if not (r > 0 and np.isfinite([x, y, r]).all()):
            raise ValueError
    except ValueError:
        raise error(f"--rim is X,Y,R in pixels, as 400,300,250.5; got {text!r}") from None
    return sm.ball.Ball((x, y), (r, r), 0.0, 1.0)


def _check_places(target: Path, preview: Path | None, inputs: list[Path]) -> None:
    if target.suffix.lower() in TEXTURES:
        raise UsageError(f"--output is an image, got {str(target)!r}")
    taken = [place.resolve() for place in inputs]
    for place, option in ((target, "--output"), (preview, "--preview")):
        if place is not None:
            if place.resolve() in taken:
                raise UsageError(f"{option} would replace {str(place)!r}, which is needed")
            taken.append(place.resolve())


def _light(photo: Picture) -> Picture:
    """Return a photo as light without alpha, of three channels or one."""
    light = picture.without_alpha(picture.as_light(photo))
    return picture.with_channels(light, list(light.names[: 3 if len(light.names) >= 3 else 1]))


def _write(place: Path, image: Picture, exposure: float, projection: str | None) -> None:
    suffix = place.suffix.lower()
    depth = "float32" if "float32" in STORED[suffix] else "uint8"
    stored = picture.as_stored(image, depth, suffix, tonemap="none", exposure=exposure)
    picture.save(place, stored, compression=None, projection=projection)


def _draw(
    place: Path | None,
    images: list[NDArray[Any]],
    rims: list[sm.ball.Ball],
    panorama: NDArray[Any] | None,
    exposure: float | None,
) -> None:
    """Write the photos with their rims, side by side, and the panorama below."""
    if place is None:
        return
    pictures = []
    for k, image in enumerate(images):
        scale = min(1.0, _HEIGHT / image.shape[0])
        picture = _resized(_rgb(io.tonemap(image, exposure=exposure)), scale)
        if k < len(rims):
            points = rims[k].points(4096) * scale
            for spread in (-0.5, 0.0, 0.5):
                middle = np.array(rims[k].center) * scale
                out = points - middle
                out *= 1 + spread / np.linalg.norm(out, axis=-1, keepdims=True)
                x, y = np.floor(middle + out).astype(int).T
                inside = (x >= 0) & (y >= 0) & (x < picture.shape[1]) & (y < picture.shape[0])
                picture[y[inside], x[inside]] = _RIM
        pictures.append(picture)
    rows = [_padded(pictures, 1)]
    if panorama is not None:
        below = _rgb(io.tonemap(panorama, exposure=exposure))
        rows.append(_resized(below, rows[0].shape[1] / below.shape[1]))
    io.write(place, _padded(rows, 0))


def _rgb(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    flat = picture if picture.ndim == 3 else picture[..., None]
    return np.repeat(flat, 3, axis=-1) if flat.shape[-1] == 1 else flat


def _resized(picture: NDArray[np.uint8], scale: float) -> NDArray[np.uint8]:
    """Return a picture at another size, by its nearest pixels: it is but a preview."""
    height, width = (max(1, round(n * scale)) for n in picture.shape[:2])
    y = np.minimum((np.arange(height) + 0.5) / scale, picture.shape[0] - 1).astype(int)
    x = np.minimum((np.arange(width) + 0.5) / scale, picture.shape[1] - 1).astype(int)
    return np.ascontiguousarray(picture[y[:, None], x])


def _padded(pictures: list[NDArray[np.uint8]], axis: int) -> NDArray[np.uint8]:
    """Return pictures in a row (axis 1) or a column (axis 0), black where they are smaller."""
    across = max(p.shape[1 - axis] for p in pictures)
    parts = []
    for p in pictures:
        pad = [(0, 0), (0, 0), (0, 0)]
        pad[1 - axis] = (0, across - p.shape[1 - axis])
        parts.append(np.pad(p, pad))
    return np.concatenate(parts, axis=axis)
