"""The rules of docs/architecture.md, held over every public signature."""

from __future__ import annotations

import inspect
import re
from importlib import import_module

import pytest
import spheremap as sm

SUBJECTS = (
    "light",
    "sh",
    "packing",
    "healpix",
    "ball",
    "cameras",
    "align",
    "tiles",
    "io",
    "plot",
    "video",
)


def public():
    rooms = {"spheremap": sm} | {name: import_module(f"spheremap.{name}") for name in SUBJECTS}
    for room, module in rooms.items():
        for name in module.__all__:
            thing = getattr(module, name)
            if inspect.isfunction(thing):
                yield f"{room}.{name}", thing


FUNCTIONS = dict(public())
FUNCTIONS["light.Distribution"] = sm.light.Distribution
PROJECTIONS = ("projection", "src", "dst")
# What a call cannot do without, and what it is asked about.
POSITIONAL = {"size", "n", "rotation", "image", "a", "b", "language", "folder"}
# In these the world of the projection is of no account: places in the image and amounts of light.
WORLDLESS = {
    "spheremap.density",
    "spheremap.explain",
    "spheremap.mipmaps",
    "spheremap.pad",
    "spheremap.convert_depth",
    "spheremap.solid_angle",
    "spheremap.valid",
    "light.integrate",
    "light.mean",
    "light.weights",
    "light.ws_psnr",
    "plot.chain",
    "plot.density_map",
    "plot.lights",
    "plot.packing_error",
    "plot.show",
    "plot.tissot",
    # A camera's, which is `pose`.
    "ball.render",
    "ball.unwrap",
    "ball.merge",
    "light.bake_matcap",
}
# Options elsewhere; what these are about.
DATA = {
    ("sh.rotate", "rotation"),
    ("sh.lobe", "lobe"),
    ("io.write_dds", "levels"),
    ("io.write_ktx2", "levels"),
}
with_projection = [
    name
    for name, function in FUNCTIONS.items()
    if any(
        p.name in PROJECTIONS and "ProjectionLike" in str(p.annotation)
        for p in inspect.signature(function).parameters.values()
    )
]


def parameters(name):
    return inspect.signature(FUNCTIONS[name]).parameters


def test_the_walk_sees_the_library():
    assert len(FUNCTIONS) > 60 and len(with_projection) > 30


@pytest.mark.parametrize("name", with_projection)
def test_data_then_projections_then_options(name):
    seen = [p for p in parameters(name).values() if p.kind is not p.VAR_KEYWORD]
    first = min(k for k, p in enumerate(seen) if p.name in PROJECTIONS)
    for k, p in enumerate(seen):
        if p.name in PROJECTIONS:
            # Photos have no projection: there `dst` says what is made of them.
            wanted = p.KEYWORD_ONLY if name.startswith("ball.") and p.name == "dst" else None
            assert p.kind is (wanted or p.POSITIONAL_OR_KEYWORD), p
        elif p.kind is p.POSITIONAL_ONLY:
            assert k < first or name.startswith("ball."), p
        elif p.kind is p.POSITIONAL_OR_KEYWORD:
            assert p.name in POSITIONAL and k > first, p
        else:
            assert p.kind is p.KEYWORD_ONLY, p


@pytest.mark.parametrize("name", with_projection)
def test_rotation_wherever_a_world_matters(name):
    assert ("rotation" in parameters(name)) is (name not in WORLDLESS)


@pytest.mark.parametrize("name", with_projection)
def test_world_wherever_two_maps_meet(name):
    given = parameters(name)
    if {"src", "dst"} <= set(given):
        # `remap_plan` and `embed` hand it to `convert` with all the rest.
        assert "world" in given or "options" in given


# Where a shape is no claim about a map: figures, photos, and what is to be told.
FREE = {name for name in with_projection if name.startswith("plot.")}


@pytest.mark.parametrize("name", with_projection)
def test_every_verb_of_an_image_checks_aspects(name):
    given = parameters(name)
    shaped = {"image", "view", "depth", "size"} & set(given)
    if shaped and name not in FREE:
        # `remap_plan` hands it to `convert` with all the rest.
        assert "any_aspect" in given or "options" in given
        if {"image", "view", "depth"} & set(given):
            assert "channels_first" in given
        for word in {"any_aspect", "channels_first"} & set(given):
            assert given[word].default is False and given[word].kind is given[word].KEYWORD_ONLY


@pytest.mark.parametrize("name", list(FUNCTIONS))
def test_one_word_for_one_thing(name):
    given = parameters(name)
    assert "shape" not in given and "into" not in given and "environment" not in given
    if "fill" in given:
        assert given["fill"].default == 0.0
        assert given["fill"].annotation == "float | Sequence[float]"
    for word in ("order", "levels", "roughness", "count", "lobe", "filter", "rotation", "axes"):
        if word in given and (name, word) not in DATA:
            assert given[word].kind is inspect.Parameter.KEYWORD_ONLY, word


@pytest.mark.parametrize("name", with_projection)
def test_documentation_is_whole(name):
    text = inspect.getdoc(FUNCTIONS[name]) or ""
    wanted = ["Parameters", "Raises", "Examples"]
    # A class has no Returns.
    if inspect.isfunction(FUNCTIONS[name]) and name != "spheremap.explain":
        wanted.append("Returns")
    for head in wanted:
        assert re.search(rf"^{head}\n-+$", text, re.M), head
    section = re.split(r"\n\n[A-Z][a-z]+\n-+\n", text)[1:]
    described = re.findall(r"^([\w*, ]+?)(?: :.*)?$", section[0] if section else text, re.M)
    words = {word.strip(" *") for line in described for word in line.split(",")}
    assert set(parameters(name)) <= words, set(parameters(name)) - words


# Methods whose functions have other names.
RENAMED = {"plan": ("spheremap.remap_plan"), "sh_project": "sh.project"}


def method_and_function():
    for name, method in vars(sm.Projection).items():
        if name.startswith("_") or name in ("turned", "in_world_of", "shape", "explain"):
            continue
        for room in ("spheremap", "light"):
            if f"{room}.{name}" in FUNCTIONS:
                yield name, method, FUNCTIONS[f"{room}.{name}"]
                break
        else:
            yield name, method, FUNCTIONS[RENAMED[name]]


@pytest.mark.parametrize("name, method, function", list(method_and_function()))
def test_a_method_is_its_function_with_the_projection_given(name, method, function):
    ours = list(inspect.signature(method).parameters.values())[1:]
    theirs = list(inspect.signature(function).parameters.values())
    given = "src" if any(p.name == "src" for p in theirs) else "projection"
    assert ours == [p for p in theirs if p.name != given]
    text = inspect.getdoc(method) or ""
    for head in ("Returns", "Raises", "Examples"):
        assert re.search(rf"^{head}\n-+$", text, re.M), head


def test_every_verb_of_an_image_is_a_method():
    # What takes one projection, or makes an image of one projection from one of another.
    verbs = {"encode", "decode", "jacobian", "density", "valid", "covers", "directions"}
    verbs |= {"solid_angle", "sample", "convert", "pad", "embed", "mipmaps", "plan", "integrate"}
    verbs |= {"mean", "irradiance", "sh_project", "turned", "in_world_of", "explain", "shape"}
    assert verbs <= set(vars(sm.Projection))
