//! A common interface of real and complex numbers, with the buffers used for the exponential.

use faer::traits::ComplexField;
use faer::{Accum, MatMut, MatRef, c64};

use super::complex_square::{ComplexSquare, Scratch};
use super::square::{Square, Symmetry};
use crate::error::{Error, Result};

/// Entries of a matrix: `f64` or `c64`. The trait is sealed.
///
/// # Examples
/// ```
/// use faer::{Mat, c64};
/// use stiefel_rs::{Result, linalg::Scalar, skew_exp};
/// fn quarter<T: Scalar>(generator: &Mat<T>) -> Result<Mat<T>> {
///     skew_exp(generator.as_ref())
/// }
/// let phase = quarter(&Mat::from_fn(1, 1, |_, _| c64::new(0.0, std::f64::consts::FRAC_PI_2)))?;
/// assert!(phase[(0, 0)].re.abs() < 1e-15 && (phase[(0, 0)].im - 1.0).abs() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub trait Scalar: Entry {}

impl Scalar for f64 {}
impl Scalar for c64 {}

/// The operations on entries that the exponential needs.
pub trait Entry: ComplexField<Real = f64> {
    /// Square buffers.
    type Square: SquareBuffer<Entry = Self>;

    /// Buffers of the spectral decomposition.
    type Spectrum;

    /// Largest size with a closed form.
    const CLOSED_FORM: usize;

    /// The spectral norm of a skew matrix is at most this multiple of its Frobenius norm.
    const FROBENIUS: f64;

    /// Number of squarings up to which the series is preferred to the spectral decomposition, for sizes below 64 and
    /// from 64 on.
    const SQUARINGS: [i32; 2];

    /// `e^{tA}` for the sizes with a closed form.
    fn exp_closed(out: MatMut<'_, Self>, a: MatRef<'_, Self>, t: f64) -> Result<()>;

    /// `e^A` by the spectral decomposition; `work` may be overwritten.
    fn exp_by_spectrum(
        spectrum: &mut Option<Self::Spectrum>,
        a: &Self::Square,
        work: &mut Self::Square,
        out: MatMut<'_, Self>,
    ) -> Result<()>;

    /// The error for a matrix that is not skew.
    fn not_skew(name: &'static str, defect: f64, tolerance: f64) -> Error;

    /// Return `NonFinite` at the first entry that is NaN or infinite.
    fn check_finite(name: &'static str, a: MatRef<'_, Self>) -> Result<()>;

    /// `|A|_F`.
    fn norm(a: MatRef<'_, Self>) -> f64;

    /// `|A + A^H|_F / 2`.
    fn skew_defect(a: MatRef<'_, Self>) -> f64;
}

/// A square buffer and the loops over it; here "skew" and "symmetric" mean skew-Hermitian and Hermitian.
pub trait SquareBuffer: Sized {
    type Entry;

    /// Buffers of products.
    type Scratch;

    fn zeros(m: usize) -> Self;

    fn scratch(m: usize) -> Self::Scratch;

    /// Real part, then imaginary part.
    fn parts(&self) -> &[Square];

    fn parts_mut(&mut self) -> &mut [Square];

    /// `alpha (A - A^H) / 2`; returns the sum of squares of `(A + A^H) / 2`.
    fn read_skew_part(&mut self, alpha: f64, a: MatRef<'_, Self::Entry>) -> f64;

    fn write_to(&self, out: MatMut<'_, Self::Entry>);

    /// A bound on the largest column sum of moduli, and the Frobenius norm.
    fn sizes(&self) -> (f64, f64);

    /// `alpha A B`.
    fn full_product(&mut self, alpha: f64, a: &Self, b: &Self, scratch: &mut Self::Scratch);

    /// `alpha A B` (optionally added), known to be symmetric or skew; the part above the diagonal is undefined before
    /// [`Self::mirror`].
    fn half_product(
        &mut self,
        beta: Accum,
        alpha: f64,
        a: &Self,
        b: &Self,
        scratch: &mut Self::Scratch,
    );

    /// `alpha A^H A`, as [`Self::half_product`].
    fn half_gram(&mut self, alpha: f64, a: &Self, scratch: &mut Self::Scratch);

    /// Fills the part above the diagonal if [`Self::half_product`] has left it undefined.
    fn mirror(&mut self, symmetry: Symmetry);

    /// Fills the part above the diagonal in any case.
    fn reflect_lower(&mut self, symmetry: Symmetry);

    /// `self = E + T` from the lower triangles of the symmetric `E` (in `self`) and the skew `T`.
    fn plus_skew(&mut self, skew: &Self);

    /// `self += alpha I`.
    fn add_to_diagonal(&mut self, alpha: f64) {
        if let Some(real) = self.parts_mut().first_mut() {
            real.add_to_diagonal(alpha);
        }
    }
}

impl SquareBuffer for Square {
    type Entry = f64;
    type Scratch = ();

    fn zeros(m: usize) -> Self {
        Square::new(m)
    }

    fn scratch(_: usize) {}

    fn parts(&self) -> &[Square] {
        std::slice::from_ref(self)
    }

    fn parts_mut(&mut self) -> &mut [Square] {
        std::slice::from_mut(self)
    }

    fn read_skew_part(&mut self, alpha: f64, a: MatRef<'_, f64>) -> f64 {
        self.set_skew_part(alpha, a)
    }

    fn write_to(&self, out: MatMut<'_, f64>) {
        self.write(out);
    }

    fn sizes(&self) -> (f64, f64) {
        self.norms()
    }

    fn full_product(&mut self, alpha: f64, a: &Self, b: &Self, (): &mut ()) {
        self.multiply(alpha, a.view(), b.view());
    }

    fn half_product(&mut self, beta: Accum, alpha: f64, a: &Self, b: &Self, (): &mut ()) {
        self.set_product(beta, alpha, a.view(), b.view());
    }

    fn half_gram(&mut self, alpha: f64, a: &Self, (): &mut ()) {
        self.set_product(Accum::Replace, alpha, a.view().transpose(), a.view());
    }

    fn mirror(&mut self, symmetry: Symmetry) {
        self.reflect_product(symmetry);
    }

    fn reflect_lower(&mut self, symmetry: Symmetry) {
        self.reflect(symmetry);
    }

    fn plus_skew(&mut self, skew: &Self) {
        self.add_skew(skew);
    }
}

impl SquareBuffer for ComplexSquare {
    type Entry = c64;
    type Scratch = Scratch;

    fn zeros(m: usize) -> Self {
        ComplexSquare::new(m)
    }

    fn scratch(m: usize) -> Scratch {
        Scratch::new(m)
    }

    fn parts(&self) -> &[Square] {
        &self.parts
    }

    fn parts_mut(&mut self) -> &mut [Square] {
        &mut self.parts
    }

    fn read_skew_part(&mut self, alpha: f64, a: MatRef<'_, c64>) -> f64 {
        self.set_skew_part(alpha, a)
    }

    fn write_to(&self, out: MatMut<'_, c64>) {
        self.write(out);
    }

    fn sizes(&self) -> (f64, f64) {
        self.norms()
    }

    fn full_product(&mut self, alpha: f64, a: &Self, b: &Self, scratch: &mut Scratch) {
        self.multiply(Accum::Replace, alpha, a.factor(), b.factor(), scratch);
    }

    fn half_product(&mut self, beta: Accum, alpha: f64, a: &Self, b: &Self, scratch: &mut Scratch) {
        self.set_product(beta, alpha, a.factor(), b.factor(), scratch);
    }

    fn half_gram(&mut self, alpha: f64, a: &Self, scratch: &mut Scratch) {
        self.set_product(Accum::Replace, alpha, a.adjoint(), a.factor(), scratch);
    }

    fn mirror(&mut self, symmetry: Symmetry) {
        self.reflect_product(symmetry);
    }

    fn reflect_lower(&mut self, symmetry: Symmetry) {
        self.reflect(symmetry);
    }

    fn plus_skew(&mut self, skew: &Self) {
        self.add_skew(skew);
    }
}
