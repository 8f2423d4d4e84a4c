"""The subcommand `spheremap view`: images as a page to look around in."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from tempfile import mkdtemp
from typing import Annotated, Any

import typer

import spheremap as sm
from spheremap import _core
from spheremap.cli import files, picture
from spheremap.cli.options import FromGuess, Part
from spheremap.cli.terminal import as_usage, check_projection, progress

# Settings of `view` that are drawn over images, and what is found in the first one.
_SETTINGS = {"graticule": 30.0} | dict.fromkeys(
    ("axes", "isolines", "clipping", "valid", "density", "tissot", "seams"), True
)
_FOUND = ("lights", "sun")
_LIGHTS = 32


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
    overlay: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help=f"What is drawn over it, as graticule,lights: {', '.join([*_SETTINGS, *_FOUND])}.",
            show_default=False,
        ),
    ] = "",
    false_color: Annotated[
        bool, typer.Option("--false-color", help="Colors for stops of luminance.")
    ] = False,
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
    drawn = [word.strip() for word in overlay.split(",") if word.strip()]
    for word in drawn:
        with as_usage():
            _core.check_word("overlay", word, [*_SETTINGS, *_FOUND])
    settings: dict[str, Any] = {word: _SETTINGS[word] for word in drawn if word in _SETTINGS}
    with progress(len(inputs)) as step:
        viewer = None
        for path in inputs:
            step(f"reading {path.name}")
            loaded, projection = _read(path, from_, part)
            pixels = loaded.pixels
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
                false_color=false_color,
                **settings,
            )
            _draw_lights(viewer, loaded, projection, drawn)
        assert viewer is not None
        step("making the page")
        target = output or Path(mkdtemp(prefix="spheremap-")) / f"{inputs[0].stem}.html"
        viewer.save(target)
    if output is None:
        print(target)
    if (output is None or open_) and not webbrowser.open(target.resolve().as_uri()):
        raise OSError(f"no browser was found to open {target}; -o FILE writes the page elsewhere")


def _draw_lights(
    viewer: Any, loaded: picture.Picture, projection: sm.Projection, drawn: list[str]
) -> None:
    """Draw what is found in the first image."""
    if not set(drawn) & set(_FOUND):
        return
    light = picture.as_light(loaded).pixels
    if "lights" in drawn:
        found = sm.light.lights(light, projection, count=_LIGHTS, negative="clip", skipna=True)
        viewer.lights(found)
    if "sun" in drawn:
        sun = sm.light.sun(light, projection)
        if sun is not None:
            viewer.lights(sun)


def _read(path: Path, name: str | None, part: str | None) -> tuple[picture.Picture, sm.Projection]:
    """Return the colors of a file, of sRGB or linear light, and their map."""
    loaded = picture.load(path, part=part)
    projection = files.taken(name, loaded.projection, *loaded.pixels.shape[:2])
    if loaded.is_light or loaded.color_space != picture.SRGB:
        loaded = picture.as_light(loaded)
    return picture.without_alpha(loaded), projection
