"""`python -m benchmarks.accuracy`: errors of `skew_exp` and `orthogonal_log` against 60 digits, as a Markdown page."""

from __future__ import annotations

import argparse
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import scipy.linalg
from tabulate import tabulate  # type: ignore[import-untyped]
from tqdm import tqdm  # type: ignore[import-untyped]

import stiefel_rs
from benchmarks.accuracy_cases import BITS, Array, Case, exp_cases, log_cases
from benchmarks.environment import ROOT
from benchmarks.fixed_point import FixedPoint, Integers
from stiefel_rs import OutsideDomainError, orthogonal_log, skew_exp

UNIT = 1e-15

# Distance of doubles next to zero: no result is closer to anything than that.
TINY = 5e-324


@dataclass(frozen=True)
class ExpErrors:
    """Errors of an exponential; see `accuracy_page.md` for what is in each."""

    forward: float
    off_diagonal: float
    defect: float

    @staticmethod
    def bounds(A: Array) -> ExpErrors:
        """What is promised: relative eps in A moves `e^A` by `eps |A|_2`, and no more than a few of those are lost."""
        m, norm = len(A), float(np.linalg.norm(A, 2))
        # Below 1e-308 doubles have an absolute spacing.
        off_diagonal = m * UNIT * max(1.0, norm) + m * (TINY / _size(A))
        return ExpErrors(UNIT * max(1.0, norm), off_diagonal, m * UNIT)

    def above(self, bounds: ExpErrors) -> list[str]:
        """Names of the errors that are above their bounds."""
        return [f.name for f in fields(self) if not getattr(self, f.name) <= getattr(bounds, f.name)]


@dataclass(frozen=True)
class LogErrors:
    """Errors of a logarithm; see `accuracy_page.md` for what is in each."""

    forward: float
    absolute: float
    condition: float
    size: float
    backward: float
    skewness: float
    real: bool

    def bounds(self, m: int) -> LogErrors:
        """What is promised for a matrix of this size and condition: few eps of backward error, and what comes of it."""
        forward = m * UNIT * self.condition
        return LogErrors(forward, forward * max(1.0, self.size), self.condition, self.size, m * UNIT, 0.0, real=True)

    def above(self, bounds: LogErrors) -> list[str]:
        """Names of the errors that are above their bounds."""
        names = ("forward", "absolute", "backward", "skewness")
        return [name for name in names if not getattr(self, name) <= getattr(bounds, name)]


def _arithmetic(A: Array) -> FixedPoint:
    """Digits for a result of the size of A's smallest column."""
    entries = np.abs(A[A != 0])
    return FixedPoint(BITS + max(0, -math.floor(math.log2(entries.min()))) if entries.size else BITS)


def exp_reference(A: Array) -> tuple[FixedPoint, Integers]:
    """Exponential of a matrix of doubles."""
    F = _arithmetic(A)
    return F, F.expm(F.exact(A))


def exp_errors(R: Array, A: Array, reference: tuple[FixedPoint, Integers]) -> ExpErrors:
    """Errors of a computed exponential."""
    F, exact = reference
    X = F.exact(R)
    error = X - exact
    off = error.copy()
    np.fill_diagonal(off, 0)
    defect = F.norm(F.multiply(X.T, X) - F.identity(len(A)))
    return ExpErrors(F.norm(error) / math.sqrt(len(A)), F.norm(off) / _size(A), defect)


def _size(A: Array) -> float:
    """Frobenius norm, at most 1 and never 0."""
    largest = max(float(np.abs(A).max()), TINY)
    # Squares of the entries themselves would underflow.
    return max(TINY, min(1.0, float(np.linalg.norm(A / largest)) * largest))


def log_reference(Q: Array) -> tuple[FixedPoint, Integers]:
    """Logarithm of the rotation nearest to a matrix of doubles."""
    off = Q.copy()
    np.fill_diagonal(off, 0)
    F = _arithmetic(off)
    return F, F.logm_rotation(F.exact(Q))


def log_errors(L: Array, Q: Array, reference: tuple[FixedPoint, Integers]) -> LogErrors:
    """Errors of a computed logarithm, of which the real part is taken."""
    F, exact = reference
    X = F.exact(np.real(L))
    size = F.norm(exact)
    error = F.norm(X - exact)
    # Of a skew matrix: its spectral norm.
    angle = float(np.linalg.norm(F.rounded(exact), 2))
    # Doubles end too early to tell pi - 1e-14 from pi well; the angle itself is right to 1e-15.
    condition = angle / math.sin(angle) if angle > 0 else 1.0
    backward = F.norm(F.expm(X) - F.exact(Q))
    skewness = float(np.abs(np.real(L) + np.real(L).T).max())
    forward = error / size if size > 0 else error
    return LogErrors(forward, error, condition, size, backward, skewness, bool(np.isrealobj(L)))


def scipy_logm(Q: Array) -> Array:
    """SciPy's logarithm, warnings aside."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return np.asarray(scipy.linalg.logm(Q))


def exp_line(case: Case) -> tuple[str, ...]:
    """One line of the table of exponentials."""
    reference = exp_reference(case.matrix)
    ours = exp_errors(skew_exp(case.matrix), case.matrix, reference)
    theirs = exp_errors(scipy.linalg.expm(case.matrix), case.matrix, reference)
    cells = _marked(ours, ("forward", "off_diagonal", "defect"), ours.above(ExpErrors.bounds(case.matrix)))
    return case.name, str(case.m), *cells, f"{theirs.forward:.1e}", f"{theirs.off_diagonal:.1e}", f"{theirs.defect:.1e}"


def _marked(errors: ExpErrors | LogErrors, names: Sequence[str], above: Sequence[str]) -> list[str]:
    """Figures, those above their bounds marked."""
    return [f"{getattr(errors, name):.1e}" + (" **above**" if name in above else "") for name in names]


def log_line(case: Case) -> tuple[str, ...]:
    """One line of the table of logarithms."""
    Q = case.matrix
    reference = log_reference(Q)
    theirs = log_errors(scipy_logm(Q), Q, reference)
    other = (
        f"{theirs.forward:.1e}",
        f"{theirs.backward:.1e}",
        f"{theirs.skewness:.1e}",
        "yes" if theirs.real else "no",
    )
    try:
        L = orthogonal_log(Q)
    except OutsideDomainError:
        return case.name, str(case.m), f"{theirs.condition:.1e}", "refused", "", "", *other
    ours = log_errors(L, Q, reference)
    cells = _marked(ours, ("forward", "backward", "skewness"), ours.above(ours.bounds(case.m)))
    return case.name, str(case.m), f"{ours.condition:.1e}", *cells, *other


EXP_HEADERS = (
    "case", "m", "forward", "off diagonal", "orthogonality",
    "SciPy forward", "off diagonal", "orthogonality",
)  # fmt: skip
LOG_HEADERS = (
    "case", "m", "condition", "forward", "backward", "skewness",
    "SciPy forward", "backward", "skewness", "real",
)  # fmt: skip

PAGE = Path(__file__).with_name("accuracy_page.md")


def page() -> str:
    """The whole page."""
    exp = [exp_line(case) for case in tqdm(exp_cases(), desc="skew_exp")]
    log = [log_line(case) for case in tqdm(log_cases(), desc="orthogonal_log")]
    return PAGE.read_text().format(
        digits=50,
        version=stiefel_rs.__version__,
        scipy=scipy.__version__,
        numpy=np.__version__,
        exp=tabulate(exp, headers=EXP_HEADERS, tablefmt="github", disable_numparse=True),
        log=tabulate(log, headers=LOG_HEADERS, tablefmt="github", disable_numparse=True),
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
