//! Splines through knots with frames: by series or collocation where the legs are slow; legs that are integrated elsewhere.

use std::sync::Arc;

use faer::Mat;

use super::chain::{Chain, Motion, Piece};
use super::ends::Ends;
use super::framed::Framed;
use super::interpolation::Interpolation;
use super::iteration::Iteration;
use super::solvable::{Effort, Solution, Solvable, Start};
use crate::collocation;
use crate::cubic::lazy_path::{LazyPath, Legs};
use crate::cubic::path::{Path, State};
use crate::cubic::reduced::{Blocks, Sized};
use crate::cubic::taylor::Accuracy;
use crate::cubic::work::of_products;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::legs::{Curves, Dense, Knots, Options};
use crate::linalg::field::multiply;
use crate::linalg::lanes::Lanes;
use crate::shooting;
use crate::space::{FixedFrames, Frames, Homogeneous};

/// Of a start whose legs turn more, in radians, the legs are integrated from the first. With 6, of 128 splines with end velocities
/// of 10 and more 15 cost two to four times as much and 5 are lost.
const FAST: f64 = 3.0;

/// Dimensions from which on sweeps of collocation take the place of series.
const MANY: usize = 8;

/// Third derivatives of a start are integrated to this share.
const START_ACCURACY: f64 = 1e-6;

impl Solvable for Framed<'_> {
    fn solve(&self, ends: &Ends, start: Start, effort: Effort<'_>) -> Result<Solution> {
        let problem = Interpolation::new(self, ends)?;
        let [is_flat, is_near] = [
            matches!(start, Start::Flat),
            matches!(start, Start::Near(_)),
        ];
        let motion = match start {
            Start::Flat => problem.start()?,
            Start::From(motion) | Start::Near(motion) => motion,
        };
        if self.start_speed(ends, &motion) <= FAST {
            let found = self.by_polynomials(ends, motion.clone(), is_flat, effort)?;
            if found.report.converged || effort.is_spent(found.report.iterations) {
                return Ok(found);
            }
        }
        // What was tried counts as work, not as iterations: closed chains on St(5, 3) need most of theirs.
        match is_near {
            true => Iteration::solve_near(&problem, motion, effort),
            false => Iteration::solve(&problem, motion, effort),
        }
    }

    fn piece(&self, leg: usize, solution: &Solution, interrupt: Interrupt<'_>) -> Result<Piece> {
        match &solution.polynomials {
            Some(legs) => Ok((None, LazyPath::of_leg(Arc::clone(legs), leg))),
            None => self.integrated(leg, &solution.motion, interrupt),
        }
    }
}

impl Framed<'_> {
    /// The largest turn of a leg by a motion's velocities, or from a knot to the next one.
    fn start_speed(&self, ends: &Ends, motion: &Motion) -> f64 {
        let [r, k] = self.shape();
        let velocities = &motion.entries[..self.size() * (self.lengths().len() + 1)];
        self.knots(ends).speed(Frames { r, k }, velocities)
    }

    /// By series or collocation.
    fn by_polynomials(
        &self,
        ends: &Ends,
        motion: Motion,
        is_flat: bool,
        effort: Effort<'_>,
    ) -> Result<Solution> {
        let [r, k] = self.shape();
        match (r, k) {
            (3, 1) => self.in_space(FixedFrames::<3, 1>, ends, motion, is_flat, effort),
            (3, 2) => self.in_space(FixedFrames::<3, 2>, ends, motion, is_flat, effort),
            (r, k) => self.in_space(Frames { r, k }, ends, motion, is_flat, effort),
        }
    }

    fn knots<'a>(&'a self, ends: &'a Ends) -> Knots<'a> {
        Knots {
            lengths: self.lengths(),
            targets: self.targets().collect(),
            ends,
        }
    }

    fn in_space(
        &self,
        space: impl Homogeneous + 'static,
        ends: &Ends,
        mut motion: Motion,
        is_flat: bool,
        effort: Effort<'_>,
    ) -> Result<Solution> {
        let knots = self.knots(ends);
        let before = motion.clone();
        let third_derivative =
            |leg: usize, times: &[f64]| self.third_derivative(&before, leg, times);
        let may_go_on = |products: f64| {
            effort.work.count(of_products(products));
            !effort.work.is_done()
        };
        let options = Options {
            third_derivative: (!is_flat).then_some(&third_derivative),
            tolerance: effort.tolerance,
            max_iterations: effort.max_iterations,
            may_go_on: &may_go_on,
            interrupt: effort.interrupt,
        };
        let knot = space.dim() * (self.lengths().len() + 1);
        let (velocities, bends) = motion.entries.split_at_mut(knot);
        let (report, curves) = match space.dim() < MANY {
            true => shooting::solve::<Lanes, _>(space, &knots, velocities, bends, &options)?,
            false => collocation::solve::<Lanes, _>(space, &knots, velocities, bends, &options)?,
        };
        Ok(Solution {
            motion,
            report,
            polynomials: curves.map(|curves| self.legs(curves)),
        })
    }

    /// `x'''` of a leg of a motion at some times, integrated.
    fn third_derivative(&self, motion: &Motion, leg: usize, times: &[f64]) -> Result<Vec<f64>> {
        let (_, state) = self.state(leg, &motion.start(leg, self.lengths()[leg]));
        let mut path = Path::at(state, Accuracy::of_tolerance(START_ACCURACY));
        path.extend_to(1.0, Interrupt::NEVER)
            .map_err(|error| error.at_knot(leg))?;
        Ok(path.third_derivatives(times))
    }

    /// Makes the curves of the legs.
    fn legs(&self, curves: Box<dyn Curves>) -> Arc<Legs> {
        let (frames, shape, columns) = (self.frames(), self.shape(), self.columns());
        Arc::new(move |leg| {
            let (polynomials, which) = curves.of_leg(leg);
            path(polynomials, which, &frames[leg], shape, columns)
        })
    }
}

/// The polynomials of a leg that starts with a frame as a curve.
fn path(
    polynomials: &Dense,
    leg: usize,
    frame: &Mat<f64>,
    [r, k]: [usize; 2],
    columns: usize,
) -> Path {
    let space = Frames { r, k };
    let blocks = Sized {
        m: r - columns,
        k: columns,
    };
    let (square, rows) = (r * r, blocks.r::<f64>());
    let terms = polynomials.order + 1;
    let frame: Vec<f64> = row_by_row(frame);
    let mut product = vec![0.0; square];
    let mut points = vec![0.0; terms * rows * columns];
    let turns = polynomials.frames(leg, square).chunks_exact(square);
    for (points, turn) in points.chunks_exact_mut(rows * columns).zip(turns) {
        multiply(r, &frame, turn, &mut product);
        for (col, points) in points.chunks_exact_mut(rows).enumerate() {
            for (row, point) in points.iter_mut().enumerate().take(r) {
                *point = product[row * r + col];
            }
        }
    }
    let write = |x: &[f64], out: &mut Vec<f64>| {
        let mut matrix = vec![0.0; square];
        space.matrix_into(x, &mut matrix);
        push_blocks(&matrix, [r, columns], out);
    };
    let mut vectors = Vec::with_capacity(terms * r * columns);
    for x in polynomials.x(leg, space.dim()).chunks_exact(space.dim()) {
        write(x, &mut vectors);
    }
    let state = |end: usize, frame: &[f64]| {
        let mut entries: Vec<f64> = (0..square).map(|i| frame[(i % r) * r + i / r]).collect();
        for x in polynomials.end(leg, end, space.dim()) {
            write(x, &mut entries);
        }
        State::of_entries(blocks, end as f64, entries)
    };
    let first = state(0, &frame);
    multiply(r, &frame, polynomials.last_frame(leg, square), &mut product);
    Path::of_polynomial(
        [first, state(1, &product)],
        polynomials.order,
        points,
        vectors,
    )
}

fn row_by_row(a: &Mat<f64>) -> Vec<f64> {
    let rows = a.row_iter();
    rows.flat_map(|row| row.iter().copied().collect::<Vec<_>>())
        .collect()
}

/// `omega` and `b` of a skew matrix, row by row, each column by column.
fn push_blocks(matrix: &[f64], [r, columns]: [usize; 2], out: &mut Vec<f64>) {
    for rows in [0..columns, columns..r] {
        for col in 0..columns {
            out.extend(rows.clone().map(|row| matrix[row * r + col]));
        }
    }
}
