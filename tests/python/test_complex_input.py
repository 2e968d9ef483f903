"""Invalid and unusual input of complex frames: typed errors with the user's shapes and defects, any memory layout."""

import numpy as np
import pytest
from complex_frames import assert_close, walk

from stiefel_rs import (
    Chart,
    CubicHermite,
    CubicSpline,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    InvalidInputError,
    OutsideDomainError,
    PoseSpline,
    QuasiGeodesic,
    RiemannianCubic,
    RotationSpline,
    SmoothingSpline,
    Stiefel,
    _core,
    estimate_velocities,
    integrate_cubic,
    solve_boundary,
)

M = Stiefel(4, 2, field="complex")
T, S, V = walk(4, 2, 3)

# Functions of a point, a tangent vector at it, and another point with a tangent vector.
CALLS = {
    "exp": lambda a, v, b, w: M.exp(a, v),
    "log": lambda a, v, b, w: M.log(a, b),
    "norm": lambda a, v, b, w: M.norm(a, v),
    "retract": lambda a, v, b, w: M.retract(a, v, "qr"),
    "quasi": lambda a, v, b, w: QuasiGeodesic(a, b),
    "geodesic": lambda a, v, b, w: Geodesic.from_velocity(a, v),
    "cubic": GeometricCubic,
    "polynomial": lambda a, v, b, w: GeometricPolynomial([a, b]),
    "boundary": RiemannianCubic.from_boundary,
    "initial": lambda a, v, b, w: RiemannianCubic.from_initial(a, v, v, v),
    "batch": solve_boundary,
    "trajectory": lambda a, v, b, w: integrate_cubic(a, v, v, v, 2),
    "spline": lambda a, v, b, w: CubicSpline([0.0, 1.0], [a, b], ((1, v), (2, w))),
    "hermite": lambda a, v, b, w: CubicHermite([0.0, 1.0], [a, b], [v, w]),
    "smoothing": lambda a, v, b, w: SmoothingSpline([0.0, 1.0], [a, b], lam=1.0),
    "estimate": lambda a, v, b, w: estimate_velocities([0.0, 1.0], [a, b]),
}
GOOD = (S[0], V[0], S[1], V[1])
WITHOUT_VECTORS = {"log", "quasi", "polynomial", "smoothing", "estimate"}


@pytest.fixture(params=CALLS)
def call(request):
    return CALLS[request.param], request.param not in WITHOUT_VECTORS


def entry(array, value):
    array = array.copy()
    array[2, 1] = value
    return array


def test_numbers_that_are_not_finite(call):
    function, vectors = call
    function(*GOOD)
    for bad in (np.nan, np.inf, 1j * np.nan, complex(0, np.inf)):
        with pytest.raises(InvalidInputError, match="not finite"):
            function(entry(S[0], bad), *GOOD[1:])
        if vectors:
            with pytest.raises(InvalidInputError, match="not finite"):
                function(S[0], entry(V[0], bad), *GOOD[2:])


def test_points_and_vectors_that_are_none(call):
    function, vectors = call
    with pytest.raises(InvalidInputError, match="not orthonormal"):
        function(S[0] + 1e-3, *GOOD[1:])
    if vectors:
        with pytest.raises(InvalidInputError, match="not tangent"):
            function(S[0], V[0] + 0.1 * S[0], *GOOD[2:])


def test_defects_are_those_of_the_complex_matrices():
    off = S[0] * (1 + 1e-6)
    defect = np.linalg.norm(off.conj().T @ off - np.eye(2))
    told = f"= {defect:.3e} exceeds 1.000e-9".replace("e-06", "e-6")
    with pytest.raises(InvalidInputError, match=told):
        M.check_point(off)
    M.check_point(off, atol=1.01 * defect)
    with pytest.raises(InvalidInputError):
        M.check_point(off, atol=0.99 * defect)
    for long in (0.1, 10.0):
        skewed = V[0] * (long / np.linalg.norm(V[0])) + 1e-7 * S[0]
        product = S[0].conj().T @ skewed
        relative = np.linalg.norm(product + product.conj().T) / 2 / max(1.0, np.linalg.norm(skewed))
        M.check_tangent(S[0], skewed, atol=1.01 * relative)
        with pytest.raises(InvalidInputError):
            M.check_tangent(S[0], skewed, atol=0.99 * relative)


def test_shapes_in_messages_are_the_users():
    with pytest.raises(InvalidInputError, match=r"S: expected shape \(\.\.\., 4, 2\), found \(\.\.\., 3, 2\)"):
        M.exp(S[0][:3], V[0])
    with pytest.raises(InvalidInputError, match=r"V0: expected shape \(4, 2\), found \(3, 2\)"):
        GeometricCubic(S[0], V[0][:3], S[1], V[1])
    with pytest.raises(InvalidInputError, match=r"S1: expected shape \(4, 2\), found \(4, 1\)"):
        QuasiGeodesic(S[0], S[1][:, :1])
    with pytest.raises(InvalidInputError, match=r"1 <= k <= n, found \(1, 2\)"):
        QuasiGeodesic(S[0][:1], S[1][:1])
    with pytest.raises(InvalidInputError, match=r"bc_type: expected shape \(4, 2\), found \(2, 2\)"):
        CubicSpline(T, S, ((1, V[0][:2]), "natural"))
    with pytest.raises(InvalidInputError, match=r"V: expected shape \(4, 2\), found \(4, 1\)"):
        CubicHermite(T, S, V[:, :, :1])
    with pytest.raises(InvalidInputError, match=r"S: expected shape \(N, n, k\), found \(4, 2\)"):
        CubicSpline(T, S[0])
    curve = RiemannianCubic.from_boundary(*GOOD)
    with pytest.raises(InvalidInputError, match=r"W: expected shape \(2, 4, 2\), .* found \(4, 2\)"):
        curve.point_pullback([0.0, 1.0], V[0])


def test_the_knot_and_the_member_are_named():
    bad = S.copy()
    bad[1] *= 1.1
    with pytest.raises(InvalidInputError, match="knot 1") as caught:
        CubicSpline(T, bad)
    assert caught.value.knot == 1
    with pytest.raises(InvalidInputError, match="batch member 1"):
        M.check_point(bad)
    with pytest.raises(InvalidInputError, match="batch member 1"):
        solve_boundary(bad, V, S, V)


def test_complex_numbers_where_frames_are_real():
    real = Stiefel(4, 2)
    point = real.random_point(rng=0)
    with pytest.raises(TypeError, match=r"S: expected real numbers; .*Stiefel\(4, 2, field='complex'\)"):
        real.exp(S[0], V[0])
    with pytest.raises(TypeError, match="V: expected real numbers"):
        real.exp(point, 0j * point)
    cubic = RiemannianCubic.from_initial(point, 0 * point, 0 * point, 0 * point)
    with pytest.raises(TypeError, match="dS0: expected real numbers"):
        cubic.point_variation(0.5, 0j * point, 0 * point, 0 * point, 0 * point)
    with pytest.raises(TypeError, match="t: expected real numbers"):
        cubic(0.5j)
    with pytest.raises(TypeError, match="weights: expected real numbers"):
        SmoothingSpline(T, S, weights=[1j, 1, 1])


def test_rotations_poses_and_charts_stay_real():
    quaternions, matrices = np.eye(4)[:2] + 0j, np.stack([np.eye(3)] * 2) + 0j
    for rotations in (quaternions, matrices):
        with pytest.raises(TypeError):
            RotationSpline([0.0, 1.0], rotations)
        with pytest.raises(TypeError):
            PoseSpline([0.0, 1.0], (rotations, np.zeros((2, 3))))
    x = np.eye(3)[:, :1] + 0j
    with pytest.raises(TypeError, match="expected real numbers"):
        Chart.sphere().state(x, 0 * x, 0 * x, 0 * x)
    spline = CubicSpline([0.0, 1.0], np.stack([np.eye(3)] * 2) + 0j)
    with pytest.raises(InvalidInputError, match="curve: expected rotations, found complex frames"):
        _core.RotationCurve.of_curve(spline)


def test_any_layout_of_memory(call):
    """Strides, byte orders, precisions, offsets, lists: the same numbers, the same result."""
    function, _ = call

    def numbers(result):
        return np.asarray(result(0.5) if callable(result) else getattr(result, "jerk", result))

    exact = numbers(function(*GOOD))
    bytes_of = [np.frombuffer(b"\0" + x.tobytes(), np.uint8)[1:].view(np.complex128).reshape(x.shape) for x in GOOD]
    strided = [np.stack([x, x], axis=-1)[..., 0] for x in GOOD]
    records = [np.zeros(x.shape, [("pad", np.int8), ("x", np.complex128)]) for x in GOOD]
    for record, x in zip(records, GOOD, strict=True):
        record["x"] = x
    layouts = {
        "Fortran": [np.asfortranarray(x) for x in GOOD],
        "reversed": [x[::-1, ::-1].copy()[::-1, ::-1] for x in GOOD],
        "sliced": strided,
        "misaligned": bytes_of,
        "in records": [record["x"] for record in records],
        "big endian": [x.astype(">c16") for x in GOOD],
        "lists": [x.tolist() for x in GOOD],
        "extended": [x.astype(np.clongdouble) for x in GOOD if np.clongdouble is not np.complex128],
        "conjugated twice": [x.conj().conj() for x in GOOD],
    }
    for name, arrays in layouts.items():
        if arrays:
            assert_close(numbers(function(*arrays)), exact, 0.0 if name != "extended" else 1e-14, name)
    frozen = S[0].copy()
    frozen.flags.writeable = False
    assert_close(numbers(function(frozen, *GOOD[1:])), exact, 0.0, "read-only")


def test_single_precision_and_real_arrays():
    eye, single = np.eye(3, 1), np.zeros((3, 1), np.complex64)
    single[1] = 0.5j
    U = Stiefel(3, 1, field="complex")
    exact = np.array([[np.cos(0.5)], [1j * np.sin(0.5)], [0]])
    assert_close(U.exp(eye, single), exact, 1e-15, "a real point and a vector in single precision")
    assert_close(U.exp(eye.astype(int), single), exact, 1e-15, "whole numbers")
    assert U.exp(eye, 0 * eye).dtype == np.complex128
    for bad in ("text", None, object(), [["a"]], np.array([[1j], [None], [0]], dtype=object)):
        with pytest.raises((TypeError, InvalidInputError)):
            U.exp(eye + 0j, bad)


def test_masked_and_ragged_arrays():
    masked = np.ma.MaskedArray(S[0], mask=np.eye(4, 2, dtype=bool))
    with pytest.raises(InvalidInputError, match="S0: 2 of 8 entries are masked"):
        QuasiGeodesic(masked, S[1])
    with pytest.raises(InvalidInputError, match="S: 2 of 8 entries are masked"):
        M.exp(masked, V[0])
    with pytest.raises((InvalidInputError, ValueError)):
        QuasiGeodesic([[1j], [0, 1]], S[1])


def test_batches_mix_real_and_complex_arrays():
    """Leading axes broadcast; a batch is complex if one array is."""
    points = np.stack([S[0], S[0]])
    found = M.exp(points, V[0])
    assert_close(found[1], M.exp(S[0], V[0]), 0.0, "a member")
    assert M.inner(points, V[0], V[0]).shape == (2,)
    assert M.exp(points[:0], V[0]).shape == (0, 4, 2)
    mixed = CubicSpline([0.0, 1.0], [np.eye(4, 2), S[0]])
    assert mixed.field == "complex"
    with pytest.raises(InvalidInputError, match="broadcast"):
        M.exp(points, np.stack([V[0]] * 3))


def test_cut_points_are_refused_or_met():
    """Antipodes have no unique logarithm: a typed error, not a curve that leaves the complex frames."""
    for S0 in (np.eye(3, 1) + 0j, np.eye(2) + 0j, S[0]):
        for curve in (QuasiGeodesic, Geodesic):
            with pytest.raises(OutsideDomainError):
                curve(S0, -S0)
    with pytest.raises(OutsideDomainError) as caught:
        CubicSpline([0.0, 1.0], [S[0], -S[0]])
    assert caught.value.knot == 0


def test_damaged_files_are_refused():
    form = CubicSpline(T, S)._stored()
    with pytest.raises(InvalidInputError, match="field: expected 'real' or 'complex'"):
        _core._restored(form | {"field": "quaternion"})
    real = CubicSpline(T, Stiefel(3, 1).random_point(rng=1, size=3))._stored()
    with pytest.raises(InvalidInputError, match="of odd shape"):
        _core._restored(real | {"field": "complex"})
    even = QuasiGeodesic(*Stiefel(4, 2).random_point(rng=1, size=2))._stored()
    with pytest.raises(OutsideDomainError, match="not complex"):
        _core._restored(even | {"field": "complex"})
    del form["field"]
    assert _core._restored(form).n == 8
