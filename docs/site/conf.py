"""The documentation site: the pages of the repository where they lie, and a reference made from the docstrings.

`make docs` builds it into out/docs; it needs no network, neither to build nor to read.
"""

import inspect
import re

import robust_ik

project = "robust_ik"
author = "the robust_ik authors"
copyright = "the robust_ik authors"
version = release = robust_ik.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "docs/index"
include_patterns = [
    "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md", "docs/reference/*.md", "examples/README.md",
    "notebooks/README.md", "benchmarks/README.md", "benchmarks/peers/README.md",
]  # fmt: skip
suppress_warnings = ["myst.header"]  # pages may begin where a reader begins
default_role = "code"
nitpicky = False

myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]

autodoc_default_options = {"exclude-members": "numbers, structural"}  # tables for compiled code, told by `Task.form`
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_type_aliases = {name: name for name in ("Array", "ArrayLike", "Stack", "Reference")}
python_use_unqualified_type_names = True
python_display_short_literal_types = True
add_module_names = False
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False  # before a colon, "Returns" have shapes and no types

html_theme = "furo"
html_title = f"robust_ik {release}"
html_show_sphinx = False
html_copy_source = False


def setup(app):
    """Docstrings are plain text: what reStructuredText would take for markup is said to be none."""
    app.connect("autodoc-process-docstring", plain, priority=100)
    app.connect("autodoc-process-docstring", whole, priority=900)
    app.connect("autodoc-process-signature", public)


def plain(_app, _what, _name, _obj, _options, lines):
    """Escapes bars and stars outside code; fenced code becomes a code block."""
    text, fenced = [], False
    for line in lines:
        if line.strip().startswith("```"):
            fenced = not fenced
            text += ["", ".. code-block:: python", ""] if fenced else [""]
        else:
            text.append("    " + line if fenced else escaped(line))
    lines[:] = text


def escaped(line):
    """The line, in which only code is markup."""
    signs = "|" if line.lstrip().startswith("*") else "|*"  # of `**options:` the section takes care
    parts = line.split("`")
    parts[::2] = [re.sub(f"[{signs}]", lambda sign: "\\" + sign[0], part) for part in parts[::2]]
    return "`".join(parts)


def whole(app, what, name, obj, options, lines):
    """A property's text as it stands: before a colon comes no type."""
    if what in ("property", "attribute") and getattr(obj, "__doc__", None):
        lines[:] = inspect.cleandoc(obj.__doc__).splitlines()
        plain(app, what, name, obj, options, lines)


def public(_app, what, _name, _obj, _options, signature, return_annotation):
    """No signature for a class that is made by functions only: one with private fields."""
    return ("", return_annotation) if what == "class" and re.search(r"[(, ]_\w", signature or "") else None
