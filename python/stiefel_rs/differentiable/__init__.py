"""Functions with derivatives for libraries of automatic differentiation: values, variations and pullbacks."""
