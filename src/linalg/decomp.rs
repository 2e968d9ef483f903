//! Factorisations: the only place that calls those of faer and translates their errors.
//!
//! Input must be finite: a factorisation may accept NaN and return it, so callers check first.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::solvers::Solve;
use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
use faer::linalg::triangular_solve;
use faer::traits::ComplexField;
use faer::traits::math_utils::real;
use faer::{Col, Mat, MatMut, MatRef, Par, Scale, c64};

use super::gram_factors::polar_near_orthonormal;
use super::structure::check_range;
use crate::error::{Error, Result};

/// Range of entries whose squares neither overflow nor underflow; faer's iteration does not converge far outside it.
const SAFE: std::ops::Range<f64> = 1e-120..1e120;

/// Singular value decomposition `A = U diag(s) V^T`, with buffers allocated once for a largest size.
///
/// Singular values are sorted in decreasing order. `U` has `min(rows, cols)` columns, `V` is square.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::linalg::decomp::Svd;
/// let a = mat![[3.0, 0.0], [4.0, 5.0]];
/// let mut svd = Svd::new(2, 2);
/// svd.compute(a.as_ref())?;
/// // The product of the singular values is the determinant, the sum of their squares the squared norm.
/// assert!((svd.s(0) * svd.s(1) - 15.0).abs() < 1e-13);
/// assert!((svd.s(0).powi(2) + svd.s(1).powi(2) - 50.0).abs() < 1e-13);
/// assert!((&a * svd.v().col(0) - svd.u().col(0) * svd.s(0)).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct Svd {
    u: Mat<f64>,
    s: Diag<f64>,
    v: Mat<f64>,
    rows: usize,
    cols: usize,
    memory: MemBuffer,
}

impl Svd {
    /// Buffers for matrices of at most `rows x cols`.
    pub fn new(rows: usize, cols: usize) -> Self {
        let rank = rows.min(cols);
        Svd {
            u: Mat::zeros(rows, rank),
            s: Diag::zeros(rank),
            v: Mat::zeros(cols, cols),
            rows: 0,
            cols: 0,
            memory: MemBuffer::new(Self::scratch(rows, cols)),
        }
    }

    fn scratch(rows: usize, cols: usize) -> StackReq {
        let (thin, full) = (ComputeSvdVectors::Thin, ComputeSvdVectors::Full);
        svd_scratch::<f64>(rows, cols, thin, full, Par::Seq, Default::default())
    }

    /// Factors `a`, which must not exceed the size given to [`Svd::new`]. Entries of extreme size are scaled in a copy.
    ///
    /// # Errors
    /// `Overflow` if an entry is not finite, since faer's iteration might not end; `Decomposition` if it does not
    /// converge.
    pub fn compute(&mut self, a: MatRef<'_, f64>) -> Result<()> {
        check_range("matrix to factor", a)?;
        let largest = a.norm_max();
        if largest == 0.0 || SAFE.contains(&largest) {
            return self.compute_scaled(a);
        }
        let scaled = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / largest);
        self.compute_scaled(scaled.as_ref())?;
        for i in 0..self.rows.min(self.cols) {
            self.s[i] *= largest;
        }
        Ok(())
    }

    fn compute_scaled(&mut self, a: MatRef<'_, f64>) -> Result<()> {
        let (rows, cols) = (a.nrows(), a.ncols());
        (self.rows, self.cols) = (rows, cols);
        if rows == 1 && cols == 1 {
            // The sphere: a single cosine, for which no iteration is needed.
            self.u[(0, 0)] = if a[(0, 0)] < 0.0 { -1.0 } else { 1.0 };
            self.s[0] = a[(0, 0)].abs();
            self.v[(0, 0)] = 1.0;
            return Ok(());
        }
        let first = self.iterate(a);
        if first.is_ok() {
            return first;
        }
        // faer's iteration stalls on about one in 1e5 matrices whose singular values come in equal pairs, as for
        // embedded complex matrices. After a change of coordinates it converges.
        self.iterate(reflected(a).as_ref())?;
        let v = reflected(self.v().transpose());
        self.v
            .as_mut()
            .submatrix_mut(0, 0, cols, cols)
            .copy_from(v.transpose());
        Ok(())
    }

    fn iterate(&mut self, a: MatRef<'_, f64>) -> Result<()> {
        let (rows, cols) = (a.nrows(), a.ncols());
        let rank = rows.min(cols);
        // For wide input, faer sets only a part of V and assumes that the rest is zero.
        self.v.fill(0.0);
        svd(
            a,
            self.s
                .as_mut()
                .column_vector_mut()
                .subrows_mut(0, rank)
                .as_diagonal_mut(),
            Some(self.u.as_mut().submatrix_mut(0, 0, rows, rank)),
            Some(self.v.as_mut().submatrix_mut(0, 0, cols, cols)),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        )
        .map_err(|_| Error::Decomposition {
            kind: "singular value decomposition",
        })
    }

    /// Left singular vectors, `rows x min(rows, cols)`.
    pub fn u(&self) -> MatRef<'_, f64> {
        self.u
            .as_ref()
            .submatrix(0, 0, self.rows, self.rows.min(self.cols))
    }

    /// The `i`-th largest singular value.
    pub fn s(&self, i: usize) -> f64 {
        self.s[i]
    }

    /// Right singular vectors, `cols x cols`.
    pub fn v(&self) -> MatRef<'_, f64> {
        self.v.as_ref().submatrix(0, 0, self.cols, self.cols)
    }
}

/// `A (I - 2 w w^T)` with an irregular unit vector `w`: the same singular values, with different rounding.
fn reflected(a: MatRef<'_, f64>) -> Mat<f64> {
    let w = Col::from_fn(a.ncols(), |j| 1.0 / (j as f64 + 1.0));
    let w = &w / w.norm_l2();
    a - (a * &w) * (2.0 * w.transpose())
}

/// The factors of a finite complex matrix, `A = U diag(s) V^H` with `s` in decreasing order.
///
/// # Errors
/// `Decomposition` if the iteration does not converge.
pub(crate) fn complex_svd(a: MatRef<'_, c64>) -> Result<(Mat<c64>, Vec<f64>, Mat<c64>)> {
    let found = a.svd().map_err(|_| Error::Decomposition {
        kind: "singular value decomposition",
    })?;
    let values = found.S().column_vector().iter().map(|s| s.re).collect();
    Ok((found.U().to_owned(), values, found.V().to_owned()))
}

/// Symmetric eigenproblem `A = W diag(lambda) W^T`, Hermitian for complex entries, with buffers allocated once for a
/// largest size; eigenvalues in increasing order.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::linalg::decomp::SymmetricEigen;
/// let a = mat![[2.0, 1.0], [1.0, 2.0]];
/// let mut eigen = SymmetricEigen::new(2);
/// eigen.compute(a.as_ref())?;
/// assert!((eigen.value(0) - 1.0).abs() < 1e-14 && (eigen.value(1) - 3.0).abs() < 1e-14);
/// assert!((&a * eigen.vectors().col(1) - eigen.vectors().col(1) * 3.0).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct SymmetricEigen<T: ComplexField<Real = f64> = f64> {
    values: Diag<T>,
    vectors: Mat<T>,
    size: usize,
    memory: MemBuffer,
}

impl<T: ComplexField<Real = f64>> SymmetricEigen<T> {
    /// Buffers for matrices of at most `m x m`.
    pub fn new(m: usize) -> Self {
        let request = self_adjoint_evd_scratch::<T>(
            m,
            ComputeEigenvectors::Yes,
            Par::Seq,
            Default::default(),
        );
        SymmetricEigen {
            values: Diag::zeros(m),
            vectors: Mat::zeros(m, m),
            size: 0,
            memory: MemBuffer::new(request),
        }
    }

    /// Factors `a`, of which the lower triangle is read, and which must not exceed the size given to
    /// [`SymmetricEigen::new`]. Entries of extreme size are scaled in a copy.
    ///
    /// # Errors
    /// `Overflow` if an entry is not finite; `Decomposition` if the iteration does not converge.
    pub fn compute(&mut self, a: MatRef<'_, T>) -> Result<()> {
        if !a.is_all_finite() {
            return Err(Error::Overflow {
                quantity: "matrix to factor",
            });
        }
        let largest = a.norm_max();
        if largest == 0.0 || SAFE.contains(&largest) {
            return self.compute_scaled(a);
        }
        // A power of two, so that no digit is lost.
        let factor = 2.0_f64.powi(if largest < 1.0 { 600 } else { -600 });
        self.compute_scaled((a * Scale(T::from_f64_impl(factor))).as_ref())?;
        let back = T::from_f64_impl(factor.recip());
        for i in 0..self.size {
            self.values[i] = &self.values[i] * &back;
        }
        Ok(())
    }

    fn compute_scaled(&mut self, a: MatRef<'_, T>) -> Result<()> {
        let m = a.nrows();
        self.size = m;
        let values = self.values.as_mut().column_vector_mut();
        self_adjoint_evd(
            a,
            values.subrows_mut(0, m).as_diagonal_mut(),
            Some(self.vectors.as_mut().submatrix_mut(0, 0, m, m)),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        )
        .map_err(|_| Error::Decomposition {
            kind: "symmetric eigenproblem",
        })
    }

    /// The `i`-th smallest eigenvalue.
    pub fn value(&self, i: usize) -> f64 {
        real(&self.values[i])
    }

    /// Eigenvectors, one per column.
    pub fn vectors(&self) -> MatRef<'_, T> {
        self.vectors.as_ref().submatrix(0, 0, self.size, self.size)
    }
}

/// Thin QR factor `Q` of a tall matrix with the sign fixed so that `R` has a non-negative diagonal.
///
/// The result has shape `(n, min(n, c))` for an `(n, c)` input; its columns are orthonormal whatever the rank of `a`.
pub fn thin_q(a: MatRef<'_, f64>) -> Mat<f64> {
    let qr = a.qr();
    let r = qr.thin_R().to_owned();
    let mut q = qr.compute_thin_Q();
    for j in 0..q.ncols() {
        if r[(j, j)] < 0.0 {
            for i in 0..q.nrows() {
                q[(i, j)] = -q[(i, j)];
            }
        }
    }
    q
}

/// Thin QR factors of a tall matrix, `A = Q R` with orthonormal `Q` of shape `(n, c)` and upper triangular `R` with
/// non-negative diagonal.
pub fn thin_qr(a: MatRef<'_, f64>) -> (Mat<f64>, Mat<f64>) {
    let qr = a.qr();
    let (mut q, mut r) = (qr.compute_thin_Q(), qr.thin_R().to_owned());
    for j in 0..r.nrows() {
        if r[(j, j)] < 0.0 {
            for i in 0..q.nrows() {
                q[(i, j)] = -q[(i, j)];
            }
            for l in j..r.ncols() {
                r[(j, l)] = -r[(j, l)];
            }
        }
        for i in j + 1..r.nrows() {
            r[(i, j)] = 0.0;
        }
    }
    (q, r)
}

/// An orthonormal basis of the span of the columns of a complex matrix and, if `is_whole`, of its orthogonal
/// complement: the columns of `Q` in `A = Q R`, with phases that make the diagonal of `R` non-negative.
pub fn unitary_q(a: MatRef<'_, c64>, is_whole: bool) -> Mat<c64> {
    let qr = a.qr();
    let r = qr.thin_R().to_owned();
    let mut q = match is_whole {
        true => qr.compute_Q(),
        false => qr.compute_thin_Q(),
    };
    for j in 0..r.nrows().min(r.ncols()) {
        let length = r[(j, j)].norm();
        if length > 0.0 {
            let phase = r[(j, j)] / length;
            for i in 0..q.nrows() {
                q[(i, j)] *= phase;
            }
        }
    }
    q
}

/// Orthonormal polar factor `U V^T` of a tall matrix `A = U diag(s) V^T`: the nearest point of the Stiefel
/// manifold in the Frobenius norm.
///
/// # Errors
/// `RankDeficient` if the smallest singular value is below `n * eps` times the largest, so that the nearest point is
/// not unique; `Decomposition`.
pub fn polar_factor(name: &'static str, a: MatRef<'_, f64>) -> Result<Mat<f64>> {
    if let Some(near) = polar_near_orthonormal(a) {
        return Ok(near);
    }
    let (n, k) = (a.nrows(), a.ncols());
    let mut svd = Svd::new(n, k);
    svd.compute(a)?;
    let (largest, smallest) = (svd.s(0), svd.s(k - 1));
    if smallest <= n as f64 * f64::EPSILON * largest {
        return Err(Error::RankDeficient {
            name,
            smallest,
            largest,
        });
    }
    // The factors lose a few digits of orthonormality in large sizes.
    Ok(newton_schulz(&(svd.u() * svd.v().transpose())))
}

/// `Y (3 I - Y^T Y) / 2`, which squares a small orthonormality defect and is the nearest point to first order.
pub fn newton_schulz(y: &Mat<f64>) -> Mat<f64> {
    let gram = y.transpose() * y;
    y * Scale(1.5) - y * gram * Scale(0.5)
}

/// Largest singular value, 0 for an empty matrix. Entries of extreme size are scaled in a copy.
///
/// # Errors
/// `Overflow` if an entry is not finite; `Decomposition`.
pub fn spectral_norm(a: MatRef<'_, f64>) -> Result<f64> {
    singular_range(a).map(|[_, largest]| largest)
}

/// Smallest and largest singular value, 0 for an empty matrix. Entries of extreme size are scaled in a copy.
///
/// # Errors
/// `Overflow` if an entry is not finite; `Decomposition`.
pub fn singular_range(a: MatRef<'_, f64>) -> Result<[f64; 2]> {
    check_range("matrix to factor", a)?;
    let largest = a.norm_max();
    if largest == 0.0 || a.nrows() == 0 || a.ncols() == 0 {
        return Ok([0.0; 2]);
    }
    let scaled = Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / largest);
    let values = scaled
        .singular_values()
        .or_else(|_| reflected(scaled.as_ref()).singular_values())
        .map_err(|_| Error::Decomposition {
            kind: "singular value decomposition",
        })?;
    Ok([values[values.len() - 1] * largest, values[0] * largest])
}

/// Smallest real part of an eigenvalue of a square matrix.
///
/// # Errors
/// `Overflow` if an entry is not finite; `Decomposition`.
pub fn smallest_real_part(a: MatRef<'_, f64>) -> Result<f64> {
    check_range("matrix to factor", a)?;
    let values = a.eigenvalues().map_err(|_| Error::Decomposition {
        kind: "eigenvalue decomposition",
    })?;
    Ok(values.iter().fold(f64::INFINITY, |m, z| m.min(z.re)))
}

/// `A^{-1} B` for square `A` by LU with partial pivoting; `None` if the matrix is singular.
pub fn solve_matrix(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let solution = a.partial_piv_lu().solve(b);
    check_range("solution", solution.as_ref())
        .is_ok()
        .then_some(solution)
}

/// `L^{-1} B` in place for lower triangular `L`.
pub fn solve_lower(l: MatRef<'_, f64>, b: MatMut<'_, f64>) {
    triangular_solve::solve_lower_triangular_in_place(l, b, Par::Seq);
}

/// `U^{-1} B` in place for upper triangular `U`.
pub fn solve_upper(u: MatRef<'_, f64>, b: MatMut<'_, f64>) {
    triangular_solve::solve_upper_triangular_in_place(u, b, Par::Seq);
}

/// [`solve_matrix`] for one right-hand side.
pub fn solve_square(a: MatRef<'_, f64>, b: &[f64]) -> Option<Vec<f64>> {
    let solution = solve_matrix(a, MatRef::from_column_major_slice(b, b.len(), 1))?;
    Some((0..b.len()).map(|i| solution[(i, 0)]).collect())
}
