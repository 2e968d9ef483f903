//! A discretization map as a user would implement it.
#![allow(dead_code)] // each binary uses a part

use nalgebra::{SMatrix, SVector};
use stiefel_rs::chart::DiscretizationMap;
use stiefel_rs::chart::discretization::Blocks;

/// A third discretization map, implemented like the crate's own: nonlinear in position and velocity.
///
/// `R_d(x, v) = (x - v/3, x + 2v/3 + c (x_i + x_{i+1}) v_i^2)`, componentwise with the next component.
pub struct Curved(pub f64);

impl<const X: usize> DiscretizationMap<X> for Curved {
    fn map(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> [SVector<f64, X>; 2] {
        let bend = SVector::from_fn(|i, _| self.0 * (x[i] + x[(i + 1) % X]) * v[i] * v[i]);
        [x - v / 3.0, x + v * (2.0 / 3.0) + bend]
    }

    fn jacobian(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> Blocks<X> {
        let identity = SMatrix::<f64, X, X>::identity();
        let (mut dx, mut dv) = (identity, identity * (2.0 / 3.0));
        for i in 0..X {
            dx[(i, i)] += self.0 * v[i] * v[i];
            dx[(i, (i + 1) % X)] += self.0 * v[i] * v[i];
            dv[(i, i)] += 2.0 * self.0 * (x[i] + x[(i + 1) % X]) * v[i];
        }
        [[identity, identity / -3.0], [dx, dv]]
    }

    fn second_derivative(
        &self,
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        l: &[SVector<f64, X>; 2],
    ) -> Blocks<X> {
        let (mut xv, mut vv) = (SMatrix::<f64, X, X>::zeros(), SMatrix::<f64, X, X>::zeros());
        for i in 0..X {
            let next = (i + 1) % X;
            xv[(i, i)] += 2.0 * self.0 * v[i] * l[1][i];
            xv[(next, i)] += 2.0 * self.0 * v[i] * l[1][i];
            vv[(i, i)] += 2.0 * self.0 * (x[i] + x[next]) * l[1][i];
        }
        [[SMatrix::zeros(), xv], [xv.transpose(), vv]]
    }
}
