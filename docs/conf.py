"""Settings of the documentation; ``make docs`` builds it into docs/_build/html."""

import os
import sys
from pathlib import Path

# Before numpy is imported: one thread, so that pages and gallery do not depend on the machine.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Measured structures, where they are beside this clone; their examples say so where they are not.
os.environ.setdefault("ANTIRES_DATA", str(Path(__file__).resolve().parents[2] / "shared" / "data"))

import antires_rs

sys.path.insert(0, str(Path(__file__).resolve().parent / "_ext"))

project = "antires_rs"
author = "The antires_rs developers"
copyright = author
release = version = antires_rs.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "drawn_math",
    "package_page",
]
html_math_renderer = "drawn"
source_suffix = {".rst": "restructuredtext", ".md": "markdown"}
exclude_patterns = ["_build", "images", "**sg_execution_times.rst"]
templates_path = ["_templates"]
suppress_warnings = ["config.cache"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

autosummary_generate = True
# A reference to a name that has no page is an error.
nitpicky = True
# The private base of the errors with fields, and its property, which numpydoc lists.
nitpick_ignore = [("py:class", "antires_rs.exceptions._Refusal"), ("py:obj", "path")]
autodoc_typehints = "none"
# Attributes and methods are listed by the class template.
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/plot_",
    "backreferences_dir": "api/backreferences",
    "doc_module": ("antires_rs",),
    "abort_on_example_error": True,
    "within_subsection_order": "gallery_order.Story",
    "capture_repr": (),
    "show_memory": False,
    "show_signature": False,
    "remove_config_comments": True,
    "download_all_examples": False,
    "min_reported_time": 1e9,
    "image_scrapers": ("matplotlib",),
}

html_theme = "pydata_sphinx_theme"
html_title = "antires_rs"
html_show_sourcelink = False
html_theme_options = {
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_static_path = ["_static"]
html_css_files = ["style.css"]
html_sidebars = {"index": [], "theory": []}
