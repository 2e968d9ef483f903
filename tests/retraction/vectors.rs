//! Retractions applied to random vectors, and generators of rotations.

use faer::{Mat, Scale};
use stiefel_rs::{Retraction, skew_exp};

use crate::common::{Rng, SIZES, project_off, random_point, random_tangent};

pub const LINEAR: [Retraction; 3] = [Retraction::Qr, Retraction::Polar, Retraction::Cayley];

pub fn apply(retraction: Retraction, s: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
    retraction
        .retract(s.as_ref(), v.as_ref())
        .unwrap_or_else(|e| panic!("{retraction:?} {:?}: {e}", s.shape()))
}

pub fn inverse(retraction: Retraction, s0: &Mat<f64>, s1: &Mat<f64>) -> Mat<f64> {
    retraction
        .inverse_retract(s0.as_ref(), s1.as_ref())
        .unwrap_or_else(|e| panic!("{retraction:?} {:?}: {e}", s0.shape()))
}

/// A point and a tangent vector of each norm, in each shape.
pub fn each_shape(norms: &[f64], mut check: impl FnMut(&Mat<f64>, &Mat<f64>, &str)) {
    let mut rng = Rng::new(71);
    for (n, k) in SIZES {
        for norm in norms {
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, *norm, &mut rng);
            check(&s, &v, &format!("({n}, {k}), |V| = {norm}"));
        }
    }
}

/// The skew `n x n` matrix `K S^T - S K^T + f S Omega S^T` of a tangent vector.
pub fn generator(s: &Mat<f64>, v: &Mat<f64>, f: f64) -> Mat<f64> {
    let omega = s.transpose() * v;
    let normal = project_off(s, v);
    &normal * s.transpose() - s * normal.transpose() + s * omega * s.transpose() * Scale(f)
}

/// The end of the geodesic of the metric of weight `w` at 1, by full-size exponentials.
pub fn exponential(s: &Mat<f64>, v: &Mat<f64>, w: f64) -> Mat<f64> {
    let skew = |a: Mat<f64>| (&a - a.transpose()) * Scale(0.5);
    let turn = skew_exp(skew(s.transpose() * v * Scale(1.0 - 2.0 * w)).as_ref()).unwrap();
    skew_exp(skew(generator(s, v, 2.0 * w)).as_ref()).unwrap() * s * turn
}
