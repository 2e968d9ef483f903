"""Figures as SVG: no background, and other colours on dark pages. Imports matplotlib's types only."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure

from .palette import DARK, INK

# Hundredths of a point: 1/7200 inch.
DECIMALS: Final = 2
NUMBER: Final = re.compile(r"-?\d+\.\d{3,}")
# Coordinates of what is drawn; not the transforms of glyphs, which are small numbers.
COORDINATES: Final = re.compile(r'(?<= )(?:d|x|y)="[^"]*"', flags=re.DOTALL)
# Equal marks in a row, each with a style of its own.
MARK: Final = r'<use xlink:href="#{}" x="[^"]*" y="[^"]*" style="{}"/>\s*'
MARKS: Final = re.compile(MARK.format(r'([^"]+)', r'([^"]*)') + "(?:" + MARK.format(r"\1", r"\2") + ")+")
NO_METADATA: Final = dict.fromkeys(("Date", "Creator", "Format", "Type"))


def dark_style(selector: str) -> str:
    """Style sheet that replaces the palette on dark pages; browsers apply it, other programs see the light colours.

    `selector` finds elements by a property, ``{what}``, and its colour, ``{colour}``.
    """
    rules = []
    for light, dark in DARK.items():
        for what in ("fill", "stroke"):
            rules.append(f"{selector.format(what=what, colour=light.lower())}{{{what}:{dark}!important}}")
    return f"<style>@media (prefers-color-scheme:dark){{{''.join(rules)}}}</style>"


def _rounded(number: re.Match[str]) -> str:
    return f"{float(number[0]):.{DECIMALS}f}".rstrip("0").rstrip(".")


def _shortened(coordinates: re.Match[str]) -> str:
    return re.sub(r"\s*\n\s*", "", NUMBER.sub(_rounded, coordinates[0]))


def _grouped(marks: re.Match[str]) -> str:
    style = f' style="{marks[2]}"'
    return f"<g{style}>{marks[0].replace(style, '').rstrip()}</g>\n"


def adapted(text: str) -> str:
    """SVG of matplotlib with rounded coordinates and the style for dark pages."""
    short = MARKS.sub(_grouped, COORDINATES.sub(_shortened, text))
    # Text in black has no style of its own.
    short = short.replace('<g id="text_', f'<g fill="{INK}" id="text_')
    style = dark_style('[style*="{what}: {colour}"]') + dark_style('[{what}="{colour}" i]')
    return short.replace("</defs>", f"</defs>{style}", 1)


def write_svg(figure: Figure, path: Path) -> None:
    """Write a figure without background, for light and dark pages."""
    memory = io.StringIO()
    figure.savefig(memory, format="svg", transparent=True, metadata=NO_METADATA)
    path.write_text(adapted(memory.getvalue()), encoding="utf-8")
