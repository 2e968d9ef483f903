//! Square matrices in row-major order, for tests of brackets.

/// Small whole numbers.
pub(crate) fn numbers(count: usize, seed: usize) -> Vec<f64> {
    let number = |i: usize| ((7 * i + 3 * seed) % 11) as f64 - 5.0;
    (0..count).map(number).collect()
}

/// The product of two square matrices.
pub(crate) fn product(r: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    let entry = |at: usize| (0..r).map(|l| a[at / r * r + l] * b[l * r + at % r]).sum();
    (0..r * r).map(entry).collect()
}

/// `a b - b a`.
pub(crate) fn commutator(r: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    let (ab, ba) = (product(r, a, b), product(r, b, a));
    ab.iter().zip(ba).map(|(x, y)| x - y).collect()
}
