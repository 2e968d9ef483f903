//! The Hamiltonian of cubics on `T^*(TSt(n, k))` in ambient variables, and its vector field.
//!
//! With `z = [S, V, p_S, p_V]`, four blocks of shape `(r, k)`,
//!
//! ```math
//! H = \langle p_S S^T + p_V V^T, X \rangle_F + \tfrac14 |Y|_F^2,\qquad
//! X = V S^T - S V^T - S \Omega S^T,\quad \Omega = \tfrac12 (S^T V - V^T S),\quad Y = p_V S^T - S p_V^T
//! ```
//!
//! and with `L = p_S S^T - S p_S^T + p_V V^T - V p_V^T`
//!
//! ```math
//! S' = X S,\quad V' = X V + Y S,\quad p_V' = X p_V - L S + \tfrac12 S K,\quad
//! p_S' = X p_S + Y p_V + L (V - S \Omega) - \tfrac12 V K,\quad K = S^T L S
//! ```
//!
//! On the constraints, `X S = V` and `|Y|_F^2 / 4 = |A|^2 / 2` for the covariant acceleration `A = Y S`. Off them, `X`
//! and `Y` are still skew, so `S^T S` and `S^T V + V^T S` are constant along every solution.
//!
//! Every term is a block of `z` times a `(k, k)` matrix built from `G = z^T z`: the field is `z C(G)`.

use faer::{Mat, MatMut, MatRef};

use crate::linalg::product::{axpy, mul_add, mul_into};
use crate::linalg::structure::dot;

/// Indices of the blocks.
pub(crate) const S: usize = 0;
pub(crate) const V: usize = 1;
pub(crate) const P_S: usize = 2;
pub(crate) const P_V: usize = 3;

/// Buffers for one evaluation.
pub(crate) struct EmbeddedField {
    k: usize,
    /// `G`, shape `(4k, 4k)`.
    products: Mat<f64>,
    /// `C`, of the same shape: its block column `j` yields the derivative of block `j`.
    coefficients: Mat<f64>,
    omega: Mat<f64>,
    square: Mat<f64>,
}

impl EmbeddedField {
    pub(crate) fn new(k: usize) -> Self {
        EmbeddedField {
            k,
            products: Mat::zeros(4 * k, 4 * k),
            coefficients: Mat::zeros(4 * k, 4 * k),
            omega: Mat::zeros(k, k),
            square: Mat::zeros(k, k),
        }
    }

    /// Evaluates the vector field; shapes `(r, 4k)`.
    pub(crate) fn evaluate(&mut self, z: MatRef<'_, f64>, out: MatMut<'_, f64>) {
        self.set_products(z);
        self.set_rotation();
        self.add_acceleration();
        self.add_momentum();
        self.add_torque();
        mul_into(out, 1.0, z, &self.coefficients);
    }

    /// `H = <p_S, X S> + <p_V, X V> + |Y|_F^2 / 4`.
    pub(crate) fn energy(&mut self, z: MatRef<'_, f64>) -> f64 {
        self.set_products(z);
        self.set_rotation();
        let k = self.k;
        let rotated = |momentum: usize, vector: usize| {
            let products = self.products.as_ref().subcols(k * momentum, k);
            dot(products, self.coefficients.as_ref().subcols(k * vector, k))
        };
        let product = |i, j| block(&self.products, k, i, j);
        let square = dot(product(S, S), product(P_V, P_V)) - dot(product(S, P_V), product(P_V, S));
        rotated(P_S, S) + rotated(P_V, V) + 0.5 * square
    }

    /// Sets `G` and `Omega`.
    fn set_products(&mut self, z: MatRef<'_, f64>) {
        mul_into(&mut self.products, 1.0, z.transpose(), z);
        let inner = block(&self.products, self.k, S, V);
        set_skew(self.omega.as_mut(), 0.5, inner);
    }

    /// Sets `C` to `X z`.
    fn set_rotation(&mut self) {
        let k = self.k;
        let with_point = self.products.as_ref().subrows(k * S, k);
        let with_velocity = self.products.as_ref().subrows(k * V, k);
        self.coefficients.fill(0.0);
        let c = &mut self.coefficients;
        axpy(c.subrows_mut(k * V, k), 1.0, with_point);
        axpy(c.subrows_mut(k * S, k), -1.0, with_velocity);
        mul_add(c.subrows_mut(k * S, k), -1.0, &self.omega, with_point);
    }

    /// Adds `Y S` to the derivative of `V` and `Y p_V` to the derivative of `p_S`.
    fn add_acceleration(&mut self) {
        for (column, vector) in [(V, S), (P_S, P_V)] {
            self.add(P_V, column, 1.0, [S, vector]);
            self.add(S, column, -1.0, [P_V, vector]);
        }
    }

    /// Adds `-L S` to the derivative of `p_V` and `L (V - S Omega)` to the derivative of `p_S`.
    fn add_momentum(&mut self) {
        let k = self.k;
        for (row, with, sign) in [(P_S, S, 1.0), (P_V, V, 1.0), (S, P_S, -1.0), (V, P_V, -1.0)] {
            self.add(row, P_V, -sign, [with, S]);
            self.add(row, P_S, sign, [with, V]);
            let turned = block(&self.products, k, with, S);
            let to = block_mut(&mut self.coefficients, k, row, P_S);
            mul_add(to, -sign, turned, &self.omega);
        }
    }

    /// Adds `S K / 2` to the derivative of `p_V` and `-V K / 2` to the derivative of `p_S`.
    fn add_torque(&mut self) {
        let k = self.k;
        let product = |i, j| block(&self.products, k, i, j);
        mul_into(&mut self.square, 1.0, product(S, P_S), product(S, S));
        mul_add(&mut self.square, 1.0, product(S, P_V), product(V, S));
        for (row, column, half) in [(S, P_V, 0.5), (V, P_S, -0.5)] {
            let to = block_mut(&mut self.coefficients, k, row, column);
            add_skew(to, half, self.square.as_ref());
        }
    }

    /// Adds a multiple of a block of `G` to a block of `C`.
    fn add(&mut self, row: usize, column: usize, factor: f64, [i, j]: [usize; 2]) {
        let to = block_mut(&mut self.coefficients, self.k, row, column);
        axpy(to, factor, block(&self.products, self.k, i, j));
    }
}

fn block(a: &Mat<f64>, k: usize, i: usize, j: usize) -> MatRef<'_, f64> {
    a.as_ref().submatrix(k * i, k * j, k, k)
}

fn block_mut(a: &mut Mat<f64>, k: usize, i: usize, j: usize) -> MatMut<'_, f64> {
    a.as_mut().submatrix_mut(k * i, k * j, k, k)
}

/// `out = factor (a - a^T)`.
fn set_skew(mut out: MatMut<'_, f64>, factor: f64, a: MatRef<'_, f64>) {
    out.fill(0.0);
    add_skew(out, factor, a);
}

/// `out += factor (a - a^T)`.
fn add_skew(mut out: MatMut<'_, f64>, factor: f64, a: MatRef<'_, f64>) {
    for j in 0..a.ncols() {
        for i in 0..a.nrows() {
            out[(i, j)] += factor * (a[(i, j)] - a[(j, i)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::structure::norm;

    const STEP: f64 = 1e-3;

    /// A state with irregular entries.
    fn state(r: usize, k: usize) -> Mat<f64> {
        Mat::from_fn(r, 4 * k, |i, j| {
            (1.7 * (i + 1) as f64 * (j + 2) as f64).sin()
        })
    }

    /// Compared with `(dH/dp, -dH/dq)` by differences of order 4: round-off `eps / STEP`, truncation `STEP^4`.
    #[test]
    fn field_is_the_symplectic_gradient_of_the_energy() {
        for (r, k) in [(2, 1), (3, 1), (3, 2), (5, 2), (4, 4)] {
            let (z, mut field) = (state(r, k), EmbeddedField::new(k));
            let mut found = Mat::zeros(r, 4 * k);
            field.evaluate(z.as_ref(), found.as_mut());
            let mut expected = Mat::zeros(r, 4 * k);
            for j in 0..4 * k {
                let (to, sign) = if j < 2 * k {
                    (j + 2 * k, -1.0)
                } else {
                    (j - 2 * k, 1.0)
                };
                for i in 0..r {
                    let mut at = |steps: f64| {
                        let mut moved = z.clone();
                        moved[(i, j)] += steps * STEP;
                        field.energy(moved.as_ref())
                    };
                    let near = at(1.0) - at(-1.0);
                    let far = at(2.0) - at(-2.0);
                    expected[(i, to)] = sign * (8.0 * near - far) / (12.0 * STEP);
                }
            }
            let error = norm((&found - &expected).as_ref()) / norm(found.as_ref());
            assert!(error < 1e-10, "({r}, {k}): {error:.1e}");
        }
    }

    /// `S^T S` and `S^T V + V^T S` are constant in the whole ambient space, to the round-off of sums of `k` products.
    #[test]
    fn constraints_are_constant_off_the_manifold() {
        for (r, k) in [(3, 1), (3, 2), (5, 2), (4, 4)] {
            let (z, mut field) = (state(r, k), EmbeddedField::new(k));
            let mut rate = Mat::zeros(r, 4 * k);
            field.evaluate(z.as_ref(), rate.as_mut());
            let part = |a: &Mat<f64>, i: usize| a.as_ref().subcols(k * i, k).to_owned();
            let (s, v, ds, dv) = (part(&z, S), part(&z, V), part(&rate, S), part(&rate, V));
            let half = s.transpose() * &dv + ds.transpose() * &v;
            let moved = [s.transpose() * &ds, half].map(|a| norm((&a + a.transpose()).as_ref()));
            let bound =
                64.0 * (r * k) as f64 * f64::EPSILON * norm(rate.as_ref()) * norm(z.as_ref());
            assert!(moved.iter().all(|x| *x <= bound), "({r}, {k}): {moved:?}");
        }
    }
}
