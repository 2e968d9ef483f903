//! Upper bounds on the derivatives of a Riemannian cubic over an interval, computed from samples.
//!
//! Along a cubic, norms grow no faster than
//!
//! ```math
//! \bigl| |V|' \bigr| \le |A|,\qquad \bigl| |A|' \bigr| \le |J|,\qquad
//! \bigl| |J|' \bigr| \le |D_t J| = |R(A, V) V| \le \tfrac54 |A| |V|^2
//! ```
//!
//! since sectional curvatures of the canonical metric lie between 0 and 5/4. The curvature tensor is constant on the
//! Lie algebra, where the covariant derivative is half a bracket, and `|[x, y]| <= sqrt 2 |x| |y|` in the norm of the
//! metric; so
//!
//! ```math
//! |D_t^2 J| \le q = \tfrac54 \bigl( |J| |V|^2 + |A|^2 |V| + \sqrt2\, |A| |V|^3 \bigr)
//! ```
//!
//! In tension `D_t J` has the additional term `tau A`, so `tau |A|` is added to the bound on `D_t J` and `tau |J|` to
//! `q`.
//!
//! Transported along the curve, `V` differs from `V_0 + s A_0` at time `s` by at most `s^2 / 2` times the largest
//! `|J|`, and so on. From both ends of an interval of width `w` to its middle, with the largest norms `v, a, j` on it
//! and the samples at its ends,
//!
//! ```math
//! v \le \max |V_0 + s A_0| + \tfrac{w^2}{8} j,\qquad a \le \max |A_0 + s J_0| + \tfrac{5 w^2}{32} a v^2,\qquad
//! j \le \max |J_0 - s R(A_0, V_0) V_0| + \tfrac{w^2}{8} q
//! ```
//!
//! Numbers for which the right-hand sides are smaller than the left-hand ones are bounds, since the norms would have to
//! exceed them first on the way from an end. Intervals whose bounds are too far above the largest sample are halved.
//!
//! Everything is computed on the Lie algebra, in the natural time of the curve, from the series of `x` with `g' = g x`:
//!
//! ```math
//! V = x,\qquad A = x',\qquad J = x'' + \tfrac12 [x, x']_m,\qquad
//! D_t J = -R(A, V) V = -[[x, x']_h, x] + \tfrac14 [x, [x, x']_m]_m
//! ```
//!
//! Ambient derivatives of a fast curve exceed its covariant ones by a factor `|V|` per order, so covariant derivatives
//! computed from them would be dominated by round-off.
//!
//! On the Grassmann manifold sectional curvatures lie between 0 and 2, `J = x''` and `D_t J = -[[x, x']_h, x]`, and the
//! curvature tensor is parallel, so the last term of `q` vanishes.
//!
//! # Source
//! The bound on curvature: Zimmermann, Stoye (2025), "High curvature means low rank: on the sectional curvature of
//! Grassmann and Stiefel manifolds and the underlying matrix trace inequalities", arXiv 2403.01879. The bound on
//! brackets: Bottcher, Wenzel (2008), "The Frobenius norm and the commutator", Linear Algebra Appl. 429, 1864-1885.

use faer::{Mat, Scale};

use super::taylor::initial::Horizontal;
use super::taylor::piecewise_taylor::PiecewiseTaylor;
use super::time_map::TimeMap;
use crate::curve::{DerivativeBounds, Guarantee};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason};
use crate::space::Quotient;

const SOLVER: &str = "derivative bounds";

/// The largest sectional curvature of the canonical metric.
const CURVATURE: f64 = 1.25;

/// The largest sectional curvature of the Grassmann manifold, whose curvature tensor is parallel: the last term of `q`
/// vanishes.
const CURVATURE_OF_SUBSPACES: f64 = 2.0;

/// Largest relative gap between a bound and the largest sample (see [`limits`]).
const GAP: f64 = 1e-3;

/// Largest gap relative to derivatives of lower order, if that is larger. With 1e-3, jerk bounds of random cubics
/// exceed the largest jerk by up to 0.6 of it; with 1e-6, a cubic on a circle at speed 50, whose jerk is zero, uses up
/// the allowed number of intervals.
const LOWER_GAP: f64 = 1e-4;

/// Allowance for round-off of the samples, relative to the largest sample of its kind and to the effect of round-off in
/// a point.
const ROUND_OFF: f64 = 1e-12;

/// Trial bounds exceed those implied by the previous guess by this relative amount.
const INFLATION: f64 = 1e-5;

/// Maximal number of intervals, about a second of work.
const MAX_INTERVALS: usize = 1 << 16;

/// Maximal number of iterations for the bounds of one interval; the first guess is 1/8 too large.
const MAX_ROUNDS: usize = 8;

/// Covariant derivatives at one time, and their norms.
#[derive(Clone)]
struct CovariantSample {
    t: f64,
    /// `V, A, J, D_t J`.
    vectors: [Horizontal; 4],
    norms: [f64; 3],
}

/// Bounds on `|V|`, `|A|`, `|J|` of a cubic over an interval `span` of its time.
///
/// # Errors
/// `NoConvergence` if too many intervals would be needed; `Overflow`, `Interrupted`.
pub(super) fn enclosed(
    taylor: &PiecewiseTaylor,
    time_map: TimeMap,
    span: (f64, f64),
    interrupt: Interrupt<'_>,
) -> Result<DerivativeBounds> {
    let ends = [span.0, span.1].map(|t| time_map.taylor_time(t));
    let bounds = in_taylor_time(taylor, ends, interrupt)?;
    let [velocity, acceleration, jerk] =
        [0, 1, 2].map(|i| time_map.derivative(bounds[i], i + 1).abs());
    if !(velocity.is_finite() && acceleration.is_finite() && jerk.is_finite()) {
        return Err(Error::Overflow { quantity: SOLVER });
    }
    Ok(DerivativeBounds {
        velocity,
        acceleration,
        jerk,
        guarantee: Guarantee::Enclosure,
    })
}

fn in_taylor_time(
    taylor: &PiecewiseTaylor,
    ends: [f64; 2],
    interrupt: Interrupt<'_>,
) -> Result<[f64; 3]> {
    let mut sampler = Sampler::new(taylor);
    let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    let mut waiting = vec![(sampler.at(low), sampler.at(high))];
    let mut largest = [0.0_f64; 3];
    for (a, b) in &waiting {
        for (largest, (x, y)) in largest.iter_mut().zip(a.norms.iter().zip(b.norms)) {
            *largest = largest.max(*x).max(y);
        }
    }
    if low == high {
        waiting.clear();
    }
    let (mut bounds, mut count) = (largest, 1);
    while let Some((a, b)) = waiting.pop() {
        interrupt.check(SOLVER)?;
        let (limit, width) = (limits(largest, high - low), b.t - a.t);
        if let Some(found) = interval_bounds(&a, &b, width, taylor)
            && found
                .iter()
                .zip(limit)
                .all(|(found, limit)| *found <= limit)
        {
            for (bound, found) in bounds.iter_mut().zip(found) {
                *bound = bound.max(found);
            }
            continue;
        }
        let middle = 0.5 * (a.t + b.t);
        if count == MAX_INTERVALS || middle <= a.t || middle >= b.t {
            return Err(not_converged(count, width));
        }
        count += 1;
        let centre = sampler.at(middle);
        for (largest, norm) in largest.iter_mut().zip(centre.norms) {
            *largest = largest.max(norm);
        }
        waiting.push((centre.clone(), b));
        waiting.push((a, centre));
    }
    Ok(bounds)
}

/// The largest acceptable bounds, given the norms of samples on an interval of the given length.
///
/// A derivative may vanish identically while those of lower order do not; these are therefore taken into account, with
/// the length as the unit of time.
fn limits(norms: [f64; 3], length: f64) -> [f64; 3] {
    let rate = length.recip();
    let mut scale = 0.0;
    std::array::from_fn(|i| {
        let lower = scale * rate;
        scale = norms[i].max(lower);
        let gap = (GAP * norms[i]).max(LOWER_GAP * lower);
        norms[i] + gap + ROUND_OFF * rate.powi(i as i32 + 1)
    })
}

struct Sampler<'a> {
    taylor: &'a PiecewiseTaylor,
    /// Taylor coefficients of `x`.
    coefficients: [Vec<f64>; 3],
}

impl<'a> Sampler<'a> {
    fn new(taylor: &'a PiecewiseTaylor) -> Self {
        let size = taylor.r() * taylor.blocks.k;
        Sampler {
            taylor,
            coefficients: std::array::from_fn(|_| vec![0.0; size]),
        }
    }

    fn at(&mut self, t: f64) -> CovariantSample {
        let k = self.taylor.blocks.k;
        let mut targets = self.coefficients.each_mut().map(Vec::as_mut_slice);
        self.taylor.vectors_into(t, &mut targets);
        self.coefficients[2].iter_mut().for_each(|x| *x *= 2.0);
        let vectors = self.coefficients.each_ref();
        let [x, a, second] = vectors.map(|entries| Horizontal::of_entries(entries, k));
        let (jerk, snap) = match self.taylor.quotient() {
            Quotient::Frames => {
                let bracket = x.bracket(&a);
                (second.plus(0.5, &bracket), snap(&x, &a, &bracket))
            }
            Quotient::Subspaces => (second, snap_of_subspaces(&x, &a)),
        };
        let snap = snap.plus(self.taylor.tension(), &a);
        let norms = [x.norm(), a.norm(), jerk.norm()];
        CovariantSample {
            t,
            vectors: [x, a, jerk, snap],
            norms,
        }
    }
}

/// `-[[x, a]_h, x] + [x, [x, a]_m]_m / 4`, which is `-R(a, x) x`.
fn snap(x: &Horizontal, a: &Horizontal, bracket: &Horizontal) -> Horizontal {
    let turned = Horizontal {
        omega: Mat::zeros(x.omega.nrows(), x.omega.ncols()),
        // (B D^T - D B^T) B with the small products first.
        normal: &x.normal * (a.normal.transpose() * &x.normal)
            - &a.normal * (x.normal.transpose() * &x.normal),
    };
    turned.plus_bracket(0.25, x, bracket)
}

/// `-[[x, a]_h, x]` when the upper left block belongs to `h` too.
fn snap_of_subspaces(x: &Horizontal, a: &Horizontal) -> Horizontal {
    let n = a.normal.transpose() * &x.normal;
    let inner = &n * Scale(2.0) - n.transpose();
    Horizontal {
        omega: Mat::zeros(x.omega.nrows(), x.omega.ncols()),
        normal: &x.normal * inner - &a.normal * (x.normal.transpose() * &x.normal),
    }
}

/// `max |X_0 + s Y_0|` for `s` from 0 to `reach`: the function is convex, so the maximum is at an end.
fn reached(at: &CovariantSample, which: usize, reach: f64) -> f64 {
    let moved = at.vectors[which]
        .clone()
        .plus(reach, &at.vectors[which + 1]);
    at.norms[which].max(moved.norm())
}

/// Bounds on one interval; `None` if it is too wide.
fn interval_bounds(
    a: &CovariantSample,
    b: &CovariantSample,
    width: f64,
    taylor: &PiecewiseTaylor,
) -> Option<[f64; 3]> {
    let tension = taylor.tension();
    let (curvature, turning) = match taylor.quotient() {
        Quotient::Frames => (CURVATURE, std::f64::consts::SQRT_2),
        Quotient::Subspaces => (CURVATURE_OF_SUBSPACES, 0.0),
    };
    let half = 0.5 * width;
    let base = [0, 1, 2].map(|i| reached(a, i, half).max(reached(b, i, -half)));
    let square = 0.5 * half * half;
    let right = |[v, a, j]: [f64; 3]| {
        let last = j * v * v + a * a * v + turning * a * v * v * v;
        [
            base[0] + square * j,
            base[1] + square * (curvature * v * v + tension) * a,
            base[2] + square * (curvature * last + tension * j),
        ]
    };
    let mut guess = right(base.map(|x| 1.125 * x));
    for _ in 0..MAX_ROUNDS {
        // Slightly above the right-hand sides of the previous guess.
        let wider = guess.map(|x| x * (1.0 + INFLATION) + f64::MIN_POSITIVE);
        let next = right(wider);
        if next.iter().zip(wider).all(|(next, wider)| *next < wider) {
            return Some(wider);
        }
        guess = next;
    }
    None
}

fn not_converged(iterations: usize, width: f64) -> Error {
    Error::NoConvergence {
        solver: SOLVER,
        report: SolverReport::new(StopReason::MaxIterations, iterations, width, GAP),
    }
}
