"""How the site is built: python -m sphinx -W docs build/site."""

import re
import sys
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

import lists  # noqa: E402

import roughsim  # noqa: E402  (of this very folder, installed or not)

project = "roughsim"
author = "the authors of roughsim"
release = version = roughsim.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = f"roughsim {release}"
html_copy_source = False
exclude_patterns = ["figures"]

html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["wide.css"]
highlight_language = "none"  # commands and their output are no Python
html_math_renderer = "mathml"  # browsers draw it themselves: no script, nothing from elsewhere

nb_execution_mode = "force"  # the notebooks are stored without results
nb_execution_in_temp = True
nb_execution_timeout = 600  # s for a cell: busy machines are slow
nb_execution_raise_on_error = True
nb_ipywidgets_js: dict[str, dict[str, str]] = {}  # nothing from elsewhere

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say the types, with shapes and units
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
default_role = "code"


def named_pages() -> set[str]:
    """The pages that the front page puts in a place of its choice."""
    return set(re.findall(r"^[a-z][\w./-]+$", (HERE / "index.md").read_text(), flags=re.MULTILINE))


def add_other_pages(app, page, source) -> None:
    """Put every page that index.md does not name in the place of OTHER-PAGES, so that a new page needs no entry."""
    if page == "index":
        pages = {str(path.relative_to(HERE).with_suffix("")) for path in HERE.rglob("*.md")} - {
            "index"
        }
        source[0] = source[0].replace("OTHER-PAGES", "\n".join(sorted(pages - named_pages())))


def add_lists(app, page, source) -> None:
    """Put the keys of a scene and the commands in their places."""
    if page == "reference/scene":
        source[0] = in_place_of("SCENE-KEYS", source[0], lists.scene_keys())
    if page == "reference/commands":
        source[0] = in_place_of("ALL-COMMANDS", source[0], lists.commands())


def in_place_of(word, text, content):
    """Return a text with content in place of the line that begins with a word: what readers of the source see."""
    return re.sub(rf"^{word}.*$", lambda _: content, text, flags=re.MULTILINE)


def keep_signs(app, what, name, obj, options, lines) -> None:
    """Keep |q| and q* as they stand: docstrings are plain text with formulas, not reStructuredText."""
    lines[:] = [re.sub(r"(?<!`)([|*])(?!`)", r"\\\1", line) for line in lines]
    lines[:] = [re.sub(r"(\w)_(?=\W|$)", r"\1\\_", line) for line in lines]


def keep_together(app, doctree) -> None:
    """Keep a number and its unit or error on one line, and give negative numbers a minus sign."""
    unit = r"(?<=\d) (?=[±%]|[kMG]?Pa\b|[µm]?m\b|K\b)|(?<=±) (?=\d)"
    for paragraph in doctree.findall(nodes.paragraph):
        for text in list(paragraph.findall(nodes.Text)):
            if not isinstance(text.parent, nodes.literal | nodes.math):
                words = re.sub(r"(?<![\w.-])-(?=\d)", "−", re.sub(unit, "\u00a0", text))
                text.parent.replace(text, nodes.Text(words))


def formula(writer, node) -> None:
    """Write a formula as MathML."""
    display = "block" if isinstance(node, nodes.math_block) else "inline"
    writer.body.append(convert(node.astext(), display=display))
    raise nodes.SkipNode


def setup(app) -> None:
    """Register all."""
    app.add_html_math_renderer("mathml", (formula, None), (formula, None))
    app.connect("source-read", add_other_pages)
    app.connect("source-read", add_lists)
    app.connect("doctree-read", keep_together)
    app.connect("autodoc-process-docstring", keep_signs, priority=400)  # before napoleon, at 500
