//! Curves of subspaces: compared with reflections, which embed the Grassmann manifold in the orthogonal matrices.

mod batch;
mod boundary;
mod closed_derivative;
#[path = "../common/mod.rs"]
mod common;
mod derivative;
mod geometric_cubic;
mod guess;
mod initial;
mod polynomial;
mod several_solutions;
mod spline;
mod velocities;

use common::{Rng, gaussian, random_orthogonal, random_point};
use faer::{Mat, MatRef, Scale};
use stiefel_rs::cubic::{BoundaryOptions, SearchOptions};
use stiefel_rs::{Grassmann, Quotient, SubspacePolynomial};

/// `n, k`: lines, planes, half of the dimensions, all but one.
const SHAPES: [(usize, usize); 6] = [(3, 1), (4, 2), (5, 2), (3, 2), (6, 3), (8, 3)];

fn boundary_options() -> BoundaryOptions<'static> {
    BoundaryOptions {
        quotient: Quotient::Subspaces,
        ..BoundaryOptions::default()
    }
}

fn search_options() -> SearchOptions<'static> {
    SearchOptions {
        boundary: boundary_options(),
        ..SearchOptions::default()
    }
}

/// `2 Y Y^T - I`.
fn reflection(y: MatRef<'_, f64>) -> Mat<f64> {
    let n = y.nrows();
    y * y.transpose() * Scale(2.0) - Mat::<f64>::identity(n, n)
}

/// The image of a horizontal vector at `y`: `2 (V Y^T + Y V^T)`.
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

/// Control points, each at a largest principal angle `step` from the previous one, in randomly rotated bases.
fn walk((n, k): (usize, usize), degree: usize, step: f64, rng: &mut Rng) -> Vec<Mat<f64>> {
    let manifold = Grassmann::new(n, k).unwrap();
    let mut points = vec![random_point(n, k, rng)];
    for _ in 0..degree {
        let from = points[points.len() - 1].clone();
        let v = horizontal(view(&from), gaussian(n, k, rng).as_ref());
        let v = &v * Scale(step / v.singular_values().unwrap()[0]);
        let to = manifold.exp(view(&from), view(&v)).unwrap();
        points.push(to * random_orthogonal(k, rng));
    }
    points
}

fn polynomial(points: &[Mat<f64>]) -> SubspacePolynomial {
    SubspacePolynomial::try_from(points).unwrap()
}
