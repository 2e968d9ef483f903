//! Several Riemannian cubics of subspaces with the same boundary data.

use faer::MatRef;

use super::subspace_problem::{SOLVER, SubspaceData, SubspaceProblem, check};
use crate::cubic::boundary::random::Random;
use crate::cubic::boundary::search::{DistinctSolutions, SEARCH_WORK, ranked};
use crate::cubic::boundary::solver::scattered;
use crate::cubic::{RiemannianCubic, SearchOptions};
use crate::error::{Error, Result, unless_interrupted};
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, Strategy};
use crate::solve::gmres::norm;
use crate::spline::chains::descent::{self, Course::Along};
use crate::spline::chains::flat_spline::flat_spline;
use crate::spline::chains::motion::Motion;
use crate::spline::chains::solution::{ChainSolution, Effort};

/// Numbers of additional turns of one principal direction; geodesics that turn it by pi return to the same subspace, so
/// half a turn counts.
const TURNS: [f64; 2] = [0.5, 1.0];

impl RiemannianCubic {
    /// Riemannian cubics of subspaces with the same boundary data that are found from several starts, cheapest first.
    ///
    /// Newton's method starts from the cubic of flat space (or from the guess), then from the results of descents to
    /// local minima of the cost: as in [`between_subspaces`](Self::between_subspaces), and from the cubics of flat
    /// space that turn one principal direction by another pi or 2 pi, forwards and backwards; finally from
    /// [`starts`](SearchOptions::starts) random initial data. For lines, the result consists of the solutions of
    /// [`all_from_boundary`](Self::all_from_boundary) on the sphere, to both unit vectors of the last line. Other
    /// solutions may exist.
    ///
    /// # Arguments
    /// As [`between_subspaces`](Self::between_subspaces).
    /// # Errors
    /// The errors of [`between_subspaces`](Self::between_subspaces); `InvalidArgument` (`distinct`); `NoConvergence` if
    /// no solution is found.
    ///
    /// # Examples
    /// ```
    /// use faer::mat;
    /// use stiefel_rs::cubic::{RiemannianCubic, SearchOptions};
    /// use stiefel_rs::{Curve, Interrupt};
    /// // From rest to rest between two lines of the plane, by the angle 1 or by pi - 1 the other way.
    /// let (y0, y1, rest) = (mat![[1.0], [0.0]], mat![[1.0_f64.cos()], [1.0_f64.sin()]], mat![[0.0], [0.0]]);
    /// let [y0, y1, rest] = [&y0, &y1, &rest].map(|a| a.as_ref());
    /// let found =
    ///     RiemannianCubic::all_between_subspaces(y0, rest, y1, rest, &SearchOptions::default(), Interrupt::NEVER)?;
    /// assert!((found[0].cost(Interrupt::NEVER)? - 12.0).abs() < 1e-9);
    /// assert!((found[1].cost(Interrupt::NEVER)? - 12.0 * (std::f64::consts::PI - 1.0).powi(2)).abs() < 1e-8);
    /// # Ok::<(), stiefel_rs::Error>(())
    /// ```
    pub fn all_between_subspaces(
        y0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        y1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &SearchOptions<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Self>> {
        options.check()?;
        let data = [y0, v0, y1, v1];
        if y0.ncols() == 1 {
            return all_between_lines(data, options, interrupt);
        }
        let problem = SubspaceProblem::new(data, &options.boundary, interrupt)?;
        if problem.is_at_rest() {
            return Ok(vec![problem.curve(&problem.solve()?)?]);
        }
        let (found, report) = search(&problem, options)?;
        if found.solutions.is_empty() {
            let tolerance = options.boundary.tolerance;
            return Err(Error::no_convergence(SOLVER, report, tolerance));
        }
        let curves = found
            .solutions
            .iter()
            .map(|(_, found)| problem.curve(found));
        ranked(curves.collect::<Result<_>>()?, interrupt)
    }
}

/// The solutions on the sphere to a unit vector of the last line, and to its negative.
fn all_between_lines(
    data: SubspaceData<'_>,
    options: &SearchOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<Vec<RiemannianCubic>> {
    check(data)?;
    let [y0, v0, y1, v1] = data;
    let opposite = [y1, v1].map(|x| -x);
    let (mut curves, mut lost) = (Vec::new(), None);
    for [y1, v1] in [[y1, v1], opposite.each_ref().map(|x| x.as_ref())] {
        match RiemannianCubic::all_between_frames([y0, v0, y1, v1], options, interrupt) {
            Ok(found) => curves.extend(found),
            Err(error) if error.is_interrupted() => return Err(error),
            Err(error) => lost = Some(error),
        }
    }
    match (curves.is_empty(), lost) {
        (true, Some(error)) => Err(error),
        _ => ranked(
            curves.iter().map(RiemannianCubic::of_lines).collect(),
            interrupt,
        ),
    }
}

/// The solutions, and the report of the last start that led to none.
type Searched = (DistinctSolutions<ChainSolution>, SolverReport);

fn search(problem: &SubspaceProblem<'_>, options: &SearchOptions<'_>) -> Result<Searched> {
    let (chain, ends) = (&problem.chain, &problem.ends);
    let work = problem.work();
    work.allow(SEARCH_WORK);
    let effort = Effort::new(&problem.options, &work, problem.interrupt);
    let mut found = DistinctSolutions::new(options.distinct);
    let mut add = |solution: ChainSolution, strategy: Strategy| {
        if solution.report.converged {
            let start = solution.motion.derivatives(0).to_vec();
            found.add((start, solution.found_by(strategy)));
        }
    };
    let first = match options.boundary.guess {
        Some(guess) => {
            let start = problem.motion_with(&problem.derivatives_of(guess)?);
            descent::nearest_to(chain, ends, &start, effort)?
        }
        None => unless_interrupted(chain.solve(ends, effort))?
            .unwrap_or_else(|| ChainSolution::unsolved(effort)),
    };
    add(first, Strategy::Direct);
    let mut courses = descent::starts(chain, ends)?;
    if let Some(data) = descent::flat_data(chain, ends)? {
        for turns in TURNS {
            courses.extend(data.turned_together(turns)?.into_iter().map(Along));
            courses.extend(data.turned(turns)?.into_iter().map(Along));
        }
    }
    for course in courses {
        add(course.end(chain, ends, effort)?, Strategy::Descent);
    }
    let flat = flat_spline(chain, ends)?;
    let mut random = Random::new(options.seed);
    for attempt in 0..options.starts as usize {
        if work.is_done() {
            break;
        }
        let derivatives = scattered(flat.derivatives(0), speeds(&flat), attempt, &mut random);
        let start = problem.motion_with(&derivatives);
        add(
            descent::nearest_to(chain, ends, &start, effort)?,
            Strategy::Direct,
        );
    }
    let report = SolverReport::new(effort.reason(0), 0, f64::INFINITY, effort.tolerance);
    Ok((found, report))
}

/// The sum of initial and end speed.
fn speeds(motion: &Motion) -> f64 {
    norm(motion.velocity(0)) + norm(motion.velocity(1))
}
