//! A leg of a spline: where the cubic from a knot arrives, in the frame of the next knot, with exact derivatives.
//!
//! From `(x, x', x'')` at the identity the frame comes to `g`. With the next knot's frame `P` and `M = P^T g`,
//!
//! ```math
//! \mathrm{hor}(M I_k),\qquad \mathrm{hor}(M x),\qquad \mathrm{hor}(M x')\qquad\text{at } t = 1
//! ```
//!
//! are the distance from the knot, and velocity and covariant acceleration there.

use faer::Mat;

use super::reduced::{Blocks, Fixed, Sized};
use super::shooting::MAX_STEPS;
use super::taylor::{Accuracy, March};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::dual::{Dual, Number};

/// What a leg comes to.
pub(crate) struct Arrival {
    /// Distance from the next knot, velocity and covariant acceleration: `3d` numbers.
    pub(crate) values: Vec<f64>,
    /// `|S(1) - S_1|`.
    pub(crate) distance: f64,
}

/// Legs of splines of one shape; sizes of blocks hidden.
pub(crate) trait Leg {
    /// From `start = (x, x', x'')`, `3d` numbers, to a knot with the frame `next`, shape `(r, r)`, column by column.
    ///
    /// # Errors
    /// Where the cubic cannot be integrated; `Interrupted`.
    fn arrival(&mut self, start: &[f64], next: &[f64], accuracy: Accuracy) -> Result<Arrival>;

    /// The derivative of the values with respect to the start, shape `(3d, 3d)`.
    ///
    /// # Errors
    /// As [`Leg::arrival`].
    fn derivative(&mut self, start: &[f64], next: &[f64], accuracy: Accuracy) -> Result<Mat<f64>>;
}

/// Legs on `St(m + k, k)`.
pub(crate) fn leg<'a>(blocks: Sized, interrupt: Interrupt<'a>) -> Box<dyn Leg + 'a> {
    match (blocks.m, blocks.k) {
        (1, 1) => Box::new(Marches::<_, 3>::new(Fixed::<1, 1>, interrupt)),
        (2, 1) => Box::new(Marches::<_, 6>::new(Fixed::<2, 1>, interrupt)),
        (3, 1) => Box::new(Marches::<_, 9>::new(Fixed::<3, 1>, interrupt)),
        (1, 2) => Box::new(Marches::<_, 9>::new(Fixed::<1, 2>, interrupt)),
        _ => Box::new(Marches::<_, 8>::new(blocks, interrupt)),
    }
}

/// A pass of dual numbers carries `N` directions.
struct Marches<'a, B, const N: usize> {
    plain: March<f64, B>,
    several: March<Dual<N>, B>,
    interrupt: Interrupt<'a>,
}

impl<'a, B: Blocks, const N: usize> Marches<'a, B, N> {
    fn new(blocks: B, interrupt: Interrupt<'a>) -> Self {
        Marches {
            plain: March::new(blocks, Accuracy::FULL),
            several: March::new(blocks, Accuracy::FULL),
            interrupt,
        }
    }
}

impl<B: Blocks, const N: usize> Leg for Marches<'_, B, N> {
    fn arrival(&mut self, start: &[f64], next: &[f64], accuracy: Accuracy) -> Result<Arrival> {
        self.plain.accuracy = accuracy;
        let (values, distance) = evaluate(&mut self.plain, start, next, self.interrupt)?;
        Ok(Arrival { values, distance })
    }

    fn derivative(&mut self, start: &[f64], next: &[f64], accuracy: Accuracy) -> Result<Mat<f64>> {
        self.several.accuracy = accuracy;
        let count = start.len();
        let mut derivative = Mat::zeros(count, count);
        for first in (0..count).step_by(N) {
            let last = (first + N).min(count);
            let mut varied: Vec<Dual<N>> = start.iter().map(|x| Dual::constant(*x)).collect();
            for direction in first..last {
                varied[direction].slope[direction - first] = 1.0;
            }
            let (values, _) = evaluate(&mut self.several, &varied, next, self.interrupt)?;
            for (row, value) in values.iter().enumerate() {
                for column in first..last {
                    derivative[(row, column)] = value.slope[column - first];
                }
            }
        }
        Ok(derivative)
    }
}

fn evaluate<T: Number, B: Blocks>(
    march: &mut March<T, B>,
    start: &[T],
    next: &[f64],
    interrupt: Interrupt<'_>,
) -> Result<(Vec<T>, f64)> {
    let (m, k) = (march.blocks.normals(), march.blocks.k());
    let (r, rows, normals) = (m + k, march.blocks.r::<T>(), march.blocks.m::<T>());
    put(march, start);
    march.run(1.0, interrupt, |_, _, _| Ok(()))?;
    let series = &march.series;
    // Rows of the transposed frame of the next knot times the frame that was reached.
    let mut turn = vec![T::ZERO; r * r];
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
    let mut square = 0.0;
    for col in 0..k {
        for row in 0..r {
            let expected = f64::from(u8::from(row == col));
            square += (turn[row + r * col].value() - expected).powi(2);
        }
    }
    let mut values = Vec::with_capacity(start.len());
    push_horizontal(&mut values, &turn[..r * k], [m, k]);
    for derivative in 0..2 {
        let (omega, b) = (series.omega(derivative), series.b(derivative));
        let mut moved = vec![T::ZERO; r * k];
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
        push_horizontal(&mut values, &moved, [m, k]);
    }
    let distance = square.sqrt();
    if distance.is_finite() && values.iter().all(|x| x.value().is_finite()) {
        return Ok((values, distance));
    }
    Err(Error::Overflow {
        quantity: "end of a leg",
    })
}

/// The independent entries of the horizontal part of an `(r, k)` block: above the diagonal of `omega`, then `normal`.
fn push_horizontal<T: Number>(values: &mut Vec<T>, block: &[T], [m, k]: [usize; 2]) {
    let r = m + k;
    for col in 0..k {
        for row in 0..col {
            values.push((block[row + r * col] + -block[col + r * row]) * 0.5);
        }
    }
    for col in 0..k {
        values.extend_from_slice(&block[r * col + k..][..m]);
    }
}

/// Puts a march at the identity with the given `(x, x', x'')`.
fn put<T: Number, B: Blocks>(march: &mut March<T, B>, start: &[T]) {
    let (m, k) = (march.blocks.normals(), march.blocks.k());
    let (rows, normals) = (march.blocks.r::<T>(), march.blocks.m::<T>());
    (march.time, march.steps, march.max_steps) = (0.0, 0, MAX_STEPS);
    let series = march.series.parts();
    series.s[..rows * k].fill(T::ZERO);
    series.e[..rows * normals].fill(T::ZERO);
    let one = T::constant(1.0);
    for col in 0..k {
        series.s[col + rows * col] = one;
    }
    for normal in 0..m {
        series.e[k + normal + rows * normal] = one;
    }
    let mut entries = start.iter();
    for (omega, b) in series.omega.into_iter().zip(series.b) {
        for col in 0..k {
            omega[col + k * col] = T::ZERO;
            for row in 0..col {
                let entry = *entries.next().expect("as many as unknowns");
                omega[row + k * col] = entry;
                omega[col + k * row] = -entry;
            }
        }
        for col in 0..k {
            let to = &mut b[normals * col..][..m];
            for (to, from) in to.iter_mut().zip(&mut entries) {
                *to = *from;
            }
        }
    }
}
