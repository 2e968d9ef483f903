"""Curves in files: archives of plain arrays with a version, validated when they are read."""

from __future__ import annotations

import io
import os
import shutil
import threading
import uuid
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from ._core import _restored
from .errors import InvalidInputError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from ._core import Curve

__all__ = ["load"]

# NumPy parses the headers of arrays with `ast`, and the parser of CPython 3.11 counts its recursion depth for all
# threads together: a thread switch occasionally causes a SystemError (cpython#106905).
_one_parser = threading.Lock()


@contextmanager
def naming(path: str | os.PathLike[str]) -> Iterator[None]:
    """Make errors name the requested file, not a temporary file in its place."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), os.fsdecode(path)) from error


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[IO[bytes]]:
    """Open a temporary file next to `path`, which replaces `path` once it is complete.

    The permissions of an existing file are kept.

    Raises
    ------
    OSError
        The file or its folder cannot be written.
    """
    # A link is kept, and points to the new file.
    name = os.path.realpath(os.fsdecode(path))
    with naming(path):
        if os.path.exists(name) and not os.path.isfile(name):
            # A device or a pipe must not be replaced; opening a folder raises.
            with open(name, "wb") as file:
                yield file
            return
        # Without the name of the file, which may be as long as the file system allows.
        partial = os.path.join(os.path.dirname(name), f".stiefel_rs-{uuid.uuid4().hex[:8]}.part")
        try:
            with open(partial, "xb") as file:
                with suppress(FileNotFoundError):
                    shutil.copymode(name, partial)
                yield file
            os.replace(partial, name)
        except BaseException:
            Path(partial).unlink(missing_ok=True)
            raise


def write(form: Mapping[str, Any], path: str | os.PathLike[str]) -> None:
    """Write the stored form of a curve; an existing file is replaced once the new one is complete."""
    with replacing(path) as file:
        np.savez(file, **form)


def load(path: str | os.PathLike[str]) -> Curve:
    """Load a curve that was saved by ``curve.save(path)``: the same curve, to the last bit.

    Parameters
    ----------
    path : str or os.PathLike
        Name of the file.

    Returns
    -------
    Curve
        Curve of the same class.

    Raises
    ------
    InvalidInputError
        The file is not a curve of this package, has a newer version, or is damaged, or its numbers are inconsistent
        (points off the manifold, steps that do not join, with the measured gap). The message names the file.
    OSError
        The file cannot be read.

    Examples
    --------
    >>> import os, tempfile
    >>> import stiefel_rs
    >>> curve = stiefel_rs.QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = os.path.join(folder, "quarter.npz")
    ...     curve.save(path)
    ...     again = stiefel_rs.load(path)
    >>> bool((again(0.3) == curve(0.3)).all())
    True
    """
    name = os.fsdecode(path)
    content = Path(name).read_bytes()
    try:
        form = _read(content)
        return _restored(form)
    # Damaged bytes may raise any exception.
    except Exception as error:
        raise InvalidInputError(f"{name}: {str(error) or type(error).__name__}") from error


def _read(content: bytes) -> dict[str, Any]:
    """Read the arrays of an archive; those without axes as strings and numbers."""
    if content[:2] != b"PK":
        raise InvalidInputError("not an archive of arrays (.npz)")
    # Importing it takes 11 ms, a third of what this package adds to NumPy.
    import zipfile  # noqa: PLC0415

    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        # This package writes uncompressed arrays. A small compressed file may exceed the memory.
        if any(member.compress_type != zipfile.ZIP_STORED for member in archive.infolist()):
            raise InvalidInputError("compressed arrays, which this package never writes")
    with _one_parser, np.load(io.BytesIO(content), allow_pickle=False) as archive:
        arrays = {key: archive[key] for key in archive.files}
    return {key: array if array.ndim else array.item() for key, array in arrays.items()}
