//! Several Riemannian cubics with the same boundary data.

use faer::MatRef;

use super::guess::FlatData;
use super::lines::{are_lines, of_vectors, to_both_vectors};
use super::problem::BoundaryProblem;
use super::random::Random;
use super::solver::{Reported, Solver};
use crate::cubic::boundary_options::BoundaryOptions;
use crate::cubic::riemannian_cubic::RiemannianCubic;
use crate::curve::Curve;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::manifold::only_bases::advised;
use crate::report::{StopReason, Strategy};
use crate::solve::gmres::norm;
use crate::space::{Kind, Quotient};

/// Work limit of a search, as a multiple of one solve.
const SEARCH_WORK: f64 = 4.0;

/// Options for finding several solutions of a boundary value problem.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{RiemannianCubic, SearchOptions};
/// use stiefel_rs::{Curve, Interrupt};
/// // A quarter of a circle from rest to rest; the other way round it is three quarters.
/// let (s0, s1, rest) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]], mat![[0.0], [0.0]]);
/// let options = SearchOptions { starts: 2, seed: 1, ..Default::default() };
/// let found = RiemannianCubic::all_from_boundary(
///     s0.as_ref(), rest.as_ref(), s1.as_ref(), rest.as_ref(), &options, Interrupt::NEVER,
/// )?;
/// // The cost is 12 angle^2, the cheapest comes first.
/// assert!((found[0].cost(Interrupt::NEVER)? / (12.0 * std::f64::consts::FRAC_PI_2.powi(2)) - 1.0).abs() < 1e-10);
/// assert!((found[1].cost(Interrupt::NEVER)? / found[0].cost(Interrupt::NEVER)? - 9.0).abs() < 1e-9);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct SearchOptions<'a> {
    /// Options for each solution.
    pub boundary: BoundaryOptions<'a>,
    /// Number of further starts. Between frames, of families of boundary data to follow: first from the cubics of flat space
    /// with an additional full turn, two for each principal direction and each plane in which the columns rotate, then from
    /// random initial data. Between subspaces, of random initial data for Newton's method.
    pub starts: u32,
    /// Seed of the random initial data: the same seed finds the same solutions.
    pub seed: u64,
    /// Solutions whose `(x', x'')` at the start differ by at most this, relative to `1 + |(x', x'')|`, count as one; in
    /// `[1e-10, 1]`.
    pub distinct: f64,
}

impl Default for SearchOptions<'_> {
    /// 4 further starts; relative difference `1e-6`.
    fn default() -> Self {
        SearchOptions {
            boundary: BoundaryOptions::default(),
            starts: 4,
            seed: 0,
            distinct: 1e-6,
        }
    }
}

impl SearchOptions<'_> {
    pub(crate) fn check(&self) -> Result<()> {
        self.boundary.check()?;
        if (1e-10..=1.0).contains(&self.distinct) {
            return Ok(());
        }
        Err(Error::InvalidArgument {
            name: "distinct",
            requirement: "between 1e-10 and 1",
            found: self.distinct,
        })
    }
}

impl RiemannianCubic {
    /// Riemannian cubics with the same boundary data that are found from several starts, cheapest first.
    ///
    /// Newton's method starts from the cubic of flat space (or from the guess). Descents to local minima of the cost
    /// start as in [`from_boundary`](Self::from_boundary), from the cubic of flat space, and from those with one or two additional
    /// full turns in one principal direction, or in a plane in which the columns rotate. Families of boundary data
    /// connect the curves of the cubics with one additional turn to the given data; every solution they pass is
    /// returned. `docs/development/rejected_alternatives.md` lists what each of these finds that the others miss. Other
    /// solutions may exist: on the sphere there are infinitely many.
    ///
    /// Principal directions of [subspaces](BoundaryOptions::quotient) turn by another half or full turn, and random initial
    /// data for Newton's method take the place of families. For lines, the result consists of the solutions on the sphere
    /// to both unit vectors of the last line.
    ///
    /// # Errors
    /// The errors of [`from_boundary`](Self::from_boundary); `NoConvergence` if no solution is found.
    ///
    /// # Examples
    /// ```
    /// use faer::mat;
    /// use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic, SearchOptions};
    /// use stiefel_rs::{Curve, Interrupt, Quotient};
    /// // From rest to rest between two lines of the plane, by the angle 1 or by pi - 1 the other way.
    /// let (y0, y1, rest) = (mat![[1.0], [0.0]], mat![[1.0_f64.cos()], [1.0_f64.sin()]], mat![[0.0], [0.0]]);
    /// let [y0, y1, rest] = [&y0, &y1, &rest].map(|a| a.as_ref());
    /// let boundary = BoundaryOptions { quotient: Quotient::Subspaces, ..Default::default() };
    /// let options = SearchOptions { boundary, ..Default::default() };
    /// let found = RiemannianCubic::all_from_boundary(y0, rest, y1, rest, &options, Interrupt::NEVER)?;
    /// assert!((found[0].cost(Interrupt::NEVER)? - 12.0).abs() < 1e-9);
    /// assert!((found[1].cost(Interrupt::NEVER)? - 12.0 * (std::f64::consts::PI - 1.0).powi(2)).abs() < 1e-8);
    /// # Ok::<(), stiefel_rs::Error>(())
    /// ```
    pub fn all_from_boundary(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &SearchOptions<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Self>> {
        options.check()?;
        let data = [s0, v0, s1, v1];
        if are_lines(data, &options.boundary) {
            return all_between_lines(data, options, interrupt);
        }
        let found = all_between(data, options, interrupt);
        match options.boundary.quotient {
            Quotient::Frames => found.map_err(|error| advised(error, s0, s1)),
            Quotient::Subspaces => found,
        }
    }
}

/// The solutions between frames, or between subspaces of several dimensions.
///
/// # Errors
/// As [`RiemannianCubic::all_from_boundary`], without the hint that the points may be mere bases.
fn all_between(
    data: [MatRef<'_, f64>; 4],
    options: &SearchOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<Vec<RiemannianCubic>> {
    let problem = BoundaryProblem::new(data, &options.boundary)?;
    let start = match options.boundary.guess {
        Some((a, j)) => problem.start_from(data[0], a, j)?,
        None => problem.flat_start(problem.flat()?.as_ref()),
    };
    let mut solver = Solver::new(&problem, &options.boundary, interrupt);
    solver.work.allow(SEARCH_WORK);
    let mut found = DistinctSolutions::new(options.distinct);
    search(&problem, &mut solver, &start, options, &mut found)?;
    if found.solutions.is_empty() {
        solver.measure(&start)?;
        return Err(solver.failure());
    }
    let curve = |(solution, report): Reported| {
        Ok(problem.curve(solution.into_taylor(&problem, interrupt)?, report))
    };
    let curves = found.solutions.into_iter().map(curve);
    ranked(curves.collect::<Result<_>>()?, interrupt)
}

/// All solutions on the sphere to a unit vector of the last line and to its negative, cheapest first.
///
/// # Errors
/// As [`RiemannianCubic::all_from_boundary`].
fn all_between_lines(
    data: [MatRef<'_, f64>; 4],
    options: &SearchOptions<'_>,
    interrupt: Interrupt<'_>,
) -> Result<Vec<RiemannianCubic>> {
    let options = SearchOptions {
        boundary: of_vectors(&options.boundary),
        ..*options
    };
    let both = to_both_vectors(data, |data: [MatRef<'_, f64>; 4]| {
        all_between(data, &options, interrupt)
    });
    let (mut curves, mut lost) = (Vec::new(), None);
    for found in both? {
        match found {
            Ok(found) => curves.extend(found),
            Err(error) if error.is_interrupted() => return Err(error),
            Err(error) => lost = Some(error),
        }
    }
    match lost {
        Some(error) if curves.is_empty() => Err(error),
        _ => ranked(
            curves.iter().map(RiemannianCubic::of_lines).collect(),
            interrupt,
        ),
    }
}

/// Sorts by cost, cheapest first.
///
/// # Errors
/// The errors of [`Curve::cost`].
fn ranked(curves: Vec<RiemannianCubic>, interrupt: Interrupt<'_>) -> Result<Vec<RiemannianCubic>> {
    let mut ranked = Vec::new();
    for curve in curves {
        ranked.push((curve.cost(interrupt)?, curve));
    }
    ranked.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    Ok(ranked.into_iter().map(|(_, curve)| curve).collect())
}

/// Distinct solutions found so far.
struct DistinctSolutions {
    solutions: Vec<Reported>,
    distinct: f64,
}

impl DistinctSolutions {
    /// An empty set; solutions that differ by at most `distinct` count as one.
    fn new(distinct: f64) -> Self {
        DistinctSolutions {
            solutions: Vec::new(),
            distinct,
        }
    }

    fn add(&mut self, (solution, report): Reported) {
        let y = &solution.start;
        let near = |(other, _): &Reported| {
            let pairs = y.iter().zip(&other.start);
            let difference: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
            norm(&difference) <= self.distinct * (1.0 + norm(y))
        };
        if !self.solutions.iter().any(near) {
            self.solutions.push((solution, report));
        }
    }
}

fn search(
    problem: &BoundaryProblem,
    solver: &mut Solver<'_>,
    start: &[f64],
    options: &SearchOptions<'_>,
    found: &mut DistinctSolutions,
) -> Result<()> {
    if let Some(solution) = solver.restarted(start)? {
        found.add((solution, solver.report(Strategy::Direct)));
    }
    if solver.has_few_steps() {
        solver.refuse(StopReason::MaxIterations);
        return Ok(());
    }
    if let Some(solution) = solver.by_descents()? {
        found.add(solution);
    }
    let (flat, quotient) = (problem.flat()?, problem.kind().quotient);
    let turns = match quotient {
        Quotient::Frames => [1.0, 2.0],
        Quotient::Subspaces => [0.5, 1.0],
    };
    let [once, twice] = match &flat {
        Some(flat) => [
            turned(problem, flat, turns[0])?,
            turned(problem, flat, turns[1])?,
        ],
        None => [Vec::new(), Vec::new()],
    };
    for flat in flat.iter().chain(&once).chain(&twice) {
        if let Some(solution) = solver.by_descent_along(flat)? {
            found.add(solution);
        }
    }
    let (size, mut random) = (norm(start), Random::new(options.seed));
    for attempt in 0..options.starts as usize {
        if solver.work.is_done() {
            break;
        }
        if quotient == Quotient::Subspaces {
            let from = solver.scattered(start, attempt, &mut random);
            if let Some(solution) = solver.restarted(&from)? {
                found.add((solution, solver.report(Strategy::Direct)));
            }
            continue;
        }
        let from = match once.get(attempt) {
            Some(flat) => problem.start_of(flat),
            None => solver.scattered(start, attempt, &mut random),
        };
        if let Some(homotopy) = solver.family_from(&from)? {
            for passed in solver.passed_by(&homotopy, &from, size)? {
                found.add(passed);
            }
        }
    }
    Ok(())
}

/// Cubics of flat space with `turns` additional full turns. Embedded complex displacements have every principal
/// direction twice, and turn in both.
fn turned(problem: &BoundaryProblem, flat: &FlatData, turns: f64) -> Result<Vec<FlatData>> {
    let mut all = match problem.kind() == Kind::REAL_FRAMES {
        true => Vec::new(),
        false => flat.turned_together(turns)?,
    };
    all.extend(flat.turned(turns)?);
    Ok(all)
}
