"""The page's curves, computed directly by the library, and a server, for the tests of both."""

import base64
import threading
from contextlib import contextmanager

import numpy as np

from stiefel_rs import CubicSpline, GeometricCubic, RiemannianCubic, RotationSpline, Stiefel
from stiefel_rs.explore import server, two_ends


def library(kind, angle, v0, v1):
    """Both curves straight from the library, and the manifold."""
    start, end = two_ends.ends(two_ends.KINDS[kind], angle)
    V0, V1 = (np.tensordot(v, e.basis, 1) for v, e in ((v0, start), (v1, end)))
    data = start.point, V0, end.point, V1
    found = {"cubic": RiemannianCubic.from_boundary(*data), "gcp": GeometricCubic(*data)}
    return found, Stiefel(3, two_ends.KINDS[kind].k)


def spline(kind, t, values, ends="natural"):
    """The spline of a scene of keyframes straight from the library."""
    values = np.asarray(values)
    if kind == "points":
        return CubicSpline(t, values[:, :, None], ends)
    return RotationSpline(t, values, ends).curve


def floats(text):
    """Entries of an array of an answer."""
    return np.frombuffer(base64.b64decode(text), "<f4")


@contextmanager
def running(kind="sphere"):
    """Run a server in a thread."""
    with server.Server(kind) as made:
        thread = threading.Thread(target=made.serve_forever, kwargs={"poll_interval": 0.02})
        thread.start()
        try:
            yield made
        finally:
            made.shutdown()
            thread.join()
