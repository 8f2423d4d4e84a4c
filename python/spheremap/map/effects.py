"""Whole lookups for shaders, around what `code` prints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .. import _core
from .._scalars import as_text
from .coding import Precision, code

__all__ = ["effect"]

# What the languages of stages spell differently: vectors, and textures with their samplers.
_VECTORS = {"hlsl": "float", "glsl": "vec", "glsl_es": "vec"}
_BEHIND = ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))
_COLOR = """
// The color in (u, v).
{vec}4 {name}_color({vec}2 uv) {{
    return {image};
}}
"""
_DIRECTION = """
// The color of {what}; nothing outside the image.
{vec}4 {name}_color({vec}3 d) {{
    {vec}2 uv = {name}_encode(d);
    {vec}4 color = {image};
    return uv.x >= 0.0 ? color : {vec}4(0.0, 0.0, 0.0, 0.0);
}}
"""
_VERTEX = """
// For the vertex stage: (u, v) of what a vertex mirrors. `view` goes from it to the eye; both are
// of unit length, in a space whose z goes away from the eye.
{vec}2 {name}_vertex({vec}3 view, {vec}3 normal) {{
    return {name}_encode({name}_reflect(view, normal));
}}
"""
_BALLS = """
// The color in a direction, of the ball that shows it nearer to its middle.
{vec}4 {name}_color({vec}3 d) {{
    {vec}2 front = {name}_front_encode(d);
    {vec}2 back = {name}_back_encode(d);
    {vec}4 one = {front};
    {vec}4 other = {back};
    {vec}2 p = front - {vec}2(0.5, 0.5);
    {vec}2 q = back - {vec}2(0.5, 0.5);
    return dot(p, p) <= dot(q, q) ? one : other;
}}
"""
_BUFFER = """
// A unit normal as two numbers from 0 to 1, for a target as RG16 or RG8.
{vec}2 {name}_pack({vec}3 normal) {{
    return {name}_encode(normal);
}}

// The unit normal of what such a target holds.
{vec}3 {name}_unpack({vec}2 stored) {{
    return {name}_decode(stored);
}}
"""


@dataclass(frozen=True)
class _Effect:
    """What an effect is made of: verbs of maps, textures, and what stands around them."""

    maps: dict[str, str]
    verbs: tuple[str, ...]
    images: tuple[str, ...]
    body: str
    what: str = ""


_EFFECTS = {
    "sphere_map": _Effect({"": "sphere:d3d"}, ("encode", "reflect"), ("image",), _VERTEX + _COLOR),
    "matcap": _Effect(
        {"": "matcap"}, ("encode",), ("image",), _DIRECTION, "a normal in view space"
    ),
    "light_probe": _Effect(
        {"": "angular:debevec"}, ("encode",), ("image",), _DIRECTION, "a direction in the world"
    ),
    "mirror_balls": _Effect(
        {"_front": "sphere", "_back": "sphere"}, ("encode",), ("front", "back"), _BALLS
    ),
    "gbuffer": _Effect({"": "octahedral"}, ("encode", "decode"), (), _BUFFER),
}

EFFECTS = tuple(_EFFECTS)


def effect(
    effect: Literal["sphere_map", "matcap", "light_probe", "mirror_balls", "gbuffer"] | str,
    language: Literal["hlsl", "glsl", "glsl_es"] | str,
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
    language : {"hlsl", "glsl", "glsl_es"}
        Of what has stages.
    name : str, optional
        What names begin with; that of the effect where nothing is said.
    precision : {"exact", "native"}
        As for `code`.

    Returns
    -------
    str
        Source text: textures that want linear filters and clamped coordinates, and functions.

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
    _core.check_word("language", language, list(_VECTORS))
    prefix = chosen if name is None else as_text(name, "name")
    made = _EFFECTS[chosen]
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
    words = {"vec": _VECTORS[language], "name": prefix, "what": made.what}
    for image in made.images:
        texture = f"{prefix}_{image}"
        place = image if len(made.images) > 1 else "uv"
        if language == "hlsl":
            texts.append(f"\nTexture2D {texture};\nSamplerState {texture}_sampler;\n")
            words[image] = f"{texture}.Sample({texture}_sampler, {place})"
        else:
            texts.append(f"\nuniform sampler2D {texture};\n")
            words[image] = f"texture({texture}, {place})"
    return "".join([*texts, made.body.format(**words)])
