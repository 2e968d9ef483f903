//! The reference solution in a chart: a Taylor method of order 26 with variable steps, to round-off.
//!
//! The coefficients are computed by evaluating the Hamiltonian's table of terms on series, one more order per sweep.
//! The step length follows from the decay of the last two coefficients.
//!
//! # Source
//! Jorba, Zou (2005), "A software package for the numerical integration of ODEs by means of high-order Taylor
//! methods", Experimental Mathematics 14, 99-117, eq. (3-8).

use nalgebra::SVector;

use super::atlas::AtlasState;
use super::chart::{Chart, check_reached};
use super::series::Series;
use super::term::accumulate_gradient;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason};

/// Number of stored coefficients: order 26.
const COEFFICIENTS: usize = 27;

/// Size of the last term of a step, relative to the state.
const TRUNCATION: f64 = 1e-18;

/// Maximal number of steps; they become ever shorter if a curve runs into a pole.
const MAX_STEPS: usize = 100_000;

/// Times between two polls of the interrupt.
const TIMES_PER_CHECK: usize = 4096;

const SOLVER: &str = "chart reference";

/// States of the exact flow at the given times, from `z0` at time 0.
///
/// # Arguments
/// * `z0` - state `(q, qdot, p_q, p_qdot)`; `t` - finite times in any order, negative ones too
/// # Accuracy
/// At most 1e-13 for curves of the size of the paper's (measured 2e-15 against 40-digit data in
/// `tests/chart_reference.rs`).
/// # Errors
/// `NonFinite`, `OutsideChart` (the curve leaves `0 < theta < pi`), `NoConvergence` (too many steps; the residual is
/// the remaining time), `Overflow`, `InvalidArgument` (memory), `Interrupted`.
/// # Source
/// See the module documentation.
pub fn reference<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z0: &SVector<f64, Z>,
    t: &[f64],
    interrupt: Interrupt<'_>,
) -> Result<Vec<SVector<f64, Z>>> {
    let start = AtlasState { turns: 0, z: *z0 };
    let states = sample(chart, &start, t, interrupt, |state| Ok(*state))?;
    Ok(states.into_iter().map(|state| state.z).collect())
}

/// As [`reference()`], across charts: between two Taylor steps, a state near a pole changes its chart.
///
/// # Accuracy
/// As [`reference()`]; 1e-12 compared with 40-digit data rotated across the poles (`tests/atlas.rs`).
/// # Errors
/// `NonFinite`, `NoConvergence`, `Overflow`, `InvalidArgument` (memory), `Interrupted`; `OutsideChart` only if a curve
/// is so fast that it reaches a pole within one step.
pub fn reference_across<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    start: &AtlasState<Z>,
    t: &[f64],
    interrupt: Interrupt<'_>,
) -> Result<Vec<AtlasState<Z>>> {
    sample(chart, start, t, interrupt, |state| state.recentred(chart))
}

/// Integrates from the start in both directions; `place` may move a state to another chart.
fn sample<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    start: &AtlasState<Z>,
    t: &[f64],
    interrupt: Interrupt<'_>,
    place: impl Fn(&AtlasState<Z>) -> Result<AtlasState<Z>>,
) -> Result<Vec<AtlasState<Z>>> {
    chart.check("z0", start.z.as_slice())?;
    if let Some(index) = t.iter().position(|t| !t.is_finite()) {
        return Err(Error::NonFinite { name: "t", index });
    }
    let mut out = Vec::new();
    if out.try_reserve_exact(t.len()).is_err() {
        let requirement = "few enough for the states to fit in memory";
        let found = t.len() as f64;
        return Err(Error::InvalidArgument {
            name: "t",
            requirement,
            found,
        });
    }
    let start = place(start)?;
    out.resize(t.len(), start);
    for direction in [1.0, -1.0] {
        let mut order: Vec<usize> = (0..t.len()).filter(|&i| t[i] * direction > 0.0).collect();
        order.sort_by(|&i, &j| t[i].abs().total_cmp(&t[j].abs()));
        let mut march = ReferenceMarch {
            chart,
            place: &place,
            state: start,
            time: 0.0,
            steps: 0,
            interrupt,
        };
        march.visit(direction, t, &order, &mut out)?;
    }
    Ok(out)
}

struct ReferenceMarch<'a, C, F, const Z: usize> {
    chart: &'a C,
    place: &'a F,
    state: AtlasState<Z>,
    time: f64,
    steps: usize,
    interrupt: Interrupt<'a>,
}

impl<C, F, const Z: usize> ReferenceMarch<'_, C, F, Z>
where
    F: Fn(&AtlasState<Z>) -> Result<AtlasState<Z>>,
{
    /// States at the times `t[order[0]], t[order[1]], ...`, sorted along the direction.
    fn visit<const X: usize>(
        &mut self,
        direction: f64,
        t: &[f64],
        order: &[usize],
        out: &mut [AtlasState<Z>],
    ) -> Result<()>
    where
        C: Chart<X, Z>,
    {
        let mut segment: Option<([Series<COEFFICIENTS>; Z], f64)> = None;
        for (visited, &target) in order.iter().enumerate() {
            if visited % TIMES_PER_CHECK == 0 {
                self.interrupt.check(SOLVER)?;
            }
            loop {
                let (series, length) = match &segment {
                    Some(segment) => segment,
                    None => {
                        let series = expand(self.chart, &self.state.z);
                        segment.insert((series, direction * step_length(&series)))
                    }
                };
                let (turns, ahead) = (self.state.turns, t[target] - self.time);
                let after = |time: f64| AtlasState {
                    turns,
                    z: value(series, time),
                };
                if ahead.abs() <= length.abs() {
                    let reached = after(ahead);
                    check_reached(self.chart, &reached.z)?;
                    out[target] = (self.place)(&reached)?;
                    break;
                }
                let (next, length) = (after(*length), *length);
                self.count_step(ahead.abs(), length.abs())?;
                check_reached(self.chart, &next.z)?;
                (self.state, self.time) = ((self.place)(&next)?, self.time + length);
                segment = None;
            }
        }
        Ok(())
    }

    /// Fails after too many steps, or as soon as the steps are so short that there would be too many.
    fn count_step(&mut self, ahead: f64, length: f64) -> Result<()> {
        self.interrupt.check(SOLVER)?;
        self.steps += 1;
        if self.steps < MAX_STEPS && ahead < MAX_STEPS as f64 * length {
            return Ok(());
        }
        let report = SolverReport::new(StopReason::MaxIterations, self.steps, ahead, 0.0);
        Err(Error::NoConvergence {
            solver: SOLVER,
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
