//! Initial data and invariants of a Riemannian cubic.

use faer::{Mat, MatRef, Scale};

use super::riemannian_cubic::RiemannianCubic;
use super::taylor::state::State;
use super::turning::bracket_of;
use crate::curve::Curve;
use crate::error::{Error, Result};
use crate::linalg::product::{columns, columns_mut, entries, mul_add, mul_into};
use crate::linalg::structure::check_range;
use crate::space::Quotient;

/// Largest number of rows for which the momentum is returned: an `(n, n)` matrix of two gigabytes.
const LARGEST_MOMENTUM: usize = 1 << 14;

/// Quantity named in errors.
const STATE: &str = "state of a Riemannian cubic";

impl RiemannianCubic {
    /// Point, velocity, covariant acceleration and covariant jerk at the start of [`t_span`](Curve::t_span), each of
    /// shape `(n, k)`.
    ///
    /// # Accuracy
    /// Accurate to round-off where the polynomials start or end at that time; otherwise as accurate as [`Curve::jerk`].
    /// # Errors
    /// `Overflow`.
    pub fn initial(&self) -> Result<[Mat<f64>; 4]> {
        self.state(self.t_span().0)
    }

    /// As `initial`, at any time.
    pub(crate) fn state(&self, t: f64) -> Result<[Mat<f64>; 4]> {
        let Some(tangents) = self.tangents_at_end(t) else {
            return Ok([
                self.point(t)?,
                self.derivative(t, 1)?,
                self.acceleration(t)?,
                self.jerk(t)?,
            ]);
        };
        let mut data = tangents.map(|x| columns(&x, self.n()).to_owned());
        let [s, v, a, j] = &mut data;
        *j += bracket_of(self.quotient(), s.as_ref(), v.as_ref(), a.as_ref()) * Scale(0.5);
        for matrix in &data {
            check_range(STATE, matrix.as_ref())?;
        }
        Ok(data)
    }

    /// The point, and the tangent vectors `g x, g x', g x''` there, shape `(n, k)` by columns.
    ///
    /// # Errors
    /// As `state`.
    pub(crate) fn tangents(&self, t: f64) -> Result<[Vec<f64>; 4]> {
        if let Some(tangents) = self.tangents_at_end(t) {
            for x in &tangents {
                check_range(STATE, columns(x, self.n()))?;
            }
            return Ok(tangents);
        }
        let mut data = self.state(t)?;
        let [s, v, a, j] = &mut data;
        *j -= bracket_of(self.quotient(), s.as_ref(), v.as_ref(), a.as_ref()) * Scale(0.5);
        Ok(data.each_ref().map(entries))
    }

    /// The same where the polynomials start or end at that time.
    fn tangents_at_end(&self, t: f64) -> Option<[Vec<f64>; 4]> {
        let state = self.state_of_taylor(t)?;
        let (r, k) = (self.taylor.r(), self.k());
        let (s, e) = (columns(state.s(), r), columns(state.e(), r));
        let tangent = |order: usize| {
            let mut v = vec![0.0; r * k];
            match order.checked_sub(1) {
                None => v.copy_from_slice(state.s()),
                Some(order) => {
                    let b = MatRef::from_column_major_slice(state.b(order), r - k, k);
                    mul_into(
                        columns_mut(&mut v, r),
                        1.0,
                        s,
                        columns(state.omega(order), k),
                    );
                    mul_add(columns_mut(&mut v, r), 1.0, e, b);
                }
            }
            for x in &mut v {
                *x = self.time_map.derivative(*x, order);
            }
            let Some(frame) = self.frame() else {
                return v;
            };
            let mut out = vec![0.0; self.n() * k];
            mul_into(columns_mut(&mut out, self.n()), 1.0, frame, columns(&v, r));
            out
        };
        Some(std::array::from_fn(tangent))
    }

    /// The state of the polynomials at a time of the curve, if they start or end there.
    pub(super) fn state_of_taylor(&self, t: f64) -> Option<&State> {
        let moment = self.time_map.taylor_time(t);
        let ends = self.taylor.ends();
        ends.into_iter().find(|state| state.time == moment)
    }

    /// The conserved energy.
    ///
    /// ```math
    /// H = \tfrac12 |D_t S'|^2 - \langle D_t D_t S', S' \rangle + \tfrac{\tau}{2} |S'|^2
    /// ```
    ///
    /// # Errors
    /// `Overflow`.
    pub fn energy(&self) -> Result<f64> {
        // <[x, x'], x> = 0, so the other part of the jerk does not contribute.
        let [x, a, second] = self.taylor.ends()[0].vectors();
        let energy = 0.5 * (a.inner(&a) + self.taylor.tension() * x.inner(&x)) - second.inner(&x);
        let energy = self.time_map.derivative(energy, 4);
        if energy.is_finite() {
            return Ok(energy);
        }
        Err(Error::Overflow { quantity: "energy" })
    }

    /// The conserved spatial momentum `g mu g^T`, skew, shape `(n, n)`.
    ///
    /// ```math
    /// \mu = \tau x - x'' + [x, x']_h
    /// ```
    ///
    /// # Errors
    /// `InvalidArgument` if `n > 16384`, for which the matrix would be too large; `Overflow`.
    pub fn momentum(&self) -> Result<Mat<f64>> {
        let n = self.n();
        if n > LARGEST_MOMENTUM {
            return Err(Error::InvalidArgument {
                name: "n",
                requirement: "at most 16384 for an (n, n) matrix",
                found: n as f64,
            });
        }
        let (r, k) = (self.taylor.r(), self.k());
        let start = self.taylor.ends()[0];
        let [x, a, second] = start.vectors();
        let second = second.plus(-self.taylor.tension(), &x);
        let turning = &a.normal * x.normal.transpose() - &x.normal * a.normal.transpose();
        let first = match self.quotient() {
            Quotient::Frames => -&second.omega,
            Quotient::Subspaces => {
                a.normal.transpose() * &x.normal - x.normal.transpose() * &a.normal
            }
        };
        let mu = Mat::from_fn(r, r, |i, j| match (i < k, j < k) {
            (true, true) => first[(i, j)],
            (false, true) => -second.normal[(i - k, j)],
            (true, false) => second.normal[(j - k, i)],
            (false, false) => turning[(i - k, j - k)],
        });
        let g = self.lifted(start.frame().to_owned());
        let momentum = &g * self.in_curve_time(mu, 3) * g.transpose();
        check_range("momentum", momentum.as_ref())?;
        Ok(momentum)
    }

    /// Converts a derivative with respect to the time of the polynomials to the curve's time.
    fn in_curve_time(&self, mut a: Mat<f64>, order: usize) -> Mat<f64> {
        for entry in a.col_iter_mut().flat_map(|column| column.iter_mut()) {
            *entry = self.time_map.derivative(*entry, order);
        }
        a
    }

    fn lifted(&self, a: Mat<f64>) -> Mat<f64> {
        match self.frame() {
            Some(frame) => frame * a,
            None => a,
        }
    }
}
