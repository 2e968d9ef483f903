"""`python -m benchmarks.accuracy`: errors of `skew_exp` and `orthogonal_log` compared with 60 digits, as a page."""

from __future__ import annotations

import argparse
import re
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import scipy.linalg
from tabulate import tabulate  # type: ignore[import-untyped]
from tqdm import tqdm  # type: ignore[import-untyped]

import stiefel_rs
from benchmarks.accuracy.cases import Array, Case, exp_cases, log_cases
from benchmarks.accuracy.errors import ExpErrors, LogErrors, exp_errors, exp_reference, log_errors, log_reference
from benchmarks.environment import ROOT
from stiefel_rs import OutsideDomainError, orthogonal_log, skew_exp


def scipy_logm(Q: Array) -> Array:
    """SciPy's logarithm, without its warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return np.asarray(scipy.linalg.logm(Q))


def exp_line(case: Case) -> tuple[str, ...]:
    """One line of the table of exponentials."""
    reference = exp_reference(case.matrix)
    ours = exp_errors(skew_exp(case.matrix), case.matrix, reference)
    theirs = exp_errors(scipy.linalg.expm(case.matrix), case.matrix, reference)
    cells = _marked(ours, ("forward", "off_diagonal", "defect"), ours.above(ExpErrors.bounds(case.matrix)))
    return case.name, str(case.m), *cells, f"{theirs.forward:.1e}", f"{theirs.defect:.1e}"


def _marked(errors: ExpErrors | LogErrors, names: Sequence[str], above: Sequence[str]) -> list[str]:
    """Formatted numbers; those above their bounds are marked."""
    return [f"{getattr(errors, name):.1e}" + (" **above**" if name in above else "") for name in names]


def log_line(case: Case) -> tuple[str, ...]:
    """One line of the table of logarithms."""
    Q = case.matrix
    reference = log_reference(Q)
    theirs = log_errors(scipy_logm(Q), Q, reference)
    other = f"{theirs.forward:.1e}" + ("" if theirs.real else " *"), f"{theirs.backward:.1e}"
    try:
        L = orthogonal_log(Q)
    except OutsideDomainError:
        return case.name, str(case.m), f"{theirs.condition:.1e}", "refused", "", "", *other
    ours = log_errors(L, Q, reference)
    cells = _marked(ours, ("forward", "backward", "skewness"), ours.above(ours.bounds(case.m)))
    return case.name, str(case.m), f"{ours.condition:.1e}", *cells, *other


EXP_HEADERS = (
    "case", "m", "forward", "off diagonal", "orthogonality",
    "SciPy forward", "orthogonality",
)  # fmt: skip
LOG_HEADERS = (
    "case", "m", "condition", "forward", "backward",
    "SciPy forward", "backward",
)  # fmt: skip
SKEWNESS = 5
# Families of which the page shows some angles or sizes; all of them are computed, and asserted by the tests.
NEAR_PI = re.compile(r"one angle pi - 1e-(\d\d)")
SHOWN = (6, 14)
LEFT_OUT = {"random, norm": (6,), "all angles 1.2": (6, 12), "angles 1e-8 apart": (6,), "angles 1e-5 apart": (6, 12)}

PAGE = Path(__file__).with_name("page.md")


def is_shown(name: str, m: int) -> bool:
    """Whether the page has a line for a case with this name and size."""
    if found := NEAR_PI.fullmatch(name):
        return int(found[1]) in SHOWN
    return not any(name.startswith(family) and m in sizes for family, sizes in LEFT_OUT.items())


def page() -> str:
    """The whole page."""
    exp = [exp_line(case) for case in tqdm(exp_cases(), desc="skew_exp") if is_shown(case.name, case.m)]
    log = [log_line(case) for case in tqdm(log_cases(), desc="orthogonal_log")]
    skewness = max((line[SKEWNESS] for line in log if line[SKEWNESS]), key=lambda cell: float(cell.split()[0]))
    shown = [(*line[:SKEWNESS], *line[SKEWNESS + 1 :]) for line in log if is_shown(line[0], int(line[1]))]
    return PAGE.read_text().format(
        digits=50,
        version=stiefel_rs.__version__,
        scipy=scipy.__version__,
        numpy=np.__version__,
        exp=tabulate(exp, headers=EXP_HEADERS, tablefmt="github", disable_numparse=True),
        skewness=skewness,
        log=tabulate(shown, headers=LOG_HEADERS, tablefmt="github", disable_numparse=True),
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.accuracy", description=__doc__)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "accuracy.md", help="page to write")
    out = parser.parse_args(arguments).out
    text = page()
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(text)
    print(f"{text}\nwritten to {out}")


if __name__ == "__main__":
    main()
