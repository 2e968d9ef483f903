"""`python -m benchmarks.accuracy`: errors of functions, geodesics and curves compared with exact ones, as a page."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import scipy

import stiefel_rs
from benchmarks.accuracy import tables
from benchmarks.environment import ROOT

TEMPLATE = Path(__file__).with_name("page.md")
# The fields of every section, by its heading.
SECTIONS: dict[str, Callable[[], dict[str, str]]] = {
    "`skew_exp`": tables.exponentials,
    "`orthogonal_log`": tables.logarithms,
    "`skew_exp`, complex": tables.complex_exponentials,
    "`orthogonal_log`, unitary": tables.unitary_logarithms,
    "`exp` and `log` of complex frames": tables.frames,
    "`exp`, `log` and principal angles of subspaces": tables.subspaces,
    "Cubics and splines of complex frames and of subspaces": tables.curves,
}


def split(text: str) -> dict[str, str]:
    """Parts of a page by their headings; the part before the first one has an empty heading."""
    parts = re.split(r"^(?=## )", text, flags=re.MULTILINE)
    return {part.split("\n", 1)[0].removeprefix("## ") if part.startswith("## ") else "": part for part in parts}


def page(only: Sequence[str] = (), old: str = "") -> str:
    """The whole page; with `only`, sections whose heading contains none of these texts are those of the old page."""
    kept = split(old) if only else {}
    parts = []
    for heading, template in split(TEMPLATE.read_text()).items():
        if not heading:
            parts.append(template.format(version=stiefel_rs.__version__, scipy=scipy.__version__, numpy=np.__version__))
        elif heading in kept and not any(text in heading for text in only):
            parts.append(kept[heading])
        else:
            parts.append(template.format(**SECTIONS[heading]()))
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.accuracy", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "accuracy.md", help="page to write")
    parser.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="TEXT",
        help="sections whose heading contains TEXT; the page keeps its other sections",
    )
    options = parser.parse_args(arguments)
    old = options.out.read_text() if options.out.is_file() else ""
    text = page(options.only, old)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(text)
    print(f"{text}\nwritten to {options.out}")


if __name__ == "__main__":
    main()
