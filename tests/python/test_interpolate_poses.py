"""`stiefel-rs interpolate` with trajectories: its output, and input refused before any computation."""

import itertools
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from stiefel_rs import cli, interpolate_poses, read_trajectory, sample_times, write_trajectory
from stiefel_rs.pose import PoseSpline
from stiefel_rs.rotation import RotationSpline

EXAMPLE = Path(__file__).parents[2] / "examples" / "data" / "freiburg1_xyz.tum"
START = 1.3e9


def poses(count=12):
    """Poses at uneven times that are exact in float64."""
    angle = np.linspace(0, 3, count)
    q = np.stack([np.sin(angle / 2) * 0.6, 0 * angle, np.sin(angle / 2) * 0.8, np.cos(angle / 2)], axis=1)
    q[3:] *= -1
    t = np.cumsum(np.tile([0.25, 0.5, 0.125], count)[:count])
    return t - t[0], (q, np.stack([np.cos(angle), np.sin(angle), angle**2], axis=1))


@pytest.fixture
def files(tmp_path):
    t, (q, p) = poses()
    write_trajectory(tmp_path / "in.tum", START + t, (q, p))
    write_trajectory(tmp_path / "in.csv", START + t, q)
    closed = np.append(q[:-1], q[:1], axis=0), np.append(p[:-1], p[:1], axis=0)
    write_trajectory(tmp_path / "closed.tum", START + t, closed)
    return tmp_path


def run(folder, *arguments, source="in.tum", out="out.tum"):
    return cli.main(["interpolate", str(folder / source), "--out", str(folder / out), *map(str, arguments)])


def table(path):
    """Names and numbers of a CSV file."""
    names = path.read_text().split("\n", 1)[0].split(",")
    return names, np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)


def test_poses_at_a_rate(files, capsys):
    t, given = poses()
    assert run(files, "--rate", "20") == 0
    out, err = capsys.readouterr()
    assert not err
    assert out == f"12 poses in {t[-1]} s, riemannian\nposes: {files / 'out.tum'}, {int(t[-1] * 20) + 1} times\n"
    found, (q, p) = read_trajectory(files / "out.tum")
    offsets = np.arange(int(t[-1] * 20) + 1) / 20
    # All decimals are written, so the result is the nearest float64.
    assert np.array_equal(found, START + offsets)
    expected, positions = PoseSpline(t, given)(offsets)
    assert np.array_equal(p, positions)
    assert np.abs(q - expected).max() < 1e-15
    assert (files / "out.tum").read_text().splitlines()[2].startswith("1300000000.05 ")


@pytest.mark.parametrize("bc_type", interpolate_poses.BC_TYPES)
def test_ends(files, bc_type):
    source = "closed.tum" if bc_type == "periodic" else "in.tum"
    assert run(files, "--bc-type", bc_type, "--num", "33", "--rates", source=source, out="out.csv") == 0
    t, given = read_trajectory(files / source)
    spline = PoseSpline(t - t[0], given, bc_type)
    names, numbers = table(files / "out.csv")
    assert names == ["t", "x", "y", "z", "qx", "qy", "qz", "qw", "vx", "vy", "vz", "wx", "wy", "wz"]
    offsets = np.linspace(0, t[-1] - t[0], 33)
    assert numbers[:, 1:4] == pytest.approx(spline(offsets)[1], abs=1e-14)
    assert numbers[:, 4:8] == pytest.approx(spline(offsets)[0], abs=1e-14)
    assert np.array_equal(numbers[:, 8:11], spline.linear_velocity(offsets, frame="world"))
    assert np.array_equal(numbers[:, 11:], spline.angular_velocity(offsets, frame="body"))
    if bc_type == "clamped":
        assert np.abs(numbers[[0, -1], 8:]).max() < 1e-12
    if bc_type == "periodic":
        assert np.abs(numbers[0, 8:] - numbers[-1, 8:]).max() < 1e-9


def test_orientations(files, capsys):
    assert run(files, "--at", f"{START + 0.5},{START + 1}", "--rates", source="in.csv", out="out.csv") == 0
    assert capsys.readouterr().out.startswith("12 rotations in ")
    t, (q, _) = poses()
    names, numbers = table(files / "out.csv")
    spline = RotationSpline(t, q)
    assert names == ["t", "qx", "qy", "qz", "qw", "wx", "wy", "wz"]
    assert numbers[:, 0].tolist() == [START + 0.5, START + 1]
    assert numbers[:, 1:5] == pytest.approx(spline([0.5, 1]), abs=1e-15)
    assert np.array_equal(numbers[:, 5:], spline.angular_velocity([0.5, 1]))
    assert run(files, "--num", "5", source="in.csv", out="out.tum") == 1
    assert "no positions, which" in capsys.readouterr().err
    assert not (files / "out.tum").exists()


def test_smoothing(files):
    assert run(files, "--kind", "smoothing", "--lam", "0.01", "--num", "9") == 0
    t, given = poses()
    _, (q, p) = read_trajectory(files / "out.tum")
    expected, positions = PoseSpline.smoothing(t, given, lam=0.01)(np.linspace(0, t[-1], 9))
    assert np.array_equal(p, positions)
    assert np.abs(q - expected).max() < 1e-15


def test_the_example(tmp_path):
    arguments = ["interpolate", str(EXAMPLE), "--rate", "200", "--out", str(tmp_path / "dense.tum")]
    assert cli.main(arguments) == 0
    knots, (_, known) = read_trajectory(EXAMPLE)
    t, (q, p) = read_trajectory(tmp_path / "dense.tum")
    assert len(t) == int((knots[-1] - knots[0]) * 200) + 1
    assert np.abs(np.diff(t) - 0.005).max() < 1e-6
    assert np.abs(np.linalg.norm(q, axis=1) - 1).max() < 1e-15
    assert np.abs(p[::2] - known[np.searchsorted(knots, t[::2] - 0.005)]).max() < 0.02


def test_nanoseconds_are_kept(files):
    _, (q, p) = poses(4)
    stamps = [1403715524907143168 + 5_000_001 * i for i in range(4)]
    rows = [
        ",".join(map(str, [s, *position, *quaternion])) for s, position, quaternion in zip(stamps, p, q, strict=True)
    ]
    header = "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_x [],q_RS_y [],q_RS_z [],q_RS_w []"
    (files / "ns.csv").write_text("\n".join([header, *rows]) + "\n")
    assert run(files, "--at", "1403715524.907143168,1403715524.912143169", source="ns.csv", out="out.csv") == 0
    lines = (files / "out.csv").read_text().splitlines()[1:]
    assert [line.split(",")[0] for line in lines] == ["1403715524.907143168", "1403715524.912143169"]
    # The second time is that of the second pose: times are not exact in float64, by 1e-7 s.
    assert table(files / "out.csv")[1][1, 1:4] == pytest.approx(p[1], abs=1e-15)


@pytest.mark.parametrize("kind", ["riemannian", "smoothing"])
def test_stamps_closer_than_float64_resolves(files, kind):
    _, (q, _) = poses(12)
    stamps = [1_700_000_000_000_000_000 + 100 * i for i in range(12)]
    rows = [",".join(map(str, [stamp, *quaternion])) for stamp, quaternion in zip(stamps, q, strict=True)]
    (files / "ns.csv").write_text("\n".join(["t [ns],qx,qy,qz,qw", *rows]) + "\n")
    options = ["--kind", kind, *(["--lam", "0"] if kind == "smoothing" else []), "--num", "12"]
    assert run(files, *options, source="ns.csv", out="out.csv") == 0
    lines = [line.split(",") for line in (files / "out.csv").read_text().splitlines()[1:]]
    # Sums of a stamp and a float64 have the digits of the float64.
    assert [round(Decimal(line[0]) * 10**12) for line in lines] == [1000 * stamp for stamp in stamps]
    found = np.array([[float(number) for number in line[1:]] for line in lines])
    assert np.abs(np.abs(np.sum(found * q, axis=1)) - 1).max() < 1e-12


@pytest.mark.parametrize(
    ("span", "rate", "count"),
    [(1.0, 10, 11), (0.3, 10, 4), (0.29999, 10, 3), (10.0, 29.97, 300), (0.5, 1, 1), (100 / 29.97, 29.97, 101)],
)
def test_times_of_a_rate(span, rate, count):
    t = sample_times.at_rate(span, rate)
    assert len(t) == count
    assert t[0] == 0
    assert t[-1] <= span
    assert np.abs(t * rate - np.arange(count)).max() < 1e-8


def test_a_rate_for_points(files):
    S = np.stack([np.eye(3), np.eye(3)[[1, 2, 0]]])
    np.savez(files / "in.npz", t=[1.0, 2.0], S=S)
    assert run(files, "--rate", "4", source="in.npz", out="out.npz") == 0
    with np.load(files / "out_samples.npz") as found:
        assert found["t"].tolist() == [1, 1.25, 1.5, 1.75, 2]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--rate", "1e9"], "--rate 1e+09: "),
        (["--at", "1"], "--at: 1 s is outside the times of the poses, 1300000000.0 to "),
        (["--at", "nan"], "--at: NaN s is outside"),
        (["--at", "1e9999"], "--at: 1E+9999 s is outside"),
        (["--at", "1_300_000_000"], "--at: not times in digits: 1_300_000_000"),
        (["--at", "1e9999999999"], "--at: not times in digits: 1e9999999999"),
        (["--at", f"1e{'9' * 20}"], "--at: not times in digits: 1e9"),
        (["--at", "1300000001,1300000000"], "--at: the times of poses must increase"),
    ],
)
def test_times_that_are_refused(files, capsys, options, message):
    assert run(files, *options) == 1
    err = capsys.readouterr().err
    assert err.startswith(f"stiefel-rs: {message}")
    assert len(err.splitlines()) == 1
    assert not (files / "out.tum").exists()


def test_errors_of_files(files, capsys):
    assert run(files, "--num", "5", source="none.tum") == 1
    assert capsys.readouterr().err == f"stiefel-rs: {files / 'none.tum'}: No such file or directory\n"
    (files / "bad.tum").write_text("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 2\n")
    assert run(files, "--num", "5", source="bad.tum") == 1
    assert capsys.readouterr().err.startswith(f"stiefel-rs: {files / 'bad.tum'}, line 2: the quaternion has norm 2,")
    half_turn = ["0 0 0 0 0 0 0 1", "1 0 0 0 0 0 0.7071 0.7071", "2 0 0 0 0 0 0.7071 -0.7071"]
    (files / "half.tum").write_text("\n".join(["# from a quarter turn to three", *half_turn]))
    assert run(files, "--num", "5", source="half.tum") == 1
    err = capsys.readouterr().err
    assert err.startswith(f"stiefel-rs: {files / 'half.tum'}, line 3: knots 1 and 2: ")
    (files / "one.tum").write_text("0 0 0 0 0 0 0 1\n")
    assert run(files, "--num", "5", source="one.tum") == 1
    assert capsys.readouterr().err.startswith("stiefel-rs: ")
    assert not (files / "out.tum").exists()


USAGE = [
    (["--num", "5"], "out.npz", "out.npz' does not end in .tum, .txt or .csv"),
    (["--num", "5"], "out.dat", "does not end in .npz, .tum, .txt or .csv"),
    ([], "out.tum", "INPUT.tum needs --rate, --num or --at"),
    (["--num", "5", "--rate", "5"], "out.tum", "not allowed with"),
    (["--rate", "0"], "out.tum", "'0' is not a positive number"),
    (["--rate", "inf"], "out.tum", "'inf' is not a positive number"),
    (["--rate", "fast"], "out.tum", "'fast' is not a positive number"),
    (["--num", "5", "--rates"], "out.tum", "--rates needs OUTPUT.csv"),
    (["--num", "5", "--kind", "geometric"], "out.tum", "--kind geometric needs INPUT.npz"),
    (["--num", "5", "--kind", "hermite"], "out.tum", "--kind hermite needs INPUT.npz"),
    (["--num", "5", "--bc-type", "velocities"], "out.tum", "--bc-type velocities needs INPUT.npz"),
    (["--num", "5", "--kind", "smoothing", "--bc-type", "natural"], "out.tum", "--bc-type needs"),
    (["--num", "5", "--lam", "1"], "out.tum", "--lam needs --kind smoothing"),
    (["--num", "5", "--samples", "s.npz"], "out.tum", "--samples needs INPUT.npz"),
    (["--num", "5", "--plot", "p.png"], "out.tum", "--plot needs INPUT.npz"),
    (["--num", "5"], "in.tum", "INPUT.tum and --out are the same file"),
    (["--num", "5"], "no folder/out.tum", "--out: there is no folder"),
    (["--num", "5"], "folder.tum", "folder.tum is a folder"),
]


@pytest.mark.parametrize(("options", "out", "message"), USAGE)
def test_usage(files, capsys, options, out, message):
    (files / "folder.tum").mkdir()
    before = sorted(files.rglob("*"))
    with pytest.raises(SystemExit) as exit_code:
        run(files, *options, out=out)
    assert exit_code.value.code == 2
    assert message in capsys.readouterr().err
    assert sorted(files.rglob("*")) == before


@pytest.mark.parametrize(
    ("options", "out", "message"),
    [
        ([], "out.tum", "does not end in .npz"),
        (["--num", "5", "--rates"], "out.npz", "--rates needs INPUT.tum or INPUT.csv"),
    ],
)
def test_usage_of_points(files, capsys, options, out, message):
    with pytest.raises(SystemExit):
        run(files, *options, source="in.npz", out=out)
    assert message in capsys.readouterr().err


def test_text_files_of_both_suffixes(files):
    (files / "in.txt").write_bytes((files / "in.tum").read_bytes())
    for source, out in itertools.product(("in.txt", "in.tum"), ("a.txt", "a.TUM")):
        assert run(files, "--num", "5", source=source, out=out) == 0
    assert (files / "a.txt").read_bytes() == (files / "a.TUM").read_bytes()
