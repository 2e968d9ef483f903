"""Curves in files are restored bit for bit, and damaged or foreign files are refused by name."""

import itertools
import os
import pickle
import stat
import zipfile

import numpy as np
import pytest

import stiefel_rs
from stiefel_rs import (
    CubicHermite,
    CubicSpline,
    Curve,
    Geodesic,
    GeometricCubic,
    GeometricPolynomial,
    Grassmann,
    InvalidInputError,
    QuasiGeodesic,
    RiemannianCubic,
    SmoothingSpline,
    Stiefel,
    _core,
)


def walk(n, k, count, seed=0):
    manifold, rng = Stiefel(n, k), np.random.default_rng(seed + n + 100 * k)
    points = [manifold.random_point(rng)]
    for _ in range(count - 1):
        V = manifold.random_tangent(points[-1], rng)
        points.append(manifold.exp(points[-1], 0.5 * V / manifold.norm(points[-1], V)))
    t, S = np.cumsum(rng.uniform(0.5, 1.5, count)), np.stack(points)
    return t, S, 0.3 * manifold.random_tangent(S, rng)


def closed(t, S):
    return np.append(t, t[-1] + 1), np.concatenate([S, S[:1]])


def subspaces(S):
    return Grassmann(*S.shape[-2:])


def across(S, V):
    """The horizontal parts of vectors."""
    return V - S @ (S.swapaxes(-1, -2) @ V)


CURVES = {
    "line": lambda t, S, V: QuasiGeodesic(S[0], S[1]),
    "geodesic": lambda t, S, V: Geodesic(S[0], S[1]),
    "geometric cubic": lambda t, S, V: GeometricCubic(S[0], V[0], S[1], V[1]),
    "cubic of geodesics": lambda t, S, V: GeometricCubic(S[0], V[0], S[1], V[1], pieces="geodesic"),
    "polynomial": lambda t, S, V: GeometricPolynomial(S[:3]),
    "polynomial of subspaces": lambda t, S, V: GeometricPolynomial(S[:3], manifold=subspaces(S)),
    "cubic of subspaces": lambda t, S, V: GeometricCubic(
        S[0], across(S[0], V[0]), S[1], across(S[1], V[1]), manifold=subspaces(S)
    ),
    "minimal cost": lambda t, S, V: GeometricPolynomial.minimal_cost(S[0], V[0], S[1], V[1], degree=4),
    "initial": lambda t, S, V: RiemannianCubic.from_initial(S[0], V[0], V[0], 0 * V[0], 2.0).reversed(),
    "boundary": lambda t, S, V: RiemannianCubic.from_boundary(S[0], V[0], S[1], V[1]),
    "hermite": CubicHermite,
    "geometric hermite": lambda t, S, V: CubicHermite(t, S, V, "geometric", extrapolate=True),
    "geometric hermite of subspaces": lambda t, S, V: CubicHermite(
        t, S, across(S, V), "geometric", manifold=subspaces(S)
    ),
    "geometric spline of subspaces": lambda t, S, V: CubicSpline(t, S, kind="geometric", manifold=subspaces(S)),
    "natural": lambda t, S, V: CubicSpline(t, S),
    "clamped": lambda t, S, V: CubicSpline(t, S, "clamped", extrapolate=True),
    "periodic": lambda t, S, V: CubicSpline(*closed(t, S), "periodic"),
    "mixed": lambda t, S, V: CubicSpline(t, S, ((2, V[0]), "clamped")),
    "smoothing": lambda t, S, V: SmoothingSpline(t, S, lam=0.1),
    "velocities": lambda t, S, V: CubicSpline(t, S, ((1, V[0]), (1, V[-1]))),
}


def public(curve):
    """The attributes of a curve, as bytes and text."""
    found = {}
    for name in dir(curve):
        if name.startswith("_") or callable(getattr(curve, name)) or name == "pieces":
            continue
        value = getattr(curve, name)
        found[name] = repr(value) if not isinstance(value, np.ndarray) else (value.shape, value.tobytes())
    return found


def assert_same(again, original):
    assert type(again) is type(original)
    assert public(again) == public(original)
    start, end = original.t_span
    shares = np.linspace(-0.2, 1.2, 15) if getattr(original, "extrapolate", False) else np.linspace(0, 1, 15)
    t = np.clip(start + (end - start) * shares, start - 0.2 * (end - start), None)
    t[shares == 1] = end
    for nu in range(4):
        assert np.array_equal(again(t, nu), original(t, nu))
    assert again.cost() == original.cost()
    if isinstance(original, stiefel_rs.PiecewiseCurve):
        for found, expected in zip(again.pieces, original.pieces, strict=True):
            assert_same(found, expected)


@pytest.mark.parametrize("size", [(3, 1), (3, 2), (4, 4), (20, 2)])
@pytest.mark.parametrize("name", CURVES)
def test_the_same_curve_comes_back(name, size, tmp_path):
    original = CURVES[name](*walk(*size, 4))
    path = tmp_path / "curve of any name"
    original.save(path)
    again = stiefel_rs.load(path)
    assert isinstance(again, Curve)
    assert_same(again, original)
    assert_same(pickle.loads(pickle.dumps(original)), original)
    # Saving again gives the same bytes: nothing is lost.
    second = tmp_path / "second.npz"
    again.save(str(second))
    with np.load(path) as first, np.load(second) as other:
        assert first.files == other.files
        for key in first.files:
            assert np.array_equal(first[key], other[key])
    assert sorted(os.listdir(tmp_path)) == ["curve of any name", "second.npz"]


def test_the_file_is_one_of_plain_arrays(tmp_path):
    t, S, V = walk(3, 2, 4)
    path = tmp_path / "spline.npz"
    CubicSpline(t, S, ((1, V[0]), "natural")).save(path)
    with np.load(path, allow_pickle=False) as file:
        assert file["format"] == "stiefel_rs curve"
        assert file["version"] == 1
        assert file["kind"] == "CubicSpline"
        assert np.array_equal(file["t"], t)
        assert np.array_equal(file["S"], S)
        assert file["bc_first"] == "velocity"
        assert np.array_equal(file["bc_first_vector"], V[0])
        assert file["bc_last"] == "natural"


def test_a_file_is_replaced_only_by_a_whole_one(tmp_path):
    t, S, V = walk(3, 2, 4)
    path = tmp_path / "curve.npz"
    QuasiGeodesic(S[0], S[1]).save(path)
    CubicHermite(t, S, V).save(path)
    assert isinstance(stiefel_rs.load(path), CubicHermite)
    with pytest.raises(OSError):
        QuasiGeodesic(S[0], S[1]).save(tmp_path)
    with pytest.raises(FileNotFoundError) as missing:
        QuasiGeodesic(S[0], S[1]).save(tmp_path / "no" / "folder.npz")
    assert missing.value.filename == str(tmp_path / "no" / "folder.npz")
    with pytest.raises(TypeError):
        QuasiGeodesic(S[0], S[1]).save(7)
    assert os.listdir(tmp_path) == ["curve.npz"]


@pytest.mark.skipif(os.name == "nt", reason="files have other permissions there")
def test_a_file_that_is_replaced_keeps_its_permissions(tmp_path):
    _, S, _ = walk(3, 2, 2)
    curve, path = QuasiGeodesic(S[0], S[1]), tmp_path / "curve.npz"
    curve.save(path)
    for mode in (0o600, 0o640, 0o400):
        path.chmod(mode)
        curve.save(path)
        assert stat.S_IMODE(path.stat().st_mode) == mode
        (tmp_path / "new.npz").unlink(missing_ok=True)
        curve.save(tmp_path / "new.npz")
        # New files have the permissions of any file.
        (tmp_path / "plain").touch()
        assert (tmp_path / "new.npz").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_names_may_be_as_long_as_the_file_system_allows(tmp_path):
    _, S, _ = walk(3, 2, 2)
    curve = QuasiGeodesic(S[0], S[1])
    for length in (217, 218, 255):
        path = tmp_path / f"{'x' * (length - 4)}.npz"
        # Longer than the file system allows, whoever writes.
        try:
            path.touch()
        except OSError:
            continue
        curve.save(path)
        assert np.array_equal(stiefel_rs.load(path)(0.3), curve(0.3))


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_links_and_devices_stay_what_they_are(tmp_path):
    _, S, _ = walk(3, 2, 2)
    curve, path, link = QuasiGeodesic(S[0], S[1]), tmp_path / "curve.npz", tmp_path / "link.npz"
    link.symlink_to(path)
    curve.save(link)
    assert link.is_symlink()
    assert not path.is_symlink()
    assert np.array_equal(stiefel_rs.load(path)(0.3), curve(0.3))
    curve.save(os.devnull)
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)
    assert sorted(os.listdir(tmp_path)) == ["curve.npz", "link.npz"]


def refused(path, match):
    with pytest.raises(InvalidInputError, match=match) as caught:
        stiefel_rs.load(path)
    assert str(path) in str(caught.value)


def test_files_that_cannot_be_read_are_errors_of_the_system(tmp_path):
    with pytest.raises(FileNotFoundError):
        stiefel_rs.load(tmp_path / "nothing")
    with pytest.raises(OSError):
        stiefel_rs.load(tmp_path)
    with pytest.raises(TypeError):
        stiefel_rs.load(None)


def test_foreign_files_are_refused(tmp_path):
    path = tmp_path / "foreign"
    for content in (
        b"",
        b"P",
        b"PK",
        b"text",
        b"\x93NUMPY",
        os.urandom(1000),
        pickle.dumps(list(CURVES)),
        b"PK" + bytes(100),
    ):
        path.write_bytes(content)
        refused(path, ": .")
    with open(path, "wb") as file:
        np.save(file, np.zeros(3))
    refused(path, "not an archive of arrays")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "hello")
    refused(path, ": .")
    for arrays in (
        {},
        {"t": np.zeros(3)},
        {"format": "another", "version": 1, "kind": "CubicSpline"},
        {"format": "stiefel_rs curve", "version": 1, "kind": "Spline"},
        {"format": "stiefel_rs curve", "version": 1},
        {"format": "stiefel_rs curve", "version": 1, "kind": "CubicSpline"},
        {"format": "stiefel_rs curve", "version": 1, "kind": 7},
        {"format": "stiefel_rs curve", "version": 1.0, "kind": "CubicSpline"},
        {"format": np.array(["stiefel_rs curve"] * 2), "version": 1, "kind": "CubicSpline"},
    ):
        with open(path, "wb") as file:
            np.savez(file, **arrays)
        refused(path, "stored curve: |expected real numbers")
    with open(path, "wb") as file:
        np.savez(file, format=np.array({"a": 1}, object))
    refused(path, "pickle")


def test_compressed_files_are_refused_before_they_are_expanded(tmp_path):
    path = tmp_path / "curve.npz"
    QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).save(path)
    with np.load(path) as archive:
        np.savez_compressed(path, **archive)
    with pytest.raises(InvalidInputError, match="compressed arrays"):
        stiefel_rs.load(path)


def test_newer_files_say_so(tmp_path):
    t, S, _ = walk(3, 2, 4)
    path = tmp_path / "newer.npz"
    CubicSpline(t, S).save(path)
    with np.load(path) as file:
        arrays = dict(file)
    newer = "written by a newer version of the package, form 2; this version reads form 1"
    for version, match in ((2, newer), (0, "expected form 1, found 0")):
        with open(path, "wb") as file:
            np.savez(file, **{**arrays, "version": version})
        refused(path, match)


@pytest.mark.parametrize("name", ["line", "geometric cubic", "boundary", "hermite", "mixed"])
def test_truncated_files_are_refused(name, tmp_path):
    original = CURVES[name](*walk(3, 2, 3))
    path = tmp_path / "cut.npz"
    original.save(path)
    whole = path.read_bytes()
    for size in np.unique(np.linspace(0, len(whole) - 1, 120).astype(int)):
        path.write_bytes(whole[:size])
        refused(path, ": .")


@pytest.mark.parametrize("name", ["geometric cubic", "boundary", "mixed"])
def test_damaged_files_are_refused_or_the_same(name, tmp_path):
    original = CURVES[name](*walk(3, 2, 3))
    path = tmp_path / "damaged.npz"
    original.save(path)
    whole = path.read_bytes()
    rng, count = np.random.default_rng(0), 0
    for place in rng.choice(len(whole), 300, replace=False):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        try:
            again = stiefel_rs.load(path)
        except InvalidInputError as error:
            assert str(path) in str(error)
            count += 1
        else:
            # For example the date of an entry.
            assert_same(again, original)
    assert count > 100


def changed(i, x):
    """One entry changed by one percent."""
    x = x.copy()
    x.flat[i % x.size] += 0.01
    return x


EDITS = {
    "scaled": lambda x: 1.01 * x,
    "negated": lambda x: -x,
    "reversed": lambda x: np.flip(x, 0),
    "rows swapped": lambda x: np.flip(x, -2) if x.ndim > 1 else np.roll(x, 1),
    "first": lambda x: changed(0, x),
    "one": lambda x: changed(x.size // 2, x),
    "last": lambda x: changed(-1, x),
    "not finite": lambda x: np.full_like(x, np.nan),
}


@pytest.mark.parametrize("size", [(3, 1), (4, 4), (20, 2)])
@pytest.mark.parametrize("name", CURVES)
def test_edited_files_are_refused_or_curves_on_the_manifold(name, size, tmp_path):
    original = CURVES[name](*walk(*size, 4))
    path, manifold, count = tmp_path / "edited.npz", Stiefel(*size), 0
    original.save(path)
    with np.load(path) as file:
        arrays = dict(file)
    numbers = [key for key, x in arrays.items() if x.dtype == float and x.size]
    for key, edit in itertools.product(numbers, EDITS):
        with open(path, "wb") as file:
            np.savez(file, **{**arrays, key: EDITS[edit](arrays[key])})
        try:
            again = stiefel_rs.load(path)
        except InvalidInputError as error:
            assert "stored curve: " in str(error), error
            count += 1
            continue
        t = np.linspace(*again.t_span, 33)
        manifold.check_point(again(t), atol=1e-9)
        assert np.isfinite(again.jerk(t)).all(), f"{key}, {edit}"
        if hasattr(again, "points"):
            manifold.check_point(again.points, atol=1e-9)
    # Scaled or non-finite numbers do not form a curve, except for those that scale time.
    assert count >= 3 * len(numbers)


def test_points_off_the_manifold_are_refused_with_their_defect():
    t, S, V = walk(3, 2, 4)
    for curve, key in (
        (GeometricCubic(S[0], V[0], S[1], V[1]), "control_points"),
        (GeometricCubic(S[0], V[0], S[1], V[1], pieces="geodesic"), "control_points"),
        (CubicSpline(t, S), "S: knot 0"),
    ):
        form = curve._stored()
        name = key.split(":")[0]
        form[name] = 1.01 * form[name]
        with pytest.raises(InvalidInputError, match=rf"stored curve: {key}: columns are not orthonormal, by 2.8\d+e-2"):
            _core._restored(form)


def test_pickled_trajectories_are_checked():
    _, S, V = walk(3, 2, 2)
    trajectory = stiefel_rs.integrate_cubic(S[0], V[0], V[0], V[0], 4)
    restore, (arrays, *drifts) = trajectory.__reduce__()
    arrays = list(arrays)
    arrays[1] = 1.01 * arrays[1]
    with pytest.raises(InvalidInputError, match=r"point: state 0: columns are not orthonormal, by 2\.8"):
        restore(arrays, *drifts)


INCONSISTENT = {
    "t": lambda x: x[::-1],
    "S": lambda x: x[::-1],
    "extrapolate": lambda x: x + 2,
    "report": lambda x: x + 7,
    "bc_type": lambda x: np.array("not-a-knot"),
    "pieces": lambda x: np.array("cubic"),
    "bc_first": lambda x: np.array("periodic"),
    "bc_first_vector": lambda x: x[:2],
}


@pytest.mark.parametrize("name", INCONSISTENT)
def test_inconsistent_splines_are_refused(name, tmp_path):
    t, S, V = walk(3, 2, 4)
    path = tmp_path / "inconsistent.npz"
    CubicSpline(t, S, ((1, V[0]), "natural")).save(path)
    with np.load(path) as file:
        arrays = dict(file)
    with open(path, "wb") as file:
        np.savez(file, **{**arrays, name: INCONSISTENT[name](arrays[name])})
    refused(path, ": .")
    for changed in (arrays[name][..., None][:0], np.full(3, np.nan), np.array("word")):
        with open(path, "wb") as file:
            np.savez(file, **{**arrays, name: changed})
        refused(path, ": .")


def test_pieces_of_different_splines_are_refused(tmp_path):
    t, S, V = walk(3, 2, 4)
    path = tmp_path / "mixed.npz"
    CubicSpline(t, S).save(path)
    with np.load(path) as file:
        arrays = dict(file)
    CubicHermite(t, S, V, "geometric").save(path)
    with np.load(path) as file:
        other = dict(file)
    for mixed in ({**arrays, "kind": "CubicHermite"}, {**other, "kind": "CubicSpline"}, {**arrays, **other}):
        with open(path, "wb") as file:
            np.savez(file, **mixed)
        refused(path, "stored curve: ")
