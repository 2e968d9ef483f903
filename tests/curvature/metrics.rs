//! The curvature tensor and its sectional curvatures at random points, in several metrics.

use faer::Mat;
use stiefel_rs::{Metric, Stiefel};

use crate::common::{Rng, SIZES, random_point, random_tangent};

pub fn metrics() -> [Metric; 4] {
    [
        Metric::CANONICAL,
        Metric::EUCLIDEAN,
        Metric::new(1.5).unwrap(),
        Metric::new(-0.8).unwrap(),
    ]
}

pub fn manifold(s: &Mat<f64>, metric: Metric) -> Stiefel {
    Stiefel::of("S", s.as_ref()).unwrap().with_metric(metric)
}

pub fn r(m: Stiefel, s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> Mat<f64> {
    m.curvature(s.as_ref(), u.as_ref(), v.as_ref(), w.as_ref())
        .unwrap()
}

pub fn inner(m: Stiefel, s: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> f64 {
    m.inner(s.as_ref(), v.as_ref(), w.as_ref()).unwrap()
}

pub fn sectional(m: Stiefel, s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>) -> f64 {
    m.sectional_curvature(s.as_ref(), u.as_ref(), v.as_ref())
        .unwrap_or_else(|e| panic!("{:?}: {e}", s.shape()))
}

/// A point and four tangent vectors of norm 1 in each shape of dimension at least 2.
pub fn each_shape(seed: u64, mut check: impl FnMut(&Mat<f64>, [&Mat<f64>; 4], &str)) {
    let mut rng = Rng::new(seed);
    for (n, k) in SIZES {
        if Stiefel::new(n, k).unwrap().dim() < 2 {
            continue;
        }
        for _ in 0..3 {
            let s = random_point(n, k, &mut rng);
            let vectors: [Mat<f64>; 4] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
            check(&s, vectors.each_ref(), &format!("({n}, {k})"));
        }
    }
}
