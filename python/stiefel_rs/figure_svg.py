"""Figures as SVG: short, no background, other colours on dark pages, text as text. Needs matplotlib."""

from __future__ import annotations

import hashlib
import io
import re
from pathlib import Path
from typing import Any, Final

import matplotlib
from matplotlib.figure import Figure

from .palette import DARK, INK

# For what is drawn as pixels.
DPI: Final = 200
# Text stays text, in the first of these fonts that the reader has; Verdana has the widths of DejaVu Sans.
SETTINGS: Final[Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "stiefel-rs",
    "font.sans-serif": ["DejaVu Sans", "Verdana", "sans-serif"],
}
NO_METADATA: Final = dict.fromkeys(("Date", "Creator", "Format", "Type"))
# Coordinates in hundredths of a point, 1/7200 inch.
SCALE: Final = 100
NUMBER: Final = re.compile(r"-?\d+\.\d{3,}")
# Not the scales of images, which may be small.
COORDINATE: Final = re.compile(r'(?<= )(?:x|y|transform)="(?![^"]*(?:matrix|scale))[^"]*"')
PATH: Final = re.compile(r'(?<= )d="([^"]*)"', flags=re.DOTALL)
# Straight lines only; the curves of marks stay as they are.
LINES: Final = re.compile(r"\s*(?:M\s*[-\d.]+\s+[-\d.]+\s*|L\s*[-\d.]+\s+[-\d.]+\s*|z\s*)+")
STEP: Final = re.compile(r"([MLz])\s*(?:([-\d.]+)\s+([-\d.]+))?")
COMMENT: Final = re.compile(r"<!--.*?-->\s*", flags=re.DOTALL)
STYLE: Final = re.compile(r'(?<= )style="([^"]*)"')
# Equal marks in a row, each with a class of its own; groups of one element.
MARK: Final = r'<use xlink:href="#{}" x="[^"]*" y="[^"]*" class="{}"/>\s*'
MARKS: Final = re.compile(MARK.format(r'([^"]+)', r'([^"]*)') + "(?:" + MARK.format(r"\1", r"\2") + ")+")
ALONE: Final = re.compile(r'<g(?: id="[^"]*")?>\s*(<(?:path|use) [^>]*/>)\s*</g>')


def _written(hundredths: int) -> str:
    return f"{hundredths / SCALE:.2f}".rstrip("0").rstrip(".")


def _rounded(text: re.Match[str]) -> str:
    return NUMBER.sub(lambda number: _written(round(float(number[0]) * SCALE)), text[0])


def _shortened(path: re.Match[str]) -> str:
    """Lines from each point to the next, relative to it: half as long as by coordinates, and as accurate."""
    if not LINES.fullmatch(path[1]):
        return re.sub(r"\s*\n\s*", "", _rounded(path))
    parts, before = [], ""
    x = y = 0
    for command, *place in STEP.findall(path[1]):
        if command == "z":
            parts.append("z")
        else:
            last, (x, y) = (x, y), (round(float(each) * SCALE) for each in place)
            start = "M" if command == "M" else " " if before == "L" else "l"
            step = (x, y) if command == "M" else (x - last[0], y - last[1])
            parts.append(f"{start}{_written(step[0])} {_written(step[1])}")
        before = command
    return f'd="{"".join(parts)}"'


def _classed(text: str) -> str:
    """Styles as classes, which have other colours on dark pages; browsers apply them, other programs see the first."""
    styles: dict[str, str] = {}

    def named(style: re.Match[str]) -> str:
        # By its content, so that figures on one page do not change each other.
        name = "s" + hashlib.sha256(style[1].encode()).hexdigest()[:5]
        styles[name] = style[1]
        return f'class="{name}"'

    text = STYLE.sub(named, text)
    light = "".join(f".{name}{{{style}}}" for name, style in styles.items())
    changed = {name: _darkened(style) for name, style in styles.items()}
    dark = "".join(f".{name}{{{style}}}" for name, style in changed.items() if style != styles[name])
    sheet = f"<style>{light}@media (prefers-color-scheme:dark){{{dark}}}</style>"
    return text.replace("<defs>", f"{sheet}<defs>", 1)


def _darkened(style: str) -> str:
    for light, dark in DARK.items():
        style = style.replace(light.lower(), dark)
    return style


def _grouped(marks: re.Match[str]) -> str:
    style = f' class="{marks[2]}"'
    return f"<g{style}>{marks[0].replace(style, '').rstrip()}</g>\n"


def adapted(text: str) -> str:
    """SVG of matplotlib, shorter and with colours for dark pages."""
    text = re.sub(r"\n +", "\n", COMMENT.sub("", text))
    text = PATH.sub(_shortened, COORDINATE.sub(_rounded, text))
    # Text in black has no colour of its own.
    text = _classed(text.replace('<g id="text_', f'<g style="fill: {INK.lower()}" id="text_'))
    text = ALONE.sub(r"\1", MARKS.sub(_grouped, text))
    return ALONE.sub(r"\1", text)


def write_svg(figure: Figure, path: Path) -> None:
    """Write a figure without background, for light and dark pages."""
    memory = io.StringIO()
    with matplotlib.rc_context(SETTINGS):
        figure.savefig(memory, format="svg", dpi=DPI, transparent=True, metadata=NO_METADATA)
    path.write_text(adapted(memory.getvalue()), encoding="utf-8")
