//! Derivatives of the Riemannian exponential and logarithm of frames with respect to points and vectors, and their
//! transposes.
//!
//! For the canonical metric, with `U = V - S S^T V / 2`,
//!
//! ```math
//! \exp_S(V) = e^A S,\qquad A = U S^T - S U^T,
//! ```
//!
//! which is smooth even where `V` is rank-deficient. The logarithm is the inverse with respect to `V`: one dense linear
//! system in orthonormal bases of both tangent spaces.
//!
//! # Source
//! Edelman, Arias, Smith (1998), section 2.4 (the exponential).

use faer::{Mat, MatRef, Scale, c64};

use super::Stiefel;
use super::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::SkewExpDifferential;
use crate::linalg::complex_embedding::{embed, restrict};
use crate::linalg::decomp::{singular_range, solve_matrix, unitary_q};
use crate::linalg::structure::{
    check_finite, check_range, check_shape, frobenius_inner, symmetric_part,
};
use crate::space::ScalarField;

/// Ends count as conjugate if the smallest singular value of the derivative is below this fraction of the largest, as
/// for boundary problems.
const CONJUGATE: f64 = 1e-11;

/// Maximal number of floating-point numbers that a derivative of the logarithm may store, 4 GB.
const LARGEST: f64 = 5e8;

/// Quantity named in `Overflow` errors.
const DERIVATIVE: &str = "derivative";

/// The derivative of `exp_S(V)`, canonical metric, at a point and a tangent vector of St(n, k); all matrices `(n, k)`.
///
/// Variations are derivatives of matrices along a family of points and vectors: `S^T S'` is skew, and `S^T V' + V'^T
/// S + S'^T V + V^T S' = 0`. The result is accurate to about `n eps` relative to their norms. Cost `O(n^3)`.
///
/// # Examples
/// ```
/// use faer::{Mat, Scale, mat};
/// use stiefel_rs::manifold::{ExponentialDifferential, Stiefel};
/// let s = mat![[1.0], [0.0], [0.0]];
/// let (v, dv) = (mat![[0.0], [0.7], [0.0]], mat![[0.0], [0.3], [1.0]]);
/// let found = ExponentialDifferential::new(s.as_ref(), v.as_ref())?.apply(Mat::zeros(3, 1).as_ref(), dv.as_ref())?;
/// let (m, h) = (Stiefel::new(3, 1)?, 1e-5);
/// let [before, after] = [-h, h].map(|h| m.exp(s.as_ref(), (&v + Scale(h) * &dv).as_ref()));
/// assert!((found - (after? - before?) * Scale(0.5 / h)).norm_l2() < 1e-9);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct ExponentialDifferential {
    s: Mat<f64>,
    v: Mat<f64>,
    /// `U`.
    half: Mat<f64>,
    rotation: SkewExpDifferential,
}

impl ExponentialDifferential {
    /// The derivative at the point `s` and the tangent vector `v`, shapes `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `Overflow`, `Decomposition`.
    pub fn new(s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Result<Self> {
        let manifold = Stiefel::of("S", s)?;
        manifold.check_point("S", s, POINT_TOLERANCE)?;
        manifold.check_tangent("V", s, v, TANGENT_TOLERANCE)?;
        let half = half_normal(s, v);
        let rotation = SkewExpDifferential::new(generator(s, half.as_ref()).as_ref())?;
        Ok(ExponentialDifferential {
            s: s.to_owned(),
            v: v.to_owned(),
            half,
            rotation,
        })
    }

    /// `exp_S(V)`.
    pub fn value(&self) -> Mat<f64> {
        self.rotation.value() * &self.s
    }

    /// The variation of the value for variations `ds` of the point and `dv` of the vector.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn apply(&self, ds: MatRef<'_, f64>, dv: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.check("dS", ds)?;
        self.check("dV", dv)?;
        let (s, v, u) = (self.s.as_ref(), self.v.as_ref(), self.half.as_ref());
        let carried = ds * (s.transpose() * v) + s * (ds.transpose() * v);
        let du = half_normal(s, dv) - Scale(0.5) * carried;
        let turned = generator(s, du.as_ref()) + generator(ds, u);
        let moved = self.rotation.apply(turned.as_ref())? * s + self.rotation.value() * ds;
        finite(moved)
    }

    /// The transpose: matrices `(GS, GV)` with `<W, apply(dS, dV)> = <GS, dS> + <GV, dV>` (Frobenius) for all
    /// variations.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn pull_back(&self, w: MatRef<'_, f64>) -> Result<(Mat<f64>, Mat<f64>)> {
        self.check("W", w)?;
        let (s, v, u) = (self.s.as_ref(), self.v.as_ref(), self.half.as_ref());
        let skew = self.rotation.pull_back((w * s.transpose()).as_ref())?;
        let by_half = Scale(2.0) * (&skew * s);
        let inner = s.transpose() * &by_half;
        let turned = &by_half * (v.transpose() * s) + v * inner.transpose();
        let by_point =
            self.rotation.value().transpose() * w - Scale(2.0) * (&skew * u) - Scale(0.5) * turned;
        let by_vector = by_half - Scale(0.5) * (s * inner);
        Ok((finite(by_point)?, finite(by_vector)?))
    }

    fn check(&self, name: &'static str, matrix: MatRef<'_, f64>) -> Result<()> {
        check_shape(name, matrix, self.s.nrows(), self.s.ncols())?;
        check_finite(name, matrix)
    }
}

/// The derivative of `log_S0(S1)`, canonical metric, at two points of St(n, k); all matrices `(n, k)`.
///
/// Variations are derivatives of matrices along families of points: `S^T S'` is skew. With `d` the dimension of the
/// manifold, construction costs `O(d n^3 + d^3)`, application `O(n^3 + d^2)`.
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::manifold::{LogarithmDifferential, Stiefel};
/// let s0 = mat![[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
/// let v = mat![[0.0, -0.5], [0.5, 0.0], [0.2, 0.3]];
/// let s1 = Stiefel::new(3, 2)?.exp(s0.as_ref(), v.as_ref())?;
/// let log = LogarithmDifferential::new(s0.as_ref(), s1.as_ref())?;
/// // Along the geodesic the end moves by its velocity, and the logarithm by its own length.
/// let moved = log.exponential().apply(Mat::zeros(3, 2).as_ref(), v.as_ref())?;
/// assert!((log.apply(Mat::zeros(3, 2).as_ref(), moved.as_ref())? - v).norm_l2() < 1e-13);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct LogarithmDifferential {
    exponential: ExponentialDifferential,
    /// Orthonormal bases of the tangent spaces at both points.
    bases: [Vec<Mat<f64>>; 2],
    /// The derivative of the exponential with respect to the vector, in these bases.
    inverse: Mat<f64>,
}

impl LogarithmDifferential {
    /// The derivative at two points, shape `(n, k)`.
    ///
    /// # Errors
    /// The errors of [`Stiefel::log`]; `InvalidArgument` if it would take more than 5e8 numbers; `ConjugateEnds` if the
    /// smallest singular value of the derivative of the exponential is below 1e-11 of the largest.
    pub fn new(s0: MatRef<'_, f64>, s1: MatRef<'_, f64>) -> Result<Self> {
        Self::over(ScalarField::Real, s0, s1, Interrupt::NEVER)
    }

    /// As `new`, for embedded complex points; variations must be embedded too, which is not checked.
    pub(crate) fn over(
        field: ScalarField,
        s0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let manifold = Stiefel::of("S0", s0)?;
        check_size(manifold.dim(), s0)?;
        let (v, _) = manifold.log_with_report(s0, s1, interrupt)?;
        let exponential = ExponentialDifferential::new(s0, v.as_ref())?;
        let bases = [tangent_basis(field, s0)?, tangent_basis(field, s1)?];
        let still = Mat::zeros(s0.nrows(), s0.ncols());
        let columns = bases[0].iter().map(|e| {
            interrupt.check(DERIVATIVE)?;
            exponential.apply(still.as_ref(), e.as_ref())
        });
        let columns = columns.collect::<Result<Vec<_>>>()?;
        let d = columns.len();
        let matrix = Mat::from_fn(d, d, |i, j| inner(&bases[1][i], columns[j].as_ref()));
        interrupt.check(DERIVATIVE)?;
        let inverse = inverse(matrix.as_ref())?;
        Ok(LogarithmDifferential {
            exponential,
            bases,
            inverse,
        })
    }

    /// The derivative of the exponential at `S0` and the logarithm.
    pub fn exponential(&self) -> &ExponentialDifferential {
        &self.exponential
    }

    /// `log_S0(S1)`.
    pub fn value(&self) -> MatRef<'_, f64> {
        self.exponential.v.as_ref()
    }

    /// The variation of the logarithm for variations `ds0` and `ds1` of the points.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn apply(&self, ds0: MatRef<'_, f64>, ds1: MatRef<'_, f64>) -> Result<Mat<f64>> {
        self.exponential.check("dS0", ds0)?;
        self.exponential.check("dS1", ds1)?;
        let (s, v) = (&self.exponential.s, &self.exponential.v);
        // The part of the variation that keeps the vector tangent.
        let mut moved = s * symmetric_part((ds0.transpose() * v).as_ref()) * Scale(-1.0);
        let missing = ds1 - self.exponential.apply(ds0, moved.as_ref())?;
        let missing = coordinates(&self.bases[1], missing.as_ref());
        let change = &self.inverse * missing;
        moved += combined(&self.bases[0], change.as_ref(), s.shape());
        finite(moved)
    }

    /// The transpose: matrices `(G0, G1)` with `<W, apply(dS0, dS1)> = <G0, dS0> + <G1, dS1>` (Frobenius) for all variations.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `Overflow`.
    pub fn pull_back(&self, w: MatRef<'_, f64>) -> Result<(Mat<f64>, Mat<f64>)> {
        self.exponential.check("W", w)?;
        let (s, v) = (&self.exponential.s, &self.exponential.v);
        let weights = self.inverse.transpose() * coordinates(&self.bases[0], w);
        let by_end = combined(&self.bases[1], weights.as_ref(), s.shape());
        let (by_start, by_vector) = self.exponential.pull_back(by_end.as_ref())?;
        let rest = symmetric_part((s.transpose() * (w - by_vector)).as_ref());
        let by_start = (by_start + v * rest) * Scale(-1.0);
        Ok((finite(by_start)?, finite(by_end)?))
    }
}

/// `InvalidArgument` if the derivative would take more numbers than allowed for a spline.
fn check_size(dimension: usize, s: MatRef<'_, f64>) -> Result<()> {
    let (n, k) = s.shape();
    let numbers = dimension as f64 * (3 * n * k + 3 * dimension) as f64;
    if numbers <= LARGEST {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "S0",
        requirement: "small enough for the derivative to have at most 5e8 numbers",
        found: numbers,
    })
}

/// `V - S S^T V / 2`.
fn half_normal(s: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Mat<f64> {
    v - Scale(0.5) * (s * (s.transpose() * v))
}

/// `U S^T - S U^T`.
fn generator(s: MatRef<'_, f64>, u: MatRef<'_, f64>) -> Mat<f64> {
    let product = u * s.transpose();
    &product - product.transpose()
}

/// An orthonormal basis of the tangent space at a point, over the real numbers.
fn tangent_basis(field: ScalarField, s: MatRef<'_, f64>) -> Result<Vec<Mat<f64>>> {
    let one = c64::new(1.0, 0.0);
    let (point, units) = match field {
        ScalarField::Real => {
            let point = Mat::from_fn(s.nrows(), s.ncols(), |i, j| c64::new(s[(i, j)], 0.0));
            (point, vec![one])
        }
        ScalarField::Complex => (restrict(s)?, vec![one, c64::new(0.0, 1.0)]),
    };
    let (n, k) = point.shape();
    let whole = unitary_q(point.as_ref(), true);
    let mut basis = Vec::new();
    let mut push = |vector: Mat<c64>| {
        let vector = match field {
            ScalarField::Real => Mat::from_fn(n, k, |i, j| vector[(i, j)].re),
            ScalarField::Complex => embed(vector.as_ref()),
        };
        let length = vector.norm_l2();
        basis.push(vector * Scale(1.0 / length));
    };
    for unit in units {
        for j in 0..k {
            // S (unit e_i e_j^T - conj(unit) e_j e_i^T); on the diagonal only imaginary numbers are skew.
            for i in 0..=j {
                let entry = unit - unit.conj() * c64::from(f64::from(u8::from(i == j)));
                if i == j && entry.norm() == 0.0 {
                    continue;
                }
                let mut vector = Mat::zeros(n, k);
                for row in 0..n {
                    vector[(row, j)] = point[(row, i)] * entry;
                    if i != j {
                        vector[(row, i)] = -point[(row, j)] * unit.conj();
                    }
                }
                push(vector);
            }
            for normal in k..n {
                let mut vector = Mat::zeros(n, k);
                for row in 0..n {
                    vector[(row, j)] = whole[(row, normal)] * unit;
                }
                push(vector);
            }
        }
    }
    Ok(basis)
}

/// The inverse of the derivative, in bases of both tangent spaces.
///
/// # Errors
/// `ConjugateEnds`.
fn inverse(matrix: MatRef<'_, f64>) -> Result<Mat<f64>> {
    let d = matrix.nrows();
    if d == 0 {
        return Ok(Mat::zeros(0, 0));
    }
    let [smallest, largest] = singular_range(matrix)?;
    let identity = Mat::<f64>::identity(d, d);
    match solve_matrix(matrix, identity.as_ref()) {
        Some(inverse) if smallest > CONJUGATE * largest => Ok(inverse),
        _ => Err(Error::ConjugateEnds { smallest, largest }),
    }
}

fn inner(a: &Mat<f64>, b: MatRef<'_, f64>) -> f64 {
    frobenius_inner(a.as_ref(), b)
}

fn coordinates(basis: &[Mat<f64>], vector: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(basis.len(), 1, |i, _| inner(&basis[i], vector))
}

fn combined(basis: &[Mat<f64>], factors: MatRef<'_, f64>, (n, k): (usize, usize)) -> Mat<f64> {
    let mut sum = Mat::zeros(n, k);
    for (i, vector) in basis.iter().enumerate() {
        sum += Scale(factors[(i, 0)]) * vector;
    }
    sum
}

fn finite(matrix: Mat<f64>) -> Result<Mat<f64>> {
    check_range(DERIVATIVE, matrix.as_ref())?;
    Ok(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(n: usize, k: usize, seed: usize) -> Mat<f64> {
        Mat::from_fn(n, k, |i, j| {
            ((31 * i * i + 17 * i * j + 5 * j * j * j + 11 * seed * (i + 1) + 3) as f64).sin()
        })
    }

    /// A point and a tangent vector of the given length.
    fn data(n: usize, k: usize, length: f64) -> (Mat<f64>, Mat<f64>) {
        let manifold = Stiefel::new(n, k).unwrap();
        let s = manifold.project(matrix(n, k, 1).as_ref()).unwrap();
        let v = tangent(s.as_ref(), 2);
        let scale = match v.norm_l2() {
            0.0 => 0.0,
            found => length / found,
        };
        (s, v * Scale(scale))
    }

    fn tangent(s: MatRef<'_, f64>, seed: usize) -> Mat<f64> {
        let z = matrix(s.nrows(), s.ncols(), seed);
        let manifold = Stiefel::of("S", s).unwrap();
        manifold.project_tangent(s, z.as_ref()).unwrap()
    }

    /// A point and a vector of a family at parameter `h`, and their derivatives at 0.
    fn moving(s: &Mat<f64>, v: &Mat<f64>, h: f64) -> (Mat<f64>, Mat<f64>) {
        let manifold = Stiefel::of("S", s.as_ref()).unwrap();
        let ds = tangent(s.as_ref(), 3);
        let moved = manifold.project((s + Scale(h) * &ds).as_ref()).unwrap();
        let other = v + Scale(h) * matrix(s.nrows(), s.ncols(), 4);
        let vector = manifold.project_tangent(moved.as_ref(), other.as_ref());
        (moved, vector.unwrap())
    }

    fn variations(s: &Mat<f64>, v: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
        // Projecting a point is linear up to second order; projecting a vector has a term from the point.
        let h = 1e-5;
        let [before, after] = [-h, h].map(|h| moving(s, v, h));
        let half = Scale(0.5 / h);
        ((after.0 - before.0) * half, (after.1 - before.1) * half)
    }

    const SHAPES: [(usize, usize); 7] = [(1, 1), (2, 2), (3, 1), (3, 2), (5, 2), (5, 4), (4, 4)];

    /// Includes points with zero entries, and zero vectors.
    fn cases() -> Vec<(Mat<f64>, Mat<f64>)> {
        let mut cases = Vec::new();
        for (n, k) in SHAPES {
            for length in [0.0, 1e-9, 0.8] {
                cases.push(data(n, k, length));
            }
            let s = Mat::from_fn(n, k, |i, j| f64::from(u8::from(i == j)));
            let v = tangent(s.as_ref(), 5);
            let scale = 0.5 / v.norm_l2().max(1e-300);
            cases.push((s, v * Scale(scale.min(1.0))));
        }
        cases
    }

    #[test]
    fn derivatives_are_limits_of_differences() {
        let h = 1e-5;
        for (s, v) in cases() {
            let (n, k) = s.shape();
            let manifold = Stiefel::new(n, k).unwrap();
            let (ds, dv) = variations(&s, &v);
            let exp = ExponentialDifferential::new(s.as_ref(), v.as_ref()).unwrap();
            let found = exp.apply(ds.as_ref(), dv.as_ref()).unwrap();
            let ends = [-h, h].map(|h| {
                let (s, v) = moving(&s, &v, h);
                manifold.exp(s.as_ref(), v.as_ref()).unwrap()
            });
            let [before, after] = &ends;
            let difference = (after - before) * Scale(0.5 / h);
            let error = (&found - difference).norm_max();
            assert!(error < 1e-8, "exp ({n}, {k}) {error:e}");
            let value = exp.value();
            let log = LogarithmDifferential::new(s.as_ref(), value.as_ref()).unwrap();
            let back = log.apply(ds.as_ref(), found.as_ref()).unwrap();
            let error = (&back - &dv).norm_max();
            assert!(error < 1e-9, "log ({n}, {k}) {error:e}");
        }
    }

    #[test]
    fn pulling_back_is_the_transpose() {
        for (s, v) in cases() {
            let (n, k) = s.shape();
            let (ds, dv) = variations(&s, &v);
            let w = matrix(n, k, 6);
            let exp = ExponentialDifferential::new(s.as_ref(), v.as_ref()).unwrap();
            let moved = exp.apply(ds.as_ref(), dv.as_ref()).unwrap();
            let (gs, gv) = exp.pull_back(w.as_ref()).unwrap();
            let error =
                inner(&w, moved.as_ref()) - inner(&gs, ds.as_ref()) - inner(&gv, dv.as_ref());
            assert!(error.abs() < 1e-12, "exp ({n}, {k}) {error:e}");
            let log = LogarithmDifferential::new(s.as_ref(), exp.value().as_ref()).unwrap();
            let found = log.apply(ds.as_ref(), moved.as_ref()).unwrap();
            let (g0, g1) = log.pull_back(w.as_ref()).unwrap();
            let error =
                inner(&w, found.as_ref()) - inner(&g0, ds.as_ref()) - inner(&g1, moved.as_ref());
            assert!(error.abs() < 1e-11, "log ({n}, {k}) {error:e}");
        }
    }

    #[test]
    fn complex_variations_are_those_of_the_complex_basis() {
        for (n, k) in [(1, 1), (2, 1), (3, 2), (3, 3)] {
            let entry = |i: usize, j: usize| {
                c64::new(
                    ((3 * i * i + i * j) as f64).sin(),
                    ((i + 5 * j * j + 2) as f64).cos(),
                )
            };
            let point = unitary_q(Mat::from_fn(n, k, entry).as_ref(), false);
            let s = embed(point.as_ref());
            let basis = tangent_basis(ScalarField::Complex, s.as_ref()).unwrap();
            assert_eq!(basis.len(), k * (2 * n - k));
            for (i, one) in basis.iter().enumerate() {
                let manifold = Stiefel::of("S", s.as_ref()).unwrap();
                manifold
                    .check_tangent("V", s.as_ref(), one.as_ref(), 1e-13)
                    .unwrap();
                restrict(one.as_ref()).unwrap();
                for (j, other) in basis.iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    assert!(
                        (inner(one, other.as_ref()) - expected).abs() < 1e-13,
                        "({n}, {k})"
                    );
                }
            }
        }
    }

    #[test]
    fn conjugate_ends_are_an_error() {
        // On the unit sphere this is a rotation by pi, whose logarithm is an error, so the end is just before it.
        let s0 = Mat::from_fn(4, 1, |i, _| f64::from(u8::from(i == 0)));
        let angle = std::f64::consts::PI - 1e-12;
        let s1 = Mat::from_fn(4, 1, |i, _| [angle.cos(), angle.sin(), 0.0, 0.0][i]);
        let found = LogarithmDifferential::new(s0.as_ref(), s1.as_ref());
        assert!(matches!(found.err(), Some(Error::ConjugateEnds { .. })));
    }
}
