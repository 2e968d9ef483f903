"""Trajectories in text files: round trips, files of other programs, and errors that name invalid lines."""

import decimal
import errno
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stiefel_rs
from stiefel_rs import InvalidInputError, read_trajectory, read_tum, trajectory_files, write_trajectory, write_tum

EXAMPLE = Path(__file__).parents[2] / "examples" / "data" / "freiburg1_xyz.tum"
# A quarter turn about z maps x to y; one about x maps y to z.
HALF = 0.5**0.5
TURN_Z = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])


def random_poses(count=50, seed=3):
    rng = np.random.default_rng(seed)
    q = rng.standard_normal((count, 4))
    t = 1.3e9 + np.cumsum(rng.uniform(0.01, 0.02, count))
    return t, q / np.linalg.norm(q, axis=1, keepdims=True), rng.standard_normal((count, 3))


def text_file(folder, text, name="in.tum"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize("name", ["a.tum", "a.txt", "a.csv", "A.CSV"])
def test_the_same_bits_come_back(tmp_path, name):
    t, q, p = random_poses()
    p[:3] = [[1e300, -1e-300, 5e-324], [0.0, -0.0, 0.1], [np.pi, 1e16, 1 / 3]]
    write_trajectory(tmp_path / name, t, (q, p))
    found, (quaternions, positions) = read_trajectory(tmp_path / name)
    assert found.tobytes() == t.tobytes()
    assert quaternions.tobytes() == q.tobytes()
    assert positions.tobytes() == p.tobytes()
    write_trajectory(tmp_path / f"again{name}", found, (quaternions, positions))
    assert (tmp_path / f"again{name}").read_bytes() == (tmp_path / name).read_bytes()


def test_orientations_alone(tmp_path):
    t, q, _ = random_poses()
    write_trajectory(tmp_path / "a.csv", t, q)
    assert (tmp_path / "a.csv").read_text().startswith("t,qx,qy,qz,qw\n")
    found, quaternions = read_trajectory(tmp_path / "a.csv")
    assert found.tobytes() == t.tobytes()
    assert quaternions.tobytes() == q.tobytes()
    for write, name in [(write_tum, "a.csv"), (write_trajectory, "a.tum")]:
        with pytest.raises(InvalidInputError, match=r"expected positions; a \.csv file may hold rotations alone"):
            write(tmp_path / name, t, q)


def test_a_file_of_the_benchmark():
    t, (q, p) = read_tum(EXAMPLE)
    assert (t.shape, q.shape, p.shape) == ((1000,), (1000, 4), (1000, 3))
    assert t[0] == 1305031098.6659
    assert p[0].tolist() == [1.3563, 0.6305, 1.6380]
    assert q[0] == pytest.approx([0.6132, 0.5962, -0.3311, -0.3986], abs=5e-5)
    assert np.abs(np.linalg.norm(q, axis=1) - 1).max() < 1e-15
    assert EXAMPLE.stat().st_size < 70_000


def test_the_last_number_is_the_scalar(tmp_path):
    # Known rotations: by 90 degrees about z, for which sine and cosine of the half angle are equal; and by 180 about x.
    path = text_file(tmp_path, f"0 1 2 3 0 0 {HALF!r} {HALF!r}\n1 0 0 0 1 0 0 0\n")
    _, (q, p) = read_tum(path)
    assert p[0].tolist() == [1, 2, 3]
    x, y, z, w = q[0]
    # The rotated x axis, by the formula for the first column.
    assert [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)] == pytest.approx([0, 1, 0], abs=1e-15)
    transform = pytest.importorskip("scipy.spatial.transform")
    assert transform.Rotation.from_quat(q[0]).as_matrix() == pytest.approx(TURN_Z, abs=1e-15)


def test_comments_blank_lines_and_line_ends(tmp_path):
    text = b"\xef\xbb\xbf# made by hand, with a \xb0\r\n\r\n0.5\t1 2  3 0 0 0 1   \r\n"
    text += b"   # more\r\n 1e0 1. .5 -3E-2 0 0 1 0\r\n\r\n"
    t, (q, p) = read_tum(text_file(tmp_path, text))
    assert t.tolist() == [0.5, 1.0]
    assert p.tolist() == [[1, 2, 3], [1, 0.5, -0.03]]
    assert q.tolist() == [[0, 0, 0, 1], [0, 0, 1, 0]]
    for end in ("\n", "\r\n", "\r"):
        lines = ["\ufefft,qw,qx,qy,qz", "", "# 1", "0,1,0,0,0 ", " 1 , 0 , 1 , 0 , 0", ""]
        t, q = read_trajectory(text_file(tmp_path, end.join(lines), "in.csv"))
        assert (t.tolist(), q.tolist()) == ([0, 1], [[0, 0, 0, 1], [1, 0, 0, 0]])


def test_quaternions_of_few_decimals_are_normalised(tmp_path):
    _, (q, _) = read_tum(text_file(tmp_path, "0 0 0 0 0.577 0.577 0.577 0.001\n1 0 0 0 -1.009 0 0 0\n"))
    assert np.abs(np.linalg.norm(q, axis=1) - 1).max() < 1e-15
    assert q[1].tolist() == [-1, 0, 0, 0]


WRONG = {
    "1 2 3 4 0 0 0": "line 3: expected 8 columns (timestamp tx ty tz qx qy qz qw), found 7",
    "1": "line 3: expected 8 columns (timestamp tx ty tz qx qy qz qw), found 1",
    "1 2 3 4 0 0 0 1 5": "line 3: expected 8 columns (timestamp tx ty tz qx qy qz qw), found 9",
    "1 2 3 four 0 0 0 1": "line 3: tz is 'four', not a number",
    "1 2 3 1_000 0 0 0 1": "line 3: tz is '1_000', not a number",
    "1 2 3 4 0 0 0 nan": "line 3: qw is nan, not finite",
    "1 -inf 3 4 0 0 0 1": "line 3: tx is -inf, not finite",
    "1 1e999 3 4 0 0 0 1": "line 3: tx is 1e999, not finite",
    "1 2 3 4 0 0 0 1.011": "line 3: the quaternion has norm 1.011, which differs from 1 by more than 0.01",
    "1 2 3 4 0 0 0 0": "line 3: the quaternion has norm 0,",
    "1 2 3 4 0 0 1e200 1": "line 3: the quaternion has norm",
    "0 2 3 4 0 0 0 1": "line 3: time 0 s does not come after 0.00 s in line 2",
    "-1.50 2 3 4 0 0 0 1": "line 3: time -1.50 s does not come after 0.00 s in line 2",
}


@pytest.mark.parametrize("line", WRONG)
def test_wrong_lines(tmp_path, line):
    path = text_file(tmp_path, f"# comment\n0.00 0 0 0 0 0 0 1\n{line}\n9 0 0 0 0 0 0 1\n")
    with pytest.raises(InvalidInputError, match=re.escape(f"{path}, {WRONG[line]}")):
        read_tum(path)


def test_times_that_are_equal_as_float64(tmp_path):
    path = text_file(tmp_path, "1300000000.00000001 0 0 0 0 0 0 1\n1300000000.00000002 0 0 0 0 0 0 1\n")
    with pytest.raises(
        InvalidInputError,
        match=r"line 2: time 1300000000\.00000002 s is the same as 1300000000\.00000001 s in line 1 for a float",
    ):
        read_tum(path)


def test_exact_stamps_may_be_closer_than_float64_resolves(tmp_path):
    text = "t [ns],qx,qy,qz,qw\n1700000000000000000,0,0,0,1\n\n1700000000000000100,0,0,0.6,0.8\n"
    path = text_file(tmp_path, text, "in.csv")
    found = trajectory_files.read(path)
    assert [str(stamp) for stamp in found.stamps] == ["1700000000.000000000", "1700000000.000000100"]
    with pytest.raises(InvalidInputError, match=r"in\.csv, line 4: .* is the same as .* in line 2 for a float"):
        read_trajectory(path)
    path = text_file(tmp_path, text + "1700000000000000100,0,0,0.6,0.8\n", "in.csv")
    with pytest.raises(InvalidInputError, match=r"in\.csv, line 5: .* does not come after .* in line 4$"):
        trajectory_files.read(path)


def test_nanoseconds_whose_unit_is_not_said(tmp_path):
    path = text_file(tmp_path, "timestamp,qx,qy,qz,qw\n1403636579758555392,0,0,0,1\n", "in.csv")
    with pytest.raises(
        InvalidInputError,
        match=r"line 2: .* probably not in seconds; .*timestamp \[ns\]",
    ):
        read_trajectory(path)


@pytest.mark.parametrize("text", ["", "# nothing\n\n", "\n"])
def test_no_poses(tmp_path, text):
    with pytest.raises(InvalidInputError, match=r"in\.tum: expected at least one pose, found none"):
        read_tum(text_file(tmp_path, text))
    with pytest.raises(InvalidInputError, match=r"in\.csv: no header"):
        read_trajectory(text_file(tmp_path, text, "in.csv"))
    with pytest.raises(InvalidInputError, match=r"in\.csv: expected at least one pose, found none"):
        read_trajectory(text_file(tmp_path, "t,qx,qy,qz,qw\n" + text, "in.csv"))


def test_bytes_that_are_no_text(tmp_path):
    with pytest.raises(InvalidInputError, match=r"line 1: expected 8 columns \(.*\), found 1"):
        read_tum(text_file(tmp_path, b"PK\x03\x04\xff\x00\x80"))


def test_one_pose_and_extreme_numbers(tmp_path):
    t, (q, p) = read_tum(text_file(tmp_path, "0e-99999999999999999999 1e-400 1e308 5e-324 0 0 0 1\n"))
    assert t.tolist() == [0]
    assert p.tolist() == [[0, 1e308, 5e-324]]
    assert q.tolist() == [[0, 0, 0, 1]]


def test_columns_in_any_order(tmp_path):
    text = 'frame_id,qz,"Time",qw, TX ,qx,tz,qy,ty\nbase_link,0.6,2.5,0.8,1,0,3,0,2\n'
    t, (q, p) = read_trajectory(text_file(tmp_path, text, "in.csv"))
    assert (t.tolist(), p.tolist(), q.tolist()) == ([2.5], [[1, 2, 3]], [[0, 0, 0.6, 0.8]])


@pytest.mark.parametrize(
    ("unit", "seconds"), [("s", 1e9), ("ms", 1e6), ("us", 1e3), ("µs", 1e3), ("ns", 1.0), ("", 1e9)]
)
def test_units(tmp_path, unit, seconds):
    text = f"timestamp [{unit}],x (mm),y [cm],z [m],qx [],qy,qz,qw\n1000000000,1001,1001,1001,0,0,0,1\n"
    t, (_, p) = read_trajectory(text_file(tmp_path, text, "in.csv"))
    assert t.tolist() == [seconds]
    assert p.tolist() == [[1.001, 10.01, 1001.0]]


@pytest.mark.parametrize("unit", ["", " [ns]"])
def test_euroc(tmp_path, unit):
    text = (
        f"#timestamp{unit}, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
        "v_RS_R_x [m s^-1]\n"
        "1403715524907143168,0.515356,1.996773,0.971104,0.161996,0.789985,-0.205376,0.554528,-0.002276\n"
    )
    path = text_file(tmp_path, text, "in.csv")
    t, (q, p) = read_trajectory(path)
    assert t.tolist() == [1403715524.907143168]
    assert p.tolist() == [[0.515356, 1.996773, 0.971104]]
    assert q[0] == pytest.approx([0.789985, -0.205376, 0.554528, 0.161996], abs=1e-6)
    with decimal.localcontext() as context:
        # Any content of the user.
        context.prec = 3
        assert str(trajectory_files.read(path).stamps[0]) == "1403715524.907143168"


HEADERS = {
    "0,0,0,0,1": "line 1: no columns for the time (t or time or timestamp); the header is '0,0,0,0,1'",
    "t,x,y,z": "line 1: no columns for the orientation (qx qy qz qw or q_rs_x q_rs_y q_rs_z q_rs_w)",
    "t,qx,qy,qz": "line 1: column qw of qx qy qz qw is missing",
    "t,x,qx,qy,qz,qw": "line 1: column y z of x y z is missing",
    "t,time,qx,qy,qz,qw": "line 1: expected one of t and time, found both",
    "t,x,y,z,tx,ty,tz,qx,qy,qz,qw": "line 1: expected one of x y z and tx ty tz, found both",
    "t,qx,qy,qz,qw,qx": "line 1: 2 columns are named 'qx'",
    "t [h],qx,qy,qz,qw": "line 1: expected one of the units s, ms, us, ns for t, found 'h'",
    "t,x [in],y,z,qx,qy,qz,qw": "line 1: expected one of the units m, cm, mm for x, found 'in'",
    "# a comment\n#t,qx,qy,qw": "line 2: column qz of qx qy qz qw is missing",
    "# t and so on": "line 2: no columns for the time",
    "t;qx;qy;qz;qw": "line 1: no columns for the time",
}


@pytest.mark.parametrize("header", HEADERS)
def test_wrong_headers(tmp_path, header):
    path = text_file(tmp_path, f"{header}\n1,0,0,0,1\n", "in.csv")
    with pytest.raises(InvalidInputError, match=re.escape(f"{path}, {HEADERS[header]}")):
        read_trajectory(path)


def test_rows_as_wide_as_the_header(tmp_path):
    path = text_file(tmp_path, "t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0,1,\n", "in.csv")
    with pytest.raises(InvalidInputError, match=r"in\.csv, line 3: expected 5 columns, as in the header, found 6"):
        read_trajectory(path)


def test_other_suffixes(tmp_path):
    path = text_file(tmp_path, "0 0 0 0 0 0 0 1\n", "poses.dat")
    for call in (read_trajectory, lambda path: write_trajectory(path, [0.0], np.eye(4)[None])):
        with pytest.raises(InvalidInputError, match=r"poses\.dat: does not end in \.tum, \.txt or \.csv"):
            call(path)
    assert len(read_tum(path)[0]) == 1
    # By its bytes, as `os` accepts names.
    assert len(read_tum(os.fsencode(path))[0]) == 1
    with pytest.raises(FileNotFoundError, match=r"none\.tum"):
        read_tum(tmp_path / "none.tum")


def test_poses_of_every_kind(tmp_path):
    transform = pytest.importorskip("scipy.spatial.transform")
    t, q, p = random_poses()
    R = transform.Rotation.from_quat(q)
    T = np.tile(np.eye(4), (len(t), 1, 1))
    T[:, :3, :3], T[:, :3, 3] = R.as_matrix(), p
    kinds = [(q, p), (R, p), (R.as_matrix(), p), T, T.tolist(), tuple(T)]
    if hasattr(transform, "RigidTransform"):
        kinds.append(transform.RigidTransform.from_components(p, R))
    for poses in kinds:
        write_tum(tmp_path / "a.tum", t, poses)
        found, (quaternions, positions) = read_tum(tmp_path / "a.tum")
        assert found.tobytes() == t.tobytes()
        assert np.abs(positions - p).max() == 0
        assert np.abs((quaternions * q).sum(axis=1)).min() > 1 - 4e-15
    write_trajectory(tmp_path / "a.csv", t, R.as_matrix())
    assert np.abs((read_trajectory(tmp_path / "a.csv")[1] * q).sum(axis=1)).min() > 1 - 4e-15
    write_tum(tmp_path / "a.tum", [0], (np.eye(4),))
    assert read_tum(tmp_path / "a.tum")[1][0].tolist() == [[0, 0, 0, 1]]


def test_quaternions_of_matrices_are_continuous(tmp_path):
    angle = np.linspace(0, 12, 200)
    R = np.tile(np.eye(3), (200, 1, 1))
    R[:, 0, 0] = R[:, 1, 1] = np.cos(angle)
    R[:, 1, 0], R[:, 0, 1] = np.sin(angle), -np.sin(angle)
    write_trajectory(tmp_path / "a.csv", angle, R)
    _, q = read_trajectory(tmp_path / "a.csv")
    assert np.abs(q - np.stack([0 * angle, 0 * angle, np.sin(angle / 2), np.cos(angle / 2)], axis=1)).max() < 1e-14


ID = np.eye(4)[None]


@pytest.mark.parametrize(
    ("t", "poses", "message"),
    [
        ([0.0], (np.eye(4)[:1], np.zeros((2, 3))), "positions: expected shape (1, 3), found (2, 3)"),
        ([0.0], (np.zeros((1, 5)), np.zeros((1, 3))), "rotations: expected shape (N, 4), found (1, 5)"),
        ([0.0], (np.eye(4)[:1],) * 3, "poses: expected a pair (rotations, positions), found 3 entries"),
        ([0.0], np.zeros((1, 2)), "poses: expected shape (N, 4)"),
        ([0.0], (2 * np.eye(4)[:1], np.zeros((1, 3))), "rotations: entry 0: the quaternion has norm 2"),
        ([0.0], (np.full((1, 3, 3), 0.5), np.zeros((1, 3))), "rotations: matrix 0 is not orthogonal, defect 0.75"),
        ([0.0], (np.full((1, 3, 3), 1e300), np.zeros((1, 3))), "rotations: matrix 0 is not orthogonal, defect "),
        ([0.0], (-np.eye(3)[None], np.zeros((1, 3))), "rotations: matrix 0 is a reflection"),
        ([0.0], ID * np.array([1, 1, 1, 2.0])[:, None], "pose 0: expected the last row (0, 0, 0, 1), found"),
        ([0.0], ID * np.nan, "poses: 16 of 16 entries are not finite"),
        ([0.0, 1.0], ID, "t and poses: expected the same number, at least one, found 2 and 1"),
        ([], np.zeros((0, 4, 4)), "t and poses: expected the same number, at least one, found 0 and 0"),
        ([0.0, 0.0], np.tile(ID, (2, 1, 1)), "t: entry 1 is 0.0, which does not come after 0.0"),
        ([np.inf], ID, "t: 1 of 1 entries are not finite"),
        ([1e12], ID, "t: 1000000000000.0 s exceeds 1e+11 s"),
        ([[0.0]], ID, "t: expected shape (N,), found (1, 1)"),
        (np.ma.masked_all(1), ID, "t: 1 of 1 entries is masked"),
    ],
)
def test_wrong_poses_are_not_written(tmp_path, t, poses, message):
    path = text_file(tmp_path, "old")
    with pytest.raises(InvalidInputError, match=re.escape(message)):
        write_tum(path, t, poses)
    assert path.read_text() == "old"
    with pytest.raises(TypeError, match="t: expected real numbers"):
        write_tum(path, [1j], ID)


def test_a_write_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    path, (t, q, p) = text_file(tmp_path, "old"), random_poses()

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(stiefel_rs.storage.os, "replace", full)
    with pytest.raises(OSError, match=r"No space left on device: '.*in\.tum'"):
        write_tum(path, t, (q, p))
    assert path.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["in.tum"]


# A disk with room for 1000 bytes; the rest of a longer write fails.
FULL = """\
import errno, io
class Full(io.FileIO):
    ROOM = 1000

    def write(self, data):
        if self.tell() + len(data) <= self.ROOM:
            return super().write(data)
        super().write(bytes(data)[: self.ROOM - self.tell()])
        return self.fail()

    def fail(self):
        raise OSError(errno.ENOSPC, "No space left on device")
"""


@pytest.mark.parametrize("write", [write_tum, write_trajectory])
def test_a_write_that_fails_in_the_middle_leaves_the_old_file(tmp_path, monkeypatch, write):
    path, (t, q, p), written = text_file(tmp_path, "old"), random_poses(), []
    names = {}
    exec(FULL, names)

    class Full(names["Full"]):
        def fail(self):
            written.append(Path(self.name).read_bytes())
            super().fail()

    monkeypatch.setattr(
        stiefel_rs.storage, "open", lambda path, mode: io.BufferedWriter(Full(path, mode)), raising=False
    )
    with pytest.raises(OSError, match=r"No space left on device: '.*in\.tum'"):
        write(path, t, (q, p))
    # Part of the new file was on the disk.
    assert written[0].startswith(b"# timestamp") and len(written[0]) == 1000
    assert path.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["in.tum"]


def test_a_process_that_ends_in_the_middle_leaves_the_old_file(tmp_path):
    path = text_file(tmp_path, "old")
    lines = [
        FULL,
        "import os, numpy, stiefel_rs.storage",
        "Full.fail = lambda self: os._exit(7)",
        "stiefel_rs.storage.open = lambda path, mode: io.BufferedWriter(Full(path, mode))",
        "t, ones = numpy.arange(5000.0), numpy.ones((5000, 1))",
        f"stiefel_rs.write_tum({str(path)!r}, t, (ones * [0, 0, 0, 1], ones * [1, 2, 3]))",
    ]
    found = subprocess.run([sys.executable, "-c", "\n".join(lines)], check=False)
    assert found.returncode == 7
    assert path.read_text() == "old"
    # What was written so far has another name.
    (other,) = (file for file in tmp_path.iterdir() if file != path)
    assert re.fullmatch(r"\.stiefel_rs-[0-9a-f]{8}\.part", other.name)
    assert other.stat().st_size == 1000


def test_many_rows(tmp_path):
    # More than are formatted at once.
    t = np.arange(10_000.0)
    q = np.tile([0, 0, 0, 1.0], (len(t), 1))
    write_tum(tmp_path / "a.tum", t, (q, np.stack([t, -t, t / 3], axis=1)))
    found, (_, p) = read_tum(tmp_path / "a.tum")
    assert np.array_equal(found, t)
    assert np.array_equal(p[:, 2], t / 3)
