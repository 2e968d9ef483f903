"""Batches of subspaces over dask arrays: bit-identical to a single process, for real and complex subspaces."""

import doctest
import importlib
import json

import numpy as np
import pytest
from dask_problem import assert_same, cluster

import stiefel_rs
from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    GeometricCubic,
    Grassmann,
    InvalidInputError,
    OutsideDomainError,
    RiemannianCubic,
    Stiefel,
)

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
zarr = pytest.importorskip("zarr")

import dask.array as da  # noqa: E402

from stiefel_rs import dask as batches  # noqa: E402
from stiefel_rs.dask import _manifold, _manifold_option  # noqa: E402

FIELDS = ["real", "complex"]
KINDS = ["riemannian", "geometric"]
T = np.array([0.0, 0.3, 1.0])
KNOTS = np.array([0.0, 0.4, 1.0, 1.5])
AT = np.array([[0.1, 0.4], [0.9, 1.5]])
COUNT = 9
MAPS = {
    "project": ["G"], "project_tangent": ["Y", "G"], "inner": ["Y", "V", "W"], "norm": ["Y", "V"],
    "principal_angles": ["Y", "R"], "align": ["Y", "R"], "projector": ["Y"], "exp": ["Y", "V"], "log": ["Y", "R"],
    "dist": ["Y", "R"], "transport": ["Y", "V", "W"], "curvature": ["Y", "U", "V", "W"],
    "sectional_curvature": ["Y", "V", "W"], "euclidean_to_riemannian_gradient": ["Y", "G"],
    "euclidean_to_riemannian_hessian": ["Y", "G", "H", "V"],
}  # fmt: skip


@pytest.fixture(autouse=True)
def in_this_thread():
    with dask.config.set(scheduler="synchronous"):
        yield


def manifold_of(field):
    return Grassmann(5, 2, field=field)


def normal(rng, field, *shape):
    numbers = rng.standard_normal(shape)
    return numbers if field == "real" else numbers + 1j * rng.standard_normal(shape)


def vectors(field):
    M, rng = manifold_of(field), np.random.default_rng(11)
    Y = M.random_point(rng, COUNT)
    U, V, W = (0.5 * M.random_tangent(Y, rng) for _ in range(3))
    G, H = normal(rng, field, COUNT, 5, 2), normal(rng, field, COUNT, 5, 2)
    return {"Y": Y, "R": in_another_basis(M.exp(Y, 0.3 * W), rng), "U": U, "V": V, "W": W, "G": G, "H": H}


def in_another_basis(Y, rng):
    """The same subspaces."""
    k = Y.shape[-1]
    field = "complex" if np.iscomplexobj(Y) else "real"
    return Y @ Stiefel(k, k, field=field).random_point(rng, Y.shape[:-2])


def random_ends(field, count=COUNT):
    M, rng = manifold_of(field), np.random.default_rng(7)
    Y0 = M.random_point(rng, count)
    Y1 = in_another_basis(M.exp(Y0, 0.4 * M.random_tangent(Y0, rng)), rng)
    return Y0, 0.3 * M.random_tangent(Y0, rng), Y1, 0.3 * M.random_tangent(Y1, rng)


def boundary_curve(kind, data, M, **options):
    if kind == "geometric":
        return GeometricCubic(*data, manifold=M, **options)
    return RiemannianCubic.from_boundary(*data, manifold=M, **options)


def initial_data(curve):
    """Point, velocity, acceleration and jerk at the start, to the last bit."""
    if isinstance(curve, RiemannianCubic):
        return curve.initial
    return curve(0.0), curve.velocity(0.0), curve.acceleration(0.0), curve.jerk(0.0)


def at_given_bases(curve):
    """Velocities at the knots."""
    turns = curve(curve.t).conj().swapaxes(-1, -2) @ curve.points
    return curve.velocity(curve.t) @ turns


def knots_of(field, periodic, count=3):
    M, rng = manifold_of(field), np.random.default_rng(5)
    Y = [M.random_point(rng, count)]
    for _ in KNOTS[1:]:
        Y.append(M.exp(Y[0], 0.3 * M.random_tangent(Y[0], rng)))
    if periodic:
        Y[-1] = Y[0]
    return in_another_basis(np.stack(Y, axis=1), rng)


# ---------------------------------------------------------------- maps


@pytest.mark.parametrize("field", FIELDS)
def test_maps(field):
    M, ours, data = manifold_of(field), batches.Grassmann(5, 2, field=field), vectors(field)
    for name, arguments in MAPS.items():
        lazy = getattr(ours, name)(*(da.from_array(data[a], chunks=(4, 3, 1)) for a in arguments))
        expected = getattr(M, name)(*(data[a] for a in arguments))
        assert (lazy.shape, lazy.dtype) == (expected.shape, expected.dtype), name
        assert lazy.numblocks[0] == 3, name
        np.testing.assert_array_equal(lazy.compute(), expected, err_msg=name)


def test_methods_and_attributes_are_those_of_the_package():
    def public(thing):
        return {name for name in dir(thing) if not name.startswith("_")}

    ours, M = batches.Grassmann(5, 2, field="complex"), manifold_of("complex")
    left_out = {"check_point", "check_tangent", "is_point", "is_tangent", "random_point", "random_tangent"}
    assert public(ours) == public(M) - left_out
    assert public(batches.Grassmann) == set(MAPS)
    assert (ours.n, ours.k, ours.dim, ours.field) == (M.n, M.k, M.dim, M.field)
    assert repr(ours) == "stiefel_rs.dask.Grassmann(5, 2, field='complex')"
    assert repr(batches.Grassmann(5, 2)) == "stiefel_rs.dask.Grassmann(5, 2)"


def test_leading_axes_of_maps_broadcast():
    data = vectors("real")
    lazy = batches.Grassmann(5, 2).principal_angles(data["Y"][0], da.from_array(data["R"], chunks=(4, 5, 2)))
    np.testing.assert_array_equal(lazy.compute(), Grassmann(5, 2).principal_angles(data["Y"][0], data["R"]))


def test_errors_of_maps_name_the_member():
    data, ours = vectors("real"), batches.Grassmann(5, 2)
    V = data["V"].copy()
    V[7] += 0.1
    lazy = da.from_array(data["Y"].reshape(3, 3, 5, 2), chunks=(2, 2, 5, 2))
    with pytest.raises(InvalidInputError, match=r"^problem \(2, 1\): V: not horizontal") as caught:
        ours.exp(lazy, V.reshape(3, 3, 5, 2)).compute()
    assert caught.value.problem == (2, 1)
    lines = np.eye(3)[:, :, None]
    for name in ("log", "align"):
        with pytest.raises(OutsideDomainError, match=r"^problem 1: ") as caught:
            getattr(batches.Grassmann(3, 1), name)(lines[0], lines[:2]).compute()
        assert caught.value.angle == pytest.approx(np.pi / 2)


def test_bad_input_of_maps_is_found_early():
    data = vectors("real")
    for call, error, text in [
        (lambda: batches.Grassmann(2, 3), InvalidInputError, r"Gr\(n, k\)"),
        (lambda: batches.Grassmann(3, 2, field="x"), InvalidInputError, "field"),
        (lambda: batches.Grassmann(4, 2).exp(data["Y"], data["V"]), InvalidInputError, "Y: expected shape"),
        (lambda: batches.Grassmann(5, 2).log(data["Y"], data["R"][:, :4]), InvalidInputError, "Y1: expected shape"),
        (lambda: batches.Grassmann(5, 2).norm(data["Y"] + 0j, data["V"]), TypeError, "Y: expected real numbers"),
    ]:
        with pytest.raises(error, match=text):
            call()


# ---------------------------------------------------------------- manifolds as JSON values


@pytest.mark.parametrize(
    "manifold",
    [
        Grassmann(5, 2),
        Grassmann(4, 1, field="complex"),
        Stiefel(5, 2),
        Stiefel(5, 2, metric=0.3, field="complex"),
    ],
    ids=repr,
)
def test_descriptions_of_manifolds(manifold):
    description = json.loads(json.dumps(_manifold.describe(manifold)))
    assert _manifold.rebuild(description) == manifold
    assert _manifold_option.described(manifold) == description
    lazy = getattr(batches, type(manifold).__name__)
    metric = {"metric": manifold.alpha} if isinstance(manifold, Stiefel) else {}
    assert _manifold_option.described(lazy(manifold.n, manifold.k, field=manifold.field, **metric)) == description


# ---------------------------------------------------------------- boundary problems


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("kind", KINDS)
def test_boundary_problems(field, kind):
    ends, M = random_ends(field), manifold_of(field)
    fields = ["S", "V", "A", "J", "cost", "converged", "iterations", "residual", "code", "message", "points"]
    sweep = batches.solve_boundary(*ends, kind=kind, t=T, manifold=M, chunk=4, fields=fields)
    (found,) = dask.compute(dict(sweep))
    for i, data in enumerate(zip(*ends, strict=True)):
        curve = boundary_curve(kind, data, M)
        report = curve.report
        expected = dict(zip("SVAJ", initial_data(curve), strict=True))
        expected |= {"cost": curve.cost(), "points": curve(T), "code": 0, "message": ""}
        expected["converged"] = report is None or report.converged
        expected["iterations"] = report.iterations if report else 0
        expected["residual"] = report.residual if report else 0.0
        assert_same({name: [values[i]] for name, values in found.items()}, {k: [v] for k, v in expected.items()})
    assert {found[name].dtype.kind for name in ("S", "J", "points")} == {"f" if field == "real" else "c"}
    assert np.abs(M.dist(found["points"][:, -1], ends[2])).max() < 1e-11


def test_options_and_axes_of_boundary_problems():
    Y0, V0, Y1, V1 = random_ends("real")
    M = batches.Grassmann(5, 2)
    loose = batches.solve_boundary(Y0, V0, Y1, V1, tol=1e-4, manifold=M, fields="iterations")["iterations"].compute()
    curves = [boundary_curve("riemannian", d, Grassmann(5, 2), tol=1e-4) for d in zip(Y0, V0, Y1, V1, strict=True)]
    assert loose.tolist() == [curve.report.iterations for curve in curves]
    speeds = np.array([0.5, 1.0])[:, None, None, None]
    grid = batches.solve_boundary(Y0, V0, Y1, speeds * V1, manifold=M, kind="geometric", pieces="geodesic", chunk=5)
    curve = boundary_curve("geometric", (Y0[4], V0[4], Y1[4], 0.5 * V1[4]), Grassmann(5, 2), pieces="geodesic")
    assert grid.shape == (2, COUNT)
    np.testing.assert_array_equal(grid["A"][0, 4].compute(), curve.acceleration(0.0))


def test_the_four_classes_of_manifolds():
    ends = random_ends("real")
    options = {"kind": "geometric", "fields": "A"}
    subspaces, frames = (
        [batches.solve_boundary(*ends, **options, manifold=M)["A"].compute() for M in both]
        for both in [(Grassmann(5, 2), batches.Grassmann(5, 2)), (None, Stiefel(5, 2), batches.Stiefel(5, 2))]
    )
    np.testing.assert_array_equal(subspaces[0], subspaces[1])
    np.testing.assert_array_equal(frames[0], frames[1])
    np.testing.assert_array_equal(frames[0], frames[2])
    assert np.abs(subspaces[0] - frames[0]).max() > 0.1


@pytest.mark.parametrize("kind", KINDS)
def test_real_arrays_on_a_complex_manifold(kind):
    Y0, V0, Y1, V1 = (array[:2] for array in random_ends("real"))
    M, C = Grassmann(5, 2), Grassmann(5, 2, field="complex")
    found = batches.solve_boundary(Y0, V0, Y1, V1, kind=kind, manifold=C, t=T)
    assert found["A"].dtype == found["points"].dtype == np.complex128
    curve = boundary_curve(kind, (Y0[1], V0[1], Y1[1], V1[1]), C)
    np.testing.assert_array_equal(found["points"][1].compute(), curve(T))
    steps = batches.evaluate(T, Y0, V0, V0, V0, manifold=C)
    assert steps.dtype == np.complex128
    np.testing.assert_allclose(steps.compute(), batches.evaluate(T, Y0, V0, V0, V0, manifold=M).compute(), atol=1e-13)


def test_failures_are_marked_or_name_the_problem():
    Y0, V0, Y1, V1 = random_ends("real")
    V0 = V0.copy()
    V0[3] += 0.1
    sweep = batches.solve_boundary(Y0, V0, Y1, V1, manifold=Grassmann(5, 2), chunk=2)
    with pytest.raises(InvalidInputError, match=r"^problem 3: V0: not horizontal") as caught:
        sweep["cost"].compute()
    assert caught.value.problem == (3,)
    lines = [np.eye(3)[:, :1], np.zeros((3, 1)), np.stack([np.eye(3)[:, :1], np.eye(3)[:, 1:2]]), np.zeros((3, 1))]
    marked = batches.solve_boundary(*lines, kind="geometric", manifold=Grassmann(3, 1), on_error="mark")
    assert marked["code"].compute().tolist() == [batches.Outcome.SOLVED, batches.Outcome.OUTSIDE_DOMAIN]
    assert np.isnan(marked["A"][1].compute()).all()


# ---------------------------------------------------------------- splines and evaluation


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("bc_type", ["natural", "clamped", "periodic"])
def test_splines(field, kind, bc_type):
    M, Y = manifold_of(field), knots_of(field, bc_type == "periodic")
    fields = ["velocities", "cost", "converged", "iterations", "residual", "points"]
    options = {"kind": kind, "at": AT, "manifold": M, "chunk": 2}
    (found,) = dask.compute(dict(batches.splines(KNOTS, Y, bc_type=bc_type, fields=fields, **options)))
    for i in range(len(Y)):
        curve = CubicSpline(KNOTS, Y[i], bc_type, kind, manifold=M)
        report = curve.report
        expected = {"velocities": at_given_bases(curve), "points": curve(AT), "cost": curve.cost()}
        expected |= {name: getattr(report, name) for name in ("converged", "iterations", "residual")}
        assert_same({name: values[i] for name, values in found.items()}, expected)
    assert np.abs(Y.conj().swapaxes(-1, -2) @ found["velocities"]).max() < 1e-13
    again = batches.splines(KNOTS, Y, found["velocities"], **options)["points"].compute()
    np.testing.assert_allclose(again, found["points"], atol=1e-11)


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("kind", KINDS)
def test_hermite_curves(field, kind):
    M, Y = manifold_of(field), knots_of(field, periodic=False)
    times = np.stack([KNOTS * (1 + i) for i in range(len(Y))])
    V = M.random_tangent(Y, rng=3) / 4
    given = batches.splines(times, Y, V, kind=kind, at=AT, manifold=M, chunk=2)
    named = batches.splines(times, Y, "akima", kind=kind, at=AT, manifold=M)["points"].compute()
    np.testing.assert_array_equal(named[2], CubicHermite(times[2], Y[2], "akima", kind, manifold=M)(AT))
    points, velocities, converged = dask.compute(given["points"], given["velocities"], given["converged"])
    np.testing.assert_array_equal(points[1], CubicHermite(times[1], Y[1], V[1], kind, manifold=M)(AT))
    np.testing.assert_allclose(velocities, V, atol=1e-13)
    assert converged.all()


def test_errors_of_splines_name_problem_and_knot():
    Y = knots_of("real", periodic=False).copy()
    Y[1, 2] *= 1.1
    with pytest.raises(InvalidInputError, match=r"^problem 1: ") as caught:
        batches.splines(KNOTS, Y, manifold=Grassmann(5, 2), chunk=2)["velocities"].compute()
    assert (caught.value.problem, caught.value.knot) == ((1,), 2)


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("what", ["point", "velocity", "acceleration", "jerk"])
def test_evaluation(field, what):
    M, ends = manifold_of(field), random_ends(field)
    initial = [da.from_array(array, chunks=(4, 5, 2)) for array in (ends[0], ends[1], ends[1] / 2, 2 * ends[1])]
    found = batches.evaluate(T, *initial, what=what, t_end=2.0, manifold=M).compute()
    curve = RiemannianCubic.from_initial(ends[0][6], ends[1][6], ends[1][6] / 2, 2 * ends[1][6], 2.0, manifold=M)
    np.testing.assert_array_equal(found[6], curve(T) if what == "point" else getattr(curve, what)(T))
    geometric = batches.evaluate(0.3, *ends, what=what, kind="geometric", chunk=4, manifold=M)[5].compute()
    curve = GeometricCubic(*(array[5] for array in ends), manifold=M)
    np.testing.assert_array_equal(geometric, curve(0.3) if what == "point" else getattr(curve, what)(0.3))


def test_evaluation_of_a_sweep():
    M, ends = batches.Grassmann(5, 2), random_ends("real")
    sweep = batches.solve_boundary(*ends, manifold=M, t=T)
    points = batches.evaluate(T, sweep["S"], sweep["V"], sweep["A"], sweep["J"], manifold=M)
    np.testing.assert_allclose(points.compute(), sweep["points"].compute(), atol=1e-12)


# ---------------------------------------------------------------- errors at once


@pytest.mark.parametrize(
    "manifold",
    [
        Grassmann(4, 2),
        Stiefel(5, 3),
        Stiefel(5, 2, metric="euclidean"),
        Grassmann(5, 2),
        Stiefel(5, 2),
        "Grassmann(5, 2)",
        3,
    ],
    ids=repr,
)
def test_bad_manifolds_raise_the_errors_of_the_class_at_once(manifold):
    """Of the shape, the metric, the field (the data are complex) or the type."""
    ends, Y = random_ends("complex", 2), knots_of("complex", periodic=False)
    one, spline = [array[0] for array in ends], (KNOTS, Y[0])
    with pytest.raises((InvalidInputError, TypeError)) as expected:
        RiemannianCubic.from_boundary(*one, manifold=manifold)
    calls = [lambda: CubicSpline(*spline, manifold=manifold), lambda: GeometricCubic(*one, manifold=manifold)]
    for kind in KINDS:
        calls += [
            lambda kind=kind: batches.solve_boundary(*ends, kind=kind, manifold=manifold, on_error="mark"),
            lambda kind=kind: batches.evaluate(T, *ends, kind=kind, manifold=manifold),
            lambda kind=kind: batches.splines(KNOTS, Y, kind=kind, manifold=manifold, on_error="mark"),
            lambda kind=kind: batches.splines(KNOTS, Y, 0 * Y, kind=kind, manifold=manifold, on_error="mark"),
            lambda kind=kind: batches.splines(KNOTS, Y, "akima", kind=kind, manifold=manifold, on_error="mark"),
        ]
    for call in calls:
        with pytest.raises(type(expected.value)) as caught:
            call()
        assert str(caught.value) == str(expected.value)
        assert str(caught.value).startswith("manifold: ")


def test_other_shapes_are_found_at_once():
    Y0, V0, Y1, V1 = random_ends("real")
    with pytest.raises(InvalidInputError, match=r"^manifold: Grassmann\(5, 2\) has points .* found .* \(2, 5\)$"):
        batches.solve_boundary(*(array.swapaxes(1, 2) for array in (Y0, V0, Y1, V1)), manifold=Grassmann(5, 2))
    with pytest.raises(InvalidInputError, match=r"^V0: expected shape \(\.\.\., 5, 2\)"):
        batches.solve_boundary(Y0, V0[:, :4], Y1, V1, manifold=Grassmann(5, 2))
    with pytest.raises(InvalidInputError, match=r"^pieces: not an option of riemannian"):
        batches.solve_boundary(Y0, V0, Y1, V1, pieces="geodesic", manifold=Grassmann(5, 2))


# ---------------------------------------------------------------- stores and clusters


@pytest.mark.parametrize("field", FIELDS)
def test_stores(field, tmp_path):
    M, ends, path = batches.Grassmann(5, 2, field=field), random_ends(field), tmp_path / "store"
    sweep = batches.solve_boundary(*ends, kind="geometric", manifold=M, t=T, chunk=4)
    stored = sweep.to_zarr(path)
    assert_same(dask.compute(stored)[0], dask.compute(dict(sweep))[0])
    assert_same(dask.compute(batches.from_zarr(path))[0], dask.compute(dict(sweep))[0])
    manifest = zarr.open_group(path, mode="r").attrs["stiefel_rs"]
    assert manifest["sweep"]["manifold"] == {"name": "Grassmann", "n": 5, "k": 2, "field": field}
    assert sweep.to_zarr(path, resume=True, compute=False).compute() == 0


def test_an_unfinished_store_goes_on(tmp_path):
    Y, path = knots_of("real", periodic=False, count=6), tmp_path / "store"
    options = {"kind": "geometric", "chunk": 2}
    sweep = batches.splines(KNOTS, Y, manifold=Grassmann(5, 2), **options)
    sweep.to_zarr(path)
    # Block 1 is incomplete.
    zarr.open_group(path, mode="r+")["complete"][1] = 0
    with pytest.raises(InvalidInputError, match="1 of 3 blocks are incomplete"):
        batches.from_zarr(path)
    for other in (None, Stiefel(5, 2)):
        with pytest.raises(InvalidInputError, match=r"belongs to another sweep, with different options$"):
            batches.splines(KNOTS, Y, manifold=other, **options).to_zarr(path, resume=True)
    same = batches.splines(KNOTS, Y, manifold=batches.Grassmann(5, 2), **options)
    assert same.to_zarr(path, resume=True, compute=False).compute() == 2
    assert_same(dask.compute(batches.from_zarr(path))[0], dask.compute(dict(sweep))[0])


def test_a_cluster():
    """Workers rebuild the manifold from its description."""
    M, ends, data = manifold_of("complex"), random_ends("complex", 4), vectors("complex")
    sweep = batches.solve_boundary(*ends, kind="geometric", manifold=M, chunk=1)
    angles = batches.Grassmann(5, 2, field="complex").principal_angles(da.from_array(data["Y"], chunks=4), data["R"])
    with cluster() as client:
        *found, there = client.compute([*sweep.values(), angles], sync=True)
    assert_same(dict(zip(sweep, found, strict=True)), dask.compute(dict(sweep))[0])
    np.testing.assert_array_equal(there, M.principal_angles(data["Y"], data["R"]))


@pytest.mark.parametrize("module", ["_grassmann", "_stiefel"])
def test_examples_run(module):
    failed, attempted = doctest.testmod(importlib.import_module(f"stiefel_rs.dask.{module}"))
    assert attempted > 0 and failed == 0


def test_public_names():
    assert "Grassmann" in batches.__all__ and issubclass(batches.Grassmann, _manifold.Manifold)
    assert all(getattr(batches.Grassmann, name).__doc__ for name in MAPS)
    assert stiefel_rs.dask is batches
