"""Formulas as drawings inside the page: no script, no network, any text colour, any zoom.

matplotlib's mathtext sets each formula as outlines; they become an inline SVG, whose unit and colour are
those of the text around it. What mathtext does not know is a warning, so an error of ``make docs``.
"""

import re
from html import escape

import matplotlib
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.textpath import TextPath
from sphinx.util import logging

#: Units of the drawing in one em of the text; digits follow.
EM = 100.0
#: Mathtext at this size looks like text of one em.
SIZE = 105.0
LETTERS = {Path.MOVETO: "M", Path.LINETO: "L", Path.CURVE3: "Q", Path.CURVE4: "C", Path.CLOSEPOLY: "Z"}


def drawn(latex, css):
    """SVG of one formula, its baseline on that of the text."""
    with matplotlib.rc_context({"mathtext.fontset": "cm"}):
        path = TextPath((0.0, 0.0), f"${latex}$", size=SIZE, prop=FontProperties())
    box = path.get_extents()
    left, low, wide, high = box.x0 - 3.0, box.y0 - 3.0, box.width + 6.0, box.height + 6.0
    strokes = "".join(
        LETTERS[code]
        + (
            ""
            if code == Path.CLOSEPOLY
            else " ".join(f"{x - left:.0f} {high + low - y:.0f}" for x, y in points.reshape(-1, 2))
        )
        for points, code in path.iter_segments(simplify=False, curves=True)
    )
    style = f"width:{wide / EM:.2f}em;height:{high / EM:.2f}em;vertical-align:{low / EM:.2f}em"
    return (
        f'<svg class="{css}" role="img" aria-label="{escape(latex)}" viewBox="0 0 {wide:.0f} {high:.0f}" '
        f'style="{style}"><path fill="currentColor" d="{strokes}"/></svg>'
    )


def formula(self, node, css, display):
    """HTML of a formula node; TeX as it stands, and a warning, where mathtext cannot read it."""
    latex = " ".join(node.astext().split())
    tag = re.search(r"\\tag\{(.*?)\}", latex)
    latex = re.sub(r"\\tag\{.*?\}", "", latex).strip()
    # A little air after a sum, which mathtext sets close.
    latex = re.sub(r"(\\sum(?:_(?:\{[^}]*\}|\w))?)", r"\1\\,", latex)
    try:
        svg = drawn(latex.replace(r"\frac", r"\dfrac") if display else latex, css)
    except ValueError as error:
        reason = str(error).strip().splitlines()[-1]
        logging.getLogger(__name__).warning("formula not drawn: %s (%s)", latex, reason, location=node)
        svg = f"<code>{escape(latex)}</code>"
    return svg, "" if tag is None else f'<span class="eqno">({escape(tag[1])})</span>'


def inline(self, node):
    """A formula in a line of text."""
    from docutils.nodes import SkipNode

    self.body.append(formula(self, node, "math", display=False)[0])
    raise SkipNode


def display(self, node):
    """A formula in lines of its own."""
    from docutils.nodes import SkipNode

    svg, number = formula(self, node, "math-block", display=True)
    self.body.append(f'<div class="math-display">{svg}{number}</div>')
    raise SkipNode


def setup(app):
    """Called by Sphinx."""
    app.add_html_math_renderer("drawn", (inline, None), (display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
