//! Splines as stored numbers: what their classes add to the pieces, and checks that both belong together.

use super::piecewise::{Cubics, PyPiecewiseCurve};
use super::prelude::*;
use super::spline_data::{Data, Kind};
use crate::cubic::RiemannianCubic;
use crate::curve::{GeometricCubic, Quantity};
use crate::linalg::structure::{distance, norm};
use crate::manifold::stored::check_orthonormal;
use crate::report::SolverReport;
use crate::spline::Piecewise;
use crate::stored::{Fields, Stored, refusal};

/// The names of a spline's own numbers and words in its stored form.
const POINTS: &str = "S";
const REPORT: &str = "report";
pub(super) const VELOCITIES: &str = "V";
pub(super) const PIECES: &str = "pieces";

/// How far the points of a spline may be from its pieces, which are solved for to a tolerance.
const STORED_TOLERANCE: f64 = 1e-6;

impl PyPiecewiseCurve {
    /// The stored form without what is the subclass's own.
    pub(super) fn stored(&self, py: Python<'_>) -> PyResult<Fields> {
        let (_, mut fields) = self.cubics.curve().stored();
        put(py, &mut fields, POINTS, &self.points)?;
        fields.put_reports(REPORT, [self.report]);
        Ok(fields)
    }
}

/// Stores an array.
pub(super) fn put(py: Python<'_>, fields: &mut Fields, name: &str, array: &Owned) -> PyResult<()> {
    let Array { shape, entries } = read(array.bind(py), name)?;
    fields.put(name, &shape, entries);
    Ok(())
}

/// What a spline is made of, from its stored numbers.
pub(super) struct Restored {
    pub(super) cubics: Cubics,
    pub(super) data: Data,
    report: Option<SolverReport>,
}

impl Restored {
    pub(super) fn of(fields: &mut Fields, kind: Kind, interrupt: Interrupt<'_>) -> Result<Self> {
        let report = fields.reports(REPORT, 1)?[0];
        let points = fields.take(POINTS)?;
        let cubics: Cubics = match kind {
            Kind::Riemannian => Piecewise::<RiemannianCubic>::restore(fields, interrupt)?.into(),
            Kind::Geometric => Piecewise::<GeometricCubic>::restore(fields, interrupt)?.into(),
        };
        let t = cubics.knots().to_vec();
        let points = Self::batch(&cubics, POINTS, points)?;
        let tolerance = report.map_or(0.0, |report| 10.0 * report.tolerance);
        let curve = cubics.curve();
        let found = curve.sample(&t, Quantity::Derivative(0), interrupt)?;
        for (knot, point) in found.iter().enumerate() {
            check_orthonormal(&format!("{POINTS}: knot {knot}"), points.get(knot))?;
            let gap = distance(point, points.get(knot));
            if gap > STORED_TOLERANCE.max(tolerance) {
                let problem = format!("knot {knot}: the curve is {gap:.3e} away from the point");
                return Err(refusal(problem));
            }
        }
        let data = Data { t, points };
        Ok(Restored {
            cubics,
            data,
            report,
        })
    }

    /// The base of the restored spline, to which its class adds its own fields.
    pub(super) fn wrap(self, py: Python<'_>) -> PyResult<PyClassInitializer<PyPiecewiseCurve>> {
        PyPiecewiseCurve::wrap(py, self.cubics, self.data, self.report)
    }

    /// Error unless velocities are those of the curve at its knots.
    pub(super) fn check_velocities(
        &self,
        velocities: &Batch,
        interrupt: Interrupt<'_>,
    ) -> Result<()> {
        let curve = self.cubics.curve();
        let found = curve.sample(&self.data.t, Quantity::Derivative(1), interrupt)?;
        let steps = self.data.t.windows(2).map(|pair| pair[1] - pair[0]);
        let shortest = steps.fold(f64::INFINITY, f64::min);
        for (knot, velocity) in found.iter().enumerate() {
            let stored = velocities.get(knot);
            let gap = distance(velocity, stored);
            // Pieces are solved for in their own unit of time.
            let allowed = STORED_TOLERANCE * norm(stored).max(shortest.recip());
            if gap.is_nan() || gap > allowed {
                let problem = format!("knot {knot}: the velocity of the curve is {gap:.3e} away");
                return Err(refusal(problem));
            }
        }
        Ok(())
    }

    /// An array of one matrix for each knot.
    pub(super) fn batch(cubics: &Cubics, name: &str, array: Array) -> Result<Batch> {
        let (n, k) = cubics.curve().shape();
        let expected = [cubics.knots().len(), n, k];
        let Array { shape, entries } = array;
        match shape == expected {
            true => Ok(Batch::of(expected, entries)),
            false => Err(refusal(format!(
                "{name}: expected shape {expected:?}, found {shape:?}"
            ))),
        }
    }
}
