"""Curves in files: archives of plain arrays, with a version, checked when they are read."""

from __future__ import annotations

import io
import os
import uuid
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _core
from .errors import InvalidInputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ._core import Curve

__all__ = ["load"]


def write(form: Mapping[str, Any], path: str | os.PathLike[str]) -> None:
    """Write the stored form of a curve; a file that is there is replaced once the new one is written."""
    path = os.fsdecode(path)
    partial = f"{path}.{uuid.uuid4().hex}.part"
    try:
        with open(partial, "xb") as file:
            np.savez(file, **form)
        os.replace(partial, path)
    except BaseException:
        Path(partial).unlink(missing_ok=True)
        raise


def load(path: str | os.PathLike[str]) -> Curve:
    """Read a curve that ``curve.save(path)`` has written: the same curve, to the last bit.

    Parameters
    ----------
    path : str or os.PathLike
        Name of the file.

    Returns
    -------
    Curve
        Of the class that was saved.

    Raises
    ------
    InvalidInputError
        The file is no curve of this package, is of a newer version, or is damaged; says what is wrong, and names the
        file.
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
        return _core._restored(form)
    # Whatever a reader of archives or of curves makes of damaged bytes.
    except Exception as error:
        raise InvalidInputError(f"{name}: {error or type(error).__name__}") from error


def _read(content: bytes) -> dict[str, Any]:
    """Read the arrays of an archive; words and numbers as such."""
    if content[:2] != b"PK":
        raise InvalidInputError("no archive of arrays (.npz)")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        # As they are written. A small compressed file may be larger than memory.
        if any(member.compress_type != zipfile.ZIP_STORED for member in archive.infolist()):
            raise InvalidInputError("compressed arrays, which this package does not write")
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        arrays = {key: archive[key] for key in archive.files}
    return {key: array if array.ndim else array.item() for key, array in arrays.items()}
