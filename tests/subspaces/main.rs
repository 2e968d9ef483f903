//! Curves of subspaces: against reflections, which put the Grassmann manifold into the orthogonal matrices.

mod batch;
mod boundary;
mod closed_derivative;
#[path = "../common/mod.rs"]
mod common;
mod derivative;
mod guess;
mod initial;
mod several_solutions;
mod spline;
mod velocities;

use faer::{Mat, MatRef, Scale};

/// `n, k`: lines, planes, half of the dimensions, all but one.
const SHAPES: [(usize, usize); 6] = [(3, 1), (4, 2), (5, 2), (3, 2), (6, 3), (8, 3)];

/// `2 Y Y^T - I`.
fn reflection(y: MatRef<'_, f64>) -> Mat<f64> {
    let n = y.nrows();
    y * y.transpose() * Scale(2.0) - Mat::<f64>::identity(n, n)
}

/// What a horizontal vector at `y` becomes: `2 (V Y^T + Y V^T)`.
fn reflected(y: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Mat<f64> {
    (v * y.transpose() + y * v.transpose()) * Scale(2.0)
}

/// `(I - Y Y^T) Z`.
fn horizontal(y: MatRef<'_, f64>, z: MatRef<'_, f64>) -> Mat<f64> {
    z - y * (y.transpose() * z)
}

fn view(a: &Mat<f64>) -> MatRef<'_, f64> {
    a.as_ref()
}
