//! Covariant accelerations at the ends of a geometric cubic, in closed form.
//!
//! Near its start the curve is
//!
//! ```math
//! e^{t X_5(t)} e^{t X_3(t)} e^{t X_0} S_0 e^{t \Omega_0} e^{t \Omega_3(t)} e^{t \Omega_5(t)}
//! ```
//!
//! All three generators agree with the generator of the first leg at the start. The second stage's generator changes at
//! the rate at which its end deviates from the continuation of the first leg, the third stage's at twice that rate.
//! With the velocities `U` of the first leg and `W` of the middle leg at their starts, and the retraction `u -> R(u)`
//! at `S_0`,
//!
//! ```math
//! D_t \gamma'(0) = K \Omega + 6\, (D R_U)^{-1} \bigl[ W - e^{X_0} U e^{\Omega_0} \bigr],\qquad \gamma'(0) = 3 U = K + S_0 \Omega
//! ```
//!
//! In flat space this is `6 (P_0 - 2 P_1 + P_2)`. The first term is the acceleration of the quasi-geodesic with the
//! same velocity: it is equal on both sides of a knot, so only the second term matters there.
//!
//! For subspaces all generators have `Omega = 0`, and `R` is the exponential in terms of bases. The term added to
//! `Omega` rotates the basis that `R` reaches, so the horizontal part of the second term is that of the curve
//! of subspaces.

use std::f64::consts::{FRAC_PI_2, PI};

use faer::{Mat, MatMut, MatRef};

use crate::error::{Error, Result};
use crate::linalg::product::{axpy, mul_add, mul_into, scale};
use crate::linalg::structure::check_range;
use crate::manifold::QuasiGeodesic;
use crate::manifold::carrier::Carrier;
use crate::manifold::grassmann::joining::join_spans;
use crate::manifold::inverse_differential::InverseDifferential;
use crate::manifold::quasi_geodesic::{Departure, EndpointProblem};
use crate::manifold::tangent::tangent_part;
use crate::solve::direction::Direction;
use crate::space::Quotient;

/// Quantity named in `Overflow` errors.
const CONTROL_POINTS: &str = "control points of a spline";

/// Computes the second terms at the ends of pieces of one shape, with its buffers.
pub(crate) struct SecondTerms {
    quotient: Quotient,
    ends: [OuterLeg; 2],
    middle: QuasiGeodesic,
    carrier: Carrier,
    problem: EndpointProblem,
    velocity: Mat<f64>,
}

impl SecondTerms {
    pub(crate) fn new(quotient: Quotient, n: usize, k: usize) -> Self {
        SecondTerms {
            quotient,
            ends: [(); 2].map(|()| OuterLeg::new(quotient, n, k)),
            middle: QuasiGeodesic::zeros(n, k),
            carrier: Carrier::new(n, k),
            problem: EndpointProblem::new(n, k),
            velocity: Mat::zeros(n, k),
        }
    }

    /// Computes the second terms at both ends of the geometric cubic between two points, in the time of the piece.
    ///
    /// # Arguments
    /// * `velocities` - at the ends, in a unit of time in which the piece takes `length`
    ///
    /// # Errors
    /// `ControlPoints` if they cannot be joined, or if an outer leg is too long; `Overflow`, `Decomposition`.
    pub(crate) fn compute(
        &mut self,
        points: [MatRef<'_, f64>; 2],
        velocities: [MatRef<'_, f64>; 2],
        length: f64,
        out: [MatMut<'_, f64>; 2],
    ) -> Result<()> {
        let [first, last] = &mut self.ends;
        first
            .leave(points[0], velocities[0], length / 3.0)
            .and_then(|()| last.leave(points[1], velocities[1], -length / 3.0))
            .map_err(Error::of_control_points)?;
        let turn = self.join_inner().map_err(Error::of_control_points)?;
        self.carrier.set(&self.middle)?;
        if let Some(turn) = &turn {
            self.carrier.turn_basis(turn);
        }
        self.velocity.copy_from(self.middle.initial_velocity());
        let [at_start, at_end] = out;
        let [first, last] = &mut self.ends;
        first.second_term(points[0], self.velocity.as_ref(), at_start)?;
        let (velocity, way) = (self.velocity.as_mut(), Direction::Forward);
        self.carrier.carry(&self.middle, velocity, way);
        scale(&mut self.velocity, -1.0);
        last.second_term(points[1], self.velocity.as_ref(), at_end)
    }

    /// Joins the inner control points; for subspaces returns the matrix that maps the basis reached to the basis there.
    fn join_inner(&mut self) -> Result<Option<Mat<f64>>> {
        let [from, to] = self.ends.each_ref().map(|end| end.end.as_ref());
        match self.quotient {
            Quotient::Frames => {
                self.middle.join(from, to, &mut self.problem)?;
                Ok(None)
            }
            Quotient::Subspaces => {
                let (middle, turn) = join_spans(from, to, &mut self.problem)?;
                self.middle = middle;
                Ok(Some(turn))
            }
        }
    }
}

/// The leg from an end to the neighbouring inner control point.
struct OuterLeg {
    quotient: Quotient,
    curve: QuasiGeodesic,
    departure: Departure,
    carrier: Carrier,
    inverse: InverseDifferential,
    velocity: Mat<f64>,
    /// The inner control point.
    end: Mat<f64>,
}

impl OuterLeg {
    fn new(quotient: Quotient, n: usize, k: usize) -> Self {
        OuterLeg {
            quotient,
            curve: QuasiGeodesic::zeros(n, k),
            departure: Departure::new(n, k),
            carrier: Carrier::new(n, k),
            inverse: InverseDifferential::new(n, k),
            velocity: Mat::zeros(n, k),
            end: Mat::zeros(n, k),
        }
    }

    fn leave(&mut self, s: MatRef<'_, f64>, v: MatRef<'_, f64>, share: f64) -> Result<()> {
        self.velocity.fill(0.0);
        axpy(&mut self.velocity, share, v);
        self.curve
            .leave(s, self.velocity.as_ref(), &mut self.departure)?;
        let angle = self.curve.angles().iter().fold(0.0, |a: f64, b| a.max(*b));
        match self.quotient {
            // A longer leg is not the principal quasi-geodesic between its ends.
            Quotient::Frames if angle >= PI => return Err(Error::OutsideLogDomain { angle }),
            Quotient::Subspaces if angle >= FRAC_PI_2 => return Err(Error::RightAngle { angle }),
            Quotient::Frames => {}
            Quotient::Subspaces => self.curve.omega_mut().fill(0.0),
        }
        self.carrier.set(&self.curve)?;
        self.end.copy_from(s);
        let way = Direction::Forward;
        self.carrier.carry(&self.curve, self.end.as_mut(), way);
        check_range(CONTROL_POINTS, self.end.as_ref())
    }

    /// The second term at `s`, from the velocity of the middle leg at the inner control point, pointing away from it.
    fn second_term(
        &mut self,
        s: MatRef<'_, f64>,
        onward: MatRef<'_, f64>,
        out: MatMut<'_, f64>,
    ) -> Result<()> {
        let mut out = out;
        out.copy_from(onward);
        let way = Direction::Backward;
        self.carrier.carry(&self.curve, out.as_mut(), way);
        axpy(out.as_mut(), -1.0, &self.velocity);
        self.inverse.apply(&self.curve, s, out.as_mut())?;
        scale(out.as_mut(), 6.0);
        if self.quotient == Quotient::Subspaces {
            let horizontal = tangent_part(self.quotient, s, out.as_ref());
            out.copy_from(horizontal);
        }
        Ok(())
    }
}

/// `out += factor K Omega`: the covariant acceleration of the quasi-geodesic with velocity `v = K + s Omega` at `s`.
pub(crate) fn add_quasi_geodesic_acceleration(
    out: MatMut<'_, f64>,
    factor: f64,
    s: MatRef<'_, f64>,
    v: MatRef<'_, f64>,
) {
    let k = s.ncols();
    let (mut omega, mut normal) = (Mat::zeros(k, k), v.to_owned());
    mul_into(&mut omega, 1.0, s.transpose(), v);
    mul_add(&mut normal, -1.0, s, &omega);
    mul_add(out, factor, &normal, &omega);
}
