"""Configuration of the site; `make docs` builds it in docs/_build/html without a network."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "Tactometry"
author = "the authors of Tactometry"
copyright = "the authors of Tactometry, GPL-3.0-or-later"  # noqa: A001

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "myst_nb",
    "sphinx_design",
    "sphinx_copybutton",
    "api_pages",
    "mathml",
    "root_pages",
]
exclude_patterns = ["_build", "_extensions", ".validated"]
nitpicky = True
# The section Raises links each name, and these errors have no page.
ERRORS = ("DeviceFailed", "InvalidFile", "InvalidParameter", "LimitExceeded")
nitpick_ignore = [("py:exc", name) for name in ERRORS]

default_role = "code"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
autodoc_member_order = "alphabetical"
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
napoleon_use_ivar = True

# Notebooks contain their output: `make notebooks` writes it, and tests compare it.
nb_execution_mode = "off"

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4

html_theme = "furo"
html_title = "Tactometry"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
pygments_style = "tango"
pygments_dark_style = "github-dark"
html_theme_options = {"navigation_with_keys": True}

copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
copybutton_only_copy_prompt_lines = True
