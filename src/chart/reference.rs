//! The reference solution in a chart: a Taylor method of order 26 with variable steps, to round-off.
//!
//! Coefficients come from the Hamiltonian's table of terms evaluated on series, one more order per sweep. The step
//! follows from the decay of the last two coefficients.
//!
//! # Source
//! Jorba, Zou (2005), "A software package for the numerical integration of ODEs by means of high-order Taylor
//! methods", Experimental Mathematics 14, 99-117, eq. (3-8).

use nalgebra::SVector;

use super::series::Series;
use super::{Chart, accumulate_gradient};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason};

/// Coefficients kept: order 26.
const COEFFICIENTS: usize = 27;

/// The last term of a step, relative to the state.
const TRUNCATION: f64 = 1e-18;

/// Steps at the most; a curve that runs into a pole takes ever shorter ones.
const MAX_STEPS: usize = 100_000;

/// States of the exact flow at the given times, from `z0` at time 0.
///
/// # Arguments
/// * `z0` - state `(q, qdot, p_q, p_qdot)`; `t` - finite times in any order, negative ones too
/// # Accuracy
/// At most 1e-13 for curves of the size of the paper's (measured 2e-15 against 40-digit data in `tests/chart_reference.rs`).
/// # Errors
/// `NonFinite`, `OutsideChart` (the curve leaves `0 < theta < pi`), `NoConvergence` (too many steps), `Interrupted`.
/// # Source
/// See the module page.
pub fn reference<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z0: &SVector<f64, Z>,
    t: &[f64],
    interrupt: Interrupt<'_>,
) -> Result<Vec<SVector<f64, Z>>> {
    chart.check("z0", z0.as_slice())?;
    if let Some(index) = t.iter().position(|t| !t.is_finite()) {
        return Err(Error::NonFinite { name: "t", index });
    }
    let mut out = vec![*z0; t.len()];
    for direction in [1.0, -1.0] {
        let mut order: Vec<usize> = (0..t.len()).filter(|&i| t[i] * direction > 0.0).collect();
        order.sort_by(|&i, &j| t[i].abs().total_cmp(&t[j].abs()));
        let mut march = March {
            chart,
            z: *z0,
            time: 0.0,
            steps: 0,
            interrupt,
        };
        for (place, states) in march
            .visit(direction, order.iter().map(|&i| t[i]))?
            .into_iter()
            .enumerate()
        {
            out[order[place]] = states;
        }
    }
    Ok(out)
}

struct March<'a, C, const Z: usize> {
    chart: &'a C,
    z: SVector<f64, Z>,
    time: f64,
    steps: usize,
    interrupt: Interrupt<'a>,
}

impl<C, const Z: usize> March<'_, C, Z> {
    /// States at times sorted along the direction.
    fn visit<const X: usize>(
        &mut self,
        direction: f64,
        times: impl Iterator<Item = f64>,
    ) -> Result<Vec<SVector<f64, Z>>>
    where
        C: Chart<X, Z>,
    {
        let mut out = Vec::new();
        let mut segment: Option<([Series<COEFFICIENTS>; Z], f64)> = None;
        for t in times {
            loop {
                let (series, length) = match &segment {
                    Some(segment) => segment,
                    None => {
                        let series = expand(self.chart, &self.z);
                        segment.insert((series, direction * step_length(&series)))
                    }
                };
                if (t - self.time).abs() <= length.abs() {
                    let state = value(series, t - self.time);
                    self.chart.check("state", state.as_slice())?;
                    out.push(state);
                    break;
                }
                (self.z, self.time) = (value(series, *length), self.time + length);
                segment = None;
                self.chart.check("state", self.z.as_slice())?;
                self.count_step(t)?;
            }
        }
        Ok(out)
    }

    fn count_step(&mut self, target: f64) -> Result<()> {
        self.interrupt.check("chart reference")?;
        self.steps += 1;
        if self.steps < MAX_STEPS {
            return Ok(());
        }
        let report = SolverReport {
            converged: false,
            iterations: self.steps,
            residual: (target - self.time).abs(),
            tolerance: 0.0,
            reason: StopReason::MaxIterations,
        };
        Err(Error::NoConvergence {
            solver: "chart reference",
            report,
        })
    }
}

/// Taylor coefficients of the flow at `z`: `z_{j+1} = (J grad H(z))_j / (j + 1)`.
fn expand<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z: &SVector<f64, Z>,
) -> [Series<COEFFICIENTS>; Z] {
    let mut series: [Series<COEFFICIENTS>; Z] = std::array::from_fn(|i| Series::from(z[i]));
    for order in 1..COEFFICIENTS {
        for s in &mut series {
            s.set_active(order);
        }
        let (sin, cos) = series[0].sin_cos();
        let mut gradient = [Series::from(0.0); Z];
        accumulate_gradient(chart.terms(sin, cos), &series, &mut gradient);
        for i in 0..X {
            series[i].set(
                order,
                gradient[X + i].coefficients()[order - 1] / order as f64,
            );
            series[X + i].set(order, -gradient[i].coefficients()[order - 1] / order as f64);
        }
    }
    series
}

/// The step at which the last two terms fall below the truncation level.
fn step_length<const Z: usize>(series: &[Series<COEFFICIENTS>; Z]) -> f64 {
    let largest = |j: usize| {
        series
            .iter()
            .fold(0.0_f64, |m, s| m.max(s.coefficients()[j].abs()))
    };
    let scale = largest(0).max(1.0);
    let limit = |j: usize| (TRUNCATION * scale / largest(j)).powf(1.0 / j as f64);
    limit(COEFFICIENTS - 2).min(limit(COEFFICIENTS - 1))
}

fn value<const Z: usize>(series: &[Series<COEFFICIENTS>; Z], t: f64) -> SVector<f64, Z> {
    SVector::from_fn(|i, _| series[i].value(t))
}
