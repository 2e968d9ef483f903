//! The parts of the exponential that are specific to skew-Hermitian matrices: closed forms and the spectral
//! decomposition.
//!
//! | size | algorithm |
//! |---|---|
//! | 1, 2 | a phase; a phase times a rotation of SU(2) |
//! | any, moderate norm | the even and odd polynomials of [`super::skew_exp`] in the Hermitian `A^2`, products by three real ones |
//! | any, large norm | Hermitian eigenproblem of `-i A` |

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, c64};

use super::complex_square::ComplexSquare;
use super::decomp::SymmetricEigen;
use super::scalar::Entry;
use super::skew_exp::check_angle;
use super::structure::check_finite_entries;
use crate::error::{Error, Result};

/// Eigenvectors, and the Hermitian matrix, which is later replaced by the eigenvectors times phases.
pub struct HermitianSpectrum {
    hermitian: Mat<c64>,
    eigen: SymmetricEigen<c64>,
}

impl Entry for c64 {
    type Square = ComplexSquare;
    type Spectrum = HermitianSpectrum;

    const CLOSED_FORM: usize = 2;

    const FROBENIUS: f64 = 1.0;

    const SQUARINGS: [i32; 2] = [5, 1];

    fn exp_closed(out: MatMut<'_, c64>, a: MatRef<'_, c64>, t: f64) -> Result<()> {
        match a.nrows() {
            0 => Ok(()),
            1 => phase(out, t * a[(0, 0)].im),
            _ => rotation_with_phase(out, a, t),
        }
    }

    fn exp_by_spectrum(
        spectrum: &mut Option<HermitianSpectrum>,
        a: &ComplexSquare,
        _: &mut ComplexSquare,
        out: MatMut<'_, c64>,
    ) -> Result<()> {
        let m = out.nrows();
        let HermitianSpectrum { hermitian, eigen } =
            spectrum.get_or_insert_with(|| HermitianSpectrum {
                hermitian: Mat::zeros(m, m),
                eigen: SymmetricEigen::new(m),
            });
        let largest = a.largest_part();
        let scale = 2.0_f64.powi(largest.log2() as i32);
        for j in 0..m {
            for i in j..m {
                let x = a.get(i, j);
                hermitian[(i, j)] = c64::new(x.im / scale, -x.re / scale);
            }
        }
        eigen.compute(hermitian.as_ref())?;
        for j in 0..m {
            let angle = scale * eigen.value(j);
            check_angle(angle)?;
            let (sin, cos) = angle.sin_cos();
            let turn = c64::new(cos, sin);
            for i in 0..m {
                hermitian[(i, j)] = turn * eigen.vectors()[(i, j)];
            }
        }
        let one = c64::new(1.0, 0.0);
        let adjoint = eigen.vectors().adjoint();
        matmul(out, Accum::Replace, &*hermitian, adjoint, one, Par::Seq);
        Ok(())
    }

    fn not_skew(name: &'static str, defect: f64, tolerance: f64) -> Error {
        Error::NotSkewHermitian {
            name,
            defect,
            tolerance,
        }
    }

    fn check_finite(name: &'static str, a: MatRef<'_, c64>) -> Result<()> {
        check_finite_entries(name, a)
    }

    fn norm(a: MatRef<'_, c64>) -> f64 {
        a.norm_l2()
    }

    fn skew_defect(a: MatRef<'_, c64>) -> f64 {
        0.5 * (a + a.adjoint()).norm_l2()
    }
}

fn phase(mut out: MatMut<'_, c64>, angle: f64) -> Result<()> {
    check_angle(angle)?;
    out[(0, 0)] = c64::new(angle.cos(), angle.sin());
    Ok(())
}

/// The exponential of `i phi I + r N`, where `N` has trace 0 and `N^2 = -I`.
///
/// ```math
/// e^A = e^{i\varphi}\,(\cos r\, I + \sin r\, N)
/// ```
fn rotation_with_phase(mut out: MatMut<'_, c64>, a: MatRef<'_, c64>, t: f64) -> Result<()> {
    let (first, second) = (0.5 * t * a[(0, 0)].im, 0.5 * t * a[(1, 1)].im);
    let (mean, difference) = (first + second, first - second);
    let re = t * (0.5 * a[(1, 0)].re - 0.5 * a[(0, 1)].re);
    let im = t * (0.5 * a[(1, 0)].im + 0.5 * a[(0, 1)].im);
    let radius = difference.hypot(re).hypot(im);
    // The eigenvalues are i (mean + radius) and i (mean - radius).
    check_angle(mean.abs() + radius)?;
    let (sin, cos) = radius.sin_cos();
    let (mean_sin, mean_cos) = mean.sin_cos();
    let turn = c64::new(mean_cos, mean_sin);
    let unit = |x: f64| if radius > 0.0 { x / radius } else { 0.0 };
    let (z, below) = (
        sin * unit(difference),
        c64::new(sin * unit(re), sin * unit(im)),
    );
    out[(0, 0)] = turn * c64::new(cos, z);
    out[(1, 1)] = turn * c64::new(cos, -z);
    out[(1, 0)] = turn * below;
    out[(0, 1)] = turn * -below.conj();
    Ok(())
}
