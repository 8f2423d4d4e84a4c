"""Make the links of README.md absolute, for a package index, which shows it and nothing beside it.

python tools/absolute_links.py https://github.com/OWNER/REPOSITORY REF    rewrites README.md

In the repository they are relative, so that they hold in a checkout, in a fork and at every commit.
The public workflow runs this before it packs: there the address is known.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LINK = re.compile(r"(!?)(\[(?:[^\[\]]|\[[^\]]*\])*\])\((?![a-z]+:|#)([^)\s]+)\)")


def absolute(text: str, address: str, ref: str) -> str:
    """Return a page of the repository's root with links to `ref` of the repository at `address`."""

    def link(found: re.Match[str]) -> str:
        picture, words, place = found.groups()
        # A picture's own bytes, or a page that shows what a file holds.
        kind = "raw" if picture else "blob"
        return f"{picture}{words}({address.rstrip('/')}/{kind}/{ref}/{place})"

    return LINK.sub(link, text)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("address", help="of the repository")
    parser.add_argument("ref", help="a tag, a branch or a commit")
    arguments = parser.parse_args()
    page = ROOT / "README.md"
    text = page.read_text(encoding="utf-8")
    page.write_text(absolute(text, arguments.address, arguments.ref), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
