"""Curves stored by older versions can be read: their files are kept here, one folder per version of the form."""

from pathlib import Path

import numpy as np
import pytest

import stiefel_rs

FOLDERS = sorted(Path(__file__).parent.glob("stored_*"))
FILES = [path for folder in FOLDERS for path in sorted(folder.glob("*.npz")) if path.stem != "values"]
# The values were computed on one processor; others round differently, some hundred times in between.
TOLERANCE = 1000 * np.finfo(float).eps


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_curve_is_read_and_is_where_it_was(path):
    curve = stiefel_rs.load(path)
    start, end = curve.t_span
    found = curve(np.clip(start + (end - start) * np.linspace(0, 1, 7), min(start, end), max(start, end)))
    with np.load(path.parent / "values.npz") as values:
        assert np.abs(found - values[path.stem]).max() < TOLERANCE


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_every_number_is_written_again(path, tmp_path):
    again = tmp_path / "again.npz"
    stiefel_rs.load(path).save(again)
    with np.load(path) as before, np.load(again) as after:
        if int(before["version"]) != int(after["version"]):
            pytest.skip("of an older form")
        assert set(after.files) == set(before.files)
        for name in before.files:
            assert after[name].dtype == before[name].dtype
            assert after[name].tobytes() == before[name].tobytes(), name


def test_every_version_and_every_class_has_its_files(tmp_path):
    stiefel_rs.QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).save(tmp_path / "line.npz")
    with np.load(tmp_path / "line.npz") as line:
        newest = int(line["version"])
    assert [folder.name for folder in FOLDERS] == [f"stored_{version}" for version in range(1, newest + 1)]
    kinds = {type(stiefel_rs.load(path)) for path in FOLDERS[-1].glob("*.npz") if path.stem != "values"}
    public = {getattr(stiefel_rs, name) for name in stiefel_rs.__all__}
    curves = {thing for thing in public if isinstance(thing, type) and issubclass(thing, stiefel_rs.Curve)}
    assert curves - {stiefel_rs.Curve, stiefel_rs.PiecewiseCurve} == kinds
