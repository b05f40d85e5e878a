"""Formulas as MathML, made while the site is built: readable without a network, a script or a picture.

Browsers since 2023 draw MathML. STIX Two Math, which the package ziamath carries, is copied beside the style sheet, so
that formulas look alike on machines without a mathematical font.
"""

from __future__ import annotations

import html
import re
from importlib.resources import files
from typing import Any

import latex2mathml.converter

FONT = "STIXTwoMath-Regular.ttf"
# Names of functions, after which a formula in type has a narrow space.
FUNCTION = re.compile(
    r"(?<!<msup>)(?<!<msub>)(?<!<msubsup>)(?<!<munder>)"
    r"(<m[io]>(?:sin|cos|tan|arctan|arcsin|arccos|exp|ln|log|max|min|tr|diag)</m[io]>)(?=<m(?!o))"
)


def markup(source: str, *, is_block: bool) -> str:
    """MathML of a formula in LaTeX.

    Raises:
        ValueError: a command that is not known.
    """
    text = re.sub(r"\s+", " ", source.strip())
    # latex2mathml sets the two signs apart
    given = text.replace(r"\mathrel{+}=", "\uffff")
    try:
        made = latex2mathml.converter.convert(given, display="block" if is_block else "inline")
    except Exception as error:
        raise ValueError(f"cannot be read ({type(error).__name__}: {error}): {text}") from error
    if left := re.search(r"\\[A-Za-z]+", html.unescape(made)):
        raise ValueError(f"{left[0]} is not known: {text}")
    made = re.sub("<m[ion]>\uffff</m[ion]>", "<mo>+=</mo>", made)
    # bars of an absolute value are as high as the line, whatever is in a formula
    made = made.replace("<mo>&#x0007C;</mo>", '<mo stretchy="false" lspace="0" rspace="0">|</mo>')
    made = FUNCTION.sub(r'\1<mspace width="0.167em" />', made)
    return made.replace("<math ", f'<math alttext="{html.escape(text)}" ', 1)


def _written(writer: Any, node: Any, *, is_block: bool) -> str:
    from sphinx.util import logging

    try:
        return markup(node.astext(), is_block=is_block)
    except ValueError as error:
        logging.getLogger(__name__).warning("formula %s", error, location=node)
        return f"<code>{html.escape(node.astext())}</code>"


def visit_inline(writer: Any, node: Any) -> None:
    """Write a formula of a line of text."""
    from docutils import nodes

    writer.body.append(f'<span class="math">{_written(writer, node, is_block=False)}</span>')
    raise nodes.SkipNode


def visit_block(writer: Any, node: Any) -> None:
    """Write a formula of its own."""
    from docutils import nodes

    writer.body.append(f'<div class="math">{_written(writer, node, is_block=True)}</div>\n')
    raise nodes.SkipNode


def copy_font(app: Any, error: Exception | None) -> None:
    """Put the font beside the style sheet of a finished site."""
    if error is None:
        font = files("ziamath") / "fonts" / FONT
        (app.outdir / "_static" / FONT).write_bytes(font.read_bytes())


def setup(app: Any) -> dict[str, Any]:
    """Register the renderer with Sphinx."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    app.connect("build-finished", copy_font)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
