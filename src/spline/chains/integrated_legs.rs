//! Legs of smoothing splines, integrated by Taylor steps on their blocks.
//!
//! From `(x, x', x'')` at the identity the frame reaches `g`. With the next knot's frame `P` and `M = P^T g`,
//!
//! ```math
//! \mathrm{hor}(M I_k),\qquad \mathrm{hor}(M x),\qquad \mathrm{hor}(M x')\qquad\text{at } t = 1
//! ```
//!
//! are the distance from the next knot, and velocity and covariant acceleration there; `hor(M x'')` is the third
//! vector.

use std::ops::Mul;

use faer::{Mat, MatRef};

use crate::cubic::taylor::blocks::{BlockSeries, BlockSizes, Sizes};
use crate::cubic::taylor::initial::{Coordinates, Horizontal};
use crate::cubic::taylor::march::{Accuracy, SHOOTING_STEPS, TaylorMarch, allowed_steps};
use crate::cubic::taylor::state::State;
use crate::cubic::taylor::work::{Work, work_of_step};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::dual::Number;
use crate::linalg::lanes::{LANES, Lanes};
use crate::space::Kind;

/// Work of eight legs at once, in units of a single leg: at most half of what they cost one by one.
const ABREAST_WORK: f64 = 4.0;

/// Integrates legs on `St(m + k, k)`, one at a time or eight at once.
pub(crate) struct IntegratedLegs<'a> {
    plain: TaylorMarch<f64, Sizes>,
    abreast: Option<TaylorMarch<Lanes, Sizes>>,
    scratch: Vec<f64>,
    work: f64,
    interrupt: Interrupt<'a>,
}

impl<'a> IntegratedLegs<'a> {
    pub(crate) fn new(blocks: Sizes, interrupt: Interrupt<'a>) -> Self {
        let mut plain = TaylorMarch::new(blocks, Accuracy::FULL);
        plain.max_steps = SHOOTING_STEPS;
        IntegratedLegs {
            plain,
            abreast: None,
            scratch: Vec::new(),
            work: 0.0,
            interrupt,
        }
    }

    /// Integrates from `start = (x, x', x'')`, `3d` numbers, to a knot with the frame `next`, shape `(r, r)`, by
    /// columns. Writes distance, velocity, acceleration and third vector, as far as `values` has room for them. Returns
    /// `|S(1) - S_1|`. The tension is in the time of the leg.
    ///
    /// # Errors
    /// An error if the cubic cannot be integrated; `Interrupted`.
    pub(crate) fn ends_into(
        &mut self,
        start: &[f64],
        next: &[f64],
        tension: f64,
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<f64> {
        self.plain.accuracy = accuracy;
        self.plain.series.set_tension(tension);
        let scratch = &mut self.scratch;
        let arrived = evaluate(
            &mut self.plain,
            start,
            next,
            self.interrupt,
            scratch,
            values,
        );
        self.work = work_of_step(self.plain.blocks) * self.plain.steps as f64;
        arrived?;
        finite(off_identity(scratch, self.plain.blocks), values)
    }

    /// The same for as many legs as there are lanes, in the time that two legs take: one start, frame and set of values
    /// per leg. All legs use the shortest step.
    ///
    /// # Errors
    /// As [`IntegratedLegs::ends_into`], if one of the legs cannot be integrated.
    pub(crate) fn arrive_abreast_into(
        &mut self,
        start: &[Vec<f64>; LANES],
        next: [&[f64]; LANES],
        tension: [f64; LANES],
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<[f64; LANES]> {
        let blocks = self.plain.blocks;
        let march = self
            .abreast
            .get_or_insert_with(|| TaylorMarch::new(blocks, Accuracy::FULL));
        (march.accuracy, march.max_steps) = (accuracy, self.plain.max_steps);
        march.series.tension = tension.iter().any(|x| *x != 0.0).then_some(Lanes(tension));
        let together = |size: usize, of: &dyn Fn(usize, usize) -> f64| -> Vec<Lanes> {
            let lanes = |i: usize| Lanes(std::array::from_fn(|lane| of(lane, i)));
            (0..size).map(lanes).collect()
        };
        let starts = together(start[0].len(), &|lane, i| start[lane][i]);
        let frames = together(next[0].len(), &|lane, i| next[lane][i]);
        let size = values.len() / LANES;
        let (mut all, mut scratch) = (vec![Lanes::ZERO; size], Vec::new());
        let arrived = evaluate(
            march,
            &starts,
            &frames,
            self.interrupt,
            &mut scratch,
            &mut all,
        );
        self.work = ABREAST_WORK * work_of_step(blocks) * march.steps as f64;
        arrived?;
        let mut distances = [0.0; LANES];
        for (lane, values) in values.chunks_exact_mut(size).enumerate() {
            for (value, all) in values.iter_mut().zip(&all) {
                *value = all.0[lane];
            }
            let turn: Vec<f64> = scratch.iter().map(|x| x.0[lane]).collect();
            distances[lane] = finite(off_identity(&turn, blocks), values)?;
        }
        Ok(distances)
    }

    /// From now on, limits integrations to the number of Taylor steps allowed for the given speed at one end.
    pub(crate) fn allow(&mut self, speed: f64) {
        self.plain.max_steps = allowed_steps(speed);
    }

    /// The work of the last integration.
    pub(crate) fn work(&self) -> f64 {
        self.work
    }
}

/// Integrates a leg, whose start and values are coordinates over the field of the blocks. Writes the final frame,
/// relative to the next knot's frame, to the start of `scratch`.
fn evaluate<T: Number + Mul<M, Output = T>, M: Copy, B: BlockSizes>(
    march: &mut TaylorMarch<T, B>,
    start: &[T],
    next: &[M],
    interrupt: Interrupt<'_>,
    scratch: &mut Vec<T>,
    values: &mut [T],
) -> Result<()> {
    let entries = march.entries(start);
    let d = entries.len() / 3;
    march.place(entries.iter().copied());
    march.run(1.0, interrupt, &mut |_, _, _| Ok(()))?;
    let Some(embedding) = &march.embedding else {
        write_values(march, d, next, scratch, values);
        return Ok(());
    };
    let mut reached = vec![T::ZERO; 3 * values.len() / start.len() * d];
    write_values(march, d, next, scratch, &mut reached);
    values.copy_from_slice(&embedding.of_real(&reached));
    Ok(())
}

/// The values at the end of a march for vectors of `d` entries.
fn write_values<T: Number + Mul<M, Output = T>, M: Copy, B: BlockSizes>(
    march: &TaylorMarch<T, B>,
    d: usize,
    next: &[M],
    scratch: &mut Vec<T>,
    values: &mut [T],
) {
    let (m, k) = (march.blocks.normals(), march.blocks.k());
    let (r, rows, normals) = (m + k, march.blocks.r::<T>(), march.blocks.m::<T>());
    let series = &march.series;
    scratch.resize(r * (r + k), T::ZERO);
    let (turn, moved) = scratch.split_at_mut(r * r);
    // Transposed frame of the next knot times the final frame, in row-major order.
    for col in 0..r {
        let column = match col.checked_sub(k) {
            None => &series.s()[rows * col..][..r],
            Some(normal) => &series.e()[rows * normal..][..r],
        };
        for row in 0..r {
            let mut sum = T::ZERO;
            for (x, y) in column.iter().zip(&next[r * row..]) {
                sum += *x * *y;
            }
            turn[row + r * col] = sum;
        }
    }
    if march.blocks.are_subspaces() {
        return write_subspace(values, turn, series, march.blocks);
    }
    let (first, rest) = values.split_at_mut(d);
    write_horizontal(first, &turn[..r * k], [m, k]);
    for (derivative, values) in rest.chunks_exact_mut(d).enumerate() {
        let (omega, b) = (series.omega(derivative), series.b(derivative));
        for col in 0..k {
            for row in 0..r {
                let mut sum = T::ZERO;
                for i in 0..k {
                    sum += turn[row + r * i] * omega[i + k * col];
                }
                for i in 0..m {
                    sum += turn[row + r * (k + i)] * b[i + normals * col];
                }
                moved[row + r * col] = sum;
            }
        }
        write_horizontal(values, moved, [m, k]);
    }
}

/// `B A^T` for the distance, and `D b A^T` for the blocks `b` of the other values, where `[[A, .], [B, D]]` is the
/// final frame relative to the next knot's frame. At the knot `B` is zero, and `A` maps the basis reached there to the
/// knot's basis.
fn write_subspace<T: Number>(
    values: &mut [T],
    turn: &[T],
    series: &BlockSeries<T>,
    blocks: impl BlockSizes,
) {
    let (m, k, normals) = (blocks.normals(), blocks.k(), blocks.m::<T>());
    let r = m + k;
    let mut moved = vec![T::ZERO; m * k];
    for (derivative, values) in values.chunks_exact_mut(m * k).enumerate() {
        for col in 0..k {
            for row in 0..m {
                moved[row + m * col] = match derivative.checked_sub(1) {
                    None => turn[k + row + r * col],
                    Some(derivative) => {
                        let b = &series.b(derivative)[normals * col..][..m];
                        let terms = b.iter().enumerate();
                        terms.fold(T::ZERO, |sum, (i, b)| {
                            sum + turn[k + row + r * (k + i)] * *b
                        })
                    }
                };
            }
        }
        for col in 0..k {
            for row in 0..m {
                let terms = (0..k).map(|i| moved[row + m * i] * turn[col + r * i]);
                values[row + m * col] = terms.fold(T::ZERO, |sum, term| sum + term);
            }
        }
    }
}

/// The norm of the difference between the first columns and those of the identity.
fn off_identity(turn: &[f64], blocks: impl BlockSizes) -> f64 {
    let (m, k) = (blocks.normals(), blocks.k());
    let r = m + k;
    // For subspaces, the distance from the span of those columns.
    let first = if blocks.are_subspaces() { k } else { 0 };
    let mut square = 0.0;
    for col in 0..k {
        for row in first..r {
            let expected = f64::from(u8::from(row == col));
            square += (turn[row + r * col] - expected).powi(2);
        }
    }
    square.sqrt()
}

fn finite(distance: f64, values: &[f64]) -> Result<f64> {
    if distance.is_finite() && values.iter().all(|x| x.is_finite()) {
        return Ok(distance);
    }
    Err(Error::Overflow {
        quantity: "end of a leg",
    })
}

/// Writes the independent entries of the horizontal part of an `(r, k)` block: above the diagonal of `omega`, then
/// `normal`.
fn write_horizontal<T: Number>(values: &mut [T], block: &[T], [m, k]: [usize; 2]) {
    let r = m + k;
    let mut values = values.iter_mut();
    let mut write = |x: T| {
        if let Some(value) = values.next() {
            *value = x;
        }
    };
    for col in 0..k {
        for row in 0..col {
            write((block[row + r * col] + -block[col + r * row]) * 0.5);
        }
    }
    for col in 0..k {
        block[r * col + k..][..m].iter().for_each(|x| write(*x));
    }
}

/// How a cubic is integrated from one end to the other.
pub(crate) struct Passage<'a> {
    pub(crate) tension: f64,
    pub(crate) accuracy: Accuracy,
    pub(crate) kind: Kind,
    /// Counts the steps, also of a cubic that cannot be integrated.
    pub(crate) work: &'a Work,
    pub(crate) interrupt: Interrupt<'a>,
}

/// Point, velocity, covariant acceleration and covariant jerk at time 1 of the cubic with the given values at time 0,
/// all of shape `(n, k)`; computed in the span of the data.
///
/// # Errors
/// An error if the cubic cannot be integrated; `Interrupted`.
pub(crate) fn end_of_leg(
    s: MatRef<'_, f64>,
    [v, a, j]: [MatRef<'_, f64>; 3],
    passage: &Passage<'_>,
) -> Result<[Mat<f64>; 4]> {
    let kind = passage.kind;
    let Coordinates {
        frame,
        blocks,
        entries,
    } = Coordinates::of_checked([s, v, a, j], 1.0, kind);
    let mut state = State::of_coordinates(blocks, entries).in_tension(passage.tension);
    let mut march = TaylorMarch::new(blocks, passage.accuracy);
    march.max_steps = SHOOTING_STEPS;
    state.load(blocks, &mut march.series);
    let arrived = march.run(1.0, passage.interrupt, &mut |_, _, _| Ok(()));
    let steps = work_of_step(blocks) * march.steps as f64;
    passage.work.count(steps);
    arrived?;
    state.store(blocks, &march.series, 1.0);
    let (point, normals) = state.frame().split_at_col(blocks.k);
    let vectors = state.vectors();
    let jerk = Horizontal::jerk(kind.quotient, vectors.each_ref());
    let tangent = |x: &Horizontal| point * &x.omega + normals * &x.normal;
    let [v, a, _] = &vectors;
    let all = [point.to_owned(), tangent(v), tangent(a), tangent(&jerk)];
    Ok(all.map(|low| match &frame {
        Some(frame) => frame * low,
        None => low,
    }))
}
