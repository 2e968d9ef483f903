"""A moving picture of the camera of `uneven_keyframes.py`: it turns by RotationSpline and by SciPy's, side by side."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import transform

import uneven_keyframes
from figures import FIGURES
from stiefel_rs import RotationSpline
from stiefel_rs.palette import BLUE, BODY_AXES, DARK, GREY, GRID_GREY, INK, ORANGE, VERMILION

Array = NDArray[np.float64]
FRAMES = 157
RADIUS = 105.0
# Where the viewer is.
AZIMUTH, ELEVATION = np.radians([-35.0, 25.0])
PLOT = (600.0, 55.0, 350.0, 210.0)
TOP_RATE = 190.0
# Lengths of the axes of the body: the first ends in the picture.
LENGTHS = np.array([1 / np.sqrt(1.16), 0.45, 0.45])
# Corners of the camera's picture, in front of it.
CORNERS = np.array([[1, 0.32, 0.24], [1, -0.32, 0.24], [1, -0.32, -0.24], [1, 0.32, -0.24]]) / np.sqrt(1.16)
STYLE = "<style>text { font: 15px system-ui, sans-serif } .small { font-size: 12px }</style>"


def dark_style() -> str:
    """Style sheet that replaces the palette on dark pages."""
    rules = [f'[{what}="{a}"]{{{what}:{b}}}' for a, b in DARK.items() for what in ("fill", "stroke")]
    return f"<style>@media (prefers-color-scheme:dark){{{''.join(rules)}}}</style>"


def projected(points: Array, centre: tuple[float, float]) -> Array:
    """Points of space as the viewer sees them, in pixels."""
    right = np.array([-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0])
    up = np.array([-np.cos(AZIMUTH) * np.sin(ELEVATION), -np.sin(AZIMUTH) * np.sin(ELEVATION), np.cos(ELEVATION)])
    return np.stack([centre[0] + RADIUS * points @ right, centre[1] - RADIUS * points @ up], axis=-1)


def joined(points: Array) -> str:
    """Pixels as SVG writes them."""
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def title(text: str, x: float, y: float) -> str:
    """A title in the middle above a part of the picture."""
    return f'<text fill="{INK}" x="{x}" y="{y}" text-anchor="middle">{text}</text>'


def note(text: str, x: float, y: float, anchor: str = "middle") -> str:
    """Small text."""
    return f'<text class="small" fill="{GREY}" x="{x}" y="{y:.0f}" text-anchor="{anchor}">{text}</text>'


def animated(attribute: str, values: Sequence[str], seconds: float) -> str:
    """An attribute that takes values at equal times, again and again."""
    line = ";".join(values)
    return f'<animate attributeName="{attribute}" dur="{seconds}s" repeatCount="indefinite" values="{line}"/>'


def camera(matrices: Array, colour: str, centre: tuple[float, float], name: str, seconds: float) -> str:
    """A camera that turns: its axes in red, green and blue, its picture, the way of its first axis, the keyframes."""
    corners = projected(np.einsum("tij,cj->tci", matrices, CORNERS), centre)
    way = projected(matrices[:, :, 0], centre)
    keyframes = projected(uneven_keyframes.rotations(uneven_keyframes.ANGLES).as_matrix()[:, :, 0], centre)
    (x, y), parts = centre, []
    parts.append(f'<circle cx="{x}" cy="{y}" r="{RADIUS}" fill="none" stroke="{GREY}"/>')
    parts.append(f'<polyline points="{joined(way)}" fill="none" stroke="{colour}" stroke-width="1.5" opacity=".55"/>')
    parts += [f'<circle cx="{p:.0f}" cy="{q:.0f}" r="4" fill="{ORANGE}"/>' for p, q in keyframes]
    values = [joined(frame) for frame in corners]
    parts.append(
        f'<polygon points="{values[0]}" fill="{colour}" fill-opacity=".35" stroke="{colour}" stroke-width="2">'
        f"{animated('points', values, seconds)}</polygon>"
    )
    tips = projected(np.swapaxes(matrices * LENGTHS, 1, 2), centre)
    for axis, shade in enumerate(BODY_AXES):
        values = [f"M{x},{y}L{frame[axis][0]:.0f},{frame[axis][1]:.0f}" for frame in tips]
        moves = animated("d", values, seconds)
        parts.append(f'<path d="{values[0]}" stroke="{shade}" stroke-width="3">{moves}</path>')
    return "".join(parts) + title(name, x, y - RADIUS - 18)


def rates(t: Array, curves: dict[str, tuple[Any, str]], seconds: float) -> str:
    """Angular velocities against time, and a line that says when it is."""
    left, top, width, height = PLOT
    across = left + width * (t - t[0]) / (t[-1] - t[0])
    ticks = [top + height * (1 - rate / TOP_RATE) for rate in (0, 50, 100, 150)]
    level = f'<line stroke="{GRID_GREY}" x1="{left}" x2="{left + width}"'
    parts = [f'{level} y1="{y:.0f}" y2="{y:.0f}"/>' for y in ticks]
    parts += [note(str(rate), left - 6, y + 4, "end") for rate, y in zip((0, 50, 100, 150), ticks, strict=True)]
    parts.append(title("angular velocity (degrees/s)", left + width / 2, top - 18))
    for time in uneven_keyframes.TIMES:
        x = left + width * (time - t[0]) / (t[-1] - t[0])
        parts.append(f'<circle cx="{x:.0f}" cy="{top + height}" r="4" fill="{ORANGE}"/>')
    values = [f"{x:.1f}" for x in across]
    moves = animated("x1", values, seconds) + animated("x2", values, seconds)
    parts.append(f'<line stroke="{GREY}" x1="{left}" x2="{left}" y1="{top}" y2="{top + height}">{moves}</line>')
    for curve, colour in curves.values():
        line = np.stack([across, top + height * (1 - uneven_keyframes.lengths(curve, t, 1) / TOP_RATE)], axis=-1)
        dot = animated("cx", values, seconds) + animated("cy", [f"{y:.1f}" for y in line[:, 1]], seconds)
        parts.append(f'<polyline points="{joined(line)}" fill="none" stroke="{colour}" stroke-width="2.5"/>')
        parts.append(f'<circle r="5" fill="{colour}" cx="{line[0, 0]:.0f}" cy="{line[0, 1]:.0f}">{dot}</circle>')
    parts.append(note("keyframes, 0.3 s to 3 s apart", left + width / 2, top + height + 24))
    return "".join(parts)


def main(out: Path) -> None:
    """Write the picture."""
    knots = uneven_keyframes.TIMES
    keyframes = uneven_keyframes.rotations(uneven_keyframes.ANGLES)
    ours, theirs = RotationSpline(knots, keyframes), transform.RotationSpline(knots, keyframes)
    t, seconds = np.linspace(knots[0], knots[-1], FRAMES), float(knots[-1] - knots[0])
    cost = uneven_keyframes.cost_of(lambda t: theirs(t, 2), knots)
    titles = f"stiefel_rs: cost {ours.cost():.1f}", f"SciPy: cost {cost:.1f}"
    body = camera(ours(t).as_matrix(), BLUE, (130.0, 165.0), titles[0], seconds)
    body += camera(theirs(t).as_matrix(), VERMILION, (395.0, 165.0), titles[1], seconds)
    body += rates(t, {"ours": (ours, BLUE), "theirs": (theirs, VERMILION)}, seconds)
    body += note("cost: integral of the squared angular acceleration, rad²/s³", 262, 303)
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 970 315" role="img">'
    out.write_text(f"{head}{STYLE}{dark_style()}{body}</svg>\n", encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write the moving picture of the README.")
    parser.add_argument("--out", type=Path, default=FIGURES.parent / "keyframes.svg", help="picture to write")
    main(parser.parse_args().out)
