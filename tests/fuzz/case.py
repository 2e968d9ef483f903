"""One case, determined by an integer: a call, or a curve and a few of its calls."""

import dataclasses
import os
import random
import tempfile
import warnings

import numpy as np

from . import curves, entries
from .draw import Draw
from .judge import ERRORS, finite_input, not_finite

LONGEST = 6


@dataclasses.dataclass
class Finding:
    """A call, and its forbidden behaviour."""

    call: str
    outcome: str

    def __str__(self):
        return f"{self.outcome}\n    in {self.call}"


def shown(value):
    if isinstance(value, np.ndarray):
        with np.printoptions(floatmode="unique", threshold=400):
            return f"{' '.join(repr(value).split())}<{value.dtype}{value.shape}>"
    if isinstance(value, (list, tuple)):
        return f"{type(value).__name__}({', '.join(map(shown, value))})"
    return repr(value)[:600]


def described(name, arguments, keywords):
    words = [shown(x) for x in arguments] + [f"{key}={shown(x)}" for key, x in keywords.items()]
    return f"{name}({', '.join(words)})"


class Case:
    """Draws and runs; `found` has the findings, `trace` the calls; `tell` is called before every call."""

    def __init__(self, source, tell=None):
        self.tell = tell
        self.draw = Draw(source)
        self.found = []
        self.trace = []
        self.outcome = ""

    def twisted(self, arguments, keywords):
        """Some of the arguments replaced; missing and unknown arguments are possible mistakes."""
        d = self.draw
        arguments, keywords = list(arguments), dict(keywords)
        if d.chance(d.wild):
            for _ in range(d.of([1, 1, 1, 2])):
                i = d.source.randrange(len(arguments) + len(keywords)) if arguments or keywords else -1
                if 0 <= i < len(arguments):
                    arguments[i] = d.twisted(arguments[i])
                elif i >= 0:
                    name = sorted(keywords)[i - len(arguments)]
                    keywords[name] = d.twisted(keywords[name])
            if d.chance(0.03):
                arguments = arguments[:-1]
            if d.chance(0.03):
                keywords["unknown"] = 1
        return arguments, keywords

    def call(self, name, function, arguments, keywords, finite=True):
        """Make one call and judge it; the result, or None."""
        inputs = [*arguments, *keywords.values()]
        # Before the call, which may exhaust an iterator.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            finite = finite and finite_input(inputs)
        line = described(name, arguments, keywords)
        self.trace.append(line)
        if self.tell:
            self.tell(line)
        before = [(x, x.copy()) for x in inputs if isinstance(x, np.ndarray) and x.nbytes < 10**6]
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                result = function(*arguments, **keywords)
                where = not_finite(result) if finite else None
        except ERRORS as error:
            self.outcome = type(error).__name__
            if not str(error).strip():
                self.found.append(Finding(line, f"{type(error).__name__} without a text"))
            return None
        except OSError as error:
            self.outcome = "OSError"
            if name not in ("load", "save"):
                self.found.append(Finding(line, f"{type(error).__name__}: {error}"))
            return None
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self.outcome = type(error).__name__
            self.found.append(Finding(line, f"{type(error).__module__}.{type(error).__name__}: {error}"))
            return None
        self.outcome = "result"
        if where:
            self.found.append(Finding(line, f"finite input, {where}"))
        for x, old in before:
            if not np.array_equal(x, old, equal_nan=x.dtype.kind in "fc"):
                self.found.append(Finding(line, "the call has changed its argument"))
        return result

    def run(self):
        d = self.draw
        if d.chance(0.5):
            name = d.of(sorted(entries.CALLS))
            function, arguments, keywords = entries.CALLS[name](d)
            self.call(name, function, *self.twisted(arguments, keywords))
        else:
            name = d.of(sorted(curves.CURVES))
            function, arguments, keywords = curves.CURVES[name](d)
            arguments, keywords = self.twisted(arguments, keywords)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                finite = finite_input([*arguments, *keywords.values()])
            curve = self.call(name, function, arguments, keywords)
            if curve is not None:
                self.sequence(curve, finite)
        return self

    def sequence(self, curve, finite):
        """Calls of one curve, none of which may change the curve."""
        d = self.draw
        first = self.probe(curve)
        for _ in range(d.source.randrange(1, LONGEST)):
            methods = curves.methods(curve)
            name = d.of(sorted(methods))
            function, arguments, keywords = methods[name](d, curve)
            if name != "duplicate":
                arguments, keywords = self.twisted(arguments, keywords)
            self.call(name, function, arguments, keywords, finite)
        if self.probe(curve) != first:
            self.found.append(Finding(self.trace[-1], "the calls have changed the curve"))

    def probe(self, curve):
        values = []
        for nu in range(2):
            try:
                values.append(curve(curve.t_span[0], nu).tobytes())
            except ERRORS as error:
                values.append(str(error))
        return values


def run(seed):
    """Run the case of `seed`."""
    return elsewhere(Case(random.Random(seed)))


def elsewhere(made):
    """Run a case in its own folder, since some of the words drawn as paths are valid file names."""
    home = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            return made.run()
        finally:
            os.chdir(home)
