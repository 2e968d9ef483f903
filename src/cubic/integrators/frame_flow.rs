//! The exact flows for any `(n, k)`: the exponential and its integral as Taylor polynomials, with one product per term.
//!
//! With `Z = h x`, the flow of `H_A` adds increments to `g^T`, `p` and `mu`:
//!
//! ```math
//! g^T \leftarrow g^T + \sum_{j \ge 1} \frac{(-Z)^j}{j!} g^T,\qquad
//! F = \sum_{j \ge 0} \frac{(-\mathrm{ad}_Z)^j}{(j + 1)!} \mu,\qquad p \leftarrow p - h F_m,\qquad
//! \mu \leftarrow \mu - [Z, F]
//! ```
//!
//! A commutator of skew matrices takes one product, `[Z, Y] = Z Y - (Z Y)^T`, and both sums share their products with
//! `Z`. The degree follows from a bound on `|Z|_2` before the first product; a rotation by more than [`LONGEST`] is
//! split into shorter ones. Cost of one term: a product `(r, r) x (r, 2r)` in which `Z` has a zero block of size `r -
//! k`; 8 to 14 terms at the usual steps.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use super::split_state::{SplitState, add_all, check_turn};
use super::trajectory::Observed;
use crate::cubic::taylor::initial::{Horizontal, InitialData};
use crate::error::Result;
use crate::linalg::simd::vectorised;
use crate::space::Quotient;

/// Largest angle of one Taylor polynomial, in radians. Cancellation in the sums costs a factor of about `e^{2
/// LONGEST}`.
const LONGEST: f64 = 0.75;

/// Truncation error of a sum, relative to its first term.
const NEGLIGIBLE: f64 = 1.4e-17;

/// Terms needed for [`LONGEST`] radians.
const MAX_TERMS: usize = 24;

/// `limits()[m]` is the largest norm of `Z` for which `m + 1` terms suffice.
///
/// The first omitted commutator is at most `(2 |Z|)^{m+2} / (m + 3)!` of `mu`, the first omitted power at most
/// `|Z|^{m+1} / (m + 2)!` of the first one.
fn limits() -> [f64; MAX_TERMS] {
    let mut factorial = 1.0;
    std::array::from_fn(|m| {
        factorial *= (m + 2) as f64;
        let power = (NEGLIGIBLE * factorial).powf(1.0 / (m + 1) as f64);
        let next = factorial * (m + 3) as f64;
        power.min(0.5 * (NEGLIGIBLE * next).powf(1.0 / (m + 2) as f64))
    })
}

/// State of a cubic in `r` dimensions. Matrices are in column-major order; `x` and `p` by their first `k` columns.
pub(crate) struct FrameState {
    r: usize,
    k: usize,
    /// The transpose of `g`, shape `(r, r)`.
    gt: Summed,
    x: Summed,
    p: Summed,
    mu: Summed,
    tension: f64,
    quotient: Quotient,
    start: Vec<f64>,
    limits: [f64; MAX_TERMS],
    work: FlowBuffers,
}

/// A matrix with the accumulated rounding errors of its sums.
struct Summed {
    value: Vec<f64>,
    low: Vec<f64>,
}

impl Summed {
    fn of(value: Vec<f64>) -> Self {
        let low = vec![0.0; value.len()];
        Summed { value, low }
    }

    #[inline(always)]
    fn add(&mut self, factor: f64, increments: &[f64]) {
        add_all(&mut self.value, &mut self.low, factor, increments);
    }
}

/// Buffers of a flow.
struct FlowBuffers {
    /// The generator, shape `(r, r)`.
    z: Vec<f64>,
    /// The last terms, `[commutator | power]`, shape `(r, 2r)`; their products with `z`; the sums of the terms.
    terms: Vec<f64>,
    products: Vec<f64>,
    sums: Vec<f64>,
}

impl FrameState {
    /// The state with the given initial data.
    pub(crate) fn new(data: &InitialData) -> Self {
        let (r, k) = (data.g.nrows(), data.velocity.omega.nrows());
        let gt = (0..r * r).map(|i| data.g[(i / r, i % r)]).collect();
        let [x, p, j] = [&data.velocity, &data.acceleration, &data.jerk].map(|v| columns(v, r));
        let mut state = FrameState {
            r,
            k,
            gt: Summed::of(gt),
            x: Summed::of(x),
            p: Summed::of(p),
            mu: Summed::of(vec![0.0; r * r]),
            tension: data.tension,
            quotient: data.quotient,
            start: vec![0.0; r * r],
            limits: limits(),
            work: FlowBuffers {
                z: vec![0.0; r * r],
                terms: vec![0.0; 2 * r * r],
                products: vec![0.0; 2 * r * r],
                sums: vec![0.0; 2 * r * r],
            },
        };
        state.set_momentum(&j);
        let mut start = std::mem::take(&mut state.start);
        start.copy_from_slice(state.spatial_momentum());
        state.start = start;
        state
    }

    /// `mu_m = tau x - (j - [x, p]_m / 2)`, `mu_h = [x, p]_h`.
    fn set_momentum(&mut self, jerk: &[f64]) {
        let (r, k) = (self.r, self.k);
        self.bracket();
        let pull = |i: usize| self.tension * self.x.value[i] - jerk[i];
        for j in 0..r {
            for i in 0..r {
                let bracket = self.work.sums[j * r + i];
                self.mu.value[j * r + i] = if self.is_held(i, j) {
                    bracket
                } else if j < k {
                    0.5 * bracket + pull(j * r + i)
                } else if i < k {
                    // The part in m must be skew as well.
                    0.5 * bracket - pull(i * r + j)
                } else {
                    bracket
                };
            }
        }
    }

    /// Whether an entry of the upper left block belongs to `h`.
    fn is_held(&self, i: usize, j: usize) -> bool {
        self.quotient == Quotient::Subspaces && i < self.k && j < self.k
    }

    /// Zeroes the upper left block of columns of a vector of `m` if that block belongs to `h`.
    fn hold(quotient: Quotient, r: usize, k: usize, columns: &mut [f64]) {
        if quotient == Quotient::Subspaces {
            for column in columns.chunks_exact_mut(r).take(k) {
                column[..k].fill(0.0);
            }
        }
    }

    /// Sets the first half of the sums to `[x, p]`.
    fn bracket(&mut self) {
        let r = self.r;
        set_generator(r, self.k, 1.0, &self.x.value, &mut self.work.z);
        set_generator(r, self.k, 1.0, &self.p.value, &mut self.work.terms);
        let FlowBuffers {
            z,
            terms,
            products,
            sums,
        } = &mut self.work;
        multiply(r, z, &terms[..r * r], &mut products[..r * r]);
        for j in 0..r {
            for i in 0..r {
                sums[j * r + i] = products[j * r + i] - products[i * r + j];
            }
        }
    }

    /// `g mu g^T`, in the first half of the sums.
    fn spatial_momentum(&mut self) -> &[f64] {
        let r = self.r;
        let FlowBuffers {
            terms,
            products,
            sums,
            ..
        } = &mut self.work;
        let g = &mut terms[..r * r];
        transpose(r, &self.gt.value, g);
        multiply(r, g, &self.mu.value, &mut products[..r * r]);
        multiply(r, &products[..r * r], &self.gt.value, &mut sums[..r * r]);
        &sums[..r * r]
    }

    /// `|x|_F / sqrt(2)`, a bound of `|x|_2`: the singular values of a skew matrix come in pairs.
    fn turning_rate(&self) -> f64 {
        let (r, k) = (self.r, self.k);
        let (mut top, mut bottom) = (0.0, 0.0);
        for column in self.x.value.chunks_exact(r) {
            top += column[..k].iter().map(|x| x * x).sum::<f64>();
            bottom += column[k..].iter().map(|x| x * x).sum::<f64>();
        }
        (0.5 * top + bottom).sqrt()
    }

    /// Applies one Taylor polynomial.
    fn turn(&mut self, h: f64, terms: usize) {
        let (r, k) = (self.r, self.k);
        set_generator(r, k, h, &self.x.value, &mut self.work.z);
        let (left, right) = self.work.terms.split_at_mut(r * r);
        left.copy_from_slice(&self.mu.value);
        right.copy_from_slice(&self.gt.value);
        series(r, k, terms, &mut self.work);
        let (integral, power) = self.work.sums.split_at_mut(r * r);
        Self::hold(self.quotient, r, k, integral);
        self.p.add(-h, &integral[..r * k]);
        if self.tension != 0.0 {
            self.p.add(h * self.tension, &self.x.value);
        }
        self.gt.add(1.0, power);
        // The commutator [Z, F] is the last product.
        self.mu.add(-1.0, &self.work.terms[..r * r]);
    }
}

impl SplitState for FrameState {
    fn rotate(&mut self, h: f64) -> Result<()> {
        let angle = h.abs() * self.turning_rate();
        check_turn(angle)?;
        let pieces = (angle / LONGEST).ceil().max(1.0);
        let part = angle / pieces;
        let enough = self.limits.iter().position(|limit| part <= *limit);
        let terms = enough.map_or(MAX_TERMS, |m| m + 1);
        for _ in 0..pieces as usize {
            self.turn(h / pieces, terms);
        }
        Ok(())
    }

    fn drift(&mut self, h: f64) {
        self.x.add(h, &self.p.value);
    }
}

impl Observed for FrameState {
    fn observe(&mut self, [point, velocity, acceleration, jerk]: [&mut [f64]; 4]) {
        let (r, k) = (self.r, self.k);
        self.bracket();
        let FlowBuffers {
            terms,
            products,
            sums,
            ..
        } = &mut self.work;
        for (i, jerk) in products[..r * k].iter_mut().enumerate() {
            *jerk = 0.5 * sums[i] + self.tension * self.x.value[i] - self.mu.value[i];
        }
        Self::hold(self.quotient, r, k, products);
        let g = &mut terms[..r * r];
        transpose(r, &self.gt.value, g);
        point.copy_from_slice(&g[..r * k]);
        multiply(r, g, &self.x.value, velocity);
        multiply(r, g, &self.p.value, acceleration);
        multiply(r, g, &products[..r * k], jerk);
    }

    /// `H = <mu, x> + |p|^2 / 2 - tau |x|^2 / 2`, in the inner product `tr(A^T B) / 2` of `so(r)`.
    fn energy(&mut self) -> f64 {
        let (r, k) = (self.r, self.k);
        let inner = |a: &[f64], b: &[f64]| -> f64 {
            let entry = |i: usize| if i % r < k { 0.5 } else { 1.0 } * a[i] * b[i];
            (0..r * k).map(entry).sum()
        };
        let (x, p) = (&self.x.value, &self.p.value);
        inner(&self.mu.value, x) + 0.5 * (inner(p, p) - self.tension * inner(x, x))
    }

    /// Defect of `g mu g^T`.
    fn momentum_defect(&mut self) -> f64 {
        let start = std::mem::take(&mut self.start);
        let now = self.spatial_momentum();
        let squares: f64 = now.iter().zip(&start).map(|(a, b)| (a - b).powi(2)).sum();
        self.start = start;
        (0.5 * squares).sqrt()
    }

    /// `|mu_h - [x, p]_h|`, in the same norm.
    fn constraint_defect(&mut self) -> f64 {
        let (r, k) = (self.r, self.k);
        self.bracket();
        let mut squares = 0.0;
        let held = (0..r * r).map(|at| (at % r, at / r));
        for (i, j) in held {
            if i.min(j) >= k || self.is_held(i, j) {
                squares += (self.mu.value[j * r + i] - self.work.sums[j * r + i]).powi(2);
            }
        }
        (0.5 * squares).sqrt()
    }
}

/// The first `k` columns of a vector of `m`.
fn columns(v: &Horizontal, r: usize) -> Vec<f64> {
    let k = v.omega.nrows();
    let entry = |i: usize, j: usize| {
        if i < k {
            v.omega[(i, j)]
        } else {
            v.normal[(i - k, j)]
        }
    };
    (0..r * k).map(|l| entry(l % r, l / r)).collect()
}

/// `out = factor v` for a vector of `m` given by its first `k` columns.
fn set_generator(r: usize, k: usize, factor: f64, v: &[f64], out: &mut [f64]) {
    out[r * k..r * r].fill(0.0);
    for j in 0..k {
        for i in 0..r {
            let x = factor * v[j * r + i];
            out[j * r + i] = x;
            if i >= k {
                out[i * r + j] = -x;
            }
        }
    }
}

fn transpose(r: usize, a: &[f64], out: &mut [f64]) {
    for j in 0..r {
        for i in 0..r {
            out[j * r + i] = a[i * r + j];
        }
    }
}

/// Sums both series from their first terms, and replaces the last commutator by `[Z, F]`.
fn series(r: usize, k: usize, terms: usize, work: &mut FlowBuffers) {
    match r {
        1 => fixed_series::<1>(terms, work),
        2 => fixed_series::<2>(terms, work),
        3 => fixed_series::<3>(terms, work),
        4 => fixed_series::<4>(terms, work),
        5 => fixed_series::<5>(terms, work),
        6 => fixed_series::<6>(terms, work),
        7 => fixed_series::<7>(terms, work),
        8 => fixed_series::<8>(terms, work),
        _ => sum_series(r, terms, work, |z, b, out| {
            horizontal_product(r, k, z, b, out)
        }),
    }
}

fn fixed_series<const R: usize>(terms: usize, work: &mut FlowBuffers) {
    vectorised(
        #[inline(always)]
        || sum_series(R, terms, work, fixed_product::<R>),
    );
}

/// [`series`] with a given product `out = Z b`.
#[inline(always)]
fn sum_series(
    r: usize,
    terms: usize,
    work: &mut FlowBuffers,
    product: impl Fn(&[f64], &[f64], &mut [f64]),
) {
    let size = r * r;
    let z = &work.z[..size];
    let last = &mut work.terms[..2 * size];
    let new = &mut work.products[..2 * size];
    let sums = &mut work.sums[..2 * size];
    sums[..size].copy_from_slice(&last[..size]);
    sums[size..].fill(0.0);
    for j in 1..=terms {
        product(z, last, new);
        let (left, right) = last.split_at_mut(size);
        let (commutator, power) = new.split_at(size);
        set_commutator(r, -1.0 / (j + 1) as f64, commutator, left);
        let factor = -1.0 / j as f64;
        for (x, y) in right.iter_mut().zip(power) {
            *x = factor * y;
        }
        for (sum, x) in sums.iter_mut().zip(&*last) {
            *sum += x;
        }
    }
    product(z, &sums[..size], &mut new[..size]);
    set_commutator(r, 1.0, &new[..size], &mut last[..size]);
}

/// `out = factor (A - A^T)`.
#[inline(always)]
fn set_commutator(r: usize, factor: f64, a: &[f64], out: &mut [f64]) {
    let (a, out) = (&a[..r * r], &mut out[..r * r]);
    for j in 0..r {
        for i in 0..r {
            out[j * r + i] = factor * (a[j * r + i] - a[i * r + j]);
        }
    }
}

/// `out = A B` for `A` of shape `(r, r)`; `b` and `out` have the same number of columns.
fn multiply(r: usize, a: &[f64], b: &[f64], out: &mut [f64]) {
    match r {
        1 => fixed_product::<1>(a, b, out),
        2 => fixed_product::<2>(a, b, out),
        3 => fixed_product::<3>(a, b, out),
        4 => fixed_product::<4>(a, b, out),
        5 => fixed_product::<5>(a, b, out),
        6 => fixed_product::<6>(a, b, out),
        7 => fixed_product::<7>(a, b, out),
        8 => fixed_product::<8>(a, b, out),
        _ => {
            let cols = b.len() / r;
            let a = MatRef::from_column_major_slice(a, r, r);
            let b = MatRef::from_column_major_slice(b, r, cols);
            let out = MatMut::from_column_major_slice_mut(out, r, cols);
            matmul(out, Accum::Replace, a, b, 1.0, Par::Seq);
        }
    }
}

#[inline(always)]
fn fixed_product<const R: usize>(a: &[f64], b: &[f64], out: &mut [f64]) {
    let a = &a.as_chunks::<R>().0[..R];
    for (out, b) in out
        .as_chunks_mut::<R>()
        .0
        .iter_mut()
        .zip(b.as_chunks::<R>().0)
    {
        let mut sum = [0.0; R];
        for l in 0..R {
            for i in 0..R {
                sum[i] += a[l][i] * b[l];
            }
        }
        *out = sum;
    }
}

/// `out = Z B` for `Z` in `m`, whose block in `h` is zero.
fn horizontal_product(r: usize, k: usize, z: &[f64], b: &[f64], out: &mut [f64]) {
    let cols = b.len() / r;
    let z = MatRef::from_column_major_slice(z, r, r);
    let b = MatRef::from_column_major_slice(b, r, cols);
    let out = MatMut::from_column_major_slice_mut(out, r, cols);
    let (top, bottom) = out.split_at_row_mut(k);
    matmul(top, Accum::Replace, z.subrows(0, k), b, 1.0, Par::Seq);
    let normal = z.submatrix(k, 0, r - k, k);
    matmul(
        bottom,
        Accum::Replace,
        normal,
        b.subrows(0, k),
        1.0,
        Par::Seq,
    );
}
