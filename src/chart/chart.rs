//! A chart as a table of terms of its Hamiltonian, from which value, gradient, Hessian, momenta and derivatives follow,
//! and its embedding.

use faer::Mat;
use nalgebra::{SMatrix, SVector};

use super::elimination::solve_in_place;
use super::series::{Series, SeriesScalar};
use super::term::{Term, accumulate_gradient, product};
use crate::error::{Error, Result};

/// A chart of dimension `d` with `X = 2d` and `Z = 4d`.
///
/// # Examples
/// ```
/// use nalgebra::SVector;
/// use stiefel_rs::chart::{Chart, Sphere};
/// // Momenta from the derivatives of a curve, and back.
/// let derivatives = [[1.2, 0.0], [0.5, 1.0], [0.3, -0.2], [0.4, 0.6]];
/// let [q, qdot, qddot, qdddot] = derivatives.each_ref().map(|d| d.as_slice());
/// let momenta = Sphere.momenta(q, qdot, qddot, qdddot)?;
/// let z = SVector::from_fn(|i, _| if i < 4 { derivatives[i / 2][i % 2] } else { momenta[i - 4] });
/// let back = Sphere.derivatives(&z);
/// assert!((back - SVector::from_fn(|i, _| derivatives[i / 2][i % 2])).norm() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub trait Chart<const X: usize, const Z: usize>: Sync {
    /// Columns of a point.
    const K: usize;

    /// The terms of the Hamiltonian at the polar angle with the given sine and cosine.
    fn terms<T: SeriesScalar>(&self, sin: T, cos: T) -> impl IntoIterator<Item = Term<T>>;

    /// The columns of the embedded point, from sine and cosine of every coordinate.
    fn columns<T: SeriesScalar>(&self, sin_cos: &[(T, T)]) -> impl IntoIterator<Item = [T; 3]>;

    /// Checks that a state is finite and that its polar angle is inside the chart, `0 < theta < pi`.
    ///
    /// # Errors
    /// `NonFinite`, `OutsideChart`.
    fn check(&self, name: &'static str, z: &[f64]) -> Result<()> {
        if let Some(index) = z.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite { name, index });
        }
        let (theta, pi) = (z.first().copied().unwrap_or(f64::NAN), std::f64::consts::PI);
        if theta > 0.0 && theta < pi {
            return Ok(());
        }
        Err(Error::OutsideChart {
            coordinate: "theta",
            value: theta,
            lower: 0.0,
            upper: pi,
        })
    }

    /// The Hamiltonian `H(z)`. This kernel and its derivatives check nothing: they are finite if [`Chart::check`]
    /// passes and the state is not next to a pole.
    fn hamiltonian(&self, z: &SVector<f64, Z>) -> f64 {
        let (sin, cos) = z[0].sin_cos();
        let value =
            |term: Term<f64>| term.coefficient[0] * product(z.as_slice(), term.factors, &[]);
        self.terms(sin, cos).into_iter().map(value).sum()
    }

    /// The exact gradient of the Hamiltonian.
    fn gradient(&self, z: &SVector<f64, Z>) -> SVector<f64, Z> {
        let (sin, cos) = z[0].sin_cos();
        let mut out = SVector::<f64, Z>::zeros();
        accumulate_gradient(self.terms(sin, cos), z.as_slice(), out.as_mut_slice());
        out
    }

    /// The exact Hessian of the Hamiltonian.
    fn hessian(&self, z: &SVector<f64, Z>) -> SMatrix<f64, Z, Z> {
        let (sin, cos) = z[0].sin_cos();
        let mut out = SMatrix::<f64, Z, Z>::zeros();
        for term in self.terms(sin, cos) {
            let [f, df, ddf] = term.coefficient;
            let factors = term.factors;
            out[(0, 0)] += ddf * product(z.as_slice(), factors, &[]);
            for i in 0..factors.len() {
                let first = df * product(z.as_slice(), factors, &[i]);
                out[(0, factors[i])] += first;
                out[(factors[i], 0)] += first;
                for j in (0..factors.len()).filter(|&j| j != i) {
                    out[(factors[i], factors[j])] += f * product(z.as_slice(), factors, &[i, j]);
                }
            }
        }
        out
    }

    /// Momenta `(p_q, p_qdot)` of a curve from its coordinate derivatives up to the third.
    ///
    /// ```math
    /// p_{\dot q} = g\,(\ddot q + \Gamma(\dot q, \dot q)),\qquad
    /// p_{q,i} = 2 \Gamma^k_{ij} \dot q^j p_{\dot q,k} - \tfrac{d}{dt} p_{\dot q,i}
    /// ```
    ///
    /// In terms of the Hamiltonian: `qddot = H_{p_qdot}`, whose time derivative gives `d/dt p_qdot`, and `p_q =
    /// -H_qdot|_{p_q = 0} - d/dt p_qdot`. All vectors have shape `(d)`; the result is `(p_q, p_qdot)`, shape `(2d)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `OutsideChart`; `Overflow` next to a pole.
    fn momenta(
        &self,
        q: &[f64],
        qdot: &[f64],
        qddot: &[f64],
        qdddot: &[f64],
    ) -> Result<SVector<f64, X>> {
        let d = X / 2;
        let arguments = [
            ("q", q),
            ("qdot", qdot),
            ("qddot", qddot),
            ("qdddot", qdddot),
        ];
        for (name, derivative) in arguments {
            check_length(name, derivative, d)?;
            if let Some(index) = derivative.iter().position(|x| !x.is_finite()) {
                return Err(Error::NonFinite { name, index });
            }
        }
        let mut z = SVector::<f64, Z>::zeros();
        z.as_mut_slice()[..d].copy_from_slice(q);
        z.as_mut_slice()[d..X].copy_from_slice(qdot);
        self.check("state", z.as_slice())?;
        // Only the block with the inverse metric matters; the rest of the system is the identity.
        let metric_solve = |z: &SVector<f64, Z>, right: &dyn Fn(usize) -> f64| {
            let hessian = self.hessian(z);
            let mut inverse_metric = SMatrix::<f64, X, X>::identity();
            let mut b = SMatrix::<f64, X, 1>::zeros();
            for i in 0..d {
                b[i] = right(i);
                for j in 0..d {
                    inverse_metric[(i, j)] = hessian[(X + d + i, X + d + j)];
                }
            }
            solve_in_place(inverse_metric, &mut b);
            b
        };
        let drift = self.gradient(&z);
        let acceleration = metric_solve(&z, &|i| qddot[i] - drift[X + d + i]);
        for i in 0..d {
            z[X + d + i] = acceleration[i];
        }
        let hessian = self.hessian(&z);
        let transported = |i: usize| -> f64 {
            let row = X + d + i;
            (0..d)
                .map(|j| hessian[(row, j)] * qdot[j] + hessian[(row, d + j)] * qddot[j])
                .sum()
        };
        let rate = metric_solve(&z, &|i| qdddot[i] - transported(i));
        let gradient = self.gradient(&z);
        let mut out = SVector::<f64, X>::zeros();
        for i in 0..d {
            out[i] = -gradient[d + i] - rate[i];
            out[d + i] = acceleration[i];
        }
        if out.iter().all(|p| p.is_finite()) {
            Ok(out)
        } else {
            Err(Error::Overflow {
                quantity: "momenta",
            })
        }
    }

    /// Coordinate derivatives `(q, qdot, qddot, qdddot)` of the curve through a state; the inverse of
    /// [`Chart::momenta`].
    fn derivatives(&self, z: &SVector<f64, Z>) -> SVector<f64, Z> {
        let d = X / 2;
        let (gradient, hessian) = (self.gradient(z), self.hessian(z));
        let mut out = *z;
        for i in 0..d {
            let row = X + d + i;
            out[X + i] = gradient[row];
            out[row] = (0..d)
                .map(|j| {
                    hessian[(row, j)] * z[d + j] + hessian[(row, d + j)] * gradient[X + d + j]
                        - hessian[(row, X + d + j)] * gradient[d + j]
                })
                .sum();
        }
        out
    }

    /// The embedded point of shape `(3, K)` from `q`, shape `(d)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `OutsideChart`.
    fn embed(&self, q: &[f64]) -> Result<Mat<f64>> {
        check_length("q", q, X / 2)?;
        self.check("q", q)?;
        let sin_cos: Vec<(f64, f64)> = q.iter().map(|x| x.sin_cos()).collect();
        Ok(columns_to_mat(Self::K, self.columns(&sin_cos), |x| x))
    }

    /// The embedded velocity of shape `(3, K)` from `q` and `qdot`, shapes `(d)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `OutsideChart`.
    fn embed_velocity(&self, q: &[f64], qdot: &[f64]) -> Result<Mat<f64>> {
        check_length("q", q, X / 2)?;
        check_length("qdot", qdot, X / 2)?;
        self.check("q", q)?;
        if let Some(index) = qdot.iter().position(|x| !x.is_finite()) {
            return Err(Error::NonFinite {
                name: "qdot",
                index,
            });
        }
        let dual = |(&x, &v): (&f64, &f64)| Series::<2>::new([x, v]).sin_cos();
        let sin_cos: Vec<_> = q.iter().zip(qdot).map(dual).collect();
        Ok(columns_to_mat(Self::K, self.columns(&sin_cos), |x| {
            x.coefficients()[1]
        }))
    }
}

/// Return `Shape` unless a vector has the given length.
fn check_length(name: &'static str, x: &[f64], length: usize) -> Result<()> {
    if x.len() == length {
        return Ok(());
    }
    let (expected, found) = (format!("({length},)"), format!("({},)", x.len()));
    Err(Error::Shape {
        name,
        expected,
        found,
    })
}

/// Return `Overflow` if a computed state is not finite, `OutsideChart` if it has left the chart.
pub(super) fn check_reached<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z: &SVector<f64, Z>,
) -> Result<()> {
    if z.iter().all(|x| x.is_finite()) {
        chart.check("state", z.as_slice())
    } else {
        Err(Error::Overflow { quantity: "state" })
    }
}

fn columns_to_mat<T>(
    k: usize,
    columns: impl IntoIterator<Item = [T; 3]>,
    read: impl Fn(T) -> f64,
) -> Mat<f64> {
    let mut out = Mat::zeros(3, k);
    for (j, column) in columns.into_iter().enumerate() {
        for (i, entry) in column.into_iter().enumerate() {
            out[(i, j)] = read(entry);
        }
    }
    out
}
