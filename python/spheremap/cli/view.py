"""The subcommand `spheremap view`: images as a page to look around in."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Annotated, Any

import typer

import spheremap as sm
from spheremap.cli import files, picture
from spheremap.cli.options import FromGuess, Part
from spheremap.cli.terminal import check_projection, progress

if TYPE_CHECKING:
    from numpy.typing import NDArray


def view(
    inputs: Annotated[
        list[Path], typer.Argument(metavar="IN...", help="Image files; several are compared.")
    ],
    from_: FromGuess = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="The page, as look.html, instead of a temporary one that is opened.",
        ),
    ] = None,
    open_: Annotated[bool, typer.Option("--open", help="Open the page of -o as well.")] = False,
    fov: Annotated[
        float,
        typer.Option(
            metavar="DEGREES", min=15, max=340, help="Field of view across; past 170 a planet."
        ),
    ] = 90.0,
    exposure: Annotated[
        float, typer.Option(metavar="STOPS", min=-126, max=126, help="How much brighter.")
    ] = 0.0,
    screen: Annotated[
        str, typer.Option(metavar="NAME", help="What is seen first: perspective, mollweide ...")
    ] = "perspective",
    max_size: Annotated[
        int,
        typer.Option(
            metavar="TEXELS", min=2, max=16384, help="The longer side of a face on the page."
        ),
    ] = 4096,
    part: Part = None,
) -> None:
    """Make a page to look around in an image; it works offline, in any browser with WebGL 2."""
    for name in (from_, screen):
        if name is not None:
            check_projection(name)
    with progress(len(inputs)) as step:
        viewer = None
        for path in inputs:
            step(f"reading {path.name}")
            pixels, projection = _read(path, from_, part)
            if viewer is not None:
                viewer.add(pixels, projection, name=path.name)
                continue
            viewer = sm.view(
                pixels,
                projection,
                name=path.name,
                fov=fov,
                exposure=exposure,
                screen=screen,
                max_size=max_size,
            )
        assert viewer is not None
        step("making the page")
        target = output or Path(mkdtemp(prefix="spheremap-")) / f"{inputs[0].stem}.html"
        viewer.save(target)
    if output is None:
        print(target)
    if (output is None or open_) and not webbrowser.open(target.resolve().as_uri()):
        raise OSError(f"no browser was found to open {target}; -o FILE writes the page elsewhere")


def _read(path: Path, name: str | None, part: str | None) -> tuple[NDArray[Any], sm.Projection]:
    """Return the colors of a file, of sRGB or linear light, and their map."""
    loaded = picture.load(path, part=part)
    projection = files.taken(name, loaded.projection, *loaded.pixels.shape[:2])
    if loaded.is_light or loaded.color_space != picture.SRGB:
        loaded = picture.as_light(loaded)
    return picture.without_alpha(loaded).pixels, projection
