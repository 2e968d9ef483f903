//! The equations of a boundary value problem: the defect of the end of a curve.
//!
//! In coordinates in which the start is the identity, an end `(S1, V1)` gives the `2d` equations
//!
//! ```math
//! \mathrm{hor}(g^T S_1) = 0,\qquad \mathrm{hor}(g^T V_1) - x = 0\qquad\text{at } t = 1
//! ```
//!
//! with the horizontal part `hor(Y) = (skew(Y_1), Y_2)`, where `Y_1` and `Y_2` are the upper and the lower block.

use faer::Mat;

use super::problem::{largest_speed, velocity_unit};
use crate::cubic::taylor::blocks::{BlockSizes, Sizes};
use crate::cubic::taylor::initial::Horizontal;
use crate::cubic::taylor::march::{TaylorMarch, allowed_steps};
use crate::cubic::taylor::packing::pack;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::dual::Number;
use crate::linalg::product::entries;

/// Boundary data in coordinates in which the start is the identity, blocks in column-major order.
#[derive(Debug, Clone)]
pub(crate) struct Target {
    /// The independent entries of the initial velocity.
    pub(crate) velocity: Vec<f64>,
    /// End point and end velocity, shape `(r, k)`.
    pub(crate) end: [Vec<f64>; 2],
    /// The larger of the end speeds, in the Frobenius norm.
    pub(crate) speed: f64,
    /// Unit in which end velocities are compared: their round-off grows with the speed.
    pub(crate) velocity_unit: f64,
    /// Tension of the cubic.
    pub(crate) tension: f64,
}

impl Target {
    /// Built from an initial velocity, and an end point and end velocity of shape `(r, k)`.
    pub(crate) fn new(velocity: &Horizontal, end: &[Mat<f64>; 2], tension: f64) -> Self {
        let speed = largest_speed(velocity, end);
        let (m, k) = velocity.normal.shape();
        Target {
            velocity: pack(Sizes::frames(m, k), std::slice::from_ref(velocity)),
            end: [entries(&end[0]), entries(&end[1])],
            speed,
            velocity_unit: velocity_unit(speed),
            tension,
        }
    }
}

/// The equations, and the distance of the end from its target.
pub(crate) struct EndResidual<T> {
    pub(crate) equations: Vec<T>,
    /// `(|S(1) - S1|^2 + |V(1) - V1|^2 / u^2)^(1/2)` with the unit `u` of velocities.
    pub(crate) distance: f64,
}

/// Integrates from `y = (x', x'')` and compares the end with the target.
pub(crate) fn evaluate<T: Number>(
    march: &mut TaylorMarch<T, Sizes>,
    target: &Target,
    y: &[T],
    interrupt: Interrupt<'_>,
) -> Result<EndResidual<T>> {
    let (m, k) = (march.blocks.normals(), march.blocks.k());
    let (r, rows, normals) = (m + k, march.blocks.r::<T>(), march.blocks.m::<T>());
    march.max_steps = allowed_steps(target.speed);
    march.series.set_tension(target.tension);
    let velocity = target.velocity.iter().map(|x| T::constant(*x));
    let entries = march.entries(y);
    march.place(velocity.chain(entries.iter().copied()));
    march.run(1.0, interrupt, &mut |_, _, _| Ok(()))?;
    let series = &march.series;
    let half = T::constant(0.5);
    let mut equations = Vec::with_capacity(y.len());
    let mut square = 0.0;
    // Components of the target in the frame at the end.
    let component = |column: &[T], of: &[f64]| {
        let mut sum = T::ZERO;
        for (x, y) in column.iter().zip(of) {
            sum += *x * *y;
        }
        sum
    };
    for (which, of) in target.end.iter().enumerate() {
        let unit = [1.0, target.velocity_unit][which];
        let upper: Vec<T> = (0..k * k)
            .map(|i| component(&series.s()[rows * (i % k)..][..r], &of[r * (i / k)..][..r]))
            .collect();
        for col in 0..k {
            for row in 0..k {
                let expected = match which {
                    0 => f64::from(u8::from(row == col)),
                    _ => series.omega(0)[row + k * col].value(),
                };
                square += ((upper[row + k * col].value() - expected) / unit).powi(2);
                if row < col {
                    let skew = (upper[row + k * col] - upper[col + k * row]) * half;
                    equations.push(match which {
                        0 => skew,
                        _ => skew - series.omega(0)[row + k * col],
                    });
                }
            }
        }
        for col in 0..k {
            for row in 0..m {
                let lower = component(&series.e()[rows * row..][..r], &of[r * col..][..r]);
                let equation = match which {
                    0 => lower,
                    _ => lower - series.b(0)[row + normals * col],
                };
                square += (equation.value() / unit).powi(2);
                equations.push(equation);
            }
        }
    }
    let distance = square.sqrt();
    if let Some(embedding) = &march.embedding {
        equations = embedding.of_real(&equations);
    }
    if distance.is_finite() {
        return Ok(EndResidual {
            equations,
            distance,
        });
    }
    Err(Error::Overflow {
        quantity: "end of the curve",
    })
}
