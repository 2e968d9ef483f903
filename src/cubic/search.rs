//! Several Riemannian cubics with the same boundary data.

use std::sync::Arc;

use faer::MatRef;

use super::boundary::{BoundaryOptions, BoundaryStrategy};
use super::continuation::{MAX_STEPS, Next, norm};
use super::curve_start::CurveFamily;
use super::guess::FlatData;
use super::homotopy::Homotopy;
use super::problem::Problem;
use super::random::Random;
use super::riemannian_cubic::RiemannianCubic;
use super::shooting::SOLVER;
use super::solver::{Solution, Solver};
use super::taylor::Accuracy;
use crate::curve::Curve;
use crate::error::{Error, Result};

/// Work that a search may take, in that of one solution.
const SEARCH_WORK: f64 = 4.0;

/// How solutions of a boundary value problem are looked for.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{RiemannianCubic, SearchOptions};
/// use stiefel_rs::Curve;
/// // A quarter of a circle from rest to rest; the other way round it is three quarters.
/// let (s0, s1, rest) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]], mat![[0.0], [0.0]]);
/// let options = SearchOptions { starts: 2, seed: 1, ..Default::default() };
/// let found = RiemannianCubic::all_from_boundary(
///     s0.as_ref(), rest.as_ref(), s1.as_ref(), rest.as_ref(), &options,
/// )?;
/// // The cost is 12 angle^2, the cheapest comes first.
/// assert!((found[0].cost()? / (12.0 * std::f64::consts::FRAC_PI_2.powi(2)) - 1.0).abs() < 1e-10);
/// assert!((found[1].cost()? / found[0].cost()? - 9.0).abs() < 1e-9);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct SearchOptions<'a> {
    /// How each of them is solved for.
    pub boundary: BoundaryOptions<'a>,
    /// Random starts of Newton's method, and as many descents and random families that are followed.
    pub starts: u32,
    /// Of the random numbers: the same seed finds the same solutions.
    pub seed: u64,
    /// Solutions whose `(x', x'')` at the start differ by at most this, relative to `1 + |(x', x'')|`, count as one; in
    /// `[1e-10, 1]`.
    pub distinct: f64,
}

impl Default for SearchOptions<'_> {
    /// 8 starts; relative difference `1e-6`.
    fn default() -> Self {
        SearchOptions {
            boundary: BoundaryOptions::default(),
            starts: 8,
            seed: 0,
            distinct: 1e-6,
        }
    }
}

impl RiemannianCubic {
    /// Riemannian cubics with the same boundary data, those that several starts find, the cheapest first.
    ///
    /// The starts are those of [`from_boundary`](Self::from_boundary), flat cubics along quasi-geodesics that make a full turn
    /// more in one principal direction, geometric and geodesic polynomials with the same data, those of least cost among them,
    /// descents from knots that are moved at random, and random initial data; families of easier data are followed through
    /// every solution they pass. There may be others: on the sphere there are infinitely many.
    ///
    /// # Errors
    /// Those of [`from_boundary`](Self::from_boundary); `NoConvergence` where none is found.
    pub fn all_from_boundary(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &SearchOptions<'_>,
    ) -> Result<Vec<Self>> {
        options.boundary.check()?;
        if !(1e-10..=1.0).contains(&options.distinct) {
            return Err(Error::InvalidArgument {
                name: "distinct",
                requirement: "between 1e-10 and 1",
                found: options.distinct,
            });
        }
        let problem = Problem::new(s0, v0, s1, v1)?;
        let start = match options.boundary.guess {
            Some((a, j)) => problem.start_from(s0, a, j)?,
            None => problem.flat_start(problem.flat()?.as_ref()),
        };
        let mut solver = Solver::new(&problem, &options.boundary);
        solver.map.allow(SEARCH_WORK);
        let mut found = Found {
            solutions: Vec::new(),
            distinct: options.distinct,
        };
        search(&problem, &mut solver, &start, options, &mut found)?;
        if found.solutions.is_empty() {
            let report = solver.report(BoundaryStrategy::Moving).solver;
            return Err(Error::NoConvergence {
                solver: SOLVER,
                report,
            });
        }
        let mut ranked = Vec::new();
        for (y, report) in found.solutions {
            let path = problem.path(&y, options.boundary.interrupt)?;
            let frame = problem.frame.clone();
            let curve = Self::of_path(
                problem.n,
                problem.k,
                frame.map(Arc::new),
                path,
                Some(report),
            );
            ranked.push((curve.cost()?, curve));
        }
        ranked.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        Ok(ranked.into_iter().map(|(_, curve)| curve).collect())
    }
}

/// Distinct solutions so far.
struct Found {
    solutions: Vec<Solution>,
    distinct: f64,
}

impl Found {
    fn add(&mut self, (y, report): Solution) {
        let near = |(other, _): &Solution| {
            let difference: Vec<f64> = y.iter().zip(other).map(|(a, b)| a - b).collect();
            norm(&difference) <= self.distinct * (1.0 + norm(&y))
        };
        if !self.solutions.iter().any(near) {
            self.solutions.push((y, report));
        }
    }
}

fn search(
    problem: &Problem,
    solver: &mut Solver<'_>,
    start: &[f64],
    options: &SearchOptions<'_>,
    found: &mut Found,
) -> Result<()> {
    let mut random = Random::new(options.seed);
    let mut starts = vec![start.to_vec()];
    if let Ok(turned) = FlatData::turned(problem.end[0].as_ref(), problem.end[1].as_ref()) {
        starts.extend(turned.iter().map(|flat| problem.start_of(flat)));
    }
    starts.extend((0..options.starts).map(|i| solver.scattered(start, i, &mut random)));
    for mut y in starts {
        if solver.restarted(&mut y)? {
            found.add((y, solver.report(BoundaryStrategy::Direct)));
        }
    }
    if let Some(flat) = geodesic(problem)? {
        let mut y = problem.start_of(&flat);
        if solver.restarted(&mut y)? {
            found.add((y, solver.report(BoundaryStrategy::Geodesic)));
        }
    }
    if let Some(solution) = solver.by_descents()? {
        found.add(solution);
    }
    search_at_other_end(problem, solver, found)?;
    let size = norm(start);
    for family in CurveFamily::ALL {
        let Some(curve) = family.start(problem, options.boundary.interrupt)? else {
            continue;
        };
        let mut y = curve.clone();
        let solution = match solver.restarted(&mut y)? {
            true => Some(y),
            false => solver.moved(&curve, norm(&curve))?,
        };
        if let Some(y) = solution {
            found.add((y, solver.report(BoundaryStrategy::Polynomial)));
        }
    }
    for attempt in 0..options.starts {
        if solver.map.exhausted() {
            break;
        }
        if let Some(solution) = solver.by_scattered_descent(attempt, &mut random)? {
            found.add(solution);
        }
    }
    if let Ok(homotopy) = Homotopy::growing(problem) {
        let rest = vec![0.0; start.len()];
        follow(
            solver,
            &homotopy,
            &rest,
            size,
            BoundaryStrategy::Growing,
            found,
        )?;
    }
    for attempt in 0..options.starts {
        if solver.map.exhausted() {
            break;
        }
        if let Some((homotopy, from)) = solver.detour(start, attempt, &mut random)? {
            follow(
                solver,
                &homotopy,
                &from,
                size,
                BoundaryStrategy::Detour,
                found,
            )?;
        }
        let from = solver.scattered(start, attempt, &mut random);
        if let Some(homotopy) = solver.family_from(&from)? {
            follow(
                solver,
                &homotopy,
                &from,
                size,
                BoundaryStrategy::Moving,
                found,
            )?;
        }
    }
    Ok(())
}

/// Share of the limit of work for the reversed problem.
const SHARE: f64 = 0.82;

/// The start of a solution of the problem of a solver, run backwards.
fn reversed(solver: &mut Solver<'_>, y: &[f64]) -> Result<Vec<f64>> {
    solver.map.set_target(&solver.problem.target);
    let [.., a, second] = solver.map.end(y, Accuracy::FULL)?;
    Ok(solver.problem.reversed_start(&a, &second))
}

/// From the starts of the reversed problem.
fn search_at_other_end(
    problem: &Problem,
    solver: &mut Solver<'_>,
    found: &mut Found,
) -> Result<()> {
    let back = problem.reversed();
    let along_geodesic = geodesic(&back)?;
    let mut there = Solver::new(&back, solver.options);
    there.map.allow(SHARE);
    for flat in [back.flat()?, along_geodesic].into_iter().flatten() {
        let mut y = back.start_of(&flat);
        if !there.restarted(&mut y)? {
            continue;
        }
        let mut y = reversed(&mut there, &y)?;
        if solver.restarted(&mut y)? {
            found.add((y, solver.report(BoundaryStrategy::Reversed)));
        }
    }
    solver.join(&there);
    Ok(())
}

/// All solutions that a family passes.
fn follow(
    solver: &mut Solver<'_>,
    homotopy: &Homotopy,
    from: &[f64],
    size: f64,
    strategy: BoundaryStrategy,
    found: &mut Found,
) -> Result<()> {
    let mut passed = Vec::new();
    solver.follow(homotopy, from, size, MAX_STEPS, |y| {
        passed.push(y.to_vec());
        Next::Continue
    })?;
    for y in passed {
        found.add((y, solver.report(strategy)));
    }
    Ok(())
}

/// Displacement and end velocity along the geodesic between the end points; `None` if no geodesic is found.
fn geodesic(problem: &Problem) -> Result<Option<FlatData>> {
    let [s1, v1] = problem.end.each_ref().map(|x| x.as_ref());
    match FlatData::along_geodesic(s1, v1) {
        Ok((flat, _)) => Ok(Some(flat)),
        Err(error @ Error::Interrupted { .. }) => Err(error),
        Err(_) => Ok(None),
    }
}
