"""Sphinx's settings for the site. `site/build.py` runs it on the pages that it has put together."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import spheremap

sys.path.insert(0, str(Path(__file__).resolve().parent))

project = "spheremap"
author = "The spheremap authors"
project_copyright = author
release = version = spheremap.__version__
language = "en"

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_nb",
    "sphinx_copybutton",
    "sphinx_design",
    "maker.sphinx",
]
root_doc = "index"
exclude_patterns: list[str] = []

# --- The reference

# Types stand in the sections of the docstrings, in words.
autodoc_typehints = "none"
autodoc_member_order = "alphabetical"
# Not in the group `site`, for their size. Their verbs need no more than the names.
autodoc_mock_imports = ["torch", "jax"]
autosummary_generate = False
numpydoc_show_class_members = False
default_role = "py:obj"
add_module_names = False
python_display_short_literal_types = True

# --- The pages

myst_enable_extensions = ["colon_fence", "attrs_inline"]
myst_heading_anchors = 6
# The text of notebooks keeps no outputs: they are made here, and again when a cell has changed.
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
# A machine may be slow; what hangs is seen.
nb_execution_timeout = -1
nb_merge_streams = True
nb_number_source_lines = False
pygments_style = "a11y-high-contrast-light"
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

# --- The look

html_theme = "pydata_sphinx_theme"
html_title = "spheremap"
html_baseurl = ""
html_static_path = ["_static"]
templates_path = ["templates"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_sidebars: dict[str, list[str]] = {"index": [], "gallery": [], "speed": []}
html_theme_options: dict[str, Any] = {
    "navbar_align": "left",
    "navbar_persistent": ["search-field"],
    "header_links_before_dropdown": 8,
    "show_prev_next": False,
    "show_nav_level": 1,
    "navigation_depth": 3,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": ["theme-version"],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
    "back_to_top_button": True,
}
