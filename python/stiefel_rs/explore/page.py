"""The page as one text: style, programs and data inside, nothing from elsewhere."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Callable
from importlib.resources import files
from typing import Any, Final

from . import two_ends
from .answers import answer, first_request
from .grid import build
from .kinds import KINDS, described

PARTS: Final = files(__package__) / "web"
# In the order in which they need each other.
PROGRAMS: Final = (
    "vectors",
    "canvas",
    "paths",
    "camera",
    "numbers",
    "samples",
    "sphere",
    "body",
    "solver",
    "status",
    "controls",
    "points",
    "rotations",
    "keyframes",
    "ends",
    "stage",
    "handles",
    "strip",
    "player",
    "timeline",
    "charts",
    "table",
    "main",
)


def _part(name: str) -> str:
    return (PARTS / name).read_text(encoding="utf-8")


def _script(text: str) -> str:
    """Keep a program from ending its own element."""
    return text.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def _data(value: Any) -> str:
    return json.dumps(value, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _hash(text: str) -> str:
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii") + "'"


def policy(programs: list[str], style: str, connect: str) -> str:
    """Content security policy: these programs and this style alone, and no connection but `connect`."""
    rules = {
        "default-src": "'none'",
        "script-src": " ".join(map(_hash, programs)),
        "style-src": _hash(style),
        "img-src": "data:",
        "connect-src": connect,
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    return "; ".join(f"{name} {value}" for name, value in rules.items())


def _assemble(config: dict[str, Any], connect: str) -> str:
    # The theme comes first, so that a dark page is never light before.
    theme = _script(_part("theme.js"))
    programs = [_script(_part(f"{name}.js")) for name in PROGRAMS]
    style = _part("page.css")
    texts = {
        "policy": policy([theme, *programs], style, connect),
        "style": style,
        "theme": theme,
        "config": _data(config),
        "programs": "\n".join(f"<script>{program}</script>" for program in programs),
    }
    pieces = _part("page.html").split("@@")
    # Names are at the odd places: no text that was put in is looked at again.
    return "".join(texts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def served(name: str) -> str:
    """Page that asks its server for curves; it shows `name` first."""
    return _assemble({"mode": "served", "kind": name, "kinds": described()}, "'self'")


def static(name: str, progress: Callable[[], object]) -> str:
    """Page without a server; `progress` is called after each node of its grids.

    Velocities of two ends snap to a grid, keyframes stay where they are.
    """
    grids = {kind: build(kind, progress) for kind in two_ends.KINDS}
    fixed = {kind: answer(first_request(kind)) for kind in KINDS if kind not in grids}
    config = {"mode": "static", "kind": name, "kinds": described(), "grids": grids, "fixed": fixed}
    return _assemble(config, "'none'")
