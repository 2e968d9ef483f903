"""Tables of the accuracy page: one line per case, errors above their bounds marked."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import scipy.linalg
from tabulate import tabulate  # type: ignore[import-untyped]
from tqdm import tqdm  # type: ignore[import-untyped]

from benchmarks.accuracy import cases, complex_cases
from benchmarks.accuracy.cases import Case
from benchmarks.accuracy.complex_cases import Unitary
from benchmarks.accuracy.curve_cases import Problem, curve_cases
from benchmarks.accuracy.curve_errors import CurveErrors, curve_errors, solve
from benchmarks.accuracy.errors import (
    ExpErrors,
    LogErrors,
    exp_errors,
    exp_reference,
    log_errors,
    log_reference,
    unitary_log_errors,
    unitary_log_reference,
)
from benchmarks.accuracy.fixed_point import Matrix
from benchmarks.accuracy.frame_cases import Shot, frame_cases, name_of, subspace_cases
from benchmarks.accuracy.frame_errors import Reference, ShotErrors, angle_error, measure
from stiefel_rs import OutsideDomainError, orthogonal_log, skew_exp

Line = tuple[str, ...]

# Families of which the page shows some angles or sizes; all of them are computed, and asserted by the tests.
NEAR_PI = re.compile(r"one angle pi - 1e-(\d\d)")
SHOWN = (6, 14)
LEFT_OUT = {"random, norm": (6,), "all angles 1.2": (6, 12), "angles 1e-8 apart": (6,), "angles 1e-5 apart": (6, 12)}


def is_shown(name: str, m: int) -> bool:
    """Whether the page has a line for a case with this name and size."""
    if found := NEAR_PI.fullmatch(name):
        return int(found[1]) in SHOWN
    return not any(name.startswith(family) and m in sizes for family, sizes in LEFT_OUT.items())


def _table(lines: Iterable[Line], *headers: str) -> str:
    return str(tabulate(list(lines), headers=headers, tablefmt="github", disable_numparse=True))


def _marked(errors: Any, names: Sequence[str], above: Sequence[str]) -> list[str]:
    """Formatted numbers, empty if there are none; those above their bounds are marked."""
    values = {name: getattr(errors, name) for name in names}
    marks = {name: " **above**" if name in above else "" for name in names}
    return ["" if value is None else f"{value:.1e}{marks[name]}" for name, value in values.items()]


def scipy_logm(Q: Matrix) -> Matrix:
    """SciPy's logarithm, without its warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return np.asarray(scipy.linalg.logm(Q))


EXP_HEADERS = "case", "m", "forward", "off diagonal", "orthogonality", "SciPy forward", "orthogonality"
LOG_HEADERS = "case", "m", "condition", "forward", "backward", "SciPy forward", "backward"
SKEWNESS = 5


def exp_line(case: Case) -> Line:
    """One line of the tables of exponentials."""
    reference = exp_reference(case.matrix)
    ours = exp_errors(skew_exp(case.matrix), case.matrix, reference)
    theirs = exp_errors(scipy.linalg.expm(case.matrix), case.matrix, reference)
    cells = _marked(ours, ("forward", "off_diagonal", "defect"), ours.above(ExpErrors.bounds(case.matrix)))
    return case.name, str(case.m), *cells, f"{theirs.forward:.1e}", f"{theirs.defect:.1e}"


def log_line(case: Case) -> Line:
    """One line of the table of logarithms."""
    Q = case.matrix
    reference = log_reference(Q)
    theirs = log_errors(scipy_logm(Q), Q, reference)
    other = f"{theirs.forward:.1e}" + ("" if theirs.real else " *"), f"{theirs.backward:.1e}"
    try:
        L = orthogonal_log(Q)
    except OutsideDomainError:
        return case.name, str(case.m), f"{theirs.condition:.1e}", "refused", "", "", *other
    return _log_line(case, log_errors(L, Q, reference), other)


def unitary_log_line(case: Unitary) -> Line:
    """One line of the table of logarithms of unitary matrices."""
    reference = unitary_log_reference(case)
    theirs = unitary_log_errors(scipy_logm(case.matrix), case, reference)
    other = f"{theirs.forward:.1e}", f"{theirs.backward:.1e}"
    return _log_line(case, unitary_log_errors(orthogonal_log(case.matrix), case, reference), other)


def _log_line(case: Case, ours: LogErrors, other: Line) -> Line:
    cells = _marked(ours, ("forward", "backward", "skewness"), ours.above(ours.bounds(case.m)))
    return case.name, str(case.m), f"{ours.condition:.1e}", *cells, *other


def shot_line(shot: Shot) -> Line:
    """One line of the tables of geodesics; with SciPy's principal angles for subspaces."""
    reference = Reference(shot)
    ours = measure(reference)
    names = ["exp", "zeros", "log", "backward"]
    other: Line = ()
    if shot.horizontal:
        names.append("angles")
        other = (f"{angle_error(scipy.linalg.subspace_angles(shot.point, reference.target), reference):.1e}",)
    return shot.name, name_of(shot.manifold), *_marked(ours, names, ours.above(ShotErrors.bounds(shot))), *other


def curve_line(problem: Problem) -> Line:
    """One line of the table of curves."""
    ours = curve_errors(problem, solve(problem))
    cells = _marked(ours, ("equation", "given", "points", "jump", "cost"), ours.above(CurveErrors.bounds()))
    return problem.kind, problem.name, name_of(problem.manifold), *cells


def _logs(lines: list[Line]) -> dict[str, str]:
    """The largest skewness, and the table without it."""
    skewness = max((line[SKEWNESS] for line in lines if line[SKEWNESS]), key=lambda cell: float(cell.split()[0]))
    shown = [(*line[:SKEWNESS], *line[SKEWNESS + 1 :]) for line in lines if is_shown(line[0], int(line[1]))]
    return {"skewness": skewness, "table": _table(shown, *LOG_HEADERS)}


def exponentials() -> dict[str, str]:
    """Fields of the section of exponentials."""
    shown = [case for case in cases.exp_cases() if is_shown(case.name, case.m)]
    return {"table": _table(map(exp_line, tqdm(shown, desc="skew_exp")), *EXP_HEADERS)}


def logarithms() -> dict[str, str]:
    """Fields of the section of logarithms."""
    return _logs([log_line(case) for case in tqdm(cases.log_cases(), desc="orthogonal_log")])


def complex_exponentials() -> dict[str, str]:
    """Fields of the section of complex exponentials."""
    lines = map(exp_line, tqdm(complex_cases.exp_cases(), desc="skew_exp, complex"))
    return {"table": _table(lines, *EXP_HEADERS)}


def unitary_logarithms() -> dict[str, str]:
    """Fields of the section of logarithms of unitary matrices."""
    return _logs([unitary_log_line(case) for case in tqdm(complex_cases.log_cases(), desc="orthogonal_log, unitary")])


def frames() -> dict[str, str]:
    """Fields of the section of complex frames."""
    lines = map(shot_line, tqdm(frame_cases(), desc="complex frames"))
    return {"table": _table(lines, "case", "manifold", "exp", "exp, zeros", "log", "log, backward")}


def subspaces() -> dict[str, str]:
    """Fields of the section of subspaces."""
    lines = map(shot_line, tqdm(subspace_cases(), desc="subspaces"))
    headers = "case", "manifold", "exp", "exp, zeros", "log", "log, backward", "angles", "SciPy angles"
    return {"table": _table(lines, *headers)}


def curves() -> dict[str, str]:
    """Fields of the section of cubics and splines."""
    lines = map(curve_line, tqdm(curve_cases(), desc="cubics and splines"))
    return {"table": _table(lines, "curve", "data", "manifold", "equation", "given", "points", "jump", "cost")}
