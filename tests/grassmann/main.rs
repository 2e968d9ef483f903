//! The Grassmann manifold: membership, geodesics, logarithms at every kind of angle, transport, curvature, gradients.

#[path = "../common/mod.rs"]
mod common;

mod curvature;
mod geodesics;
mod logarithm;
mod membership;

use common::{Rng, frobenius, gaussian, project_off, random_point};
use faer::{Mat, Scale};
use stiefel_rs::Grassmann;

/// Lines, `n = 2k`, `n < 2k`, hyperplanes, a single point, and more columns than plane rotations are used for.
pub const SIZES: [(usize, usize); 10] = [
    (3, 1),
    (2, 1),
    (4, 2),
    (5, 3),
    (5, 4),
    (3, 3),
    (1, 1),
    (20, 4),
    (12, 5),
    (30, 12),
];

pub fn manifold(y: &Mat<f64>) -> Grassmann {
    Grassmann::of("Y", y.as_ref()).unwrap()
}

/// A horizontal vector at `y` of the given norm; zero if it is the only one.
pub fn horizontal(y: &Mat<f64>, length: f64, rng: &mut Rng) -> Mat<f64> {
    let (n, k) = y.shape();
    let v = project_off(y, &project_off(y, &gaussian(n, k, rng)));
    if n == k {
        return Mat::zeros(n, k);
    }
    let size = frobenius(v.as_ref());
    v * Scale(length / size)
}

/// Points of all shapes with a generator for vectors.
pub fn each_point(mut test: impl FnMut(Grassmann, Mat<f64>, &mut Rng)) {
    let mut rng = Rng::new(20_240_601);
    for (n, k) in SIZES {
        for _ in 0..5 {
            let y = random_point(n, k, &mut rng);
            test(manifold(&y), y, &mut rng);
        }
    }
}

pub fn exp(y: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
    manifold(y).exp(y.as_ref(), v.as_ref()).unwrap()
}

pub fn log(y0: &Mat<f64>, y1: &Mat<f64>) -> Mat<f64> {
    manifold(y0).log(y0.as_ref(), y1.as_ref()).unwrap()
}

pub fn angles(y0: &Mat<f64>, y1: &Mat<f64>) -> Vec<f64> {
    manifold(y0)
        .principal_angles(y0.as_ref(), y1.as_ref())
        .unwrap()
}

pub fn transport(y: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> Mat<f64> {
    manifold(y)
        .transport(y.as_ref(), v.as_ref(), w.as_ref())
        .unwrap()
}
