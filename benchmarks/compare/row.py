"""The parts of a comparison: a piece of work, its rivals, its bounds."""

from __future__ import annotations

from dataclasses import dataclass

# Number of threads of the rows that time several threads.
THREADS = 2


@dataclass(frozen=True)
class Rival:
    """The same work done in another way.

    Attributes
    ----------
    peer : str
        Process that does it.
    task : str
        Its name there, after the colon.
    label : str
        What the table calls it.
    at_most : float or None
        To be reached: our time over this one's.
    agree : float or None
        Results are to agree to this, relative to their norm; None where they differ by nature.
    pick : int or None
        Entry of our result that this one's is compared with.
    identical : bool
        Results are to agree in every bit.
    best_of : bool
        Whether this one counts when the best of all rivals is looked for.
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
        What the table calls it.
    unit : str
        What the time is of: a call, a point, a problem.
    seconds : float or None
        To be reached: our time.
    ahead : float or None
        To be reached: the best rival's time over ours.
    ours : str
        The process of ours that is timed.
    exact : bool
        Whether that process knows the exact result too, as its task "exact": everybody's error is told.
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
