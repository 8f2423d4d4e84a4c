"""Open Shading Language in Blender's Cycles, which runs in a Python of its own.

SPHEREMAP_BLENDER names that Python; `make test-programs` makes one.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import numpy as np

from . import openimageio_oracle, osl_render

SIZE = osl_render.SIZE
SHADER = """{text}
shader look(output closure color Out = 0) {{
    color row = texture("{given}", P[0] / {size}, 1.0 - P[1] / {size}, "interp", "closest");
    vector given = vector(row[0], row[1], row[2]);
    vector r = vector(0.0, 0.0, 0.0);
    {call}
    Out = emission() * color(r[0], r[1], r[2]);
}}
"""


class Shading:
    """A Blender that shades rows."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._names = (folder / str(k) for k in count())
        self._said = (folder / "said.txt").open("w+")
        command = [os.environ["SPHEREMAP_BLENDER"], osl_render.__file__]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=self._said, text=True, cwd=folder
        )

    def run(self, text: str, call: str, rows: np.ndarray) -> np.ndarray:
        """Return (n, 3) float32: what a call of printed code puts into r for each row, `given`."""
        name = str(next(self._names))
        given = np.zeros((SIZE * SIZE, 3), np.float32)
        given[: len(rows), : rows.shape[1]] = rows
        # Cycles keeps textures that it has read: each has a name of its own.
        path = openimageio_oracle.write(given.reshape(SIZE, SIZE, 3), Path(f"{name}-in.exr"))
        shader = SHADER.format(text=text, given=path, call=call, size=float(SIZE))
        Path(f"{name}.osl").write_text(shader)
        print(f"{name}.osl {name}.exr", file=self.process.stdin, flush=True)
        for line in self.process.stdout or ():
            if line == "rendered\n":
                break
        else:
            raise RuntimeError((self._folder / "said.txt").read_text())
        made = openimageio_oracle.read(Path(f"{name}.exr"))[..., :3].reshape(-1, 3)
        for file in self._folder.glob(f"{Path(name).name}[.-]*"):
            file.unlink()
        return np.ascontiguousarray(made[: len(rows)])

    def close(self) -> None:
        """End it."""
        if self.process.stdin and self.process.stdout:
            self.process.stdin.close()
            self.process.stdout.read()
            self.process.stdout.close()
        self.process.wait()
        self._said.close()


@contextmanager
def shading(folder: Path) -> Iterator[Shading]:
    """Give a Blender, and end it."""
    blender = Shading(folder)
    yield blender
    blender.close()
