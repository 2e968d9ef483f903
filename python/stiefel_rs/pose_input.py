"""Conversion of poses from and to SciPy's `RigidTransform`, matrices, and rotations with positions."""

from __future__ import annotations

from typing import Any, Final, Literal, NamedTuple, TypeAlias

import numpy as np

from .array_input import Array, at_knot, check_knots_finite, flag, real_array, shape_of
from .errors import InvalidInputError
from .rotation_input import (
    ORTHONORMAL,
    ORTHONORMAL_SINGLE,
    Rotations,
    is_single,
    is_transform,
    read_rotations,
    scipy_module,
)

PoseKind: TypeAlias = Literal["RigidTransform", "matrices", "pair"]

EXPECTED: Final = "expected a RigidTransform, matrices (N, 4, 4) or a tuple (rotations, positions)"
LAST_ROW: Final = (0.0, 0.0, 0.0, 1.0)


class Poses(NamedTuple):
    """Validated poses.

    Attributes
    ----------
    kind : {"RigidTransform", "matrices", "pair"}
        Kind in which they were given.
    rotations : Rotations
        N rotations.
    positions : ndarray, shape (N, 3)
        Finite positions.
    """

    kind: PoseKind
    rotations: Rotations
    positions: Array


def read_poses(poses: Any, *, project: bool = False) -> Poses:
    """Read N poses of any kind.

    Parameters
    ----------
    poses : RigidTransform, or array_like, shape (N, 4, 4), or tuple of (rotations, positions)
        Rotations of any kind that `RotationSpline` accepts, and positions of shape (N, 3), in any unit of length.
    project : bool, default False
        If True, rotation matrices are replaced by the nearest rotations first.

    Raises
    ------
    InvalidInputError
        Wrong shape, non-finite entries, a last row other than (0, 0, 0, 1), rotations that `read_rotations` refuses,
        different numbers of rotations and positions.
    TypeError
        Not real numbers; a `project` that is not a truth value.
    """
    project = flag("project", project)
    if is_transform(poses, "RigidTransform"):
        return _of_scipy(poses)
    if isinstance(poses, list | tuple) and any(is_transform(item, "RigidTransform") for item in poses):
        raise TypeError("poses: found a list of RigidTransform objects; join them with RigidTransform.concatenate")
    # A tuple may also consist of two matrices.
    if isinstance(poses, tuple) and len(poses) == 2 and shape_of(poses[1]) != (4, 4):
        return _of_pair(*poses, project=project)
    return _of_matrices(poses, project=project)


def _of_scipy(poses: Any) -> Poses:
    positions = np.asarray(poses.translation, dtype=np.float64)
    if positions.ndim != 2:
        found = "a single pose" if positions.ndim == 1 else f"shape {positions.shape[:-1]}"
        raise InvalidInputError(f"poses: expected N poses, found {found}")
    check_knots_finite(positions, "poses", 1)
    return Poses("RigidTransform", read_rotations(poses.rotation), positions)


def _of_matrices(poses: Any, *, project: bool) -> Poses:
    if shape_of(poses) is None:
        raise InvalidInputError(f"poses: {EXPECTED}, found items of different shapes")
    matrices = real_array(poses, "poses")
    single = is_single(poses)
    if matrices.ndim != 3 or matrices.shape[1:] != (4, 4):
        raise InvalidInputError(f"poses: {EXPECTED}, found shape {matrices.shape}")
    check_knots_finite(matrices, "poses", 2)
    wrong = (np.abs(matrices[:, 3] - LAST_ROW) > (ORTHONORMAL_SINGLE if single else ORTHONORMAL)).any(axis=-1)
    if wrong.any():
        knot = int(np.argmax(wrong))
        raise at_knot(f"poses: the last row must be (0, 0, 0, 1), found {tuple(matrices[knot, 3].tolist())}", knot)
    rotations = matrices[:, :3, :3].astype(np.float32 if single else np.float64)
    return Poses("matrices", read_rotations(rotations, project=project), matrices[:, :3, 3].copy())


def _of_pair(rotations: Any, positions: Any, *, project: bool) -> Poses:
    array = real_array(positions, "positions")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidInputError(f"positions: expected shape (N, 3), found {array.shape}")
    check_knots_finite(array, "positions", 1)
    found = read_rotations(rotations, project=project)
    lead = found.quaternions.shape[:-1]
    if len(lead) != 1:
        raise InvalidInputError(f"rotations: expected N rotations, found leading axes {lead}")
    if array.shape != (*lead, 3):
        raise InvalidInputError(f"positions: expected shape {(*lead, 3)}, found {array.shape}")
    return Poses("pair", found, array)


def pose_matrices(rotations: Array, positions: Array) -> Array:
    """Return the matrices, shape ``(..., 4, 4)``, of rotations ``(..., 3, 3)`` and positions ``(..., 3)``."""
    out = np.zeros((*positions.shape[:-1], 4, 4))
    out[..., :3, :3], out[..., :3, 3], out[..., 3, 3] = rotations, positions, 1.0
    return out


def give_back_poses(kind: PoseKind, rotations: Any, positions: Array) -> Any:
    """Return rotations and positions as poses of a kind.

    Raises
    ------
    ImportError
        A SciPy class is requested, and SciPy is not installed or older than 1.16.
    """
    if kind == "pair":
        return rotations, positions
    if kind == "matrices":
        return pose_matrices(rotations, positions)
    transform = scipy_module("scipy.spatial.transform", "a RigidTransform").RigidTransform
    return transform.from_components(positions, rotations)
