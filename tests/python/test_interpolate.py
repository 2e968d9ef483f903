"""`stiefel-rs interpolate`: its output, and its messages for invalid input."""

import errno
import os
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from beside import HANGS

import stiefel_rs
from stiefel_rs import CubicHermite, CubicSpline, InvalidInputError, Stiefel, cli, interpolate

WITHOUT_MATPLOTLIB = "import sys; sys.modules['matplotlib'] = None; from stiefel_rs.cli import main; sys.exit(main())"


def rotations(count=6, n=3, k=2, step=0.6):
    """Points along a path with steps of equal length."""
    M = Stiefel(n, k)
    points = [M.random_point(rng=1)]
    for i in range(count - 1):
        V = M.random_tangent(points[-1], rng=2 + i)
        points.append(M.exp(points[-1], step * V / M.norm(points[-1], V)))
    return np.linspace(0.0, 3.0, count) ** 1.2, np.stack(points)


@pytest.fixture
def files(tmp_path):
    t, S = rotations()
    V = np.stack([Stiefel(3, 2).random_tangent(X, rng=i) for i, X in enumerate(S)])
    np.savez(tmp_path / "in.npz", t=t, S=S, V=V, weights=np.arange(1.0, 7.0))
    return tmp_path


def run(folder, *arguments, source="in.npz"):
    return cli.main(["interpolate", str(folder / source), "--out", str(folder / "out.npz"), *map(str, arguments)])


CURVES = {
    "riemannian": lambda t, S, V: CubicSpline(t, S),
    "hermite": CubicHermite,
    "geometric-hermite": lambda t, S, V: CubicHermite(t, S, V, kind="geometric"),
    "geometric": lambda t, S, V: CubicSpline(t, S, kind="geometric"),
}


@pytest.mark.parametrize("kind", CURVES)
def test_the_curve_is_that_of_the_class(files, kind, capsys):
    assert run(files, "--kind", kind) == 0
    with np.load(files / "in.npz") as data:
        expected = CURVES[kind](data["t"], data["S"], data["V"])
    found = stiefel_rs.load(files / "out.npz")
    t = np.linspace(*expected.t_span, 31)
    assert np.array_equal(found(t), expected(t))
    out, err = capsys.readouterr()
    assert not err
    assert out.startswith(f"St(3,2), 6 points, {kind}: cost {expected.cost():.6g}")
    assert not (files / "out_samples.npz").exists()


@pytest.mark.parametrize("bc_type", interpolate.BC_TYPES)
def test_ends(files, bc_type):
    with np.load(files / "in.npz") as data:
        arrays = dict(data)
    if bc_type == "periodic":
        arrays["S"][-1] = arrays["S"][0]
        arrays["V"][-1] = arrays["V"][0]
        np.savez(files / "in.npz", **arrays)
    assert run(files, "--bc-type", bc_type) == 0
    curve, V = stiefel_rs.load(files / "out.npz"), arrays["V"]
    first, last = curve.t_span
    gaps = {
        "natural": [curve.acceleration(first), curve.acceleration(last)],
        "clamped": [curve.velocity(first), curve.velocity(last)],
        "periodic": [
            curve.velocity(first) - curve.velocity(last),
            curve.acceleration(first) - curve.acceleration(last),
        ],
        "velocities": [curve.velocity(first) - V[0], curve.velocity(last) - V[-1]],
    }
    assert max(np.abs(gap).max() for gap in gaps[bc_type]) < 1e-10


def test_smoothing(files):
    assert run(files, "--kind", "smoothing", "--lam", "0.01") == 0
    with np.load(files / "in.npz") as data:
        expected = stiefel_rs.SmoothingSpline(data["t"], data["S"], weights=data["weights"], lam=0.01)
    t = np.linspace(*expected.t_span, 31)
    assert np.array_equal(stiefel_rs.load(files / "out.npz")(t), expected(t))


def test_samples(files, capsys):
    assert run(files, "--num", "11") == 0
    curve = stiefel_rs.load(files / "out.npz")
    with np.load(files / "out_samples.npz") as found:
        assert found.files == ["t", "S", "V", "A"]
        assert np.array_equal(found["t"], np.linspace(*curve.t_span, 11))
        assert np.array_equal(found["S"], curve(found["t"]))
        assert np.array_equal(found["V"], curve.velocity(found["t"]))
        assert np.array_equal(found["A"], curve.acceleration(found["t"]))
    assert run(files, "--at", "0.5,1.25", "--samples", files / "some.npz") == 0
    with np.load(files / "some.npz") as found:
        assert found["t"].tolist() == [0.5, 1.25]
        assert np.array_equal(found["S"], curve([0.5, 1.25]))
    assert f"samples: {files / 'some.npz'}, 2 times" in capsys.readouterr().out


def test_samples_outside_of_the_curve_are_an_error(files, capsys):
    assert run(files, "--at=-0.5,1") == 1
    assert "-0.5" in capsys.readouterr().err
    assert not (files / "out.npz").exists()


@pytest.mark.parametrize(("n", "k"), [(2, 1), (2, 2), (3, 1), (3, 2), (3, 3), (5, 2)])
def test_plots(files, n, k):
    t, S = rotations(4, n, k, step=0.4)
    np.savez(files / "in.npz", t=t, S=S)
    assert run(files, "--plot", files / "plot.png") == 0
    assert (files / "plot.png").read_bytes().startswith(b"\x89PNG")
    assert run(files, "--plot", files / "plot.svg") == 0
    assert b"<svg" in (files / "plot.svg").read_bytes()[:1000]


@pytest.mark.parametrize(
    ("arrays", "options", "message"),
    [
        ({}, [], "--kind riemannian needs the array 't'; found: none"),
        ({"t": [0.0, 1.0]}, [], "--kind riemannian needs the array 'S'; found: t"),
        ({"S": [[[1.0]]]}, [], "needs the array 't'; found: S"),
        ({"t": [0.0, 1.0], "S": np.eye(2)[:, :, None]}, ["--kind", "hermite"], "--kind hermite needs the array 'V'"),
        (
            {"t": [0.0, 1.0], "S": np.eye(2)[:, :, None]},
            ["--bc-type", "velocities"],
            "--bc-type velocities needs the array 'V'",
        ),
        ({"t": [0.0, 1.0], "S": np.eye(2)[:, :, None], "V": [1.0]}, ["--bc-type", "velocities"], "V: expected shape"),
        ({"t": [1.0, 0.0], "S": np.eye(2)[:, :, None]}, [], "t"),
        ({"t": [0.0, 1.0], "S": 2 * np.eye(2)[:, :, None]}, [], "orthonormal"),
        ({"t": [0.0, 1.0, 2.0], "S": np.eye(2)[:, :, None]}, [], "3"),
        ({"t": np.array([0, 1], "M8[s]"), "S": np.eye(2)[:, :, None]}, [], "t: "),
        ({"t": [0.0, 1.0], "S": np.eye(2)[:, :, None].astype(str)}, [], "S"),
    ],
)
def test_wrong_arrays(files, capsys, arrays, options, message):
    np.savez(files / "in.npz", **arrays)
    assert run(files, *options) == 1
    err = capsys.readouterr().err
    assert err.startswith("stiefel-rs: ")
    assert message in err
    assert len(err.splitlines()) == 1
    assert not (files / "out.npz").exists()


@pytest.mark.parametrize("content", [b"", b"hello", b"PK\x03\x04 torn off", b"\x80\x04pickle"])
def test_files_of_another_kind(files, capsys, content):
    (files / "bad.npz").write_bytes(content)
    assert run(files, source="bad.npz") == 1
    assert "bad.npz: not an .npz archive of plain arrays" in capsys.readouterr().err


def test_a_truncated_file(files, capsys):
    whole = (files / "in.npz").read_bytes()
    for length in (len(whole) // 3, len(whole) - 30):
        (files / "cut.npz").write_bytes(whole[:length])
        assert run(files, source="cut.npz") == 1
        assert "cut.npz: not an .npz archive" in capsys.readouterr().err


def marked(content, offset, value, size=1):
    """An archive whose first entry has other bytes in its local and its central header."""
    changed = bytearray(content)
    for start in (content.index(b"PK\x03\x04") - 2, content.index(b"PK\x01\x02")):
        changed[start + offset : start + offset + size] = value.to_bytes(size, "little")
    return bytes(changed)


@pytest.mark.parametrize(
    ("offset", "value", "message"),
    [(8, 1, "encrypted"), (10, 99, "compression")],
    ids=["encrypted", "unknown compression"],
)
def test_archives_that_cannot_be_unpacked(files, capsys, offset, value, message):
    (files / "bad.npz").write_bytes(marked((files / "in.npz").read_bytes(), offset, value))
    assert run(files, source="bad.npz") == 1
    err = capsys.readouterr().err
    assert err.startswith(f"stiefel-rs: {files / 'bad.npz'}: not an .npz archive of plain arrays (")
    assert message in err
    assert not (files / "out.npz").exists()


def test_damaged_compressed_arrays(files, capsys):
    with np.load(files / "in.npz") as data:
        np.savez_compressed(files / "bad.npz", **data)
    content = bytearray((files / "bad.npz").read_bytes())
    # A block of the third type, which deflate does not have.
    with zipfile.ZipFile(files / "bad.npz") as archive:
        first = archive.infolist()[0]
    name, extra = (int.from_bytes(content[first.header_offset + at :][:2], "little") for at in (26, 28))
    content[first.header_offset + 30 + name + extra] = 0x07
    (files / "bad.npz").write_bytes(content)
    assert run(files, source="bad.npz") == 1
    assert "bad.npz: not an .npz archive of plain arrays (Error -3" in capsys.readouterr().err


@pytest.mark.skipif(not os.path.exists("/proc/self/mem"), reason="a file of Linux")
def test_a_file_that_fails_while_it_is_read_is_named(files, capsys):
    assert cli.main(["interpolate", "/proc/self/mem", "--out", str(files / "out.npz")]) == 1
    assert capsys.readouterr().err == "stiefel-rs: /proc/self/mem: Input/output error\n"


def test_objects_and_single_arrays_are_refused(files, capsys):
    np.savez(files / "objects.npz", t=np.array([object()]), S=np.eye(2))
    np.save(files / "one.npy", np.eye(2))
    assert run(files, source="objects.npz") == 1
    assert "not an .npz archive of plain arrays" in capsys.readouterr().err
    assert run(files, source="one.npy") == 1
    assert "expected an .npz archive of t and S, found a single array" in capsys.readouterr().err
    with pytest.raises(InvalidInputError, match="found a single array"):
        interpolate.read(files / "one.npy")


def test_files_that_are_not_there(files, capsys):
    assert run(files, source="none.npz") == 1
    assert "none.npz: No such file" in capsys.readouterr().err
    assert not (files / "out.npz").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--out", "no folder/out.npz"], "--out: there is no folder"),
        (["--num", "5", "--samples", "no folder/s.npz"], "--samples: there is no folder"),
        (["--num", "5", "--samples", "folder.npz"], "folder.npz is a folder"),
        (["--plot", "no folder/p.png"], "--plot: there is no folder"),
        (["--plot", "folder"], "folder.png is a folder"),
        (["--plot", "p.doc"], "'p.doc' does not end in .png, .pdf or .svg"),
        (["--plot", "p.npz"], "does not end in .png"),
    ],
)
def test_files_that_could_not_be_written_are_refused_before_any_work(files, capsys, monkeypatch, options, message):
    monkeypatch.chdir(files)
    for name in ("folder.npz", "folder.png"):
        (files / name).mkdir()
    before = sorted(files.rglob("*"))
    with pytest.raises(SystemExit) as exit_code:
        run(files, *options)
    assert exit_code.value.code == 2
    assert message in capsys.readouterr().err
    assert sorted(files.rglob("*")) == before


def test_what_was_written_before_an_error_is_said(files, capsys, monkeypatch):
    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(interpolate.np, "savez", full)
    monkeypatch.setattr(stiefel_rs.CubicSpline, "save", lambda curve, path: path.touch(), raising=False)
    assert run(files, "--num", "5") == 1
    out, err = capsys.readouterr()
    assert out.endswith(f"curve: {files / 'out.npz'}\n")
    assert err == f"stiefel-rs: {files / 'out_samples.npz'}: No space left on device\n"
    assert sorted(path.name for path in files.iterdir()) == ["in.npz", "out.npz"]


def test_the_figure_has_the_name_that_is_said(files, capsys):
    assert run(files, "--plot", files / "plot") == 0
    assert capsys.readouterr().out.endswith(f"plot: {files / 'plot.png'}\n")
    assert (files / "plot.png").read_bytes().startswith(b"\x89PNG")
    assert not (files / "plot").exists()
    assert run(files, "--plot", files / "PLOT.PDF") == 0
    assert (files / "PLOT.PDF").read_bytes().startswith(b"%PDF")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_folder_that_cannot_be_written(files, capsys):
    folder = files / "closed"
    folder.mkdir(mode=0o500)
    assert run(files, "--out", folder / "out.npz") == 1
    assert "Permission denied" in capsys.readouterr().err


def test_without_matplotlib(files):
    command = ["interpolate", str(files / "in.npz"), "--out", str(files / "out.npz"), "--plot", str(files / "p.png")]
    found = subprocess.run(
        [sys.executable, "-c", WITHOUT_MATPLOTLIB, *command], capture_output=True, text=True, timeout=HANGS, check=False
    )
    assert found.returncode == 1
    assert "pip install 'stiefel-rs[plot]'" in found.stderr
    # The curve is written nevertheless.
    assert stiefel_rs.load(files / "out.npz").n == 3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--kind", "cubic"], "invalid choice"),
        (["--kind", "hermite", "--bc-type", "natural"], "--bc-type needs"),
        (["--lam", "1"], "--lam needs"),
        (["--kind", "smoothing", "--lam", "-1"], "not a number of at least 0"),
        (["--kind", "smoothing", "--lam", "nan"], "not a number of at least 0"),
        (["--num", "1"], "whole number from 2"),
        (["--num", "5", "--at", "1"], "not allowed with"),
        (["--at", "1,x"], "comma-separated list of numbers"),
        (["--samples", "s.npz"], "--samples needs"),
        (["--out", "out.txt"], "does not end in .npz"),
    ],
)
def test_usage(files, capsys, options, message):
    with pytest.raises(SystemExit) as exit_code:
        run(files, *options)
    assert exit_code.value.code == 2
    assert message in capsys.readouterr().err


def test_no_file_is_written_over_another(files, capsys):
    before = (files / "in.npz").read_bytes()
    for arguments, message in [
        (["--out", str(files / "in.npz")], "INPUT.npz and --out are the same file"),
        (["--num", "5", "--samples", str(files / "out.npz")], "--out and --samples are the same file"),
    ]:
        with pytest.raises(SystemExit):
            run(files, *arguments)
        assert message in capsys.readouterr().err
    assert (files / "in.npz").read_bytes() == before
    picture = files / "p.png"
    picture.write_bytes(before)
    # Without its extension, the name denotes the same file.
    with pytest.raises(SystemExit):
        run(files, "--plot", files / "p", source="p.png")
    assert "INPUT.npz and --plot are the same file" in capsys.readouterr().err
    assert picture.read_bytes() == before


def test_help(capsys, monkeypatch):
    # The name on the page of the documentation.
    monkeypatch.setenv("COLUMNS", "90")
    with pytest.raises(SystemExit) as exit_code:
        cli.main(["interpolate", "--help"])
    assert exit_code.value.code == 0
    text = capsys.readouterr().out
    assert all(f"  {kind} " in text for kind in interpolate.KINDS)
    assert max(map(len, text.splitlines())) <= 90
    # For readers who look for their data.
    assert "orientations as unit quaternions, scalar last" in text


def test_rounded_points_are_projected_where_it_is_asked_for(tmp_path, capsys):
    S = Stiefel(3, 2).random_point(rng=0, size=4).round(4)
    source, out = tmp_path / "rounded.npz", tmp_path / "curve.npz"
    np.savez(source, t=np.arange(4.0), S=S)
    assert cli.main(["interpolate", str(source), "--out", str(out)]) == 1
    assert "exceeds 1.000e-9; --project accepts it" in capsys.readouterr().err
    assert cli.main(["interpolate", str(source), "--project", "--out", str(out)]) == 0
    np.testing.assert_allclose(stiefel_rs.load(out)(1.0), Stiefel(3, 2).project(S[1]), atol=1e-13)


def test_arrays_of_objects_are_refused_in_plain_words(tmp_path, capsys):
    source = tmp_path / "objects.npz"
    np.savez(source, t=np.arange(2.0), S=np.array([object(), object()]))
    assert cli.main(["interpolate", str(source), "--out", str(tmp_path / "curve.npz")]) == 1
    message = capsys.readouterr().err
    assert "it holds Python objects: save arrays of numbers" in message
    assert "pickle" not in message
