"""What Sphinx is told beside its settings: where pictures are, and whose a name is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx


def find_static(app: Sphinx, config: Any) -> None:
    """Take what is static from beside the pages."""
    config.html_static_path = [str(Path(app.srcdir) / "_static")]


def load_pictures_late(app: Sphinx, doctree: nodes.document) -> None:
    """Have a browser load each picture when it comes near, but the first."""
    for image in list(doctree.findall(nodes.image))[1:]:
        image["loading"] = "lazy"


def find_name(app: Sphinx, env: Any, node: nodes.Element, content: nodes.Node) -> Any:
    """Return the link of a name as docstrings have it: `light.mean`, `convert`."""
    if node.get("refdomain") != "py":
        return None
    domain = env.get_domain("py")
    target = node["reftarget"].removeprefix("sm.")
    module = node.get("py:module") or ""
    for whole in (f"{module}.{target}", f"spheremap.{target}"):
        if whole in domain.objects:
            found = domain.objects[whole]
            return app.builder and nodes.reference(
                "",
                "",
                content,
                internal=True,
                refuri=app.builder.get_relative_uri(node["refdoc"], found.docname)
                + f"#{found.node_id}",
            )
    return None


def name_toggles(app: Sphinx, page: str, template: str, context: Any, doctree: Any) -> None:
    """Give what folds the table of contents a name, which the theme leaves out."""
    make = context.get("generate_toctree_html")
    if make is None:
        return

    def named(kind: str, *given: Any, **options: Any) -> Any:
        made = make(kind, *given, **options)
        if kind != "sidebar":
            return made
        return str(made).replace("<summary><span", '<summary aria-label="Pages below"><span')

    context["generate_toctree_html"] = named


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell it."""
    app.connect("config-inited", find_static)
    app.connect("doctree-read", load_pictures_late)
    app.connect("missing-reference", find_name)
    app.connect("html-page-context", name_toggles, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
