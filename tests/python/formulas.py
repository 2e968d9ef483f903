"""Formulas used by several formulas of docs/mathematics.md."""

import numpy as np


def skew(A):
    return (A - A.T) / 2


def bracket(A, B):
    return A @ B - B @ A


def split(S, V):
    """The parts `Omega` and `K` of a tangent vector, and the generator `X`."""
    Omega = S.T @ V
    K = V - S @ Omega
    return Omega, K, K @ S.T - S @ K.T


def christoffel(S, V, W):
    P = np.eye(len(S)) - S @ S.T
    return (V @ W.T + W @ V.T) @ S / 2 + S @ (V.T @ P @ W + W.T @ P @ V) / 2
