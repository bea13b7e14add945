"""Configuration of the Sphinx site: `make docs` builds it into out/site."""

import os
import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS), str(DOCS.parent)]

from site_pages import escape_docstring, escape_help, outer_pages, write_generated_pages  # noqa: E402  (needs the path above)

import cnnsim  # noqa: E402

project, author, release = "Cellular wave machine for touch", "The project's authors", cnnsim.__version__
copyright = author  # noqa: A001  (the name that Sphinx reads)

extensions = [
    "myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon",
    "sphinx.ext.mathjax", "sphinx-mathjax-offline", "sphinx.ext.intersphinx",
    "sphinx_click", "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]  # fmt: skip
exclude_patterns = ["_build", "generated/examples", "**.ipynb_checkpoints"]
html_theme = "pydata_sphinx_theme"
html_theme_options = {"show_prev_next": False, "navigation_with_keys": True, "secondary_sidebar_items": ["page-toc"],
                      "logo": {"text": "Cellular wave machine"}}  # fmt: skip
html_title = project
html_show_sourcelink = False

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 4
default_role = "code"  # docstrings name code in single backticks
autodoc_typehints = "none"  # docstrings have shapes and units
autodoc_member_order = "bysource"
autosummary_generate = True
napoleon_google_docstring, napoleon_numpy_docstring = True, False

# Inventories of other projects come from the network, so a build takes them only when it is asked to.
intersphinx_mapping = (
    {"numpy": ("https://numpy.org/doc/stable/", None), "python": ("https://docs.python.org/3", None)}
    if os.environ.get("DOCS_ONLINE") else {}
)  # fmt: skip

write_generated_pages(DOCS / "generated")
sphinx_gallery_conf = {
    "examples_dirs": "generated/examples", "gallery_dirs": "generated/gallery", "filename_pattern": r"\.py",
    "default_thumb_file": str(DOCS / "generated" / "wave.png"),
    "image_scrapers": ("site_pages.collect_pictures",), "download_all_examples": False, "show_memory": False,
    "reset_modules": ("matplotlib", "site_pages.name_example"), "remove_config_comments": True,
    "min_reported_time": 1e9, "abort_on_example_error": True, "write_computation_times": False,
}  # fmt: skip
suppress_warnings = ["config.cache"]  # the scraper above is a function


def setup(app):
    """Connect the rewriting of links and the escapes of docstrings and help texts."""
    app.connect("source-read", outer_pages)
    app.connect("autodoc-process-docstring", escape_docstring)
    for part in ("description", "options", "arguments", "epilog"):
        app.connect(f"sphinx-click-process-{part}", escape_help)
