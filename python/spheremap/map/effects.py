"""Whole lookups for shaders, around what `code` prints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from .. import _core
from .._scalars import as_text
from .coding import Precision, code
from .stages import STAGES, Stage

__all__ = ["effect"]

_BEHIND = ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))


@dataclass(frozen=True)
class _Effect:
    """What an effect is made of: verbs of maps, textures, and what stands around them."""

    maps: dict[str, str]
    verbs: tuple[str, ...]
    images: tuple[str, ...]
    body: Callable[[Stage, str], str]


def _image(stage: Stage, name: str, place: str) -> str:
    return stage.look.format(name=name, place=place)


def _sphere_map(stage: Stage, name: str) -> str:
    vertex = stage.define(
        "// For the vertex stage: (u, v) of what a vertex mirrors. `view` goes from it to the eye; "
        "both are\n// of unit length, in a space whose z goes away from the eye.",
        f"{name}_vertex",
        2,
        {"view": 3, "normal": 3},
        [f"{name}_encode({name}_reflect(view, normal))"],
    )
    image = f"{name}_image"
    color = stage.define(
        "// For the pixel stage: the color in (u, v).",
        f"{name}_color",
        4,
        {"uv": 2},
        [_image(stage, image, "uv")],
        (image,),
    )
    return vertex + color


def _color_of(what: str) -> Callable[[Stage, str], str]:
    def body(stage: Stage, name: str) -> str:
        image = f"{name}_image"
        return stage.define(
            f"// The color of {what}; nothing outside the image.",
            f"{name}_color",
            4,
            {"d": 3},
            [
                stage.let(2, "uv", f"{name}_encode(d)"),
                stage.let(4, "color", _image(stage, image, "uv")),
                stage.choose("uv.x >= 0.0", "color", stage.of("0.0", "0.0", "0.0", "0.0")),
            ],
            (image,),
        )

    return body


def _two_balls(stage: Stage, name: str) -> str:
    front, back, middle = f"{name}_front", f"{name}_back", stage.of("0.5", "0.5")
    return stage.define(
        "// The color in a direction, of the ball that shows it nearer to its middle.",
        f"{name}_color",
        4,
        {"d": 3},
        [
            stage.let(2, "front", f"{front}_encode(d)"),
            stage.let(2, "back", f"{back}_encode(d)"),
            stage.let(4, "one", _image(stage, front, "front")),
            stage.let(4, "other", _image(stage, back, "back")),
            stage.let(2, "p", f"front - {middle}"),
            stage.let(2, "q", f"back - {middle}"),
            stage.choose("dot(p, p) <= dot(q, q)", "one", "other"),
        ],
        (front, back),
    )


def _buffer(stage: Stage, name: str) -> str:
    pack = stage.define(
        "// A unit normal as two numbers from 0 to 1, for a target as RG16 or RG8.",
        f"{name}_pack",
        2,
        {"normal": 3},
        [f"{name}_encode(normal)"],
    )
    unpack = stage.define(
        "// The unit normal of what such a target holds.",
        f"{name}_unpack",
        3,
        {"stored": 2},
        [f"{name}_decode(stored)"],
    )
    return pack + unpack


_EFFECTS = {
    "sphere_map": _Effect({"": "sphere:d3d"}, ("encode", "reflect"), ("image",), _sphere_map),
    "matcap": _Effect({"": "matcap"}, ("encode",), ("image",), _color_of("a normal in view space")),
    "light_probe": _Effect(
        {"": "angular:debevec"}, ("encode",), ("image",), _color_of("a direction in the world")
    ),
    "mirror_balls": _Effect(
        {"_front": "sphere", "_back": "sphere"}, ("encode",), ("front", "back"), _two_balls
    ),
    "gbuffer": _Effect({"": "octahedral"}, ("encode", "decode"), (), _buffer),
}

EFFECTS = tuple(_EFFECTS)


def effect(
    effect: Literal["sphere_map", "matcap", "light_probe", "mirror_balls", "gbuffer"] | str,
    language: Literal["hlsl", "slang", "glsl", "glsl_es", "wgsl", "msl"] | str,
    *,
    name: str | None = None,
    precision: Precision = "exact",
) -> str:
    """Return a whole lookup as functions of a shading language, with its textures.

    What is between the texture and the surface is what `code` prints, so that a picture that
    `convert` made is seen as `sample` sees it.

    Parameters
    ----------
    effect : {"sphere_map", "matcap", "light_probe", "mirror_balls", "gbuffer"}
        "sphere_map" is that of Direct3D: `vertex` gives the (u, v) that a vertex mirrors, `color`
        looks them up. "matcap" gives the color of a normal in view space, "light_probe" that of a
        direction in an angular map. "mirror_balls" looks up two pictures of a mirror ball, seen
        from +z and from -z, where neither shows its rim. "gbuffer" has `pack` and `unpack` of unit
        normals, octahedral.
    language : {"hlsl", "slang", "glsl", "glsl_es", "wgsl", "msl"}
        What has stages. Functions of WGSL and MSL take their textures, those of WGSL samplers, too.
    name : str, optional
        What names begin with; that of the effect where nothing is said.
    precision : {"exact", "native"}
        As for `code`.

    Returns
    -------
    str
        Source text: functions, and textures that want linear filters and clamped coordinates; in
        HLSL and MSL the state of samplers says so.

    Raises
    ------
    ValueError, TypeError
        For names that are unknown or that the language does not take.

    Examples
    --------
    >>> import spheremap as sm
    >>> text = sm.effect("matcap", "hlsl")
    >>> [line for line in text.splitlines() if line.startswith(("Texture", "float4"))]
    ['Texture2D matcap_image;', 'float4 matcap_color(float3 d) {']
    """
    chosen = as_text(effect, "effect")
    _core.check_word("effect", chosen, list(EFFECTS))
    language = as_text(language, "language")
    _core.check_word("language", language, list(STAGES))
    prefix = chosen if name is None else as_text(name, "name")
    made, stage = _EFFECTS[chosen], STAGES[language]
    texts = [
        code(
            projection,
            language,
            verbs=made.verbs,
            name=f"{prefix}{end}",
            precision=precision,
            rotation=_BEHIND if end == "_back" else None,
        )
        for end, projection in made.maps.items()
    ]
    for image in made.images:
        texture = f"{prefix}_{image}"
        texts.append(f"\n{stage.sampler}{stage.texture.format(name=texture)}")
    return "".join([*texts, made.body(stage, prefix)])
