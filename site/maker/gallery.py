"""The gallery: each picture is made by the program that is shown under it.

The programs lie in site/gallery. Each runs in a folder that holds `sky.exr`, the panorama of
`spheremap demo`, and leaves one picture, of the program's own name.
"""

from __future__ import annotations

import ast
import hashlib
import os
import subprocess
import sys
import tempfile
from io import BytesIO
from pathlib import Path

import numpy as np
import spheremap as sm
from PIL import Image
from spheremap import io
from spheremap.cli.sky import radiance

from .source import ROOT, Source

FOLDER = ROOT / "site" / "gallery"
HEIGHT = 1024

HEAD = """\
# Gallery

Each picture is made by the lines under it, when this site is built. `sky.exr` is a panorama,
2048×1024, of the sky that `spheremap demo` draws; put your own in its place.
"""


def run(program: Path, source: Source) -> bytes:
    """Return the picture that a program leaves; an earlier one of the same program and version."""
    key = hashlib.sha256(program.read_bytes() + sm.__version__.encode()).hexdigest()[:16]
    kept = source.folder.parent / "gallery" / f"{program.stem}-{key}.png"
    if not kept.exists():
        with tempfile.TemporaryDirectory() as folder:
            sky = radiance(sm.directions("latlong", HEIGHT, dtype=np.float32))
            io.write(Path(folder) / "sky.exr", sky.astype(np.float32))
            environment = {**os.environ, "MPLBACKEND": "Agg"}
            command = [sys.executable, "-W", "error", str(program)]
            done = subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, text=True, check=False
            )
            if done.returncode:
                raise SystemExit(f"{program.name} of the gallery failed:\n{done.stderr}")
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_bytes((Path(folder) / f"{program.stem}.png").read_bytes())
    return kept.read_bytes()


def section(program: Path, source: Source) -> str:
    """Return what the page has of a program."""
    text = program.read_text(encoding="utf-8")
    title, _, says = (ast.get_docstring(ast.parse(text)) or "").partition("\n\n")
    code = text.split('"""', 2)[2].strip()
    # All of them are on one page, which is to stay small.
    small = BytesIO()
    with Image.open(BytesIO(run(program, source))) as picture:
        picture.convert("RGB").save(small, "WEBP", quality=90)
    source.write(f"gallery/{program.stem}.webp", small.getvalue())
    says = " ".join(says.split())
    return "\n\n".join(
        [
            f"## {title.rstrip('.')}",
            says,
            f"![{title.rstrip('.')}](gallery/{program.stem}.webp)",
            f"```python\n{code}\n```",
        ]
    )


def make(source: Source) -> None:
    """Write the page, running what has changed."""
    programs = sorted(FOLDER.glob("*.py"))
    source.write("gallery.md", "\n\n".join([HEAD, *(section(p, source) for p in programs)]) + "\n")
