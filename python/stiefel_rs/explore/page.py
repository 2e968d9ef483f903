"""The page as one text: style, plotly.js, program and data inside, nothing from elsewhere."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Callable
from importlib.resources import files
from typing import Any, Final

from .curves import KINDS
from .grid import AXES, SAMPLES, build, size

PARTS: Final = files(__package__)


def plotly_js() -> str:
    """Text of plotly.js.

    Raises
    ------
    ImportError
        plotly is not installed.
    """
    try:
        # Here, since plotly is optional and slow to import.
        from plotly.offline import get_plotlyjs  # noqa: PLC0415
    except ImportError as missing:
        raise ImportError(f"the page needs plotly ({missing}): pip install 'stiefel-rs[explore]'") from missing
    return str(get_plotlyjs())


def _part(name: str) -> str:
    return (PARTS / name).read_text(encoding="utf-8")


def _script(text: str) -> str:
    """Keep a program from ending its own element."""
    return text.replace("</script", "<\\/script").replace("<!--", "<\\!--")


def _data(value: Any) -> str:
    return json.dumps(value, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _hash(text: str) -> str:
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii") + "'"


def policy(programs: list[str], connect: str) -> str:
    """Content security policy: these programs alone, and no connection but `connect`."""
    rules = {
        "default-src": "'none'",
        "script-src": " ".join(map(_hash, programs)),
        # plotly.js makes style elements.
        "style-src": "'unsafe-inline'",
        "img-src": "data:",
        "connect-src": connect,
        "base-uri": "'none'",
        "form-action": "'none'",
    }
    return "; ".join(f"{name} {value}" for name, value in rules.items())


def _described() -> dict[str, Any]:
    return {
        name: {
            "title": kind.title,
            "k": kind.k,
            "parameters": kind.parameters,
            "limit": kind.limit,
            "angle": kind.angle,
            "velocities": kind.velocities,
        }
        for name, kind in KINDS.items()
    }


def spacing(name: str) -> str:
    """Say where the nodes of the grid of a kind are."""
    parts = [
        f"{parameter}: {axis[0]:g} to {axis[-1]:g} in steps of {axis[1] - axis[0]:g}"
        for parameter, axis in zip(KINDS[name].parameters, AXES[name], strict=True)
    ]
    count = f"at {SAMPLES[name]} times each, for {size(KINDS[name])} pairs of velocities"
    return f"Computed before, {count}: {'; '.join(parts)}. Velocities snap to these."


def _assemble(config: dict[str, Any], make_grid: Callable[[], dict[str, Any] | None], note: str, connect: str) -> str:
    # First, since the grid takes long, which would be in vain without plotly.
    programs = {"plotly": _script(plotly_js()), "program": _script(_part("page.js"))}
    texts = {
        "policy": policy(list(programs.values()), connect),
        "style": _part("page.css"),
        "note": note,
        "config": _data(config),
        "grid": _data(make_grid()),
        **programs,
    }
    pieces = _part("page.html").split("@@")
    # Names are at the odd places: no text that was put in is looked at again.
    return "".join(texts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def served(name: str) -> str:
    """Page that asks its server for curves; it shows `name` first."""
    config = {"mode": "served", "kind": name, "kinds": _described()}
    return _assemble(config, lambda: None, "Computed by stiefel_rs as you drag.", "'self'")


def static(name: str, progress: Callable[[], object]) -> str:
    """Page with a grid of curves of one kind; `progress` is called after each node."""
    config = {"mode": "static", "kind": name, "kinds": {name: _described()[name]}}
    return _assemble(config, lambda: build(name, progress), spacing(name), "'none'")
