//! Velocities at knots from the points alone, by the formulas of flat space in tangent spaces.
//!
//! Displacements are those of the quasi-geodesics between neighbours, which also carry vectors from knot to knot.

use faer::{Mat, Scale};

use super::ends::{EndCondition, EndConditions};
use crate::cubic::guess::carry;
use crate::error::Result;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::EndpointProblem;

/// Sweeps of the Gauss-Seidel method: each leaves at most a quarter of the error.
const SWEEPS: usize = 12;

/// Quasi-geodesics between neighbours.
pub(super) struct Links {
    curves: Vec<QuasiGeodesic>,
    /// Their velocities at both ends.
    displacements: Vec<[Mat<f64>; 2]>,
}

impl Links {
    /// # Errors
    /// `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents`, in `AtKnot` of the first of the two.
    pub(super) fn new(points: &[Mat<f64>]) -> Result<Self> {
        let (n, k) = points[0].shape();
        let mut problem = EndpointProblem::new(n, k);
        let (mut curves, mut displacements) = (Vec::new(), Vec::new());
        for (knot, pair) in points.windows(2).enumerate() {
            let mut curve = QuasiGeodesic::zeros(n, k);
            curve
                .join(pair[0].as_ref(), pair[1].as_ref(), &mut problem)
                .map_err(|error| error.at_knot(knot))?;
            let first = curve.initial_velocity();
            let last = carry(&curve, first.as_ref(), 1.0)?;
            curves.push(curve);
            displacements.push([first, last]);
        }
        Ok(Links {
            curves,
            displacements,
        })
    }

    /// Displacement of a leg and its end velocity `v`, both at the start of the leg.
    pub(super) fn back(&self, leg: usize, v: &Mat<f64>) -> Result<[Mat<f64>; 2]> {
        let carried = carry(&self.curves[leg], v.as_ref(), -1.0)?;
        Ok([self.displacements[leg][0].clone(), carried])
    }

    /// Velocities of the cubic spline of flat space.
    ///
    /// ```math
    /// \frac{2 v_{i-1} + 4 v_i}{h_-} + \frac{4 v_i + 2 v_{i+1}}{h_+}
    ///     = 6 \Bigl( \frac{\Delta_-}{h_-^2} + \frac{\Delta_+}{h_+^2} \Bigr)
    /// ```
    pub(super) fn spline(&self, lengths: &[f64], ends: &EndConditions) -> Result<Vec<Mat<f64>>> {
        let legs = lengths.len();
        let (n, k) = self.displacements[0][0].shape();
        let mut velocities = vec![Mat::zeros(n, k); legs + 1];
        for _ in 0..SWEEPS {
            for knot in 0..=legs {
                let (mut right, mut weight) = (Mat::zeros(n, k), 0.0);
                let mut before = knot.checked_sub(1);
                let mut after = (knot < legs).then_some(knot);
                match ends {
                    EndConditions::Periodic => {
                        before = before.or(Some(legs - 1));
                        after = after.or(Some(0));
                    }
                    EndConditions::Natural => {}
                    EndConditions::Each(each) => {
                        let end = match (before, after) {
                            (None, _) => Some((&each[0], -1.0)),
                            (_, None) => Some((&each[1], 1.0)),
                            _ => None,
                        };
                        match end {
                            Some((EndCondition::Velocity(v), _)) => {
                                velocities[knot] = v.clone();
                                continue;
                            }
                            Some((EndCondition::Acceleration(a), sign)) => right += a * Scale(sign),
                            None => {}
                        }
                    }
                }
                if let Some(leg) = before {
                    let h = lengths[leg];
                    let v = &velocities[leg];
                    let carried = carry(&self.curves[leg], v.as_ref(), 1.0)?;
                    right += &self.displacements[leg][1] * Scale(6.0 / (h * h))
                        - carried * Scale(2.0 / h);
                    weight += 4.0 / h;
                }
                if let Some(leg) = after {
                    let h = lengths[leg];
                    let v = &velocities[leg + 1];
                    let carried = carry(&self.curves[leg], v.as_ref(), -1.0)?;
                    right += &self.displacements[leg][0] * Scale(6.0 / (h * h))
                        - carried * Scale(2.0 / h);
                    weight += 4.0 / h;
                }
                velocities[knot] = right * Scale(1.0 / weight);
            }
        }
        if matches!(ends, EndConditions::Periodic) {
            velocities[legs] = velocities[0].clone();
        }
        Ok(velocities)
    }
}
