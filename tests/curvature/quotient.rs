//! The manifold as a quotient of the group of rotations, with full-size matrices.

use faer::Mat;

use crate::common::{Rng, gaussian};

/// The quotient `SO(n) / SO(n-k)` with full matrices: the first k columns of `g` are `S`.
pub struct Quotient {
    g: Mat<f64>,
    k: usize,
}

impl Quotient {
    pub fn at(s: &Mat<f64>, rng: &mut Rng) -> Self {
        let (n, k) = s.shape();
        let mut both = Mat::zeros(n, n);
        both.as_mut().subcols_mut(0, k).copy_from(s);
        both.as_mut()
            .subcols_mut(k, n - k)
            .copy_from(gaussian(n, n - k, rng));
        let mut g = both.qr().compute_Q();
        g.as_mut().subcols_mut(0, k).copy_from(s);
        Quotient { g, k }
    }

    /// The `x` in `m` such that the first k columns of `g x` are `v`.
    pub fn lift(&self, v: &Mat<f64>) -> Mat<f64> {
        let (n, k) = (self.g.nrows(), self.k);
        let body = self.g.transpose() * v;
        Mat::from_fn(n, n, |i, j| match (i < k, j < k) {
            (_, true) => body[(i, j)],
            (true, false) => -body[(j, i)],
            _ => 0.0,
        })
    }

    pub fn push(&self, x: &Mat<f64>) -> Mat<f64> {
        (&self.g * x).subcols(0, self.k).to_owned()
    }

    /// The two parts of `[x, y]`.
    pub fn bracket(&self, x: &Mat<f64>, y: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
        let full = x * y - y * x;
        let (n, k) = (x.nrows(), self.k);
        let h = Mat::from_fn(
            n,
            n,
            |i, j| if i >= k && j >= k { full[(i, j)] } else { 0.0 },
        );
        (&full - &h, h)
    }
}
