"""Functions with their derivatives, for libraries of automatic differentiation: values, variations, pullbacks."""
