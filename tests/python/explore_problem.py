"""The page's curves, computed directly by the library, and a server, for the tests of both."""

import threading
from contextlib import contextmanager

import numpy as np

from stiefel_rs import GeometricCubic, RiemannianCubic, Stiefel
from stiefel_rs.explore import curves, server
from stiefel_rs.explore.curves import KINDS


def library(kind, angle, v0, v1):
    """Both curves, computed directly by the library, and the manifold."""
    start, end = curves.ends(KINDS[kind], angle)
    V0, V1 = (np.tensordot(v, e.basis, 1) for v, e in ((v0, start), (v1, end)))
    data = start.point, V0, end.point, V1
    return GeometricCubic(*data), RiemannianCubic.from_boundary(*data), Stiefel(3, KINDS[kind].k)


@contextmanager
def running():
    """Run a server in a thread."""
    with server.Server("sphere") as made:
        thread = threading.Thread(target=made.serve_forever, kwargs={"poll_interval": 0.02})
        thread.start()
        try:
            yield made
        finally:
            made.shutdown()
            thread.join()
