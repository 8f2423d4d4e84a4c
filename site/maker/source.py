"""The folder that Sphinx reads: laid out as the checkout is, so that links of its pages hold."""

from __future__ import annotations

import io
from pathlib import Path

from PIL import Image

# A picture that is worth to be packed anew.
LARGE = 100_000
ROOT = Path(__file__).resolve().parents[2]


class Source:
    """Pages and files by their place. What stays the same is not written, so Sphinx keeps it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.made: set[Path] = set()

    def write(self, place: str, content: str | bytes) -> Path:
        """Put a text or bytes at a place."""
        path = self.folder / place
        data = content.encode() if isinstance(content, str) else content
        self.made.add(path)
        if not path.exists() or path.read_bytes() != data:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        return path

    def copy(self, path: Path, place: str) -> Path:
        """Put a file of the checkout at a place."""
        data = path.read_bytes()
        if path.suffix == ".png" and len(data) > LARGE:
            data = packed(data)
        return self.write(place, data)

    def forget_others(self) -> None:
        """Remove what an earlier build has left and this one has not made."""
        for path in sorted(self.folder.rglob("*"), reverse=True):
            if path.is_dir():
                if not any(path.iterdir()):
                    path.rmdir()
            elif path not in self.made:
                path.unlink()


def packed(data: bytes) -> bytes:
    """Return a PNG with the same pixels in fewer bytes."""
    target = io.BytesIO()
    with Image.open(io.BytesIO(data)) as picture:
        picture.save(target, "PNG", optimize=True)
    return min(data, target.getvalue(), key=len)


def toctree(entries: list[str]) -> str:
    """Return a hidden table of contents."""
    return "\n".join(["```{toctree}", ":hidden:", "", *entries, "```", ""])
