"""Sphinx' settings for the site of documentation: `make docs` builds it, without a network.

The source folder is the checkout itself, so that a link between pages, notebooks and files is the
same one here and where the checkout is browsed. `docs/index.md` has the navigation: a page that
stands in none is a warning, and a warning is an error.
"""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent.parent)]

import pen_mhe as pm  # noqa: E402

project = "pen-mhe"
release = version = pm.__version__
copyright = "the authors of pen-mhe, MIT licence"
root_doc = "docs/index"
include_patterns = ["docs/**", "notebooks/*.ipynb"]
exclude_patterns = [".*", "build", "dist", "results", "docs/site"]
extensions = ["sphinx.ext.autodoc", "sphinx.ext.napoleon", "myst_nb", "docstrings", "suite_tables"]

html_theme = "furo"
html_title = f"pen-mhe {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_show_sourcelink = False
html_show_search_summary = False  # would fetch pages, which a browser forbids in a folder
pygments_style, pygments_dark_style = "friendly", "github-dark"
templates_path = ["templates"]
html_additional_pages = {"index": "to_first_page.html"}

myst_enable_extensions = ["attrs_inline", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # notebooks are shown as they are kept: executed, by a test too
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True}
default_role = "code"
python_use_unqualified_type_names = True
napoleon_google_docstring = False
napoleon_use_rtype = False
