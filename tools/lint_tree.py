"""Hold the tree in docs/architecture.md to the disk.

python tools/lint_tree.py            fail where the page and the checkout differ
python tools/lint_tree.py --write    rewrite the block, keeping remarks and order

The block lists every folder and file that lies directly in a root, and, in a folder whose files it
lists at all, every one of these. A folder needs a remark: what is it for?
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "architecture.md"
BEGIN = "<!-- tree: held to the disk by tools/lint_tree.py -->"
END = "<!-- end of tree -->"
ROOTS = ("src", "python/spheremap", "tests", "docs", "benches", "tools", "site")
COLUMN = 27


@dataclass
class Entry:
    """One name of the tree. A folder's entries are None where the block does not list them."""

    remark: str = ""
    line: int = 0
    entries: dict[str, Entry] | None = None


@dataclass
class Disk:
    """The files of a checkout, by folder."""

    folders: dict[str, set[str]] = field(default_factory=dict)

    def __init__(self, files: list[str]) -> None:
        self.folders = {}
        for file in files:
            path = PurePosixPath(file)
            for child, parent in zip([path, *path.parents], path.parents, strict=False):
                name = child.name + ("/" if child != path else "")
                self.folders.setdefault(str(parent), set()).add(name)


def tracked(root: Path) -> list[str]:
    """Return the files that git knows, or will know once they are added."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    run = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True)
    return [line for line in run.stdout.splitlines() if (root / line).exists()]


def parsed(block: str, first: int = 1) -> dict[str, Entry]:
    """Return the tree that an indented block describes, two spaces a level."""
    top: dict[str, Entry] = {}
    stack: list[tuple[int, dict[str, Entry]]] = [(-1, top)]
    last: Entry | None = None
    for number, line in enumerate(block.splitlines(), first):
        if not line.strip():
            continue
        depth = len(line) - len(line.lstrip())
        name, _, remark = line.strip().partition(" ")
        if depth > stack[-1][0] + 1 and last is not None and stack[-1][0] >= 0:
            last.entries = {}
            stack.append((depth, last.entries))
        elif stack[-1][0] < 0:
            stack.append((depth, top))
        while stack[-1][0] > depth:
            stack.pop()
        last = Entry(remark.strip(), number)
        stack[-1][1][name] = last
    return top


def at(tree: dict[str, Entry], path: str) -> Entry | None:
    """Return the entry of a folder; a root such as `python/spheremap/` is one name."""
    if f"{path}/" in tree:
        return tree[f"{path}/"]
    here: Entry | None = Entry(entries=tree)
    for name in path.split("/"):
        here = (here.entries or {}).get(f"{name}/") if here else None
    return here


def true_tree(
    old: dict[str, Entry], disk: Disk, roots: tuple[str, ...] = ROOTS
) -> dict[str, Entry]:
    """Return what the block should say: as deep as it is now, in its order, with its remarks."""

    def folder(path: str, known: Entry | None, listed: bool) -> dict[str, Entry] | None:
        names = disk.folders.get(path, set())
        if not listed and (known is None or known.entries is None):
            return None
        before = (known.entries or {}) if known else {}
        order = [n for n in before if n in names]
        # Folders first, then files.
        order += sorted(names - set(order), key=lambda n: (not n.endswith("/"), n))
        out = {}
        for name in order:
            was = before.get(name)
            inner = folder(f"{path}/{name[:-1]}", was, False) if name.endswith("/") else None
            out[name] = Entry(was.remark if was else "", was.line if was else 0, inner)
        return out

    tree = {}
    for root in [x.rstrip("/") for x in old] + [x for x in roots if f"{x}/" not in old]:
        was = old.get(f"{root}/")
        if root in disk.folders and (was or root in roots):
            inner = folder(root, was, root in roots)
            tree[f"{root}/"] = Entry(was.remark if was else "", was.line if was else 0, inner)
    return tree


def rendered(tree: dict[str, Entry], depth: int = 0) -> str:
    lines = ""
    for name, entry in tree.items():
        lines += f"{'  ' * depth}{name}".ljust(COLUMN) + f" {entry.remark}"
        lines = lines.rstrip() + "\n" + rendered(entry.entries or {}, depth + 1)
    return lines


def complaints(tree: dict[str, Entry], disk: Disk, roots: tuple[str, ...] = ROOTS) -> list[str]:
    """Return what differs, each with the line of the page, 0 where there is none."""
    said: list[str] = []

    def compare(here: dict[str, Entry], wanted: dict[str, Entry], path: str, line: int) -> None:
        for name, entry in here.items():
            if name not in wanted:
                said.append(f"{entry.line}: {path}{name} is not on the disk")
            elif name.endswith("/") and not entry.remark:
                said.append(f"{entry.line}: {path}{name} has no remark: what is it for?")
        for name, entry in wanted.items():
            if name not in here:
                said.append(f"{line}: {path}{name} is missing")
            elif entry.entries is not None:
                compare(here[name].entries or {}, entry.entries, path + name, here[name].line)

    compare(tree, true_tree(tree, disk, roots), "", 0)
    return said


def block_of(text: str) -> tuple[str, str, str]:
    """Return a page's text before, in and after the block."""
    before, begin, rest = text.partition(f"{BEGIN}\n```text\n")
    block, end, after = rest.partition(f"```\n{END}")
    if not (begin and end):
        raise SystemExit(f"{PAGE.name} lacks the marks {BEGIN} and {END} around a block of text")
    return before + begin, block, end + after


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help="rewrite the block")
    write = parser.parse_args().write
    before, block, after = block_of(PAGE.read_text(encoding="utf-8"))
    tree = parsed(block, before.count("\n") + 1)
    disk = Disk(tracked(ROOT))
    if write:
        text = before + rendered(true_tree(tree, disk)) + after
        PAGE.write_text(text, encoding="utf-8")
        tree = parsed(block_of(text)[1], before.count("\n") + 1)
    said = complaints(tree, disk)
    for line in said:
        print(f"{PAGE.relative_to(ROOT)}:{line}", file=sys.stderr)
    if said and not write:
        print("python tools/lint_tree.py --write lists what is there", file=sys.stderr)
    return 1 if said else 0


if __name__ == "__main__":
    raise SystemExit(main())
