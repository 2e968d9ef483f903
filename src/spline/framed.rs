//! A chain of few dimensions: every knot has an orthogonal frame, and vectors are coordinates in it.

use faer::{Mat, MatRef, Scale};

use super::chain::{Chain, Way};
use crate::cubic::guess::turned;
use crate::cubic::initial::Horizontal;
use crate::cubic::leg::{Leg, leg};
use crate::cubic::problem::{entries, pack};
use crate::cubic::reduced::Sized;
use crate::cubic::taylor::Accuracy;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::SkewExp;
use crate::manifold::QuasiGeodesic;

/// Knots with frames, shape `(r, r)`, the point as first columns.
pub(super) struct Framed<'a> {
    blocks: Sized,
    /// Of the points: one more than that of the blocks where `St(r, r)` is solved as `St(r, r - 1)`.
    columns: usize,
    lengths: Vec<f64>,
    links: Vec<Link>,
    interrupt: Interrupt<'a>,
}

/// What a leg knows of its ends, matrices column by column.
struct Link {
    /// The next knot's frame in that of the knot where the leg starts, shape `(r, r)`.
    next: Vec<f64>,
    /// A vector `v` is carried to `left v right`, in the frames of the two knots.
    left: Vec<f64>,
    right: Vec<f64>,
    displacement: Vec<f64>,
}

impl Link {
    /// The part `share` of the way along a quasi-geodesic between two knots. What lies there is moved on to the second knot by
    /// an isometry from the left, so for less than the whole way the leg is shorter and everything else is as before.
    fn new(
        curve: &QuasiGeodesic,
        frames: [&Mat<f64>; 2],
        share: f64,
        blocks: Sized,
    ) -> Result<Self> {
        let k = curve.k();
        let turn = |t: f64| -> Result<Mat<f64>> {
            let mut turn = Mat::zeros(k, k);
            SkewExp::new(k).exp_into(turn.as_mut(), curve.omega(), t)?;
            Ok(turn)
        };
        let mut end = frames[1].clone();
        if share < 1.0 {
            end = turned(curve, end.as_ref(), share - 1.0);
            let point = end.as_ref().subcols(0, k) * turn(share - 1.0)?;
            end.as_mut().subcols_mut(0, k).copy_from(point);
        }
        let displacement = curve.initial_velocity() * Scale(share);
        let displacement = displacement.as_ref().subcols(0, blocks.k);
        Ok(Link {
            next: entries(&(frames[0].transpose() * &end)),
            left: entries(&(end.transpose() * turned(curve, frames[0].as_ref(), share))),
            right: entries(&turn(share)?),
            displacement: pack(&[Horizontal::of_tangent(frames[0].as_ref(), displacement)]),
        })
    }
}

impl<'a> Framed<'a> {
    /// For quasi-geodesics between knots with the given frames, each run through up to `share`.
    ///
    /// # Errors
    /// Those of an exponential.
    pub(super) fn new(
        blocks: Sized,
        curves: &[QuasiGeodesic],
        frames: &[Mat<f64>],
        lengths: &[f64],
        share: f64,
        interrupt: Interrupt<'a>,
    ) -> Result<Self> {
        let links = curves
            .iter()
            .zip(frames.windows(2))
            .map(|(curve, ends)| Link::new(curve, [&ends[0], &ends[1]], share, blocks))
            .collect::<Result<_>>()?;
        Ok(Framed {
            blocks,
            columns: curves[0].k(),
            lengths: lengths.to_vec(),
            links,
            interrupt,
        })
    }
}

/// Integrates legs and carries vectors.
pub(super) struct Worker<'a> {
    leg: Box<dyn Leg + 'a>,
    scratch: Vec<f64>,
}

impl<'a> Chain for Framed<'a> {
    type Worker = Worker<'a>;

    fn size(&self) -> usize {
        let Sized { m, k } = self.blocks;
        k * k.saturating_sub(1) / 2 + m * k
    }

    fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    fn worker(&self) -> Worker<'a> {
        let r = self.blocks.m + self.blocks.k;
        Worker {
            leg: leg(self.blocks, self.interrupt),
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
        way: Way,
        v: &[f64],
        out: &mut [f64],
    ) -> Result<()> {
        let Sized { m, k } = self.blocks;
        let (r, columns, link) = (m + k, self.columns, &self.links[leg]);
        let (vector, moved) = worker.scratch.split_at_mut(r * columns);
        write_vector(vector, v, [r, k]);
        let transposed = way == Way::Back;
        // left v, then (left v) right; transposed factors on the way back.
        for col in 0..columns {
            for row in 0..r {
                moved[row + r * col] = (0..r)
                    .map(|i| at(&link.left, r, row, i, transposed) * vector[i + r * col])
                    .sum();
            }
        }
        for col in 0..columns {
            for row in 0..r {
                vector[row + r * col] = (0..columns)
                    .map(|i| moved[row + r * i] * at(&link.right, columns, i, col, transposed))
                    .sum();
            }
        }
        read_vector(vector, out, [r, k]);
        Ok(())
    }

    fn arrive_into(
        &self,
        worker: &mut Worker<'a>,
        leg: usize,
        start: &[f64],
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<f64> {
        let next = &self.links[leg].next;
        worker.leg.arrive_into(start, next, accuracy, values)
    }

    fn derivative(
        &self,
        worker: &mut Worker<'a>,
        leg: usize,
        start: &[f64],
        accuracy: Accuracy,
    ) -> Result<Option<Mat<f64>>> {
        let next = &self.links[leg].next;
        worker.leg.derivative(start, next, accuracy).map(Some)
    }

    fn derivative_work(&self) -> f64 {
        // Dual numbers take half a residual for a direction; small matrices take the rest.
        3.0 + 1.5 * self.size() as f64
    }
}

fn at(a: &[f64], rows: usize, row: usize, col: usize, transposed: bool) -> f64 {
    if transposed {
        a[col + rows * row]
    } else {
        a[row + rows * col]
    }
}

/// The vector `[omega; b]` with the given coordinates, or all of `[[omega, -b^T], [b, 0]]` where there is room for it.
fn write_vector(out: &mut [f64], v: &[f64], [r, k]: [usize; 2]) {
    let mut v = v.iter();
    let mut next = || *v.next().expect("as many as coordinates");
    for col in 0..k {
        out[col + r * col] = 0.0;
        for row in 0..col {
            let entry = next();
            out[row + r * col] = entry;
            out[col + r * row] = -entry;
        }
    }
    let all = out.len() == r * r && r == k + 1;
    for col in 0..k {
        for row in k..r {
            let entry = next();
            out[row + r * col] = entry;
            if all {
                out[col + r * row] = -entry;
            }
        }
    }
    if all {
        out[r * r - 1] = 0.0;
    }
}

/// Coordinates of the horizontal part.
fn read_vector(vector: &[f64], out: &mut [f64], [r, k]: [usize; 2]) {
    let mut out = out.iter_mut();
    let mut write = |x: f64| *out.next().expect("as many as coordinates") = x;
    for col in 0..k {
        for row in 0..col {
            write(0.5 * (vector[row + r * col] - vector[col + r * row]));
        }
    }
    for col in 0..k {
        for row in k..r {
            write(vector[row + r * col]);
        }
    }
}

/// Coordinates of a tangent vector at the first columns of a frame.
pub(super) fn coordinates(frame: MatRef<'_, f64>, v: MatRef<'_, f64>, blocks: Sized) -> Vec<f64> {
    pack(&[Horizontal::of_tangent(frame, v.subcols(0, blocks.k))])
}
