"""The parts of a comparison: a piece of work, its rivals, its bounds."""

from __future__ import annotations

from dataclasses import dataclass

# Number of threads of the rows that time several threads.
THREADS = 2


@dataclass(frozen=True)
class Rival:
    """The same work done by another method.

    Attributes
    ----------
    peer : str
        Process that does the work.
    task : str
        Name of the task in that process, after the colon.
    label : str
        Name in the table.
    at_most : float or None
        Target for the ratio of our time to this one's.
    agree : float or None
        Required agreement of the results, relative to their norm; None if they differ by nature.
    pick : int or None
        Entry of our result with which this one's is compared.
    identical : bool
        Whether results must agree bit for bit.
    best_of : bool
        Whether this one is a candidate for the best rival.
    """

    peer: str
    task: str
    label: str
    at_most: float | None = None
    agree: float | None = 1e-9
    pick: int | None = None
    identical: bool = False
    best_of: bool = True


@dataclass(frozen=True)
class Bound:
    """A number other than a time, and its bound; None if it is only reported."""

    measure: str
    label: str
    bound: float | None = None


@dataclass(frozen=True)
class Row:
    """One piece of work: our time, the rivals', and the targets.

    Attributes
    ----------
    name : str
        Name of the task, before the colon.
    work : str
        Name in the table.
    unit : str
        Unit of work to which times refer: a call, a point, a problem.
    seconds : float or None
        Target for our time.
    ahead : float or None
        Target for the ratio of the best rival's time to ours.
    ours : str
        Which of our processes is timed.
    exact : bool
        Whether that process has a task "exact" with the exact result, so that everybody's error is listed.
    """

    name: str
    work: str
    rivals: tuple[Rival, ...] = ()
    unit: str = "call"
    seconds: float | None = None
    ahead: float | None = None
    bounds: tuple[Bound, ...] = ()
    ours: str = "stiefel_rs"
    exact: bool = False

    @property
    def title(self) -> str:
        """Name of the work in the table, with its unit."""
        return self.work + ("" if self.unit == "call" else f", a {self.unit}")

    @property
    def threads(self) -> int:
        """Number of threads of the timed process."""
        return 1 if self.ours == "stiefel_rs" else THREADS
