//! Upper bounds of the derivatives of a Riemannian cubic that hold everywhere, from samples.
//!
//! Along a cubic, norms change no faster than
//!
//! ```math
//! \bigl| |V|' \bigr| \le |A|,\qquad \bigl| |A|' \bigr| \le |J|,\qquad
//! \bigl| |J|' \bigr| \le |D_t J| = |R(A, V) V| \le \tfrac54 |A| |V|^2
//! ```
//!
//! since sectional curvatures of the canonical metric lie between 0 and 5/4. The curvature tensor is constant on the
//! Lie algebra, where the covariant derivative is half of a bracket, and `|[x, y]| <= sqrt 2 |x| |y|` in the norm of
//! the metric; so
//!
//! ```math
//! |D_t^2 J| \le q = \tfrac54 \bigl( |J| |V|^2 + |A|^2 |V| + \sqrt2\, |A| |V|^3 \bigr)
//! ```
//!
//! Carried along the curve, `V` differs from `V_0 + tau A_0` by at most `tau^2 / 2` times the largest `|J|`, and so on.
//! From both ends of an interval of width `w` to its middle, with the largest norms `v, a, j` on it and the samples at
//! its ends,
//!
//! ```math
//! v \le \max |V_0 + \tau A_0| + \tfrac{w^2}{8} j,\qquad a \le \max |A_0 + \tau J_0| + \tfrac{5 w^2}{32} a v^2,\qquad
//! j \le \max |J_0 - \tau R(A_0, V_0) V_0| + \tfrac{w^2}{8} q
//! ```
//!
//! Numbers for which the right-hand sides are smaller than the left-hand ones are bounds: on the way from an end the
//! norms would have to pass them first. Intervals whose bounds are too far above the largest sample are halved.
//!
//! # Source
//! The bound of curvature: Zimmermann, Stoye (2025), "High curvature means low rank: on the sectional curvature of
//! Grassmann and Stiefel manifolds and the underlying matrix trace inequalities", arXiv 2403.01879. The bound of
//! brackets: Bottcher, Wenzel (2008), "The Frobenius norm and the commutator", Linear Algebra Appl. 429, 1864-1885.

use faer::{Mat, MatRef, Scale};

use super::RiemannianCubic;
use crate::curve::{Curve, DerivativeBounds, Guarantee};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::Jet;
use crate::manifold::{Stiefel, covariant};
use crate::report::{SolverReport, StopReason};

const SOLVER: &str = "derivative bounds";

/// The largest sectional curvature of the canonical metric.
const CURVATURE: f64 = 1.25;

/// Bounds are at most this much above the largest sample (see [`limits`]).
const GAP: f64 = 1e-3;

/// Room for round-off of the samples, relative to the largest of a kind and to what round-off of a point makes.
const ROUND_OFF: f64 = 1e-12;

/// Bounds are tried this much above what follows from the guess before.
const INFLATION: f64 = 1e-5;

/// Intervals at the most.
const MAX_INTERVALS: usize = 1 << 16;

/// Rounds in which bounds of one interval settle; the first guess is 1/8 too large.
const MAX_ROUNDS: usize = 8;

/// The state at one parameter.
struct Sample {
    t: f64,
    /// `V, A, J, D_t J`.
    vectors: [Mat<f64>; 4],
    point: Mat<f64>,
    norms: [f64; 3],
}

/// Bounds of `|V|`, `|A|`, `|J|` over the interval of a cubic.
///
/// # Errors
/// `NoConvergence` where too many intervals would be needed; `Interrupted`.
pub(super) fn enclosed(
    cubic: &RiemannianCubic,
    interrupt: Interrupt<'_>,
) -> Result<DerivativeBounds> {
    let mut sampler = Sampler::new(cubic)?;
    let (start, end) = cubic.t_span();
    let (low, high) = (start.min(end), start.max(end));
    let mut waiting = vec![(sampler.at(low)?, sampler.at(high)?)];
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
        let found = sampler.interval_bounds(&a, &b, width)?;
        if let Some(found) = found
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
        let centre = sampler.at(middle)?;
        for (largest, norm) in largest.iter_mut().zip(centre.norms) {
            *largest = largest.max(norm);
        }
        waiting.push((centre.clone(), b));
        waiting.push((a, centre));
    }
    Ok(DerivativeBounds {
        velocity: bounds[0],
        acceleration: bounds[1],
        jerk: bounds[2],
        guarantee: Guarantee::Enclosure,
    })
}

/// The largest bounds that are good enough, after the norms of samples on an interval of the given length.
///
/// A derivative may be zero all along where those of lower order are not: they count with that length as their unit of
/// time.
fn limits(norms: [f64; 3], length: f64) -> [f64; 3] {
    let rate = length.recip();
    let mut scale = 0.0;
    std::array::from_fn(|i| {
        scale = norms[i] + scale * rate;
        norms[i] + GAP * scale + ROUND_OFF * rate.powi(i as i32 + 1)
    })
}

impl Clone for Sample {
    fn clone(&self) -> Self {
        Sample {
            t: self.t,
            vectors: self.vectors.clone(),
            point: self.point.clone(),
            norms: self.norms,
        }
    }
}

struct Sampler<'a> {
    cubic: &'a RiemannianCubic,
    manifold: Stiefel,
    work: <RiemannianCubic as Curve>::Workspace,
    jet: Jet,
}

impl<'a> Sampler<'a> {
    fn new(cubic: &'a RiemannianCubic) -> Result<Self> {
        let rows = cubic.frame().map_or(cubic.n(), |frame| frame.ncols());
        Ok(Sampler {
            cubic,
            manifold: Stiefel::new(rows.max(cubic.k()), cubic.k())?,
            work: cubic.workspace(),
            jet: Jet::zeros(rows, cubic.k()),
        })
    }

    fn at(&mut self, t: f64) -> Result<Sample> {
        let jet = &mut self.jet;
        self.cubic.coordinates_into(t, 3, &mut self.work, jet)?;
        let [s, d1, d2, d3] = [0, 1, 2, 3].map(|j| &jet.c[j] * Scale([1.0, 1.0, 2.0, 6.0][j]));
        let [x, y, z] = [&d1, &d2, &d3].map(Mat::as_ref);
        let a = covariant::acceleration(s.as_ref(), x, y);
        let j = covariant::jerk(s.as_ref(), x, y, z);
        let bend = self
            .manifold
            .curvature(s.as_ref(), a.as_ref(), d1.as_ref(), d1.as_ref())?;
        let vectors = [d1, a, j, bend * Scale(-1.0)];
        let mut norms = [0.0; 3];
        for (norm, vector) in norms.iter_mut().zip(&vectors) {
            *norm = self.manifold.norm(s.as_ref(), vector.as_ref())?;
        }
        Ok(Sample {
            t,
            vectors,
            point: s,
            norms,
        })
    }

    /// `max |X_0 + tau Y_0|` for `tau` from 0 to `reach`: a convex function, largest at an end.
    fn reached(&self, at: &Sample, which: usize, reach: f64) -> Result<f64> {
        let moved = &at.vectors[which] + &at.vectors[which + 1] * Scale(reach);
        let point: MatRef<'_, f64> = at.point.as_ref();
        Ok(at.norms[which].max(self.manifold.norm(point, moved.as_ref())?))
    }

    /// Bounds on one interval; none where it is too wide for them.
    fn interval_bounds(&self, a: &Sample, b: &Sample, width: f64) -> Result<Option<[f64; 3]>> {
        let half = 0.5 * width;
        let base = [
            self.reached(a, 0, half)?.max(self.reached(b, 0, -half)?),
            self.reached(a, 1, half)?.max(self.reached(b, 1, -half)?),
            self.reached(a, 2, half)?.max(self.reached(b, 2, -half)?),
        ];
        let square = 0.5 * half * half;
        let right = |[v, a, j]: [f64; 3]| {
            let last = j * v * v + a * a * v + std::f64::consts::SQRT_2 * a * v * v * v;
            [
                base[0] + square * j,
                base[1] + square * CURVATURE * a * v * v,
                base[2] + square * CURVATURE * last,
            ]
        };
        let mut guess = base.map(|x| 1.125 * x);
        guess = right(guess);
        for _ in 0..MAX_ROUNDS {
            // A little above the right-hand sides of the guess before.
            let wider = guess.map(|x| x * (1.0 + INFLATION) + f64::MIN_POSITIVE);
            let next = right(wider);
            if next.iter().zip(wider).all(|(next, wider)| *next < wider) {
                return Ok(Some(wider));
            }
            guess = next;
        }
        Ok(None)
    }
}

fn not_converged(iterations: usize, width: f64) -> Error {
    Error::NoConvergence {
        solver: SOLVER,
        report: SolverReport {
            converged: false,
            iterations,
            residual: width,
            tolerance: GAP,
            reason: StopReason::MaxIterations,
        },
    }
}
