//! The Taylor method for Riemannian cubics: steps of high order, whose length follows from the decay of the
//! coefficients.
//!
//! # Source
//! Jorba, Zou (2005), "A software package for the numerical integration of ODEs by means of high-order Taylor methods",
//! Experimental Mathematics 14, 99-117: order (3-9), of which the one here is four more; step length (3-8).

use std::borrow::Cow;

use super::blocks::{BlockSeries, BlockSizes, block};
use super::embedding::Embedding;
use super::recurrence::expand;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::dual::Number;
use crate::linalg::simd::vectorised;

/// Maximal number of steps.
pub(crate) const MAX_STEPS: usize = 100_000;

/// Maximal number of Taylor steps of one integration: curves that need more are too fast for shooting.
pub(crate) const SHOOTING_STEPS: usize = 4_000;

/// Taylor steps allowed for a curve with zero end speeds, and additional steps per unit of speed: a few times as many
/// as observed solutions take (11 from rest to rest at distance 2.7). Trials that go astray are stopped here: with a
/// fixed limit of 4000, one in forty problems from rest to rest on St(10,3) and St(5,2) spent all its work on one start.
const STEPS: f64 = 60.0;
const STEPS_PER_SPEED: f64 = 8.0;

/// Number of Taylor steps allowed for a curve with the given speed at one of its ends.
pub(crate) fn allowed_steps(speed: f64) -> usize {
    ((STEPS + STEPS_PER_SPEED * speed) as usize).min(SHOOTING_STEPS)
}

pub(crate) const SOLVER: &str = "Taylor integration";

/// Accuracy of a step, and the number of its terms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Accuracy {
    /// Size of the terms that a step leaves out, relative to the state, at most 0.1.
    pub(crate) truncation: f64,
    pub(crate) order: usize,
}

impl Accuracy {
    /// Full accuracy: the truncation error is below a tenth of round-off.
    pub(crate) const FULL: Accuracy = Accuracy {
        truncation: 1e-17,
        order: 20,
    };

    /// The same truncation with another number of terms.
    pub(crate) fn with_order(self, order: usize) -> Self {
        Accuracy { order, ..self }
    }

    /// The more accurate of two.
    pub(crate) fn finer(self, other: Self) -> Self {
        if other.truncation < self.truncation {
            other
        } else {
            self
        }
    }

    /// The order for a tolerance, `5 - ln(tolerance) / 2`. The fewest multiplications per unit of time take four terms
    /// less (Jorba, Zou), but steps have other costs too. With that order, curves on St(3,1) to St(50,5) take 0.93 to
    /// 1.9 times as long over one unit of time, for tolerances from 1e-13 to 1e-3, and up to 5 times over 20 units on
    /// St(3,2).
    pub(crate) fn of_tolerance(tolerance: f64) -> Self {
        let truncation = tolerance.max(Self::FULL.truncation);
        let order = (5.0 - 0.5 * truncation.ln()).ceil() as usize;
        Accuracy {
            truncation,
            order: order.min(Self::FULL.order),
        }
    }

    /// Allowed size of the last terms. Terms that decrease by a factor `q` at every order leave out `q / (1 - q)` times
    /// the last one, which is more than that for large tolerances only: without this, a curve with a speed of 300 gains
    /// so much speed at a tolerance of 0.1 that it is not finished within 100000 steps.
    fn last_term(self) -> f64 {
        if self.truncation <= 0.5_f64.powi(self.order as i32) {
            return self.truncation;
        }
        let ratio = self.truncation.powf(1.0 / self.order as f64);
        self.truncation * (1.0 - ratio) / ratio
    }
}

/// What is called for every step, with the series, the start and the signed length.
type Visit<'a, T> = dyn FnMut(&BlockSeries<T>, f64, f64) -> Result<()> + 'a;

/// A state integrated along the flow. It is stored as the coefficients of order 0 of the series.
#[derive(Debug, Clone)]
pub(crate) struct TaylorMarch<T, B> {
    pub(crate) blocks: B,
    pub(crate) series: BlockSeries<T>,
    pub(crate) accuracy: Accuracy,
    pub(crate) time: f64,
    pub(crate) steps: usize,
    pub(crate) max_steps: usize,
    /// Maximal length of a step: infinite, unless variations are carried along.
    pub(crate) longest: f64,
    /// Coordinates of complex blocks.
    pub(crate) embedding: Option<Embedding>,
}

impl<T: Number, B: BlockSizes> TaylorMarch<T, B> {
    /// A march at time 0 with all entries zero.
    pub(crate) fn new(blocks: B, accuracy: Accuracy) -> Self {
        TaylorMarch {
            blocks,
            series: BlockSeries::zeros(blocks, accuracy.order),
            accuracy,
            time: 0.0,
            steps: 0,
            max_steps: MAX_STEPS,
            longest: f64::INFINITY,
            embedding: blocks.embedding(),
        }
    }

    /// The independent entries of vectors with the given coordinates.
    pub(crate) fn entries<'y>(&self, y: &'y [T]) -> Cow<'y, [T]> {
        match &self.embedding {
            None => Cow::Borrowed(y),
            Some(embedding) => Cow::Owned(embedding.to_real(y)),
        }
    }

    /// Resets the march to time 0, with the identity as its frame and the given independent entries of `(x, x', x'')`:
    /// for each vector the entries of `omega` above the diagonal (unless `omega` is always zero), then `b`, in
    /// column-major order.
    pub(crate) fn place(&mut self, entries: impl IntoIterator<Item = T>) {
        let (m, k) = (self.blocks.normals(), self.blocks.k());
        let (rows, normals) = (self.blocks.r::<T>(), self.blocks.m::<T>());
        (self.time, self.steps) = (0.0, 0);
        let series = self.series.parts();
        series.s[..rows * k].fill(T::ZERO);
        series.e[..rows * normals].fill(T::ZERO);
        let one = T::constant(1.0);
        for col in 0..k {
            series.s[col + rows * col] = one;
        }
        for normal in 0..m {
            series.e[k + normal + rows * normal] = one;
        }
        let mut entries = entries.into_iter();
        for (omega, b) in series.omega.into_iter().zip(series.b) {
            for col in 0..k {
                omega[col + k * col] = T::ZERO;
                for row in 0..col {
                    let entry = match self.blocks.are_subspaces() {
                        true => T::ZERO,
                        false => entries.next().expect("as many as unknowns"),
                    };
                    omega[row + k * col] = entry;
                    omega[col + k * row] = -entry;
                }
            }
            for col in 0..k {
                let to = &mut b[normals * col..][..m];
                for (to, from) in to.iter_mut().zip(&mut entries) {
                    *to = from;
                }
            }
        }
    }

    /// Integrates to `t_end`; `visit` is called for every step with series, start and signed length; it is a
    /// trait object, so that this is compiled once for each number type and size. The steps are inlined here:
    /// as functions of their own they make initial value problems on St(3,1) and St(3,2) take 1.2 times as long.
    ///
    /// # Errors
    /// `TooManySteps`, `Overflow`, `Interrupted`, and the errors of `visit`.
    pub(crate) fn run(
        &mut self,
        t_end: f64,
        interrupt: Interrupt<'_>,
        visit: &mut Visit<'_, T>,
    ) -> Result<()> {
        while self.time != t_end {
            interrupt.check(SOLVER)?;
            let ahead = t_end - self.time;
            let length = vectorised(
                #[inline(always)]
                || {
                    expand(&mut self.series, self.blocks, self.accuracy.order);
                    self.step_length()
                },
            );
            let length = if self.longest < length {
                self.longest
            } else {
                length
            };
            self.check_step(ahead, length)?;
            let last = ahead.abs() <= length;
            let step = if last { ahead } else { length.copysign(ahead) };
            visit(&self.series, self.time, step)?;
            vectorised(
                #[inline(always)]
                || self.advance(step),
            );
            self.time = if last { t_end } else { self.time + step };
            self.steps += 1;
        }
        Ok(())
    }

    /// Fails after too many steps, or as soon as the steps are so short that there would be too many.
    fn check_step(&self, ahead: f64, length: f64) -> Result<()> {
        if length.is_nan() {
            return Err(Error::Overflow {
                quantity: "Riemannian cubic",
            });
        }
        let left = self.max_steps.saturating_sub(self.steps);
        // The last step may be shorter than that, and is infinitely long if nothing moves.
        if left > 0 && ahead.abs() <= left as f64 * length {
            return Ok(());
        }
        let count = [self.steps, self.max_steps];
        Err(Error::too_many_steps(SOLVER, count, ahead.abs(), length))
    }

    /// The step at which the last three terms fall to [`Accuracy::last_term`]; NaN if they are not finite.
    ///
    /// Three terms are used because two of three vanish if only the jerk is nonzero at the start: time then enters as
    /// its cube.
    ///
    /// Terms of `x''` are measured relative to the cube of the rate, `max(|x|^3, |x'|^(3/2), |x''|)`, those of the
    /// point relative to 1.
    #[inline(always)]
    fn step_length(&self) -> f64 {
        let (r, k) = (self.blocks.r::<T>(), self.blocks.k());
        let [x, a, b] = [0, 1, 2].map(|derivative| self.largest(derivative, 0));
        let scale = (x * x * x).max(a * a.sqrt()).max(b);
        let (order, allowed) = (self.accuracy.order, self.accuracy.last_term());
        // The logarithm, infinite if all terms vanish, for a curve at rest. NaN is propagated.
        let mut least = f64::INFINITY;
        for j in order - 2..=order {
            let point = largest_of(&self.series.s()[block(j, r * k)]);
            let relative = self.largest(2, j) / if scale > 0.0 { scale } else { 1.0 };
            let size = if relative <= point { point } else { relative };
            let limit = (allowed / size).ln() / j as f64;
            if !(least <= limit || least.is_nan()) {
                least = limit;
            }
        }
        least.exp()
    }

    /// The largest entry of a coefficient of `x` or a derivative. NaN is propagated.
    #[inline(always)]
    fn largest(&self, derivative: usize, j: usize) -> f64 {
        let (m, k) = (self.blocks.m::<T>(), self.blocks.k());
        let omega = largest_of(&self.series.omega(derivative)[block(j, k * k)]);
        let b = largest_of(&self.series.b(derivative)[block(j, m * k)]);
        if b <= omega { omega } else { b }
    }

    /// Advances the state by `step` along the series.
    #[inline(always)]
    fn advance(&mut self, step: f64) {
        let (r, m, k) = (self.blocks.r::<T>(), self.blocks.m::<T>(), self.blocks.k());
        let order = self.accuracy.order;
        let parts = self.series.parts();
        move_start(parts.s, r * k, order, step);
        move_start(parts.e, r * m, order, step);
        for series in parts.omega {
            move_start(series, k * k, order, step);
        }
        for series in parts.b {
            move_start(series, m * k, order, step);
        }
    }
}

/// The largest absolute value. NaN is propagated.
#[inline(always)]
fn largest_of<T: Number>(entries: &[T]) -> f64 {
    let mut largest = 0.0_f64;
    for entry in entries {
        let entry = entry.value().abs();
        if entry > largest || entry.is_nan() {
            largest = entry;
        }
    }
    largest
}

/// Replaces the coefficient of order 0 by the value at `t`; overwrites the one of the highest order.
#[inline(always)]
fn move_start<T: Number>(series: &mut [T], size: usize, order: usize, t: f64) {
    if size == 0 {
        return;
    }
    let (lower, top) = series[..size * (order + 1)].split_at_mut(size * order);
    if size <= T::REGISTERS {
        let mut sums = [T::ZERO; FEW];
        sums[..size].copy_from_slice(top);
        horner(&mut sums[..size], lower, t);
        return lower[..size].copy_from_slice(&sums[..size]);
    }
    horner(top, lower, t);
    lower[..size].copy_from_slice(top);
}

/// Largest number of sums kept in registers.
const FEW: usize = 16;

/// Evaluates the polynomial at `t` in place, starting from the coefficients of the highest order.
#[inline(always)]
fn horner<T: Number>(sums: &mut [T], lower: &[T], t: f64) {
    for coefficient in lower.chunks_exact(sums.len()).rev() {
        for (sum, c) in sums.iter_mut().zip(coefficient) {
            *sum = *sum * t + *c;
        }
    }
}
