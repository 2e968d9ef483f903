"""Conversion of rotations from and to SciPy's `Rotation`, quaternions and matrices."""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any, Final, Literal, NamedTuple, TypeAlias

import numpy as np

from ._core import Stiefel
from .array_input import Array, at_knot, check_knots_finite, flag, located, real_array
from .errors import InvalidInputError

RotationKind: TypeAlias = Literal["Rotation", "quaternions", "matrices"]

KINDS: Final = ("Rotation", "quaternions", "matrices")
EXPECTED: Final = "expected a Rotation, quaternions (..., N, 4) or matrices (..., N, 3, 3)"
# Largest entry of R^T R - I: round-off of products, and of numbers stored in single precision.
ORTHONORMAL: Final = 1e-9
ORTHONORMAL_SINGLE: Final = 1e-5


def scipy_module(name: str, use: str) -> Any:
    """Import a module of SciPy, which is not a dependency of this package.

    Raises
    ------
    ImportError
        SciPy is not installed; the message states what needs it.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise ImportError(
            f"{use} needs SciPy, which is not installed with stiefel_rs ({error}): pip install scipy"
        ) from error


def is_transform(thing: object, name: str) -> bool:
    """Whether an object is of a class of `scipy.spatial.transform`, without importing SciPy."""
    module = sys.modules.get("scipy.spatial.transform")
    found = getattr(module, name, None)
    return isinstance(found, type) and isinstance(thing, found)


class Rotations(NamedTuple):
    """Validated rotations.

    Attributes
    ----------
    kind : {"Rotation", "quaternions", "matrices"}
        Kind in which they were given.
    quaternions : ndarray, shape (..., N, 4)
        Scalar last, of any nonzero length.
    """

    kind: RotationKind
    quaternions: Array


def read_rotations(rotations: Any, *, project: bool = False) -> Rotations:
    """Read rotations of any kind.

    Parameters
    ----------
    rotations : Rotation, or array_like, shape (..., N, 4) or (..., N, 3, 3), or Rotations
        N rotations: a SciPy `Rotation`; quaternions, scalar last, of any nonzero length; or matrices. The result of an
        earlier call is returned as it is.
    project : bool, default False
        If True, matrices are replaced by the nearest rotations first.

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, a quaternion of length zero, a matrix that is not a rotation (with its defect).
    TypeError
        Not real numbers; a `project` that is not a truth value.
    """
    project = flag("project", project)
    if isinstance(rotations, Rotations):
        return rotations
    if is_transform(rotations, "Rotation"):
        return Rotations("Rotation", _of_scipy(rotations))
    if rotations is None:
        raise TypeError(f"rotations: {EXPECTED}, found None")
    if isinstance(rotations, list | tuple) and any(is_transform(item, "Rotation") for item in rotations):
        raise TypeError("rotations: found a list of Rotation objects; join them with Rotation.concatenate")
    array = real_array(rotations, "rotations")
    single = is_single(rotations)
    if array.ndim >= 2 and array.shape[-1] == 4:
        check_knots_finite(array, "rotations", 1)
        _check_lengths(array)
        return Rotations("quaternions", array)
    if array.ndim >= 3 and array.shape[-2:] == (3, 3):
        check_knots_finite(array, "rotations", 2)
        return Rotations("matrices", quaternions_of(_rotation_matrices(array, single=single, project=project)))
    raise InvalidInputError(f"rotations: {EXPECTED}, found shape {array.shape}")


def is_single(values: Any) -> bool:
    """Whether the numbers of an array or of a list of arrays have single precision or less."""
    try:
        dtype = np.asarray(values).dtype
    except ValueError:
        return False
    return dtype.kind == "f" and dtype.itemsize <= np.dtype(np.float32).itemsize


def _of_scipy(rotations: Any) -> Array:
    quaternions = np.asarray(rotations.as_quat(), dtype=np.float64)
    if quaternions.ndim == 1:
        raise InvalidInputError("rotations: expected a sequence of rotations, found a single one")
    if quaternions.ndim > 2:
        shape = quaternions.shape[:-1]
        raise InvalidInputError(
            f"rotations: expected N rotations, found shape {shape}; for batches use quaternions or matrices"
        )
    check_knots_finite(quaternions, "rotations", 1)
    return quaternions


def _check_lengths(quaternions: Array) -> None:
    nonzero = quaternions.any(axis=-1)
    if not nonzero.all():
        where = located(int(np.argmin(nonzero)), nonzero.shape)
        raise at_knot("rotations: a quaternion of length zero", *where)


def _rotation_matrices(matrices: Array, *, single: bool, project: bool) -> Array:
    """Check matrices, or project them, and return rotations."""
    lead, tolerance = matrices.shape[:-2], ORTHONORMAL_SINGLE if single else ORTHONORMAL
    if project:
        matrices = Stiefel(3, 3).project(matrices)
    else:
        # Huge entries overflow and may give NaN, which must be rejected.
        with np.errstate(over="ignore", invalid="ignore"):
            defects = np.abs(np.swapaxes(matrices, -1, -2) @ matrices - np.eye(3)).max(axis=(-1, -2))
            bad = ~(defects <= tolerance)
        if bad.any():
            worst = int(np.argmax(bad))
            defect = defects.flat[worst]
            raise at_knot(
                f"rotations: the matrix is not orthonormal, by {defect:.3g} (tolerance {tolerance:g}; "
                "project=True uses the nearest rotation)",
                *located(worst, lead),
            )
    determinants = np.linalg.det(matrices)
    if (determinants < 0).any():
        mirror = int(np.argmax(determinants < 0))
        raise at_knot("rotations: the matrix is a reflection, its determinant is -1", *located(mirror, lead))
    return matrices


def unit(quaternions: Array) -> Array:
    """Return quaternions of any nonzero length, shape ``(..., 4)``, scaled to length 1."""
    # Prevents squares from overflowing and underflowing.
    scaled = quaternions / np.abs(quaternions).max(axis=-1, keepdims=True)
    return np.asarray(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True))


def quaternions_of(matrices: Array) -> Array:
    """Return unit quaternions of rotation matrices.

    Parameters
    ----------
    matrices : ndarray, shape (..., 3, 3)
        Rotations, orthonormal up to a small defect.

    Returns
    -------
    ndarray, shape (..., 4)
        Quaternions, scalar last, of the nearest rotations up to the square of the defect; the largest entry is
        positive.

    Notes
    -----
    ``4 q q^T`` is linear in the matrix. Its column with the largest diagonal entry is parallel to ``q`` (Shepperd
    1978); one power iteration moves it to the nearest rotation (Bar-Itzhack 2000).
    """
    R = matrices
    xx, yy, zz = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    outer = np.empty((*R.shape[:-2], 4, 4))
    outer[..., 0, 0], outer[..., 1, 1] = 1 + xx - yy - zz, 1 - xx + yy - zz
    outer[..., 2, 2], outer[..., 3, 3] = 1 - xx - yy + zz, 1 + xx + yy + zz
    outer[..., 0, 1] = outer[..., 1, 0] = R[..., 0, 1] + R[..., 1, 0]
    outer[..., 0, 2] = outer[..., 2, 0] = R[..., 0, 2] + R[..., 2, 0]
    outer[..., 1, 2] = outer[..., 2, 1] = R[..., 1, 2] + R[..., 2, 1]
    outer[..., 0, 3] = outer[..., 3, 0] = R[..., 2, 1] - R[..., 1, 2]
    outer[..., 1, 3] = outer[..., 3, 1] = R[..., 0, 2] - R[..., 2, 0]
    outer[..., 2, 3] = outer[..., 3, 2] = R[..., 1, 0] - R[..., 0, 1]
    largest = np.argmax(np.einsum("...ii->...i", outer), axis=-1)
    column = np.take_along_axis(outer, largest[..., None, None], axis=-1)
    q = (outer @ column)[..., 0]
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def matrices_of(quaternions: Array) -> Array:
    """Return the rotation matrices of unit quaternions.

    Parameters
    ----------
    quaternions : ndarray, shape (..., 4)
        Scalar last, of length 1.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    out = np.empty((*x.shape, 3, 3))
    out[..., 0, 0] = 1 - 2 * (y * y + z * z)
    out[..., 1, 1] = 1 - 2 * (x * x + z * z)
    out[..., 2, 2] = 1 - 2 * (x * x + y * y)
    out[..., 0, 1], out[..., 1, 0] = 2 * (x * y - z * w), 2 * (x * y + z * w)
    out[..., 0, 2], out[..., 2, 0] = 2 * (x * z + y * w), 2 * (x * z - y * w)
    out[..., 1, 2], out[..., 2, 1] = 2 * (y * z - x * w), 2 * (y * z + x * w)
    return out


def rotated(quaternions: Array, vectors: Array) -> Array:
    """Rotate vectors, shape ``(..., 3)``, by unit quaternions, shape ``(..., 4)``."""
    axis, scalar = quaternions[..., :3], quaternions[..., 3:]
    across = np.cross(axis, vectors)
    return np.asarray(vectors + 2 * (scalar * across + np.cross(axis, across)))


def inverse(quaternions: Array) -> Array:
    """Return the inverses of unit quaternions, shape ``(..., 4)``."""
    out = -quaternions
    out[..., 3] = quaternions[..., 3]
    return out


def give_back(kind: RotationKind, quaternions: Array) -> Any:
    """Return unit quaternions, shape ``(..., 4)``, as rotations of a kind.

    Raises
    ------
    ImportError
        A SciPy class is requested, and SciPy is not installed.
    """
    if kind == "quaternions":
        return quaternions
    if kind == "matrices":
        return matrices_of(quaternions)
    return scipy_module("scipy.spatial.transform", "a Rotation").Rotation.from_quat(quaternions)
