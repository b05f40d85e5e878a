"""Settings of Sphinx for the site; scripts/documentation/make_site.py starts it on a staged copy of docs/."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from weavesim import __version__  # noqa: E402

project = "weavesim"
author = "the weavesim contributors"
version = release = __version__
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "scripts.documentation.formulas",
    "scripts.documentation.parameter_fields",
]

# Markdown as GitHub reads it: its anchors, formulas between dollars and in blocks.
myst_enable_extensions = ["dollarmath"]
myst_dmath_allow_labels = False
myst_dmath_double_inline = True
myst_fence_as_directive = ["math"]
myst_heading_anchors = 6
# Notebooks show the outputs that are kept in them.
nb_execution_mode = "off"

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"weavesim {__version__}"
html_static_path = [str(Path(__file__).parent / "static")]
html_css_files = ["site.css"]
html_js_files = ["search_from_folder.js"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"
# Code is copied without prompts.
copybutton_prompt_text = r"\$ "
copybutton_prompt_is_regexp = True
