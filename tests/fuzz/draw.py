"""Random arguments: points, tangent vectors, times and numbers, most of them valid, some not."""

import array
import decimal
import fractions
import math
import random

import numpy as np

TINY = 5e-324
SPECIAL = [0.0, -0.0, TINY, 1e-310, 1e-300, 1e-160, 1e-16, 1e-8, 1.0, -1.0, math.pi, 1e8, 1e16, 1e155, 1e300, 1e308]
NOT_FINITE = [math.nan, math.inf, -math.inf]
SCALES = [0.0, TINY, 1e-310, 1e-160, 1e-16, 1e-8, 3.0, math.pi, 2 * math.pi, 1e3, 1e8, 1e155, 1e300]
DTYPES = [
    *["?", "i1", "u1", "i4", ">i4", "i8", "u8", "f2", "f4", ">f4", ">f8", "g", "F", "D", "G", "O", "S8", "U8"],
    *["m8[s]", "M8[s]", "V8"],
]


class Refuses:
    """Looks like an array, but cannot be read."""

    def __array__(self, dtype=None, copy=None):
        raise ValueError("no array inside")

    def __float__(self):
        raise ValueError("no number inside")

    def __index__(self):
        raise ValueError("no integer inside")


class IsNumber:
    def __float__(self):
        return 0.5

    def __index__(self):
        return 2


def junk():
    return [
        *[
            None,
            "",
            "text",
            "natural",
            "\ud800",
            b"x",
            1j,
            {},
            set(),
            object(),
            [],
            (),
            [[]],
            [[1.0], [2.0, 3.0]],
            True,
        ],
        *[0, -1, 2**63, 10**30, 10**400, 0.5, math.nan, Refuses(), IsNumber(), iter([1.0]), int, len, Ellipsis],
        *[np.float64(0.5), np.int8(3), np.datetime64("2020-01-01"), np.zeros(()), np.zeros((0,)), np.zeros((3, 0, 2))],
        *[np.zeros((2, 2), object), np.array("text"), decimal.Decimal("0.5"), fractions.Fraction(1, 2)],
        *[np.ma.masked_array([1.0, 2.0], [True, False]), memoryview(b"abcdefgh"), array.array("d", [0.0, 1.0])],
        *[
            np.zeros((1,) * 32),
            slice(None),
            range(4),
            "x" * 5000,
            [[[[[[[[1.0]]]]]]]],
            ("natural", "natural"),
            ((1, 2),),
        ],
    ]


class Draw:
    """The choices of one case; `source` is a `random.Random`."""

    def __init__(self, source: random.Random):
        self.source = source
        self.rng = np.random.default_rng(source.getrandbits(64))
        self.n = source.choice([1, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 5, 5, 6, 9, 12, 14])
        # Near squares, and in many rows also few columns: legs of splines then have other coordinates than points.
        is_tall = self.n > 6 and source.random() < 0.7
        self.k = source.choice([1, 2, 3]) if is_tall else self.n - source.choice([0, 1, 2, 2, 3]) % self.n
        # How unusual the case is: in a third of them all arguments are valid.
        self.wild = source.choice([0.0, 0.15, 0.4])
        self.seen = []

    def chance(self, p):
        return self.source.random() < p

    def of(self, values):
        return self.source.choice(values)

    # Valid values.

    def orthonormal(self, n, k):
        kind = self.of(["eye", "signed", "random", "random", "random"])
        if kind == "eye":
            return np.eye(n, k)
        if kind == "signed":
            S = np.zeros((n, k))
            S[self.rng.permutation(n)[:k], np.arange(k)] = self.rng.choice([-1.0, 1.0], k)
            return S
        return np.linalg.qr(self.rng.standard_normal((n, k)))[0]

    def point(self):
        """A point of St(n, k): new, equal to the last one, opposite to it, or near it."""
        S = self.orthonormal(self.n, self.k)
        if self.seen and self.chance(0.5):
            last = self.seen[-1]
            kind = self.of(["same", "opposite", "near", "near", "near", "turned"])
            if kind == "same":
                S = last.copy()
            elif kind == "opposite" and self.chance(self.wild):
                S = -last
            elif kind == "turned":
                S = np.ascontiguousarray(last[:, ::-1])
            else:
                step = self.of([1e-300, 1e-16, 1e-12, 1e-8, 1e-3, 0.1, 0.3, 0.5])
                S = np.linalg.qr(last + step * self.rng.standard_normal(last.shape))[0]
                S = S * np.where(np.sum(S * last, axis=0) < 0, -1.0, 1.0)
        self.seen.append(S)
        return S

    def points(self, count):
        return np.stack([self.point() for _ in range(count)]) if count else np.zeros((0, self.n, self.k))

    def batch(self):
        shape = self.of([(), (), (), (1,), (2,), (0,), (2, 3), (2, 0)])
        S = self.points(math.prod(shape)).reshape(*shape, self.n, self.k)
        return S

    def tangent(self, S):
        S = np.asarray(S, float)
        Z = self.rng.standard_normal(S.shape)
        G = np.swapaxes(S, -1, -2) @ Z
        V = Z - S @ (G + np.swapaxes(G, -1, -2)) / 2
        scale = self.of(SCALES) if self.chance(self.wild) else self.of([0.0, 0.1, 0.3, 0.5, 1.0, 2.0])
        with np.errstate(all="ignore"):
            V = V * scale
        return np.where(np.isfinite(V), V, 0.0)

    def tangent_of_some(self, S):
        """At one of a batch of points, at all of them, or at the same number of points in another layout."""
        S = np.asarray(S, float)
        return self.tangent(S.reshape(-1, *S.shape[-2:])[0] if S.size and self.chance(0.1) else S)

    def skew(self, m):
        A = self.rng.standard_normal((*self.of([(), (), (2,), (0,)]), m, m))
        with np.errstate(all="ignore"):
            A = (A - np.swapaxes(A, -1, -2)) * (self.of(SCALES) if self.chance(self.wild) else 0.5)
        return np.where(np.isfinite(A), A, 0.0)

    def rotation(self):
        m = self.of([1, 2, 3, 4, 7])
        Q = self.orthonormal(m, m)
        if self.chance(0.8) and np.linalg.det(Q) < 0:
            Q[:, 0] *= -1
        return Q

    def times(self, count):
        t = np.cumsum(self.rng.uniform(0.1, 1.5, count)) if count else np.zeros(0)
        if self.chance(self.wild):
            with np.errstate(all="ignore"):
                t = t * self.of([1e-310, 1e-160, 1e-8, 1e8, 1e155, 1e300]) + self.of([0.0, 0.0, 1e8, -1e16, 1e300])
            t = np.where(np.isfinite(t), t, 0.0)
        return t

    def parameters(self):
        """Parameters at which a curve is evaluated."""
        t = self.of([0.0, 1.0, 0.5, -0.5, 2.5, self.rng.uniform(0, 1, 3), self.rng.uniform(-1, 4, (2, 2)), np.zeros(0)])
        return self.of(SPECIAL) * self.of([1, -1]) if self.chance(self.wild) else t

    def near(self, d, spread=0.3):
        """Coordinates inside a chart."""
        q = 1.2 + self.rng.uniform(-spread, spread, d)
        return q

    def small(self, shape):
        x = self.rng.uniform(-0.5, 0.5, shape)
        return x * self.of([1e-300, 1e-8, 10.0, 1e3, 1e155]) if self.chance(self.wild) else x

    def number(self, good):
        return self.of([*SPECIAL, *NOT_FINITE]) * self.of([1, -1]) if self.chance(self.wild) else self.of(good)

    def integer(self, good):
        return self.of([0, -1, 1, 2**31, 2**40, 2**62, 2**63 - 1, 10**30]) if self.chance(self.wild) else self.of(good)

    def word(self, good):
        return self.of(["", "text", None, 3, 1.5, b"natural", ["natural"]]) if self.chance(self.wild) else self.of(good)

    # Invalid or unusual values.

    def twisted(self, value):
        """The same argument in another dtype, layout or shape, with other entries, or something else altogether."""
        if not isinstance(value, np.ndarray) or value.dtype != float or self.chance(0.1):
            return self.of(junk())
        kind = self.of([self.entries, self.entries, self.scaled, self.dtype, self.layout, self.layout, self.shape])
        return kind(value)

    def entries(self, x):
        x = x.copy()
        if not x.size:
            return x
        where = self.source.randrange(x.size)
        match self.of(["one", "nan", "ulp", "all", "sign"]):
            case "one":
                x.flat[where] = self.of(SPECIAL) * self.of([1, -1])
            case "nan":
                x.flat[where] = self.of(NOT_FINITE)
            case "ulp":
                x = x + self.of([1e-17, 1e-16, 1e-15, 1e-13, 1e-12, 1e-10, 1e-8, 1e-5]) * self.rng.standard_normal(
                    x.shape
                )
            case "all":
                x[...] = self.of(SPECIAL)
            case _:
                x = -x
        return x

    def scaled(self, x):
        with np.errstate(all="ignore"):
            y = x * self.of([*SPECIAL, 1 + 1e-15, 1 - 1e-12, 1 + 1e-9])
        return np.where(np.isfinite(y), y, x)

    def dtype(self, x):
        kind = self.of(DTYPES)
        if kind == "V8":
            return np.zeros(x.shape, [("a", "f4"), ("b", "f4")])
        with np.errstate(all="ignore"):
            clipped = (
                np.clip(x, -100, 100) if kind in ("?", "i1", "u1", "i4", ">i4", "i8", "u8", "m8[s]", "M8[s]") else x
            )
            if kind in ("u1", "u8"):
                clipped = np.abs(clipped)
            return clipped.astype("i8").astype(kind) if kind in ("m8[s]", "M8[s]") else clipped.astype(kind)

    def layout(self, x):  # noqa: PLR0911
        back = tuple([slice(None, None, -1)] * x.ndim)
        match self.of(["F", "read", "negative", "wide", "byte", "imag", "masked", "list", "tuple", "view", "class"]):
            case "F":
                return np.asfortranarray(x)
            case "read":
                y = x.copy()
                y.flags.writeable = False
                return y
            case "negative":
                return np.ascontiguousarray(x[back])[back]
            # With 32 axes it would not fit into memory, without any it is a number.
            case "wide" if 0 < x.ndim < 8:
                y = np.full(tuple(3 * s + 2 for s in x.shape), np.nan)[tuple(slice(1, 1 + 3 * s, 3) for s in x.shape)]
                y[...] = x
                return y
            case "byte":
                y = np.zeros(8 * x.size + 1, "u1")[1:].view("f8").reshape(x.shape)
                y[...] = x
                return y
            case "imag":
                y = np.zeros((*x.shape, 2))
                y[..., 1] = x
                return y.view(complex)[..., 0].imag
            case "masked":
                return np.ma.masked_array(x, self.rng.random(x.shape) < self.of([0.0, 0.2]))
            case "list":
                return x.tolist()
            case "tuple":
                return tuple(x) if x.ndim else x
            case "view":
                return memoryview(np.ascontiguousarray(x))
            case _:
                return x.view(type("Sub", (np.ndarray,), {}))

    def shape(self, x):  # noqa: PLR0911
        match self.of(["drop", "add", "empty", "swap", "twice", "broadcast", "flat", "cut", "many"]):
            case "drop":
                return x[0] if x.ndim and len(x) else x
            case "add":
                return x[None]
            case "empty":
                return np.zeros(tuple(self.of([0, s]) for s in x.shape))
            case "swap":
                return x.T
            case "twice":
                return np.concatenate([x, x], axis=-1) if x.ndim else x
            case "broadcast":
                return np.broadcast_to(x, (self.of([0, 1, 3]), *x.shape))
            case "flat":
                return x.ravel()
            case "cut":
                return x[..., : max(0, x.shape[-1] - 1)] if x.ndim else x
            case _:
                return x[(None,) * self.source.randrange(1, 30)]
