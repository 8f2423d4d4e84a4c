"""A runnable example at every public function and method of the crate.

Reads what `cargo doc` wrote, which knows what is public. Items of other crates that are exported
are theirs to explain: their pages lead to no source of ours. Nor do those that only lead to
another page, as where a private module is exported from.
"""

import re
import sys
from pathlib import Path

EXAMPLE = "rust-example-rendered"
OWN = re.compile(r'<a class="src" href="[./]*src/spheremap/')
METHOD = re.compile(r'(?=<section id="method\.)')
OWN_METHODS = re.compile(r'<div id="implementations-list">(.*?)(?=<h2 id="|$)', re.DOTALL)


def without_example(page: Path) -> tuple[int, list[str]]:
    """How many functions a page shows, and those that have no example."""
    text = page.read_text(encoding="utf-8")
    if not OWN.search(text):
        return 0, []
    if page.name.startswith("fn."):
        return 1, [] if EXAMPLE in text else [page.stem.removeprefix("fn.")]
    found = OWN_METHODS.search(text)
    methods = METHOD.split(found[1])[1:] if found else []
    names = {re.match(r'<section id="method\.(\w+)"', part)[1]: part for part in methods}
    return len(names), [name for name, part in names.items() if EXAMPLE not in part]


def main() -> int:
    """Prints what has none."""
    root = Path(sys.argv[1])
    kinds = ("fn", "struct", "enum", "trait")
    pages = [page for kind in kinds for page in sorted(root.rglob(f"{kind}.*.html"))]
    count = failures = 0
    for page in pages:
        shown, without = without_example(page)
        count += shown
        for name in without:
            failures += 1
            print(f"{page.relative_to(root)}: {name} has no example")
    # A rustdoc that writes other pages would otherwise make this pass.
    if count < 100:
        print(f"{count} functions were found in {root}: its pages have another form")
        return 1
    print(f"{count} public functions, {failures} without an example")
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
