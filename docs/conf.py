"""Sphinx: the reference of ``core`` from its docstrings, made by ``python3 dev.py docs``; it is not committed."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

project = "Wayfarer"
author = "Wayfarer developers"
release = re.search(r'^version = "(.+)"', (ROOT / "blender_manifest.toml").read_text("utf-8"), re.MULTILINE).group(1)

extensions = ["sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
# Words of prose in the types of docstrings, "x" and "y" for instance, happen to be attributes elsewhere.
suppress_warnings = ["ref.python"]

# Docstrings follow NumPy's conventions: "Parameters", "Attributes", "Returns", "Raises".
napoleon_google_docstring = False
# The attributes of a dataclass stand in its docstring; autodoc would list its fields once more.
napoleon_use_ivar = True
autodoc_member_order = "bysource"
autodoc_inherit_docstrings = False
autodoc_typehints = "signature"
# Settings are shown as they are written, not as their values print.
autodoc_preserve_defaults = True
toc_object_entries_show_parents = "hide"

html_theme = "alabaster"
html_theme_options = {
    "description": "NumPy and SciPy; knows nothing of Blender",
    "page_width": "1100px",
    "sidebar_width": "260px",
}


def split_attributes(app, what, name, obj, options, lines):
    """Give attributes that share a line of a docstring ("nx, ny : int") an entry each, as Napoleon wants them."""
    if what in ("data", "attribute"):
        # Napoleon takes what stands before a colon in the first line for a type: let that be an empty comment.
        lines[:0] = ["..", ""]
        return
    if "Attributes" not in lines:
        return
    start = lines.index("Attributes") + 2
    result, names, entry = lines[:start], [], []
    for line in [*lines[start:], ""]:
        heads = re.fullmatch(r"(\w+(?:, \w+)+)( : .*)?", line)
        if names and (heads or not line.startswith(" ")):
            result += [text for each in names for text in (each, *entry)]
            names, entry = [], []
        if heads:
            names = [each + (heads.group(2) or "") for each in heads.group(1).split(", ")]
        elif names:
            entry.append(line)
        else:
            result.append(line)
    lines[:] = result


def setup(app):
    # Before Napoleon, whose priority is that of everything that does not say otherwise: 500.
    app.connect("autodoc-process-docstring", split_attributes, priority=400)
