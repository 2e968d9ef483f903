//! Splines as stored numbers: what their classes add to the pieces, and checks that both belong together.

use super::piecewise::{Cubics, Data, PyPiecewiseCurve};
use super::prelude::*;
use crate::cubic::RiemannianCubic;
use crate::curve::{GeometricCubic, Quantity};
use crate::report::SolverReport;
use crate::spline::Piecewise;
use crate::spline::stored_values::{check_points, check_velocities};
use crate::stored::{Fields, Stored, refusal};

/// The names of a spline's own numbers and words in its stored form.
const POINTS: &str = "S";
const REPORT: &str = "report";
pub(super) const VELOCITIES: &str = "V";
pub(super) const PIECES: &str = "pieces";

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
    pub(super) fn of(
        fields: &mut Fields,
        geometric: bool,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let report = fields.reports(REPORT, 1)?[0];
        let points = fields.take(POINTS)?;
        let cubics: Cubics = match geometric {
            false => Piecewise::<RiemannianCubic>::restore(fields, interrupt)?.into(),
            true => Piecewise::<GeometricCubic>::restore(fields, interrupt)?.into(),
        };
        let t = cubics.knots().to_vec();
        let points = Self::batch(&cubics, POINTS, points)?;
        let tolerance = report.map_or(0.0, |report| 10.0 * report.tolerance);
        let found = cubics
            .curve()
            .sample(&t, Quantity::Derivative(0), interrupt)?;
        check_points(POINTS, &points.views(), &found, tolerance)?;
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

    /// The velocities at the knots, which are those of the curve.
    pub(super) fn velocities(&self, array: Array, interrupt: Interrupt<'_>) -> Result<Batch> {
        let (t, velocities) = (&self.data.t, Self::batch(&self.cubics, VELOCITIES, array)?);
        let found = self
            .cubics
            .curve()
            .sample(t, Quantity::Derivative(1), interrupt)?;
        check_velocities(t, &velocities.views(), &found)?;
        Ok(velocities)
    }

    /// An array of one matrix for each knot.
    fn batch(cubics: &Cubics, name: &str, array: Array) -> Result<Batch> {
        let (n, k) = cubics.curve().shape();
        let expected = [cubics.knots().len(), n, k];
        let Array { shape, entries } = array;
        if shape == expected {
            return Ok(Batch::of(expected, entries));
        }
        let problem = format!("{name}: expected shape {expected:?}, found {shape:?}");
        Err(refusal(problem))
    }
}
