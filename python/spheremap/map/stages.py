"""What shading languages with stages spell differently: functions, names, choices, textures."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["STAGES", "Stage"]


@dataclass(frozen=True)
class Stage:
    """How a language writes what stands around `code`; the fields are templates."""

    vector: str
    # What stands before the functions, for each texture.
    texture: str
    # The color of a texture at a place.
    look: str
    # What a function takes for each texture, where textures are no global names.
    taken: str = ""
    sampler: str = "// Wants a linear filter and clamped coordinates.\n"
    function: str = "{gives} {name}({takes}) {{"
    argument: str = "{kind} {name}"
    local: str = "{kind} {name} = {value};"
    choice: str = "{condition} ? {a} : {b}"

    def of(self, *numbers: str) -> str:
        """Return a vector of numbers."""
        return f"{self.kind(len(numbers))}({', '.join(numbers)})"

    def kind(self, width: int) -> str:
        """Return the type of a vector."""
        return self.vector.format(width)

    def let(self, width: int, name: str, value: str) -> str:
        """Return the statement that names a vector."""
        return self.local.format(kind=self.kind(width), name=name, value=value)

    def choose(self, condition: str, a: str, b: str) -> str:
        """Return one value or another."""
        return self.choice.format(condition=condition, a=a, b=b)

    def define(
        self,
        doc: str,
        name: str,
        gives: int,
        takes: dict[str, int],
        lines: list[str],
        textures: tuple[str, ...] = (),
    ) -> str:
        """Return a function of vectors, below what it is; the last line is what it returns."""
        textures = textures if self.taken else ()
        arguments = [self.taken.format(name=texture) for texture in textures]
        arguments += [
            self.argument.format(kind=self.kind(width), name=argument)
            for argument, width in takes.items()
        ]
        head = self.function.format(gives=self.kind(gives), name=name, takes=", ".join(arguments))
        *lines, last = lines
        body = "".join(f"    {line}\n" for line in [*lines, f"return {last};"])
        return f"\n{doc}\n{head}\n{body}}}\n"


_GLSL = Stage(
    vector="vec{}", texture="uniform sampler2D {name};\n", look="texture({name}, {place})"
)
_SAMPLED = "{name}.Sample({name}_sampler, {place})"

STAGES = {
    # The state is read by Direct3D's effects; other compilers leave it to the program.
    "hlsl": Stage(
        vector="float{}",
        texture="Texture2D {name};\nSamplerState {name}_sampler {{\n"
        "    Filter = MIN_MAG_MIP_LINEAR;\n    AddressU = Clamp;\n    AddressV = Clamp;\n}};\n",
        look=_SAMPLED,
    ),
    "slang": Stage(
        vector="float{}",
        texture="Texture2D<float4> {name};\nSamplerState {name}_sampler;\n",
        look=_SAMPLED,
    ),
    "glsl": _GLSL,
    "glsl_es": _GLSL,
    # Textures have a place in a layout, or among the arguments of a stage, which the program knows.
    "wgsl": Stage(
        vector="vec{}<f32>",
        texture="",
        look="textureSample({name}, {name}_sampler, {place})",
        taken="{name}: texture_2d<f32>, {name}_sampler: sampler",
        function="fn {name}({takes}) -> {gives} {{",
        argument="{name}: {kind}",
        local="let {name} = {value};",
        choice="select({b}, {a}, {condition})",
    ),
    "msl": Stage(
        vector="float{}",
        texture="constexpr sampler {name}_sampler(filter::linear, address::clamp_to_edge);\n",
        look="{name}.sample({name}_sampler, {place})",
        taken="texture2d<float> {name}",
        sampler="",
        function="static inline {gives} {name}({takes}) {{",
    ),
}
