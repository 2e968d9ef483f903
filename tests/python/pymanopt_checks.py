"""pymanopt's own checks of gradients and Hessians, with numbers instead of pictures."""

import re

import numpy as np
import pytest

EPS = np.finfo(float).eps
# Residuals of the tangent spaces of gradient and Hessian, of linearity, and of symmetry.
RESIDUALS = [
    r"residual should be close to 0: ([-+.e0-9]+)\.\n",
    r"Residual: ([-+.e0-9]+)\.\n",
    r"a\*H\[d1\] \+ b\*H\[d2\] should be very close to 0: ([-+.e0-9]+)\.\n",
    r" = ([-+.e0-9]+)\.\n",
]


def assert_derivatives(diagnostics, problem, capsys):
    """Run `check_gradient` and `check_hessian`, and compare the residuals that they print with round-off."""
    diagnostics.check_gradient(problem)
    diagnostics.check_hessian(problem)
    said = capsys.readouterr().out
    for pattern in RESIDUALS:
        found = re.search(pattern, said)
        assert found, f"{pattern} not in {said}"
        # Derivatives are below 1000.
        assert abs(float(found[1])) <= 1e5 * EPS, found[0]


def assert_slopes(diagnostics, problem):
    """The linear model is exact to second order, the quadratic one to third order."""
    for quadratic, order in ((False, 2), (True, 3)):
        _, _, _, line = diagnostics.check_directional_derivative(problem, use_quadratic_model=quadratic)
        assert line[0] == pytest.approx(order, abs=0.1)
