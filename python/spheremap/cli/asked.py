"""What the command line can ask of a conversion, and what does not go together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import typer

from spheremap.cli import files, sizes, targets
from spheremap.cli.conversion import Options
from spheremap.cli.large import IDLE
from spheremap.cli.lengths import as_bytes
from spheremap.cli.options import (
    AnyAspect,
    ColorSpace,
    FromSaid,
    Height,
    Lookup,
    Memory,
    NoClobber,
    OneLookup,
    Part,
    Rotation,
    Size,
    Width,
    World,
    finite,
)
from spheremap.cli.terminal import UsageError, as_usage, check_projection, refuse
from spheremap.io.images import STORED, TEXTURES
from spheremap.io.tonemap import Curve
from spheremap.map.flat import flat


@dataclass(frozen=True, kw_only=True)
class Asked:
    """The options of every command that converts files as `convert` does."""

    to: Annotated[str, typer.Option("--to", metavar="NAME", help="Projection of OUT.")]
    from_: FromSaid = None
    height: Height = None
    width: Width = None
    size: Size = None
    layout: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="How OUT lays out its faces; faces for a file each, as out_{face}.png. "
            "[default: cross or strip]",
        ),
    ] = None
    from_layout: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="How IN lays out its faces. [by default from its size]"),
    ] = None
    face_names: Annotated[
        Literal["px", "posx", "0"],
        typer.Option(help="How {face} is written: px nx py ..., posx negx ..., or 0 1 2 ..."),
    ] = "px"
    rotate: Rotation = (0.0, 0.0, 0.0)
    world: World = "match"
    face_sun: Annotated[
        bool, typer.Option("--face-sun", help="Turn the sun to the center of OUT.")
    ] = False
    filter: Lookup = "bilinear"
    fill: Annotated[float, typer.Option(metavar="X", help="Value where nothing is known.")] = 0.0
    alias: OneLookup = False
    alpha: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Weight colors by this channel, from 0; -1 for the last. "
            "[by default by straight alpha]",
        ),
    ] = None
    skipna: Annotated[
        bool, typer.Option("--skipna", help="Leave NaN and infinite texels out of every mean.")
    ] = False
    channels: Annotated[
        str | None, typer.Option(metavar="NAMES", help="Keep these channels, as R,G,B.")
    ] = None
    drop_alpha: Annotated[bool, typer.Option("--drop-alpha", help="Keep no alpha.")] = False
    half: Annotated[bool, typer.Option("--half", help="Write half floats.")] = False
    float_: Annotated[bool, typer.Option("--float", help="Write floats of 32 bits.")] = False
    bits: Annotated[
        int | None, typer.Option(metavar="N", help="Write integers of 8 or 16 bits.")
    ] = None
    colorspace: ColorSpace = None
    tonemap: Annotated[Curve, typer.Option(help="How floats become integers; none cuts at 1.")] = (
        "none"
    )
    exposure: Annotated[
        float,
        typer.Option(
            metavar="STOPS",
            callback=finite,
            help="Of floats in .png and .jpg, and of a preview.",
        ),
    ] = 0.0
    compression: Annotated[
        str | None, typer.Option(metavar="NAME", help="As zip, piz or dwaa:45 for .exr.")
    ] = None
    mips: Annotated[
        bool, typer.Option("--mips", help="Write all mips: .ktx2 and .dds hold them.")
    ] = False
    part: Part = None
    any_aspect: AnyAspect = False
    no_clobber: NoClobber = False
    memory: Memory = None
    resume: Annotated[
        bool, typer.Option("--resume", help="With --memory: go on where this was cut off.")
    ] = False

    def check_names(self) -> None:
        """Raise a usage error for a name that is no projection's."""
        for name in (self.to, self.from_):
            if name is not None:
                check_projection(name)

    def options(
        self,
        context: typer.Context,
        outputs: Sequence[Path],
        *,
        stdout: str | None = None,
        preview: Path | None = None,
        verbose: bool = False,
    ) -> Options:
        """Return what is asked for, or raise a usage error for what does not go together."""
        textures = all(out.suffix.lower() in TEXTURES for out in outputs)
        with as_usage():
            whole = self.layout == "faces" or (textures and self.layout is None)
            dst = files.of_faces(self.to) if whole else flat(self.to, self.layout)
            if self.from_ is not None and self.from_layout is not None:
                flat(self.from_, self.from_layout)
            wanted = sizes.wanted(dst, self.height, self.width, self.size)
        _check_together(
            {"--half": self.half, "--float": self.float_, "--bits": self.bits is not None},
            {"--channels": self.channels is not None, "--drop-alpha": self.drop_alpha},
            {"--rotation": any(self.rotate), "--face-sun": self.face_sun},
            {"--tonemap": self.tonemap != "none", "--bits 16": self.bits == 16},
        )
        if self.bits not in (None, 8, 16):
            raise UsageError(f"--bits is 8 or 16, got {self.bits}")
        if self.memory is None:
            refuse(context, ["resume"], "without --memory")
        else:
            refuse(context, IDLE, "with --memory")
        targets.check_outputs(outputs, self.layout, dst.faces)
        floats_only = textures or _holds_floats(outputs, self.bits, stdout)
        _refuse_idle(context, outputs, floats_only=floats_only, shown=preview is not None)
        return Options(
            from_=self.from_, from_layout=self.from_layout, to=self.to, dst=dst, size=wanted,
            face_names=self.face_names, rotate=self.rotate, face_sun=self.face_sun,
            filter=self.filter, fill=self.fill, alias=self.alias, alpha=self.alpha,
            skipna=self.skipna,
            channels=None if self.channels is None else self.channels.split(","),
            drop_alpha=self.drop_alpha, half=self.half, single=self.float_, bits=self.bits,
            color_space=self.colorspace, tonemap=self.tonemap, exposure=self.exposure,
            preview=preview, compression=self.compression, mips=self.mips, part=self.part,
            any_aspect=self.any_aspect, no_clobber=self.no_clobber, verbose=verbose,
            world=self.world, resume=self.resume,
            memory=None if self.memory is None else as_bytes("--memory", self.memory),
        )  # fmt: skip


def _check_together(*groups: dict[str, bool]) -> None:
    """Raise a usage error where two options of a group are given."""
    for group in groups:
        given = [name for name, is_given in group.items() if is_given]
        if len(given) > 1:
            raise UsageError(f"give {given[0]} or {given[1]}, not both")


def _holds_floats(outputs: Sequence[Path], bits: int | None, stdout: str | None) -> bool:
    """Tell whether nothing but floats will be written, whatever the inputs are."""
    suffixes = [stdout] if stdout else {out.suffix.lower() for out in outputs}
    kinds = [kind for suffix in suffixes for kind in STORED.get(suffix, ())]
    return bits is None and all(kind.startswith("float") for kind in kinds)


def _refuse_idle(
    context: typer.Context, outputs: Sequence[Path], *, floats_only: bool, shown: bool
) -> None:
    """Raise a usage error for an option that does nothing for these outputs."""
    textures = [out.suffix.lower() in TEXTURES for out in outputs]
    if floats_only:
        refuse(context, ["tonemap"], "where floats are written")
        if not shown:
            refuse(context, ["exposure"], "where floats are written")
    if all(textures):
        why = "in .ktx2 and .dds, which hold half floats"
        refuse(context, ["compression", "half", "float_", "bits"], why)
    if not any(textures):
        refuse(context, ["mips"], "but in .ktx2 and .dds")
    if not any(targets.has_faces(out) for out in outputs):
        refuse(context, ["face_names"], "without {face} in the name of OUT")
