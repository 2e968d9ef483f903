//! A chain in few dimensions: every knot has an orthogonal frame, and vectors are coordinates in it.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::chain::{Chain, JOINS, Means, Movable};
use super::motion::Motion;
use super::neighbours::{Joining, NeighbourLink};
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::initial::{Horizontal, complete_over};
use crate::cubic::taylor::packing::{pack, read_vector, unpack, write_vector};
use crate::cubic::taylor::state::State;
use crate::cubic::taylor::work::{work_of_curve, work_of_join};
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::decomp::thin_q;
use crate::linalg::lanes::LANES;
use crate::manifold::carrier::turned;
use crate::manifold::grassmann::joining::join_spans;
use crate::manifold::quasi_geodesic::EndpointProblem;
use crate::manifold::{Grassmann, QuasiGeodesic, Stiefel};
use crate::solve::direction::Direction;
use crate::space::{Kind, Quotient, Shape};
use crate::spline::chains::integrated_legs::IntegratedLegs;
use crate::spline::joining_curves::JOIN;
use crate::threads::{self, scaled};

/// Microseconds of a link between rotations; 3.8 on St(4,2), where a quasi-geodesic joins the points.
const LINK: f64 = 0.3;

/// Number of legs from which integrating eight at once is faster.
const WORTHWHILE: usize = 3;

/// Knots with frames of shape `(r, r)`, whose first columns are the point.
pub(crate) struct Framed<'a> {
    blocks: Sizes,
    /// Columns of the points: one more than the blocks have if `St(r, r)` is solved as `St(r, r - 1)`.
    columns: usize,
    frames: Arc<[Mat<f64>]>,
    lengths: Vec<f64>,
    tension: f64,
    links: Vec<NeighbourLink>,
    interrupt: Interrupt<'a>,
}

impl<'a> Framed<'a> {
    /// Built for knots with the given frames, whose first columns are the points.
    ///
    /// # Errors
    /// `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents`, wrapped in `AtKnot`.
    pub(crate) fn new(
        kind: Kind,
        frames: Arc<[Mat<f64>]>,
        columns: usize,
        lengths: Vec<f64>,
        interrupt: Interrupt<'a>,
    ) -> Result<Self> {
        let blocks = blocks(kind, [frames[0].nrows(), columns]);
        let links = threads::map(
            lengths.len(),
            scaled(LINK, frames[0].shape()),
            || Joining::new(blocks, columns),
            |joining, leg| {
                let ends = [&frames[leg], &frames[leg + 1]];
                let link = joining.link(ends, blocks, columns);
                link.map_err(|error| error.at_knot(leg))
            },
        )?;
        Ok(Framed {
            blocks,
            columns,
            frames,
            lengths,
            tension: 0.0,
            links,
            interrupt,
        })
    }

    /// The same chain for curves in tension.
    pub(crate) fn in_tension(mut self, tension: f64) -> Self {
        self.tension = tension;
        self
    }

    /// Tension of the curves.
    pub(crate) fn tension(&self) -> f64 {
        self.tension
    }

    /// The tension in the time of a leg.
    fn leg_tension(&self, leg: usize) -> f64 {
        self.tension * self.lengths[leg].powi(2)
    }

    /// The largest distance between neighbours, along the curves that join them.
    pub(crate) fn longest(&self) -> f64 {
        let lengths = self
            .links
            .iter()
            .map(|link| self.blocks.square(&link.displacement));
        lengths.fold(0.0, f64::max).sqrt()
    }

    /// The space whose equations are solved.
    pub(crate) fn shape(&self) -> Shape {
        self.blocks.shape()
    }

    /// Sizes of the blocks of the space whose equations are solved.
    pub(crate) fn blocks(&self) -> Sizes {
        self.blocks
    }

    /// Columns of a point.
    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    /// Frames at the knots, shape `(r, r)`, with the points as first columns.
    pub(crate) fn frames(&self) -> Arc<[Mat<f64>]> {
        Arc::clone(&self.frames)
    }

    /// For each leg, the frame of the next knot relative to the frame of the knot where the leg starts.
    pub(crate) fn targets(&self) -> impl Iterator<Item = &[f64]> {
        self.links.iter().map(|link| link.next.as_slice())
    }

    /// The state of a leg's cubic where it has the given frame and vectors, in the time of the leg.
    pub(crate) fn state_in(&self, frame: &Mat<f64>, leg: usize, vectors: &[f64]) -> State {
        let vectors = unpack::<3>(vectors, self.blocks);
        let vectors = if self.blocks.k < self.columns {
            vectors.map(|x| full(&x))
        } else {
            vectors
        };
        let normals = frame.nrows() - self.columns;
        let shape = Sizes::new(normals, self.columns, self.blocks.quotient);
        let state = State::in_blocks(shape, frame, vectors.each_ref());
        state.in_tension(self.leg_tension(leg))
    }

    fn point(&self, knot: usize) -> MatRef<'_, f64> {
        self.frames[knot].as_ref().subcols(0, self.columns)
    }

    /// The tangent vector with the given coordinates.
    pub(crate) fn tangent(&self, knot: usize, v: &[f64]) -> Mat<f64> {
        let r = self.frames[knot].nrows();
        let mut vector = vec![0.0; r * self.columns];
        write_vector(&mut vector, v, r, self.blocks);
        &self.frames[knot] * MatRef::from_column_major_slice(&vector, r, self.columns)
    }

    /// The frame of a knot after moving it along a tangent vector.
    fn moved_frame(&self, knot: usize, shift: &[f64]) -> Result<Mat<f64>> {
        let k = self.columns;
        let tangent = self.tangent(knot, shift);
        let curve = QuasiGeodesic::from_velocity(self.point(knot), tangent.as_ref())?;
        let mut frame = turned(&curve, self.frames[knot].as_ref(), 1.0);
        let point = curve.point(1.0)?;
        frame.as_mut().subcols_mut(0, k).copy_from(point);
        // Removes the round-off accumulated over many moves.
        Ok(thin_q(frame.as_ref()))
    }
}

/// Block sizes of a problem with points of shape `(r, k)`. `St(r, r)` is solved as `St(r, r - 1)`, to which each of its
/// components is isometric, since the other columns determine the last one. `St(1, 1)`, two points, is not reduced.
pub(crate) fn blocks(kind: Kind, [r, k]: [usize; 2]) -> Sizes {
    let columns = if kind == Kind::REAL_FRAMES && r == k && k > 1 {
        k - 1
    } else {
        k
    };
    Sizes::of_kind(r - columns, columns, kind)
}

/// Frames whose first columns are the points. For subspaces they are carried along from one to the next.
///
/// # Errors
/// `NoJoiningCurve` wrapped in `AtKnot`, for subspaces.
pub(crate) fn frames(kind: Kind, points: &[Mat<f64>]) -> Result<Vec<Mat<f64>>> {
    let complete = |point: &Mat<f64>| complete_over(kind.field, point.as_ref());
    let (r, k) = points[0].shape();
    if r == k {
        return Ok(points.to_vec());
    }
    if kind.quotient == Quotient::Frames {
        return Ok(points.iter().map(complete).collect());
    }
    let mut problem = EndpointProblem::new(r, k);
    let mut frames = vec![complete(&points[0])];
    for knot in 1..points.len() {
        let ends = [knot - 1, knot].map(|knot| points[knot].as_ref());
        let (curve, _) =
            join_spans(ends[0], ends[1], &mut problem).map_err(|error| error.at_knot(knot - 1))?;
        let mut frame = match points[knot] == points[0] {
            // The last frame of a closed chain.
            true => frames[0].clone(),
            false => turned(&curve, frames[knot - 1].as_ref(), 1.0),
        };
        frame.as_mut().subcols_mut(0, k).copy_from(&points[knot]);
        frames.push(frame);
    }
    Ok(frames)
}

/// Integrates legs and carries vectors.
pub(crate) struct Worker<'a> {
    leg: IntegratedLegs<'a>,
    scratch: Vec<f64>,
}

impl<'a> Chain for Framed<'a> {
    type Worker = Worker<'a>;

    fn size(&self) -> usize {
        self.blocks.dim()
    }

    fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    fn worker(&self) -> Worker<'a> {
        let r = self.blocks.m + self.blocks.k;
        Worker {
            leg: IntegratedLegs::new(self.blocks, self.interrupt),
            scratch: vec![0.0; 2 * r * self.columns],
        }
    }

    fn displacement_into(&self, leg: usize, out: &mut [f64]) {
        out.copy_from_slice(&self.links[leg].displacement);
    }

    fn carry_into(
        &self,
        worker: &mut Worker<'a>,
        leg: usize,
        way: Direction,
        v: &[f64],
        out: &mut [f64],
    ) -> Result<()> {
        let Some([left, right]) = &self.links[leg].carrying else {
            out.copy_from_slice(v);
            return Ok(());
        };
        let Sizes { m, k, .. } = self.blocks;
        let (r, columns) = (m + k, self.columns);
        let (vector, moved) = worker.scratch.split_at_mut(r * columns);
        write_vector(vector, v, r, self.blocks);
        let transposed = way == Direction::Backward;
        // left v, then (left v) right; transposed factors for the opposite direction.
        for col in 0..columns {
            for row in 0..r {
                moved[row + r * col] = (0..r)
                    .map(|i| at(left, r, row, i, transposed) * vector[i + r * col])
                    .sum();
            }
        }
        for col in 0..columns {
            for row in 0..r {
                vector[row + r * col] = (0..columns)
                    .map(|i| moved[row + r * i] * at(right, columns, i, col, transposed))
                    .sum();
            }
        }
        read_vector(vector, out, r, self.blocks);
        Ok(())
    }

    fn ends_into(
        &self,
        worker: &mut Worker<'a>,
        first: usize,
        starts: &[Vec<f64>],
        means: &Means<'_>,
        values: &mut [f64],
        distances: &mut [f64],
    ) -> Result<()> {
        let size = values.len() / starts.len();
        let Means {
            accuracy,
            speed,
            work,
        } = *means;
        worker.leg.allow(speed);
        if starts.len() >= WORTHWHILE {
            // The last leg fills unused lanes.
            let at = |lane: usize| lane.min(starts.len() - 1);
            let next = std::array::from_fn(|lane| self.links[first + at(lane)].next.as_slice());
            let padded = std::array::from_fn(|lane| starts[at(lane)].clone());
            let tension = std::array::from_fn(|lane| self.leg_tension(first + at(lane)));
            let mut all = vec![0.0; size * LANES];
            let found = worker
                .leg
                .arrive_abreast_into(&padded, next, tension, accuracy, &mut all);
            work.count(worker.leg.work());
            match found {
                Ok(found) => {
                    distances.copy_from_slice(&found[..starts.len()]);
                    values.copy_from_slice(&all[..values.len()]);
                    return Ok(());
                }
                Err(error) if error.is_interrupted() => return Err(error),
                // The failing leg is identified below.
                Err(_) => {}
            }
        }
        for (i, (start, values)) in starts.iter().zip(values.chunks_exact_mut(size)).enumerate() {
            let next = &self.links[first + i].next;
            let tension = self.leg_tension(first + i);
            let found = worker.leg.ends_into(start, next, tension, accuracy, values);
            work.count(worker.leg.work());
            distances[i] = found.map_err(|error| error.at_knot(first + i))?;
        }
        Ok(())
    }

    fn state(&self, leg: usize, start: &[f64]) -> (Option<Mat<f64>>, State) {
        (None, self.state_in(&self.frames[leg], leg, start))
    }

    fn work_of_leg(&self) -> f64 {
        work_of_leg(self.links.len(), self.blocks)
    }
}

impl Movable for Framed<'_> {
    fn work_of_knot(&self) -> f64 {
        JOINS * work_of_join(self.blocks)
    }

    /// Frames are carried along, so coordinates do not change.
    fn moved(&self, shifts: &[f64], _: &mut Motion) -> Result<Self> {
        let shift = |knot: usize| &shifts[self.size() * knot..][..self.size()];
        let frames = threads::map(
            self.frames.len(),
            scaled(JOIN, self.frames[0].shape()),
            || (),
            |(), knot| {
                let moved = self.moved_frame(knot, shift(knot));
                moved.map_err(|error| error.at_knot(knot))
            },
        )?;
        let lengths = self.lengths.clone();
        let (kind, columns) = (self.blocks.kind(), self.columns);
        let moved = Framed::new(kind, frames.into(), columns, lengths, self.interrupt)?;
        Ok(moved.in_tension(self.tension))
    }

    fn towards(&self, knot: usize, point: &Mat<f64>) -> Result<Vec<f64>> {
        let ((r, k), kind) = (point.shape(), self.blocks.kind());
        let v = match kind.quotient {
            Quotient::Frames => Stiefel::new(r, k)?.log(self.point(knot), point.as_ref())?,
            Quotient::Subspaces => Grassmann::new(r, k)?.log(self.point(knot), point.as_ref())?,
        };
        Ok(coordinates(kind, self.frames[knot].as_ref(), v.as_ref()))
    }

    fn square(&self, _: usize, v: &[f64]) -> f64 {
        self.blocks.square(v)
    }
}

/// Typical work of integrating one of so many legs: eight at once take at most half as long.
pub(crate) fn work_of_leg(legs: usize, blocks: Sizes) -> f64 {
    let share = if legs < WORTHWHILE { 1.0 } else { 0.5 };
    share * work_of_curve(blocks)
}

fn at(a: &[f64], rows: usize, row: usize, col: usize, transposed: bool) -> f64 {
    if transposed {
        a[col + rows * row]
    } else {
        a[row + rows * col]
    }
}

/// Coordinates of a tangent vector at the first columns of a frame.
pub(crate) fn coordinates(kind: Kind, frame: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Vec<f64> {
    let blocks = blocks(kind, [v.nrows(), v.ncols()]);
    pack(
        blocks,
        &[Horizontal::of_tangent(frame, v.subcols(0, blocks.k))],
    )
}

/// The vector of `St(r, r)` that corresponds to a vector of `St(r, r - 1)`.
fn full(x: &Horizontal) -> Horizontal {
    let k = x.omega.nrows();
    let omega = Mat::from_fn(k + 1, k + 1, |i, j| match (i < k, j < k) {
        (true, true) => x.omega[(i, j)],
        (false, true) => x.normal[(0, j)],
        (true, false) => -x.normal[(0, i)],
        (false, false) => 0.0,
    });
    Horizontal {
        omega,
        normal: Mat::zeros(0, k + 1),
    }
}
