"""Trajectories in files: name -> function of a `Draw` that returns (callable, arguments)."""

import tempfile
from pathlib import Path

import numpy as np

import stiefel_rs

from .functions import damaged

HEADERS = ["t,x,y,z,qx,qy,qz,qw", "#timestamp [ns],p_RS_R_x [m],p_RS_R_y,p_RS_R_z,q_RS_x,q_RS_y,q_RS_z,q_RS_w"]


def poses(d):
    """Times, unit quaternions and positions."""
    count = d.of([1, 2, 5])
    q = d.rng.standard_normal((count, 4))
    return (
        np.cumsum(d.rng.uniform(0.1, 1, count)),
        q / np.linalg.norm(q, axis=1)[:, None],
        d.rng.normal(size=(count, 3)),
    )


def reading(read, name):
    """Read a file with the given bytes."""

    def call(content):
        if not isinstance(content, bytes):
            raise TypeError("bytes expected")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            path.write_bytes(content)
            return read(path)

    return call


def writing(write, name):
    """Write a file and read it."""

    def call(t, rotations, positions):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            write(path, t, (rotations, positions))
            return stiefel_rs.read_trajectory(path)

    return call


def text(d, name):
    t, q, p = poses(d)
    head, separator = (d.of(HEADERS), ",") if name.endswith(".csv") else ("# timestamp tx ty tz qx qy qz qw", " ")
    rows = np.column_stack([t, p, q]).tolist()
    return "\n".join([head, *(separator.join(map(repr, row)) for row in rows), ""]).encode()


def read_of(d, read, name):
    content = text(d, name)
    return reading(read, name), [damaged(content, d) if d.chance(0.5) else content], {}


TRAJECTORIES = {
    "read_tum": lambda d: read_of(d, stiefel_rs.read_tum, "a.tum"),
    "read_trajectory": lambda d: read_of(d, stiefel_rs.read_trajectory, d.of(["a.tum", "a.csv"])),
    "write_tum": lambda d: (writing(stiefel_rs.write_tum, "a.tum"), [*poses(d)], {}),
    "write_trajectory": lambda d: (writing(stiefel_rs.write_trajectory, d.of(["a.tum", "a.csv"])), [*poses(d)], {}),
}
