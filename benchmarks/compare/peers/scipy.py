"""SciPy, LAPACK, NumPy's GEMM, and the methods written with them in `benchmarks/compare/methods`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import scipy.linalg
from scipy.spatial.transform import Rotation, RotationSpline

from benchmarks import problems
from benchmarks.compare import cubic_problems, rotation_problems, spline_problems
from benchmarks.compare.methods import casteljau, cubics, rotation_spline
from benchmarks.compare.methods.hermite import TangentHermite
from benchmarks.compare.methods.stiefel_log import cayley_log, rotation_log, stiefel_log, unitary_log
from benchmarks.compare.protocol import Task, Tasks, serve

# A loop over all problems of a batch would take minutes for the slow functions; times are per problem.
LOOP = {"skew_exp": 1000, "orthogonal_log": 100}
# Relative residual, for which the error of position and velocity in the middle is 5e-12.
COLLOCATION = 1e-8


def exp_task(m: int) -> Task:
    """`scipy.linalg.expm`."""
    A = problems.skew(m)
    return Task(lambda: scipy.linalg.expm(A))


def gemm_task(m: int) -> Task:
    """One product of two m x m matrices, into an existing array."""
    A, B = problems.skew(m), problems.rotation(m)
    out = np.empty_like(A)
    return Task(lambda: np.matmul(A, B, out=out))


def logm_task(m: int) -> Task:
    """`scipy.linalg.logm`."""
    Q = problems.rotation(m)
    return Task(lambda: scipy.linalg.logm(Q).real)


def schur_task(m: int) -> Task:
    """LAPACK's real Schur form and atan2."""
    Q = problems.rotation(m)
    return Task(lambda: rotation_log(Q))


def cayley_task(m: int) -> Task:
    """Cayley transform and a symmetric eigenproblem."""
    Q = problems.rotation(m)
    return Task(lambda: cayley_log(Q))


def complex_task(function: Callable[[problems.ComplexArray], problems.ComplexArray], A: problems.ComplexArray) -> Task:
    """A function of a complex matrix; the result as pairs of real numbers."""
    return Task(lambda: function(A), result=lambda: np.ascontiguousarray(function(A)).view(np.float64))


def loop_task(work: str, m: int) -> Task:
    """A Python loop over small problems."""
    count = LOOP[work]
    if work == "skew_exp":
        batch, function = problems.skew(m, (problems.BATCH,))[:count], scipy.linalg.expm
    else:
        batch, function = problems.rotation(m, (problems.BATCH,))[:count], lambda Q: scipy.linalg.logm(Q).real
    return Task(lambda: [function(A) for A in batch], units=count)


def thin_task(n: int, k: int) -> Task:
    """De Casteljau, thin, vectorised over 1000 points."""
    b = problems.boundary(n, k)
    P, t = casteljau.control_points(b.S0, b.V0, b.S1, b.V1), problems.parameters(1000)
    return Task(lambda: casteljau.casteljau(P, t), units=len(t))


def single_task() -> Task:
    """One point of a curve on the sphere."""
    b = problems.boundary(3, 1)
    P, t = casteljau.control_points(b.S0, b.V0, b.S1, b.V1), np.array([0.3])
    return Task(lambda: casteljau.casteljau(P, t)[0])


def formula_task(n: int, k: int) -> Task:
    """One point of de Casteljau's algorithm by the paper's n x n formulas."""
    b = problems.boundary(n, k)
    P, t = casteljau.control_points(b.S0, b.V0, b.S1, b.V1), problems.parameters(1000)
    return Task(lambda: casteljau.formulas(P, float(t[problems.FORMULA_POINT])))


def tall_gemm_task() -> Task:
    """A single product that writes as many numbers as the curve on St(10^6, 4)."""
    rng = np.random.default_rng(0)
    n, k = problems.TALL
    E, C = rng.standard_normal((n, 4 * k)), rng.standard_normal((4 * k, k * problems.TALL_POINTS))
    return Task(lambda: E @ C, units=problems.TALL_POINTS, result=lambda: np.zeros(0))


def log_task(n: int, k: int, distance: str) -> Task:
    """Riemannian logarithm by the algebraic method."""
    S0, S1, _ = problems.log_problem(n, k, distance)
    return Task(lambda: stiefel_log(S0, S1))


def cubic_task() -> Task:
    """The paper's initial value problem on the sphere by DOP853."""
    start = np.concatenate([each[:, 0] for each in cubic_problems.paper("sphere").initial])
    run = partial(cubics.solve, cubics.sphere_field_scalar, start, tol=cubics.FINEST)
    return Task(run, result=lambda: run()[:6].reshape(2, 3, 1))


def shooting_task(name: str) -> Task:
    """A boundary problem by DOP853 and `scipy.optimize.root`."""
    shape = cubic_problems.RANDOM[0]
    b = cubic_problems.paper(name).boundary if name in cubic_problems.PAPER else cubic_problems.random_boundary(*shape)
    shooting = cubics.SphereShooting(b) if name == "sphere" else cubics.GroupShooting(b)
    return Task(shooting.solve, result=lambda: shooting.at(shooting.solve(), 0.5))


def collocation_task() -> Task:
    """The paper's boundary problem on the sphere by `solve_bvp`."""
    b = cubic_problems.paper("sphere").boundary
    return Task(
        lambda: cubics.sphere_collocation(b, COLLOCATION), result=lambda: cubics.sphere_collocation(b, COLLOCATION)(0.5)
    )


def cubic_parts_task(n: int, k: int) -> Task:
    """The parts of a tall boundary problem before and after its solution: the QR of its data, the lift of a point."""
    b = cubic_problems.random_boundary(n, k)
    S = cubic_problems.reduced(b).S1
    return Task(lambda: cubic_problems.basis(b) @ S)


def rotation_spline_task(count: int) -> Task:
    """`RotationSpline` through keyframes."""
    t, rotations = rotation_problems.keyframes(count)

    def note() -> str:
        spline = RotationSpline(t, rotations)
        return f"cost {rotation_spline.cost(spline, t):.6g}, jump {rotation_spline.jump(spline, t):.1g}"

    return Task(lambda: RotationSpline(t, rotations), result=lambda: np.zeros(0), note=note)


def rotation_points_task() -> Task:
    """Points of that spline."""
    t, rotations = rotation_problems.keyframes(spline_problems.EVALUATED)
    spline, times = RotationSpline(t, rotations), spline_problems.evaluations(t)
    return Task(lambda: spline(times), units=len(times), result=lambda: spline(times).as_matrix()[..., :2])


def rotation_curve_task() -> Task:
    """A spline and its first evaluation."""
    t, rotations = rotation_problems.keyframes(rotation_problems.EVALUATED)
    times = spline_problems.evaluations(t)
    return Task(lambda: RotationSpline(t, rotations)(times), result=lambda: np.zeros(0))


def rotation_values_task(order: int) -> Task:
    """Rotations or rates of a spline at many times."""
    t, rotations = rotation_problems.keyframes(rotation_problems.EVALUATED)
    spline, times = RotationSpline(t, rotations), spline_problems.evaluations(t)
    return Task(lambda: spline(times, order), units=len(times), result=lambda: np.zeros(0))


def rotation_crowd_task() -> Task:
    """A loop over many splines."""
    t, quaternions = rotation_problems.crowd()
    members = [(times, Rotation.from_quat(q)) for times, q in zip(t, quaternions, strict=True)]
    return Task(lambda: [RotationSpline(*each) for each in members], units=len(t), result=lambda: np.zeros(0))


def tangent_hermite(*, points: bool) -> Task:
    """Zimmermann's Hermite interpolation of the known curve: its preparation, or one point."""
    knots, t = spline_problems.sampled(), spline_problems.checks()
    assert knots.V is not None
    make = partial(TangentHermite, knots.t, knots.S, knots.V)
    curve = make()
    return Task(
        partial(curve, 0.3) if points else make,
        result=lambda: np.stack([curve(float(x)) for x in t]),
    )


def matrix_tasks() -> Tasks:
    """The tasks with exponentials and logarithms of matrices."""
    found: dict[str, Callable[[], Task]] = {}
    for m in problems.SMALL_EXP + problems.LARGE:
        found[f"skew_exp/{m}:expm"] = partial(exp_task, m)
    for m in problems.LARGE:
        found[f"skew_exp/{m}:gemm"] = partial(gemm_task, m)
    for m in problems.SMALL_LOG + problems.LARGE:
        found[f"orthogonal_log/{m}:logm"] = partial(logm_task, m)
        found[f"orthogonal_log/{m}:cayley"] = partial(cayley_task, m)
        found[f"orthogonal_log/{m}:schur"] = partial(schur_task, m)
    for m in problems.COMPLEX:
        found[f"skew_exp_complex/{m}:expm"] = partial(complex_task, scipy.linalg.expm, problems.skew_hermitian(m))
        found[f"unitary_log/{m}:logm"] = partial(complex_task, scipy.linalg.logm, problems.unitary(m))
        found[f"unitary_log/{m}:schur"] = partial(complex_task, unitary_log, problems.unitary(m))
    return found


def tasks() -> Tasks:
    """All tasks by name."""
    found: dict[str, Callable[[], Task]] = {"curve_single/3,1:thin": single_task, "curve_tall:gemm": tall_gemm_task}
    found["cubic_initial/sphere:dop853"] = cubic_task
    found["cubic_boundary/sphere:bvp"] = collocation_task
    found["cubic_boundary/1000,5:qr_lift"] = partial(cubic_parts_task, 1000, 5)
    for name in ("sphere", "frame", "10,3"):
        found[f"cubic_boundary/{name}:shooting"] = partial(shooting_task, name)
    for count in spline_problems.KEYFRAMES:
        found[f"spline_setup/{count}:rotation_spline"] = partial(rotation_spline_task, count)
    found["spline_points:rotation_spline"] = rotation_points_task
    for count in rotation_problems.COUNTS:
        found[f"rotation_setup/{count}:rotation_spline"] = partial(rotation_spline_task, count)
    for name, order in rotation_problems.VALUES.items():
        found[f"rotation_values/{name}:rotation_spline"] = partial(rotation_values_task, order)
    found["rotation_curve:rotation_spline"] = rotation_curve_task
    found["rotation_crowd:rotation_spline"] = rotation_crowd_task
    found["spline_hermite/setup:tangent"] = partial(tangent_hermite, points=False)
    found["spline_hermite/point:tangent"] = partial(tangent_hermite, points=True)
    found |= matrix_tasks()
    for n, k in problems.CURVES:
        found[f"curve/{n},{k}:thin"] = partial(thin_task, n, k)
        found[f"curve/{n},{k}:formulas"] = partial(formula_task, n, k)
    for work in LOOP:
        for m in (3, 6):
            found[f"batch/{work}/{m}:loop"] = partial(loop_task, work, m)
    for n, k in problems.LOGS:
        for distance in problems.DISTANCES:
            found[f"log/{n},{k}/{distance}:algebraic"] = partial(log_task, n, k, distance)
    return found


if __name__ == "__main__":
    serve(tasks(), packages=("numpy", "scipy"))
