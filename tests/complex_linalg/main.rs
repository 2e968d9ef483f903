//! Exponentials of skew-Hermitian matrices and logarithms of unitary ones.

#[path = "../common/mod.rs"]
mod common;
mod exponential;
mod logarithm;

use common::{Rng, gaussian};
use faer::{Mat, Scale, c64};

pub const SIZES: [usize; 12] = [1, 2, 3, 4, 5, 8, 12, 23, 24, 30, 50, 81];

pub fn i_times(x: f64) -> c64 {
    c64::new(0.0, x)
}

pub fn phase(angle: f64) -> c64 {
    c64::new(angle.cos(), angle.sin())
}

pub fn complex(re: &Mat<f64>, im: &Mat<f64>) -> Mat<c64> {
    Mat::from_fn(re.nrows(), re.ncols(), |i, j| {
        c64::new(re[(i, j)], im[(i, j)])
    })
}

pub fn identity(m: usize) -> Mat<c64> {
    Mat::identity(m, m)
}

pub fn random_unitary(m: usize, rng: &mut Rng) -> Mat<c64> {
    complex(&gaussian(m, m, rng), &gaussian(m, m, rng))
        .qr()
        .compute_thin_Q()
}

pub fn diagonal(entries: &[c64]) -> Mat<c64> {
    Mat::from_fn(entries.len(), entries.len(), |i, j| {
        if i == j {
            entries[i]
        } else {
            c64::new(0.0, 0.0)
        }
    })
}

/// `B diag(entries) B^H`.
pub fn conjugated(b: &Mat<c64>, entries: impl Iterator<Item = c64>) -> Mat<c64> {
    b * diagonal(&entries.collect::<Vec<_>>()) * b.adjoint()
}

pub fn skew_with_angles(b: &Mat<c64>, angles: &[f64]) -> Mat<c64> {
    let a = conjugated(b, angles.iter().map(|x| i_times(*x)));
    (&a - a.adjoint()) * Scale(c64::new(0.5, 0.0))
}

pub fn unitary_with_angles(b: &Mat<c64>, angles: &[f64]) -> Mat<c64> {
    conjugated(b, angles.iter().map(|x| phase(*x)))
}

pub fn spectral(a: &Mat<c64>) -> f64 {
    a.singular_values()
        .expect("singular values of finite input")[0]
}

pub fn distance(a: &Mat<c64>, b: &Mat<c64>) -> f64 {
    spectral(&(a - b))
}

pub fn unitarity(u: &Mat<c64>) -> f64 {
    distance(&(u.adjoint() * u), &identity(u.nrows()))
}

pub fn random_skew_hermitian(m: usize, norm: f64, rng: &mut Rng) -> Mat<c64> {
    let x = complex(&gaussian(m, m, rng), &gaussian(m, m, rng));
    let a = &x - x.adjoint();
    let size = spectral(&a);
    Mat::from_fn(m, m, |i, j| a[(i, j)] / size * norm)
}

pub fn embedded(a: &Mat<c64>) -> Mat<f64> {
    let m = a.nrows();
    Mat::from_fn(2 * m, 2 * m, |i, j| {
        let x = a[(i % m, j % m)];
        match (i < m, j < m) {
            (true, true) | (false, false) => x.re,
            (true, false) => -x.im,
            (false, true) => x.im,
        }
    })
}
