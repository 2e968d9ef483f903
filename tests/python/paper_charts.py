"""Charts, Hamiltonians and data of section 4 of arXiv 2404.19407 as printed; numbers may be complex."""

import numpy as np
from numpy import cos, sin, tan

SPHERE = ("theta", "phi")
FRAME = ("theta", "phi", "psi")
# Angles, velocities, accelerations and jerks at t = 0, section 4.2.
SPHERE_DATA = ([np.pi / 2, np.pi], [0.1, 0.2], [1, 0.5], [0.1, 0.2])
FRAME_DATA = ([np.pi / 4, np.pi, np.pi], [0.1, 0.1, 0.05], [1, 0.3, 0.5], [0.1, 0.1, 0.05])


def sphere_point(q):
    """The parametrisation of the sphere, one column."""
    theta, phi = q
    return np.array([[cos(phi) * sin(theta)], [sin(phi) * sin(theta)], [cos(theta)]])


def frame_point(q):
    """The matrix A(theta, phi, psi)."""
    theta, phi, psi = q
    return np.array(
        [
            [cos(phi) * sin(theta), -sin(phi) * sin(psi) + cos(phi) * cos(psi) * cos(theta)],
            [sin(phi) * sin(theta), sin(phi) * cos(psi) * cos(theta) + sin(psi) * cos(phi)],
            [cos(theta), -sin(theta) * cos(psi)],
        ]
    )


def sphere_hamiltonian(z):
    """The Hamiltonian on T*(TS^2)."""
    theta, _phi, dtheta, dphi, p_theta, p_phi, q_theta, q_phi = z
    fraction = (-dphi * dtheta * q_phi * sin(2 * theta) + q_phi**2 / 2) / sin(theta) ** 2
    return dphi**2 * q_theta * sin(2 * theta) / 2 + dphi * p_phi + dtheta * p_theta + q_theta**2 / 2 + fraction


def frame_terms(z):
    """Terms of the Hamiltonian on T*(T St(3,2)): the two halves of the bracket, the other terms, and the divisor."""
    theta, _phi, _psi, dtheta, dphi, dpsi, p_theta, p_phi, p_psi, q_theta, q_phi, q_psi = z
    s, c = sin(theta), cos(theta)
    first = -dphi * dtheta * q_phi * sin(2 * theta) / 8 + dphi * dtheta * q_psi * s / 4 + dpsi * dtheta * q_phi * s / 4
    second = -dpsi * dtheta * q_psi * sin(2 * theta) / 8 + q_phi**2 / 4 - q_phi * q_psi * c / 2 + q_psi**2 / 4
    squares = -((-q_phi + q_psi / c) ** 2) * s**4 / 2 - (-q_phi / c + q_psi) ** 2 * s**4 / 2
    products = (q_phi**2 - q_phi * q_psi * c - q_phi * q_psi / c + q_psi**2) * s**4
    flow = dphi * p_phi + dpsi * p_psi + dtheta * p_theta - q_theta**2 / 2 - q_theta * (dphi * dpsi * s - q_theta)
    divisor = s**6 * tan(theta) ** 2
    return first, second, squares + products + flow * divisor, divisor


def frame_hamiltonian(z):
    """The Hamiltonian on T*(T St(3,2)), with the bracket of the cube closed after both fractions."""
    first, second, rest, divisor = frame_terms(z)
    return ((1 - cos(2 * z[0])) ** 3 * (first + second) / (cos(2 * z[0]) + 1) + rest) / divisor


def frame_hamiltonian_as_typeset(z):
    """The same Hamiltonian, with each of the two fractions taken separately."""
    first, second, rest, divisor = frame_terms(z)
    return (((1 - cos(2 * z[0])) ** 3 * first + second) / (cos(2 * z[0]) + 1) + rest) / divisor


def gradient(function, z):
    """The gradient of an analytic function, by complex steps: exact to round-off."""
    z, step = np.asarray(z, dtype=complex), 1e-30
    return np.array([function(z + 1j * step * e).imag / step for e in np.eye(len(z))])
