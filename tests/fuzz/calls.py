"""What is called: every public function, and the methods of what they return."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from random import Random
from typing import Any

import spheremap as sm

from .values import PROJECTIONS, Choice, literal_words, projection

SUBJECTS = ("light", "sh", "packing", "healpix", "ball", "cameras", "align", "tiles", "io", "video")
# Records that a user reads and nothing computes with.
RECORDS = {"Bake", "Energy", "Light", "Lights", "MergedBalls", "UnwrappedBall", "Packing", "Sun"}
RECORDS |= {"Candidate", "Comparison", "Identification", "Projections", "UnboundedPackingWarning"}
RECORDS |= {"Ball", "Pyramid", "View", "Converted"}
# Whose methods are called as well, and how one is made.
OBJECTS: dict[str, Callable[[Choice], str]] = {
    "Projection": lambda c: c.of(
        f"sm.projection({c.projection!r})", f"sm.projection({projection(c)})"
    ),
    "RemapPlan": lambda c: f"sm.remap_plan({c.projection!r}, {c.of(*PROJECTIONS)!r}, size=4)",
    "cameras.Rig": lambda c: "sm.cameras.rig(8, fov=100)",
    "light.Distribution": lambda c: "sm.light.Distribution(np.ones((4, 8)), 'latlong')",
    "viewer.Viewer": lambda c: "sm.view(np.ones((4, 8)), 'latlong')",
}
# They take long: one call in so many of those that would be chosen.
RARE = {"ball.merge": 10, "ball.find": 4, "align.identify": 4, "light.bake": 4, "cameras.rig": 4}
# Without these a call is a large one.
ALWAYS = {"size", "diffuse_size", "samples", "order", "step"}


@dataclass(frozen=True)
class Target:
    """One function, and what it is called on."""

    name: str
    parameters: tuple[inspect.Parameter, ...]
    owner: str | None = None


@cache
def targets() -> tuple[Target, ...]:
    """Return what is public and can be called."""
    found = []
    for room in ("", *SUBJECTS):
        module = import_module(f"spheremap.{room}") if room else sm
        for name in module.__all__:
            thing = getattr(module, name)
            if callable(thing) and name not in RECORDS:
                found.append(Target(f"{room}.{name}".lstrip("."), _parameters(thing)))
    for owner in OBJECTS:
        found += _methods(owner)
    return tuple(found)


def _methods(owner: str) -> list[Target]:
    thing: Any = sm
    for part in owner.split("."):
        thing = getattr(thing, part)
    names = [n for n in dir(thing) if not n.startswith("_") and callable(getattr(thing, n))]
    if "__call__" in vars(thing):
        names.append("__call__")
    return [Target(n, _parameters(getattr(thing, n))[1:], owner) for n in names]


def _parameters(thing: Any) -> tuple[inspect.Parameter, ...]:
    return tuple(inspect.signature(thing).parameters.values())


@cache
def words() -> tuple[str, ...]:
    """Return the strings that are names of something, and some that are of nothing."""
    annotations = [
        p.annotation
        for target in targets()
        for p in target.parameters
        if p.annotation is not p.empty
    ]
    return (*literal_words(annotations), "mitsuba", "orthonormal", "aluminum", "zip", "nothing", "")


def call(seed: int, index: int) -> str:
    """Return one call, as a line of Python."""
    random = Random(f"{seed} {index}")
    target = random.choice(targets())
    while random.random() > 1 / RARE.get(target.name, 1):
        target = random.choice(targets())
    choice = Choice(random, random.choice(PROJECTIONS), words())
    arguments = []
    for p in target.parameters:
        arguments += _argument(choice, p, ", ".join(arguments))
    place = f"({OBJECTS[target.owner](choice)})" if target.owner else "sm"
    return f"{place}.{target.name}({', '.join(arguments)})"


def _argument(choice: Choice, p: inspect.Parameter, before: str) -> list[str]:
    if p.kind is p.VAR_KEYWORD:
        return [f"{choice.of('fov', 'filter', 'x', 'fill')}={choice.hostile()}"] * choice.chance(
            0.1
        )
    if p.kind is p.VAR_POSITIONAL:
        return []
    needed = p.default is p.empty or p.name in ALWAYS
    if not needed and not choice.chance(0.25):
        return []
    text = choice.argument(p.name, str(p.annotation))
    if not before and text.startswith("np.") and choice.chance(0.2):
        choice.made["first"] = text
        text = f"(first := {text})"
    by_position = p.default is p.empty and p.kind is not p.KEYWORD_ONLY
    return [text if by_position or p.kind is p.POSITIONAL_ONLY else f"{p.name}={text}"]
