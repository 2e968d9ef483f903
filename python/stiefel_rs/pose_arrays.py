"""Poses in the form written to files: unit quaternions, scalar last, and positions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ._core import _as_numpy, _check_unmasked
from .array_input import shape_of
from .errors import InvalidInputError
from .rotation_input import quaternions_of

Array = NDArray[np.float64]

# Largest error of the norm from rounding to few decimals.
NORM_TOLERANCE: Final = 1e-2
# Error of the norm due to rounding of the entries and of the norm itself.
ROUNDING: Final = 8 * float(np.finfo(np.float64).eps)
# Rotations in single precision have a defect of about 1e-7.
ROTATION_TOLERANCE: Final = 1e-5


def floats(name: str, value: Any, shape: tuple[int | None, ...]) -> Array:
    """Read an array of finite numbers with the given shape, where None stands for any length.

    Raises
    ------
    InvalidInputError
        The shape is wrong, or an entry is masked or not finite.
    TypeError
        The entries are not real numbers.
    """
    _check_unmasked(name, value)
    given: NDArray[Any] = _as_numpy(name, value)
    if not np.can_cast(given.dtype, np.float64, "same_kind"):
        raise TypeError(f"{name}: expected real numbers, found {given.dtype}")
    fits = given.ndim == len(shape)
    if not fits or any(size not in (None, found) for size, found in zip(shape, given.shape, strict=True)):
        wanted = ", ".join("N" if size is None else str(size) for size in shape) + "," * (len(shape) == 1)
        raise InvalidInputError(f"{name}: expected shape ({wanted}), found {given.shape}")
    array = given.astype(np.float64)
    if not (finite := np.isfinite(array)).all():
        first = tuple(map(int, np.argwhere(~finite)[0]))
        count = finite.size - finite.sum()
        raise InvalidInputError(f"{name}: {count} of {finite.size} entries are not finite, the first is {list(first)}")
    return array


def unit_quaternions(quaternions: Array) -> Array:
    """Normalise quaternions, except those whose norm is 1 up to rounding.

    Raises
    ------
    InvalidInputError
        A norm differs from 1 by more than 0.01; `knot` is the index of the first such quaternion.
    """
    # Squares of huge entries overflow, for which NumPy would warn.
    with np.errstate(over="ignore"):
        norms = np.linalg.norm(quaternions, axis=-1, keepdims=True)
    off = np.abs(norms - 1)
    if (bad := np.flatnonzero(off > NORM_TOLERANCE)).size:
        error = InvalidInputError(
            f"the quaternion has norm {norms[bad[0], 0]:.6g}, which differs from 1 by more than {NORM_TOLERANCE}"
        )
        error.knot = int(bad[0])
        raise error
    return np.where(off <= ROUNDING, quaternions, quaternions / norms)


def as_components(poses: Any) -> tuple[Array, Array | None]:
    """Return quaternions and positions of poses, or of rotations alone.

    Raises
    ------
    InvalidInputError
        Wrong shapes, entries that are not finite, or matrices that are not rotations.
    """
    if hasattr(poses, "as_components"):
        translations, rotations = poses.as_components()
        poses = (rotations, translations)
    if isinstance(poses, tuple) and not _is_matrix(poses[-1:]):
        if len(poses) != 2:
            raise InvalidInputError(f"poses: expected a pair (rotations, positions), found {len(poses)} entries")
        quaternions = as_quaternions("rotations", poses[0])
        return quaternions, floats("positions", poses[1], (len(quaternions), 3))
    if not hasattr(poses, "as_quat") and (shape_of(poses) or ())[1:] == (4, 4):
        return _of_matrices(floats("poses", poses, (None, 4, 4)))
    return as_quaternions("poses", poses), None


def _is_matrix(last: Sequence[Any]) -> bool:
    """Whether the last item of a tuple is a 4 x 4 matrix: then the tuple holds poses, not rotations and positions."""
    return any(shape_of(pose) == (4, 4) for pose in last if not hasattr(pose, "as_quat"))


def _of_matrices(poses: Array) -> tuple[Array, Array]:
    off = np.abs(poses[:, 3] - [0.0, 0.0, 0.0, 1.0]).max(axis=-1)
    if (bad := np.flatnonzero(off > ROTATION_TOLERANCE)).size:
        raise InvalidInputError(f"pose {bad[0]}: expected the last row (0, 0, 0, 1), found {poses[bad[0], 3]}")
    return as_quaternions("rotations", poses[:, :3, :3]), poses[:, :3, 3]


def as_quaternions(name: str, rotations: Any) -> Array:
    """Return unit quaternions of a SciPy ``Rotation``, of quaternions (N, 4), or of matrices (N, 3, 3).

    Raises
    ------
    InvalidInputError
        Wrong shape, entries that are not finite, or matrices that are not rotations.
    """
    if hasattr(rotations, "as_quat"):
        rotations = np.atleast_2d(rotations.as_quat())
    if len(shape_of(rotations) or ()) == 3:
        return _quaternions_of(name, floats(name, rotations, (None, 3, 3)))
    try:
        return unit_quaternions(floats(name, rotations, (None, 4)))
    except InvalidInputError as error:
        if error.knot is None:
            raise
        raise InvalidInputError(f"{name}: entry {error.knot}: {error}") from None


def _quaternions_of(name: str, R: Array) -> Array:
    """Return quaternions of matrices, with signs chosen for continuity."""
    # Huge entries overflow and may give NaN, which is rejected.
    with np.errstate(over="ignore", invalid="ignore"):
        defects = np.abs(R.swapaxes(-1, -2) @ R - np.eye(3)).max(axis=(-1, -2))
    if (bad := np.flatnonzero(~(defects <= ROTATION_TOLERANCE))).size:
        raise InvalidInputError(
            f"{name}: matrix {bad[0]} is not orthogonal, defect {defects[bad[0]]:.3g}, tolerance {ROTATION_TOLERANCE}"
        )
    if (bad := np.flatnonzero(np.linalg.det(R) < 0)).size:
        raise InvalidInputError(f"{name}: matrix {bad[0]} is a reflection, its determinant is -1")
    q = quaternions_of(R)
    turns = np.where(np.einsum("ni,ni->n", q[1:], q[:-1]) < 0, -1.0, 1.0)
    first = np.where(q[:1, 3] < 0, -1.0, 1.0)
    return q * np.cumprod(np.concatenate([first, turns]))[:, None]
