"""Sphinx settings of the documentation: Markdown pages, search without a server, nothing remote."""

from __future__ import annotations

project = "BlueKoi"
author = "the BlueKoi authors"
html_title = "BlueKoi"

extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
myst_heading_anchors = 4
myst_enable_extensions = ["deflist", "dollarmath"]
suppress_warnings = ["misc.highlighting_failure"]

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["bluekoi.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_search_summary = False  # would fetch pages, which browsers refuse under file://
html_show_sphinx = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": False}
