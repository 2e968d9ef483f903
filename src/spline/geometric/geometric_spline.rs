//! The geometric spline: pieces of de Casteljau's algorithm, joined twice continuously differentiably.

use faer::{Mat, MatRef, Scale};

use super::end_accelerations::{SecondTerms, add_quasi_geodesic_acceleration};
use super::links::Links;
use crate::curve::GeometricCubic;
use crate::error::{Error, Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::legs::Knots;
use crate::linalg::product::{columns, columns_mut, entries};
use crate::manifold::only_bases::advised_knots;
use crate::manifold::tangent::tangent_part;
use crate::report::{SolverReport, StopReason};
use crate::solve::anderson::Anderson;
use crate::solve::gmres::norm;
use crate::solve::line_search::backtracked;
use crate::solve::newton_krylov::newton_step;
use crate::solve::tridiagonal::{Isometries, Tridiagonal};
use crate::space::{Kind, Quotient};
use crate::spline::ends::{End, EndConditions, Ends, check_ends};
use crate::spline::knots;
use crate::spline::options::SplineOptions;
use crate::spline::piecewise::Piecewise;
use crate::spline::reduced_knots::ReducedKnots;
use crate::threads::{self, scaled};

const SOLVER: &str = "geometric spline";

/// Number of past steps used by Anderson mixing.
const DEPTH: usize = 5;

/// Microseconds of the accelerations of a leg between rotations, and of a piece.
const ACCELERATIONS: f64 = 5.0;
const PIECE: f64 = 18.0;

/// Minimal number of legs per group, and maximal number of groups: each group has its own buffers.
const GROUP: usize = 16;
const MAX_GROUPS: usize = 64;

/// Mixing continues as long as this many steps halve the residual.
const PATIENCE: usize = 4;

/// Relative residual to which Newton's equations are solved.
const FORCING: f64 = 1e-3;

/// Number of lengths of a Newton step that are tried.
const STEP_LENGTHS: i32 = 10;

/// The spline of geometric cubics through points, with continuous velocity and covariant acceleration.
///
/// Each piece is a curve of the adjusted de Casteljau algorithm with the velocities at its knots
/// ([`GeometricCubic::from_boundary`]); the velocities are chosen such that the accelerations of the two pieces at
/// every knot agree. The curve is close to the spline of Riemannian cubics (`cubic_spline`), which on rotations and
/// spheres is quicker to compute (bench `geometric_spline`); use this one for pieces that are evaluated from their
/// control points by de Casteljau's algorithm. On the circle `St(2, 1)` both are the cubic spline of the angle.
///
/// # Arguments
/// * `t` - increasing times; `points` - one per time, shape `(n, k)`
/// # Accuracy
/// Covariant accelerations at a knot differ by at most `options.tolerance` in the time of the shorter leg.
/// # Method
/// The accelerations at the ends of a piece are given in closed form. The equations are solved by a fixed-point
/// iteration with Anderson mixing, preconditioned by the tridiagonal system of flat space in tangent spaces; if it
/// stalls, by Newton's method with GMRES and the same preconditioner. Time is linear in the number of knots
/// and in `n`. Legs are computed in parallel; results are bit-identical for any number of threads.
/// # Errors
/// `Shape`, `NonFinite`, `InvalidArgument` (tolerance, tension, times, ends that do not close); `Overflow` (times that
/// differ too much), `NoConvergence`, `Interrupted`; wrapped in `AtKnot`: `NotOrthonormal`, `NotTangent`, `NoJoiningCurve`, `OutsideLogDomain` and
/// `DifferentComponents` (no curve leads to the next point), and the errors of [`GeometricCubic::from_boundary`] if a
/// piece is too long or too fast. Errors about distance are in `OnlyBases` if the points look like mere bases.
pub fn geometric_spline(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    ends: &EndConditions,
    options: &SplineOptions,
    interrupt: Interrupt<'_>,
) -> Result<(Piecewise<GeometricCubic>, SolverReport)> {
    let found = solved(Quotient::Frames, t, points, ends, options, interrupt);
    let found =
        found.and_then(|(problem, velocities, report)| Ok((problem.pieces(&velocities)?, report)));
    let (pieces, report) = found.map_err(|error| advised_knots(error, Quotient::Frames, points))?;
    Ok((Piecewise::new(t.to_vec(), pieces), report))
}

/// The equations, and velocities that solve them.
///
/// # Errors
/// The errors of [`geometric_spline`].
pub(crate) fn solved<'a>(
    quotient: Quotient,
    t: &[f64],
    points: &[MatRef<'_, f64>],
    ends: &EndConditions,
    options: &SplineOptions,
    interrupt: Interrupt<'a>,
) -> Result<(GeometricProblem<'a>, Vec<f64>, SolverReport)> {
    knots::check_tolerance(options.tolerance)?;
    if options.tension != 0.0 {
        return Err(Error::InvalidArgument {
            name: "tension",
            requirement: "0 for geometric cubics, which minimise no cost that tension could be added to",
            found: options.tension,
        });
    }
    knots::check(t, points)?;
    check_ends(quotient, points, ends)?;
    let mut problem = GeometricProblem::new(quotient, t, points, ends, interrupt)?;
    let (velocities, report) = problem.solve(options.tolerance, options.max_iterations)?;
    if !report.converged {
        return Err(Error::NoConvergence {
            solver: SOLVER,
            report,
        });
    }
    Ok((problem, velocities, report))
}

/// The equations, in the coordinates of the span of the data and in units of the mean length of a leg.
pub(crate) struct GeometricProblem<'a> {
    knots: ReducedKnots,
    ends: Ends,
    links: Links,
    flat: Tridiagonal<1>,
    /// One per group of legs.
    work: Vec<SecondTerms>,
    shape: (usize, usize),
    interrupt: Interrupt<'a>,
}

/// Residuals of the equations for given velocities.
struct GeometricResidual {
    /// The change of the velocities by a step of the fixed-point iteration.
    step: Vec<f64>,
    /// The largest jump of the acceleration, in the time of the shorter leg; Frobenius norm.
    size: f64,
    /// Root of the sum of squares.
    total: f64,
}

impl<'a> GeometricProblem<'a> {
    fn new(
        quotient: Quotient,
        t: &[f64],
        points: &[MatRef<'_, f64>],
        ends: &EndConditions,
        interrupt: Interrupt<'a>,
    ) -> Result<Self> {
        let knots = ReducedKnots::of_spline(Kind::real(quotient), t, points, ends)?;
        let ends = knots.ends(ends, |_, v| entries(v));
        let (n, k) = knots.shape();
        let legs = knots.lengths.len();
        let groups = legs.div_ceil(group(legs));
        Ok(GeometricProblem {
            shape: (n, k),
            work: (0..groups)
                .map(|_| SecondTerms::new(quotient, n, k))
                .collect(),
            links: Links::new(&knots.points, quotient)?,
            flat: Knots::of_points(&knots.lengths, &ends).flat_system()?,
            knots,
            ends,
            interrupt,
        })
    }

    /// Solves for the velocities at the knots that have a separate one.
    fn solve(&mut self, tolerance: f64, max_iterations: usize) -> Result<(Vec<f64>, SolverReport)> {
        let mut velocities = self.links.right_sides(&self.grid());
        self.flat.solve(&mut self.links, &mut velocities)?;
        let mut found = self.residual(&velocities)?;
        let mut iterations = self.mix(&mut velocities, &mut found, tolerance, max_iterations)?;
        let reason = loop {
            if found.size <= tolerance {
                break StopReason::Converged;
            }
            if iterations >= max_iterations {
                break StopReason::MaxIterations;
            }
            iterations += 1;
            let width = norm(&velocities);
            let step = newton_step(&found.step, width, FORCING, |share, direction| {
                let beside = self.residual(&plus(&velocities, share, direction))?;
                Ok(Some(beside.step))
            })?;
            let Some(step) = step else {
                break StopReason::Stagnated;
            };
            let better = backtracked(found.total, STEP_LENGTHS, |share| {
                let trial = plus(&velocities, share, &step);
                let found = self.try_residual(&trial)?;
                Ok(found.map(|found| (found.total, (trial, found))))
            })?;
            let Some((better, _)) = better else {
                break StopReason::Stagnated;
            };
            (velocities, found) = better;
        };
        let report = SolverReport::new(reason, iterations, found.size, tolerance);
        Ok((velocities, report))
    }

    /// Fixed-point iteration with Anderson mixing, until it converges or stalls; stores the best velocities and returns
    /// the number of steps.
    fn mix(
        &mut self,
        best: &mut Vec<f64>,
        found: &mut GeometricResidual,
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<usize> {
        let mut anderson = Anderson::new(DEPTH);
        let moved = |x: &[f64], dx: Vec<f64>| x.iter().zip(dx).map(|(x, dx)| x + dx).collect();
        let mut next: Vec<f64> = moved(best, anderson.increment(found.step.clone()));
        // The residual must halve in every PATIENCE steps, or the iteration has stalled.
        let mut mark = found.size;
        for iteration in 0..max_iterations {
            if found.size <= tolerance {
                return Ok(iteration);
            }
            if iteration > 0 && iteration % PATIENCE == 0 {
                if found.size > 0.5 * mark {
                    return Ok(iteration);
                }
                mark = found.size;
            }
            let Some(here) = self.try_residual(&next)? else {
                return Ok(iteration);
            };
            let following = moved(&next, anderson.increment(here.step.clone()));
            if here.size < found.size {
                (*best, *found) = (next, here);
            }
            next = following;
        }
        Ok(max_iterations)
    }

    /// [`GeometricProblem::residual`]; `None` if a piece does not exist.
    fn try_residual(&mut self, velocities: &[f64]) -> Result<Option<GeometricResidual>> {
        let found = unless_interrupted(self.residual(velocities))?;
        Ok(found.filter(|found| found.total.is_finite()))
    }

    fn residual(&mut self, velocities: &[f64]) -> Result<GeometricResidual> {
        let second_terms = self.second_terms(velocities)?;
        let jumps = self.jumps(velocities, &second_terms);
        let (mut size, mut total) = (0.0_f64, 0.0);
        for (knot, jump) in jumps.chunks_exact(self.links.size()).enumerate() {
            let length = self.grid().shortest(knot).powi(2) * norm(jump);
            size = if length <= size { size } else { length };
            total += length * length;
        }
        let mut step: Vec<f64> = jumps.iter().map(|jump| -jump).collect();
        self.flat.solve(&mut self.links, &mut step)?;
        Ok(GeometricResidual {
            step,
            size,
            total: total.sqrt(),
        })
    }

    /// The second terms of the accelerations at the start and the end of every leg (`end_accelerations.rs`), in the
    /// time of the leg.
    fn second_terms(&mut self, velocities: &[f64]) -> Result<Vec<f64>> {
        let (legs, size) = (self.knots.lengths.len(), self.shape.0 * self.shape.1);
        let group = group(legs);
        let mut all = vec![0.0; 2 * size * legs];
        let mut work = std::mem::take(&mut self.work);
        let of_group =
            |(): &mut (), which: usize, (all, work): &mut (&mut [f64], &mut SecondTerms)| {
                for (i, out) in all.chunks_mut(2 * size).enumerate() {
                    let leg = which * group + i;
                    let second_terms = self.second_terms_of_leg(leg, velocities, work, out);
                    second_terms.map_err(|error| error.at_knot(leg))?;
                }
                Ok(())
            };
        let groups = all.chunks_mut(2 * size * group).zip(&mut work);
        let each = group as f64 * scaled(ACCELERATIONS, self.shape);
        let done = threads::map_parts(groups, each, || (), of_group);
        self.work = work;
        done?;
        Ok(all)
    }

    fn second_terms_of_leg(
        &self,
        leg: usize,
        velocities: &[f64],
        work: &mut SecondTerms,
        out: &mut [f64],
    ) -> Result<()> {
        self.interrupt.check(SOLVER)?;
        let ends = [leg, leg + 1];
        let points = ends.map(|knot| self.knots.points[knot].as_ref());
        let velocities = ends.map(|knot| self.velocity(velocities, knot));
        let (first, last) = out.split_at_mut(out.len() / 2);
        let out = [first, last].map(|out| columns_mut(out, self.shape.0));
        work.compute(points, velocities, self.knots.lengths[leg], out)
    }

    fn grid(&self) -> Knots<'_> {
        Knots::of_points(&self.knots.lengths, &self.ends)
    }

    /// The velocity of a knot, among the velocities of the knots that have a separate one.
    fn velocity<'v>(&self, velocities: &'v [f64], knot: usize) -> MatRef<'v, f64> {
        let size = self.links.size();
        let knot = knot % self.grid().count();
        columns(&velocities[knot * size..][..size], self.shape.0)
    }

    /// The accelerations before the knots minus those after them; at an end, minus the given one.
    fn jumps(&self, velocities: &[f64], second_terms: &[f64]) -> Vec<f64> {
        let (grid, size) = (self.grid(), self.links.size());
        let ends =
            |leg: usize| [2 * leg, 2 * leg + 1].map(|end| &second_terms[end * size..][..size]);
        let mut jumps = grid.jumps::<f64>(size, ends);
        for (knot, jump) in jumps.chunks_exact_mut(size).enumerate() {
            if let Some((End::Acceleration(_), sign)) = grid.end_at(knot) {
                let point = self.knots.points[knot].as_ref();
                let velocity = self.velocity(velocities, knot);
                add_quasi_geodesic_acceleration(
                    columns_mut(jump, self.shape.0),
                    -sign,
                    point,
                    velocity,
                );
            }
        }
        jumps
    }

    /// The velocity at the given basis of a knot, in the caller's time.
    pub(crate) fn velocity_at(
        &self,
        knot: usize,
        point: MatRef<'_, f64>,
        velocities: &[f64],
    ) -> Mat<f64> {
        let velocity = self.velocity(velocities, knot);
        self.knots.lift_vector(knot, point, velocity) * Scale(self.knots.unit.recip())
    }

    fn pieces(&self, velocities: &[f64]) -> Result<Vec<GeometricCubic>> {
        let piece = |(): &mut (), leg: usize| {
            self.interrupt.check(SOLVER)?;
            let (h, ends) = (Scale(self.knots.lengths[leg]), [leg, leg + 1]);
            let velocity = |knot| self.velocity(velocities, knot) * h;
            // The solved velocities are tangent to the solver's tolerance; make them tangent to round-off.
            let [v0, v1] = ends.map(|knot| {
                let point = self.knots.points[knot].as_ref();
                self.knots
                    .lift(tangent_part(Quotient::Frames, point, velocity(knot).as_ref()).as_ref())
            });
            let [s0, s1] = ends.map(|knot| self.knots.lift(self.knots.points[knot].as_ref()));
            let [s0, v0, s1, v1] = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
            GeometricCubic::from_boundary(s0, v0, s1, v1).map_err(|error| error.at_knot(leg))
        };
        let each = scaled(PIECE, self.shape);
        threads::map(self.knots.lengths.len(), each, || (), piece)
    }
}

/// Number of legs that are computed one after another, the same for any number of threads.
fn group(legs: usize) -> usize {
    legs.div_ceil(MAX_GROUPS).max(GROUP)
}

fn plus(a: &[f64], share: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + share * b).collect()
}
