//! A manifold of every shape, with a point and two tangent vectors.

use faer::Mat;
use stiefel_rs::Stiefel;

use crate::common::{Rng, SIZES, random_point, random_tangent};

pub fn manifold(s: &Mat<f64>) -> Stiefel {
    Stiefel::of("S", s.as_ref()).unwrap()
}

/// A point and two tangent vectors of norms 2 and 1 in each shape.
pub fn each_shape(
    seed: u64,
    mut check: impl FnMut(Stiefel, &Mat<f64>, &Mat<f64>, &Mat<f64>, &str),
) {
    let mut rng = Rng::new(seed);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let (v, w) = (
            random_tangent(&s, 2.0, &mut rng),
            random_tangent(&s, 1.0, &mut rng),
        );
        check(manifold(&s), &s, &v, &w, &format!("({n}, {k})"));
    }
}
