//! Many boundary value problems of the same shape.

use super::few_dimensions::{STEPS, end_data};
use super::from_boundary::{between, solved};
use super::guess::FlatWork;
use super::problem::BoundaryProblem;
use crate::cubic::boundary_options::BoundaryOptions;
use crate::cubic::riemannian_cubic::RiemannianCubic;
use crate::cubic::taylor::packing::unpack;
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::lanes::LANES;
use crate::linalg::product::product;
use crate::shooting::{EndData, LoneLeg, lone_legs};
use crate::space::Quotient;
use crate::threads::{self, ALWAYS};
use faer::{Mat, MatRef};

const SOLVER: &str = "boundary value problems of Riemannian cubics";

/// Problems per task of the thread pool.
const TASK: usize = 64;

/// Largest number of rows for which problems are solved eight at once. On St(3,1) and St(3,2) this took 0.87 and 0.73
/// times as long as one by one, before they were sorted; on St(4,2) and St(6,3) it would take 1.4 and 2.1 times as long
/// as one series each, which takes longer than nodes.
const MOST_ROWS: usize = 3;

/// The Riemannian cubic that solves a boundary value problem, by its initial data.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::cubic::{BoundaryOptions, solve_boundary};
/// // A quarter of a circle from rest to rest.
/// let (s0, s1, rest) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]], mat![[0.0], [0.0]]);
/// let problem = [&s0, &rest, &s1, &rest].map(|a| a.as_ref());
/// let found = solve_boundary(&[problem], &BoundaryOptions::default(), Interrupt::NEVER)?;
/// let solution = found[0].as_ref().expect("it is an easy problem");
/// // It accelerates along the circle at first, by 6 angle.
/// assert!((solution.acceleration[(1, 0)] - 3.0 * std::f64::consts::PI).abs() < 1e-10);
/// assert!(solution.residual <= 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BoundarySolution {
    /// Covariant acceleration at `S0`, shape `(n, k)`.
    pub acceleration: Mat<f64>,
    /// Covariant jerk at `S0`, shape `(n, k)`.
    pub jerk: Mat<f64>,
    /// The integral of the squared covariant acceleration over `[0, 1]`.
    pub cost: f64,
    /// Defect of the end conditions, as in [`SolverReport`](crate::SolverReport).
    pub residual: f64,
}

/// Solve for Riemannian cubics on `[0, 1]` with given end points and end velocities `[S0, V0, S1, V1]`, all of shape
/// `(n, k)`.
///
/// Each solution is the one of [`RiemannianCubic::from_boundary`], between frames up to the tolerance, between subspaces
/// bit for bit. Problems between frames with at most three rows and with displacement and speeds up to 2 are solved eight
/// at once, by Newton's method for a single Taylor series. The others, those on which this fails, and all problems with a
/// guess are solved one by one. Results do not depend on the number of threads; within the tolerance, a solution between
/// frames depends on the problems beside it.
///
/// # Errors
/// `InvalidArgument` and `Interrupted` for the whole call; the errors of `from_boundary` for single problems, without the
/// hint about mere bases.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::cubic::{BoundaryOptions, IntegrationOptions, RiemannianCubic, solve_boundary};
/// let (s0, v0) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (s1, v1) = (mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [2.0]]);
/// let problem = [&s0, &v0, &s1, &v1].map(|a| a.as_ref());
/// let found = solve_boundary(&[problem; 10], &BoundaryOptions::default(), Interrupt::NEVER)?;
/// let solution = found[9].as_ref().expect("it is an easy problem");
/// let [s, v, a, j] = [&s0, &v0, &solution.acceleration, &solution.jerk].map(|a| a.as_ref());
/// let curve = RiemannianCubic::from_initial(s, v, a, j, &IntegrationOptions::default(), Interrupt::NEVER)?;
/// assert!((stiefel_rs::Curve::point(&curve, 1.0)? - s1).norm_l2() < 1e-12);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub fn solve_boundary(
    problems: &[[MatRef<'_, f64>; 4]],
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<Vec<Result<BoundarySolution>>> {
    options.check()?;
    let size = match options.quotient {
        Quotient::Frames => TASK,
        Quotient::Subspaces => 1,
    };
    let tasks: Vec<_> = problems.chunks(size).collect();
    let solved = |(): &mut (), task: usize| match options.quotient {
        Quotient::Frames => solve_task(tasks[task], options, interrupt),
        Quotient::Subspaces => tasks[task]
            .iter()
            .map(|&data| {
                interrupt.check(SOLVER)?;
                uninterrupted(solution(between(data, options, interrupt), interrupt))
            })
            .collect(),
    };
    let found = threads::map(tasks.len(), ALWAYS, || (), solved)?;
    Ok(found.into_iter().flatten().collect())
}

/// Separates an interruption, which ends everything, from the result of a problem.
fn uninterrupted<T>(found: Result<T>) -> Result<Result<T>> {
    match found {
        Err(error) if error.is_interrupted() => Err(error),
        found => Ok(found),
    }
}

/// Solves the problems of a task, between frames.
///
/// # Errors
/// `Interrupted`.
fn solve_task(
    task: &[[MatRef<'_, f64>; 4]],
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<Vec<Result<BoundarySolution>>> {
    let problems: Vec<Result<BoundaryProblem>> = task
        .iter()
        .map(|&data| BoundaryProblem::new(data, options))
        .collect();
    let mut legs: Vec<Option<LoneLeg>> = problems.iter().map(|_| None).collect();
    if let Some(first) = problems.iter().flatten().next()
        && options.guess.is_none()
        && options.tension == 0.0
        && first.end[0].nrows() <= MOST_ROWS
    {
        let shape = first.end[0].shape();
        let mut work = FlatWork::new(shape.0, shape.1);
        let easy = problems.iter().enumerate().filter_map(|(i, problem)| {
            let problem = problem.as_ref().ok()?;
            if problem.end[0].shape() != shape || problem.unknowns() == 0 {
                return None;
            }
            let flat = problem.flat_in(&mut work).ok()??;
            let is_easy = problem.is_moderate(&flat);
            is_easy.then(|| (i, end_data(problem, &flat)))
        });
        abreast(first, alike(easy.collect()), &mut legs, options, interrupt)?;
    }
    let all = problems.into_iter().zip(legs).zip(task);
    all.map(|((problem, leg), data)| {
        uninterrupted(problem.and_then(|problem| match leg {
            Some(leg) => Ok(transformed(&problem, &leg)),
            None => solution(solved(&problem, data[0], options, interrupt), interrupt),
        }))
    })
    .collect()
}

/// Problems in order of their speed: a group of eight takes as many steps and terms as the hardest of them. In the
/// given order, problems with distance and speeds up to 2 on St(3,1) take 1.08 times as long.
fn alike(mut easy: Vec<(usize, EndData)>) -> Vec<(usize, EndData)> {
    easy.sort_by(|(_, a), (_, b)| a.speed().total_cmp(&b.speed()));
    easy
}

/// Solves easy problems in groups, each by a single series.
///
/// # Errors
/// `Interrupted`.
fn abreast(
    like: &BoundaryProblem,
    easy: Vec<(usize, EndData)>,
    legs: &mut [Option<LoneLeg>],
    options: &BoundaryOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<()> {
    let mut solve = lone_legs(like.shape());
    // Factor from coordinates to the lengths of real vectors.
    let scale = like.weight().sqrt();
    let (places, data): (Vec<usize>, Vec<EndData>) = easy.into_iter().unzip();
    for (places, data) in places.chunks(LANES).zip(data.chunks(LANES)) {
        interrupt.check(SOLVER)?;
        let steps = STEPS.min(options.max_iterations);
        for (place, leg) in places
            .iter()
            .zip(solve(data, options.tolerance / scale, steps))
        {
            legs[*place] = leg.map(|leg| LoneLeg {
                cost: leg.cost * scale * scale,
                residual: leg.residual * scale,
                ..leg
            });
        }
    }
    Ok(())
}

/// The initial data, cost and residual of a curve.
fn solution(curve: Result<RiemannianCubic>, interrupt: Interrupt<'_>) -> Result<BoundarySolution> {
    let curve = curve?;
    let [_, _, acceleration, jerk] = curve.initial()?;
    Ok(BoundarySolution {
        acceleration,
        jerk,
        cost: curve.cost(interrupt)?,
        residual: curve.report().map_or(0.0, |report| report.residual),
    })
}

/// The solution, transformed back to the start of the problem.
fn transformed(problem: &BoundaryProblem, leg: &LoneLeg) -> BoundarySolution {
    let [a, second] = unpack::<2>(&leg.start, problem.blocks());
    // j = x'' + [x, x']_m / 2.
    let jerk = second.plus_bracket(0.5, &problem.velocity, &a);
    let [acceleration, jerk] = [a, jerk].map(|v| {
        let low = product(&problem.g, v.tangent());
        match &problem.frame {
            Some(basis) => product(basis, &low),
            None => low,
        }
    });
    BoundarySolution {
        acceleration,
        jerk,
        cost: leg.cost,
        residual: leg.residual,
    }
}
