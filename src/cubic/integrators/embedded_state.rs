//! The state of a cubic on the embedded `T^*(TSt(r, k))`: its momenta, its constraints, and one implicit step.

use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};

use super::embedded_field::{EmbeddedField, P_S, P_V, S, V};
use super::split_state::add_all;
use super::trajectory::Observed;
use crate::cubic::taylor::initial::InitialData;
use crate::error::{Error, Result};
use crate::linalg::product::{axpy, mul_add, mul_into};
use crate::linalg::structure::norm;
use crate::report::{SolverReport, StopReason};

/// Maximal number of iterations per step; 5 to 20 are usual.
const MAX_ITERATIONS: usize = 100;

/// Largest acceptable error of an increment, relative to the increment of a curve of that speed.
const NEGLIGIBLE: f64 = 1.1e-16;

/// Changes below this that no longer decrease count as round-off.
const ROUND_OFF: f64 = 1e-12;

/// Exponents of the rate in the magnitudes of `S`, `V`, `p_S` and `p_V`.
const POWERS: [usize; 4] = [0, 1, 3, 2];

/// `(S, V, p_S, p_V)`.
pub(crate) struct EmbeddedState {
    r: usize,
    k: usize,
    /// The blocks in order, each in column-major order, and their accumulated rounding errors.
    z: Vec<f64>,
    low: Vec<f64>,
    /// `p_S S^T + p_V V^T` at the start.
    start: Mat<f64>,
    field: EmbeddedField,
    work: StateBuffers,
}

/// Buffers of a step.
struct StateBuffers {
    /// As long as the state.
    increment: Vec<f64>,
    next: Vec<f64>,
    middle: Vec<f64>,
    squares: [Mat<f64>; 3],
    momentum: Mat<f64>,
}

impl EmbeddedState {
    /// The state with the given initial data:
    ///
    /// ```math
    /// p_V = A - \tfrac12 S S^T A,\qquad p_S = B - \tfrac12 S S^T B,\qquad
    /// B = \tfrac12 (X_V A - X_A V) + p_V S^T V - V S^T p_V - J
    /// ```
    ///
    /// where `V = X_V S` and `A = X_A S`. The momenta satisfy `S^T p_V + p_V^T S = 0` and `S^T p_S + p_S^T S = 0`.
    pub(crate) fn new(data: &InitialData) -> Self {
        let (r, k) = (data.g.nrows(), data.velocity.omega.nrows());
        let s = data.g.as_ref().subcols(0, k);
        let vectors = [&data.velocity, &data.acceleration, &data.jerk];
        let [v, a, j] = vectors.map(|x| &data.g * x.tangent());
        let mut squares = [(); 3].map(|()| Mat::zeros(k, k));
        let mut p_v = a.clone();
        subtract_half_tangential(p_v.as_mut(), s, &mut squares[0]);
        let mut p_s = Mat::zeros(r, k);
        set_brackets(
            p_s.as_mut(),
            [s, v.as_ref(), a.as_ref(), p_v.as_ref()],
            &mut squares,
        );
        axpy(&mut p_s, -1.0, &j);
        subtract_half_tangential(p_s.as_mut(), s, &mut squares[0]);
        let blocks = [s, v.as_ref(), p_s.as_ref(), p_v.as_ref()];
        let columns = blocks.iter().flat_map(|block| block.col_iter());
        let z: Vec<f64> = columns.flat_map(|column| column.iter().copied()).collect();
        let zeros = || vec![0.0; z.len()];
        let mut state = EmbeddedState {
            r,
            k,
            low: zeros(),
            start: Mat::zeros(r, r),
            field: EmbeddedField::new(k),
            work: StateBuffers {
                increment: zeros(),
                next: zeros(),
                middle: zeros(),
                squares,
                momentum: Mat::zeros(r, r),
            },
            z,
        };
        state.set_momentum();
        state.start = state.work.momentum.clone();
        state
    }

    /// Takes one step of the midpoint rule, `z_1 = z_0 + h f((z_0 + z_1) / 2)`, and restores the momentum constraints.
    ///
    /// # Errors
    /// `NoConvergence` (the step is too long for the iteration), `Overflow`.
    pub(crate) fn step(&mut self, h: f64) -> Result<()> {
        let rate = self.rate();
        if rate == 0.0 {
            return Ok(());
        }
        self.work.increment.fill(0.0);
        let mut last = f64::INFINITY;
        for iteration in 1..=MAX_ITERATIONS {
            self.iterate(h);
            let change = self.change(h, rate);
            if !change.is_finite() {
                return Err(failed(iteration, last, StopReason::Diverged));
            }
            if is_settled(change, last) {
                add_all(&mut self.z, &mut self.low, 1.0, &self.work.increment);
                self.restore_momenta();
                return Ok(());
            }
            last = change;
        }
        Err(failed(MAX_ITERATIONS, last, StopReason::MaxIterations))
    }

    /// `max(|V|, |p_V|^(1/2), |p_S|^(1/3))`: in a time of one over this rate the curve moves a distance of about one.
    fn rate(&self) -> f64 {
        let size = |i: usize| norm(part(&self.z, self.r, self.k, i));
        size(V).max(size(P_V).sqrt()).max(size(P_S).cbrt())
    }

    /// Sets `next = h f(z + increment / 2)`.
    fn iterate(&mut self, h: f64) {
        let StateBuffers {
            increment,
            next,
            middle,
            ..
        } = &mut self.work;
        for ((middle, z), increment) in middle.iter_mut().zip(&self.z).zip(&*increment) {
            *middle = z + 0.5 * increment;
        }
        let (r, k) = (self.r, self.k);
        let middle = MatRef::from_column_major_slice(middle, r, 4 * k);
        let out = MatMut::from_column_major_slice_mut(next, r, 4 * k);
        self.field.evaluate(middle, out);
        for next in next {
            *next *= h;
        }
    }

    /// Replaces the increment by the next iterate; returns the largest change of a block, relative to the increments of
    /// a curve of that rate.
    fn change(&mut self, h: f64, rate: f64) -> f64 {
        let StateBuffers {
            increment, next, ..
        } = &mut self.work;
        for (old, new) in increment.iter_mut().zip(&*next) {
            *old = new - *old;
        }
        let mut largest = 0.0_f64;
        for (i, power) in POWERS.into_iter().enumerate() {
            let size = norm(part(increment, self.r, self.k, i)) / h.abs();
            // Divide one factor at a time: the product of the factors may underflow.
            let relative = (0..=power).fold(size, |size, _| size / rate);
            // `f64::max` of NaN and a number returns the number.
            if !relative.is_finite() {
                return relative;
            }
            largest = largest.max(relative);
        }
        std::mem::swap(increment, next);
        largest
    }

    /// Adds multiples of the gradients of the constraints, which only change the momenta off the manifold: `p_S -= S
    /// M_S + V M_V` and `p_V -= S M_V` with symmetric matrices such that `S^T p_S` and `S^T p_V` become skew.
    fn restore_momenta(&mut self) {
        let (r, k) = (self.r, self.k);
        let size = r * k;
        let StateBuffers {
            next,
            squares: [inner, symmetric, _],
            ..
        } = &mut self.work;
        let product = &mut next[..size];
        for (momentum, targets) in [(P_V, &[(P_V, S), (P_S, V)][..]), (P_S, &[(P_S, S)])] {
            let s = part(&self.z, r, k, S);
            mul_into(
                &mut *inner,
                1.0,
                s.transpose(),
                part(&self.z, r, k, momentum),
            );
            symmetric.fill(0.0);
            axpy(&mut *symmetric, 0.5, &*inner);
            axpy(&mut *symmetric, 0.5, inner.transpose());
            for &(to, gradient) in targets {
                let out = MatMut::from_column_major_slice_mut(product, r, k);
                mul_into(out, 1.0, part(&self.z, r, k, gradient), &*symmetric);
                let range = to * size..(to + 1) * size;
                add_all(
                    &mut self.z[range.clone()],
                    &mut self.low[range],
                    -1.0,
                    product,
                );
            }
        }
    }

    /// Sets the buffer to `p_S S^T + p_V V^T`.
    fn set_momentum(&mut self) {
        let block = |i: usize| part(&self.z, self.r, self.k, i);
        mul_into(
            &mut self.work.momentum,
            1.0,
            block(P_S),
            block(S).transpose(),
        );
        mul_add(
            &mut self.work.momentum,
            1.0,
            block(P_V),
            block(V).transpose(),
        );
    }
}

impl Observed for EmbeddedState {
    /// `A = p_V - S p_V^T S`, and `J` from the formula of [`EmbeddedState::new`].
    fn observe(&mut self, out: [&mut [f64]; 4]) {
        let (r, k) = (self.r, self.k);
        let [mut point, mut velocity, mut acceleration, mut jerk] =
            out.map(|out| MatMut::from_column_major_slice_mut(out, r, k));
        let [s, v, p_s, p_v] = [S, V, P_S, P_V].map(|i| part(&self.z, r, k, i));
        let squares = &mut self.work.squares;
        point.copy_from(s);
        velocity.copy_from(v);
        acceleration.copy_from(p_v);
        mul_into(&mut squares[0], 1.0, p_v.transpose(), s);
        mul_add(acceleration.rb_mut(), -1.0, s, &squares[0]);
        set_brackets(jerk.rb_mut(), [s, v, acceleration.as_ref(), p_v], squares);
        axpy(jerk.rb_mut(), -1.0, p_s);
        mul_into(&mut squares[0], 1.0, p_s.transpose(), s);
        mul_add(jerk, 1.0, s, &squares[0]);
    }

    fn energy(&mut self) -> f64 {
        let z = MatRef::from_column_major_slice(&self.z, self.r, 4 * self.k);
        self.field.energy(z)
    }

    /// Defect of `p_S S^T - S p_S^T + p_V V^T - V p_V^T`.
    fn momentum_defect(&mut self) -> f64 {
        self.set_momentum();
        axpy(&mut self.work.momentum, -1.0, &self.start);
        let moved = &self.work.momentum;
        let mut squares = 0.0;
        for j in 0..self.r {
            for i in 0..j {
                squares += (moved[(i, j)] - moved[(j, i)]).powi(2);
            }
        }
        squares.sqrt()
    }

    /// The largest of `|S^T S - I|`, `|S^T V + V^T S|` and the corresponding defects of both momenta, Frobenius norms.
    fn constraint_defect(&mut self) -> f64 {
        let (r, k) = (self.r, self.k);
        let inner = &mut self.work.squares[0];
        let s = part(&self.z, r, k, S);
        let mut largest = 0.0_f64;
        for i in [S, V, P_S, P_V] {
            mul_into(&mut *inner, 1.0, s.transpose(), part(&self.z, r, k, i));
            let mut squares = 0.0;
            for col in 0..k {
                for row in 0..k {
                    let sum = inner[(row, col)] + inner[(col, row)];
                    let one = f64::from(u8::from(row == col));
                    squares += if i == S { 0.5 * sum - one } else { sum }.powi(2);
                }
            }
            if squares.is_nan() {
                return squares;
            }
            largest = largest.max(squares.sqrt());
        }
        largest
    }
}

/// One block of a state.
fn part(z: &[f64], r: usize, k: usize, i: usize) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(&z[i * r * k..][..r * k], r, k)
}

/// `a -= S S^T a / 2`.
fn subtract_half_tangential(a: MatMut<'_, f64>, s: MatRef<'_, f64>, inner: &mut Mat<f64>) {
    mul_into(&mut *inner, 1.0, s.transpose(), a.rb());
    mul_add(a, -0.5, s, &*inner);
}

/// `out = (X_V A - X_A V) / 2 + p_V S^T V - V S^T p_V`, which is `J + p_S - S p_S^T S`.
///
/// `X_V A - X_A V = V S^T A - A S^T V - S (N - N^T)` with `N = V^T A + S^T V S^T A`.
fn set_brackets(
    mut out: MatMut<'_, f64>,
    [s, v, a, p_v]: [MatRef<'_, f64>; 4],
    [with_a, with_v, n]: &mut [Mat<f64>; 3],
) {
    mul_into(&mut *with_a, 1.0, s.transpose(), a);
    mul_into(&mut *with_v, 1.0, s.transpose(), v);
    mul_into(&mut *n, 1.0, v.transpose(), a);
    mul_add(&mut *n, 1.0, &*with_v, &*with_a);
    mul_into(out.rb_mut(), 0.5, v, &*with_a);
    mul_add(out.rb_mut(), -0.5, a, &*with_v);
    mul_add(out.rb_mut(), -0.5, s, &*n);
    mul_add(out.rb_mut(), 0.5, s, n.transpose());
    mul_add(out.rb_mut(), 1.0, p_v, &*with_v);
    mul_into(&mut *with_a, 1.0, s.transpose(), p_v);
    mul_add(out, -1.0, v, &*with_a);
}

/// Whether the remaining error of a linearly convergent iteration is below round-off.
fn is_settled(change: f64, last: f64) -> bool {
    if change == 0.0 {
        return true;
    }
    if !last.is_finite() {
        return false;
    }
    let ratio = change / last;
    change * ratio <= NEGLIGIBLE * (1.0 - ratio) || (change <= ROUND_OFF && ratio >= 1.0)
}

fn failed(iterations: usize, residual: f64, reason: StopReason) -> Error {
    if !residual.is_finite() {
        return Error::Overflow {
            quantity: "Hamiltonian vector field",
        };
    }
    Error::NoConvergence {
        solver: "implicit step",
        report: SolverReport::new(reason, iterations, residual, ROUND_OFF),
    }
}
