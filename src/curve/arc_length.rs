//! Arc length of a curve, its inverse, and the curve at constant speed.

use rayon::prelude::*;

use super::cost::{POINTS, gauss_legendre};
use super::{Curve, Quantity, Samples, check_parameter};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::Jet;
use crate::manifold::Stiefel;
use crate::report::{SolverReport, StopReason};

const SOLVER: &str = "arc length quadrature";

/// Error of the length of the whole curve, relative; panels get their share by their own length.
const TOLERANCE: f64 = 1e-13;

/// The velocity is known to this much of a radian over the interval: a curve of less length does not move.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// A panel is halved so often at the most. Where the speed vanishes it has a corner, and each halving takes three
/// quarters of the error away.
const MAX_HALVINGS: usize = 40;

/// Panels between two breakpoints at the most.
const MAX_PANELS: usize = 1 << 16;

/// Intervals, or lengths to invert, that one thread does together.
const BLOCK: usize = 64;

/// Steps of the inversion in one panel at the most; bisection alone needs 53.
const MAX_STEPS: usize = 120;

/// The length of a curve from the start of an interval, as a function that can be inverted.
///
/// ```math
/// s(t) = \int_{t_0}^{t} |S'(\tau)|\, d\tau
/// ```
///
/// in the canonical metric. Gauss-Legendre quadrature on panels that are halved until both halves together agree with
/// the whole; panels end at the breakpoints of the curve.
///
/// # Accuracy
/// Lengths and inverses relative to 1e-12 of the total, or to round-off of the velocity or of the parameter where that is more.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::curve::ArcLength;
/// use stiefel_rs::{Interrupt, QuasiGeodesic};
/// let (x, y) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]]);
/// let quarter = QuasiGeodesic::between(x.as_ref(), y.as_ref())?;
/// let length = ArcLength::of(&quarter, Interrupt::NEVER)?;
/// assert!((length.total() - std::f64::consts::FRAC_PI_2).abs() < 1e-14);
/// assert!((length.parameter(length.total() / 4.0)? - 0.25).abs() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct ArcLength<'a, C: Curve> {
    curve: &'a C,
    rule: Rule,
    panels: Vec<Panel>,
    total: f64,
    interrupt: Interrupt<'a>,
}

/// A piece of the interval on which one application of the rule is enough.
struct Panel {
    start: f64,
    end: f64,
    /// Length before it.
    before: f64,
    length: f64,
}

/// What the length of a panel may miss.
struct Allowed {
    /// In any panel.
    whole: f64,
    /// In a panel of length one of the parameter.
    noise: f64,
}

/// A quadrature rule.
struct Rule {
    nodes: Vec<f64>,
    weights: Vec<f64>,
    /// What the polynomial through the values at the nodes is at the end of the panel, and mirrored at its start.
    continuation: Vec<f64>,
}

impl Rule {
    fn new() -> Self {
        let (nodes, weights) = gauss_legendre(POINTS);
        let share = |i: usize| {
            let others = (0..POINTS).filter(|j| *j != i);
            others.fold(1.0, |product, j| {
                product * (1.0 - nodes[j]) / (nodes[i] - nodes[j])
            })
        };
        Rule {
            continuation: (0..POINTS).map(share).collect(),
            nodes,
            weights,
        }
    }

    /// The integral, how far off it may be because of a corner between an end and the node beside it, and by how much the
    /// integrand varies.
    ///
    /// No node sees such a corner. But the polynomial through the nodes misses the value at the end by twice the slope
    /// times the distance of the corner from the end, and the integral by the slope times the square of that distance.
    fn guarded(
        &self,
        a: f64,
        b: f64,
        mut integrand: impl FnMut(f64) -> Result<f64>,
    ) -> Result<[f64; 3]> {
        let ends = [integrand(a)?, integrand(b)?];
        let (mut least, mut most) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let (mut at_start, mut at_end, mut place) = (0.0, 0.0, 0);
        let integral = self.integral(a, b, |t| {
            let value = integrand(t)?;
            at_end += self.continuation[place] * value;
            at_start += self.continuation[POINTS - 1 - place] * value;
            place += 1;
            (least, most) = (least.min(value), most.max(value));
            Ok(value)
        })?;
        let miss = (at_start - ends[0]).abs().max((at_end - ends[1]).abs());
        // The outermost node is this share of the panel away from its end.
        let gap = 0.5 * (1.0 - self.nodes[0].abs());
        Ok([integral, 0.5 * miss * gap * (b - a), most - least])
    }

    fn integral(
        &self,
        a: f64,
        b: f64,
        mut integrand: impl FnMut(f64) -> Result<f64>,
    ) -> Result<f64> {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        let mut sum = 0.0;
        for (x, w) in self.nodes.iter().zip(&self.weights) {
            sum += w * integrand(middle + half * x)?;
        }
        Ok(half * sum)
    }
}

/// The speed of a curve, in buffers made once.
struct Speed<'a, C: Curve> {
    curve: &'a C,
    manifold: Stiefel,
    work: C::Workspace,
    jet: Jet,
}

impl<'a, C: Curve> Speed<'a, C> {
    fn new(curve: &'a C) -> Result<Self> {
        let rows = curve.frame().map_or(curve.n(), |frame| frame.ncols());
        Ok(Speed {
            curve,
            manifold: Stiefel::new(rows.max(curve.k()), curve.k())?,
            work: curve.workspace(),
            jet: Jet::zeros(rows, curve.k()),
        })
    }

    fn at(&mut self, t: f64) -> Result<f64> {
        self.curve
            .coordinates_into(t, 1, &mut self.work, &mut self.jet)?;
        self.manifold
            .norm_along("arc length", self.jet.c[0].as_ref(), self.jet.c[1].as_ref())
    }
}

impl<'a, C: Curve> ArcLength<'a, C> {
    /// Over the interval that the curve is made for.
    ///
    /// # Errors
    /// `NoConvergence`, `Overflow`, `Interrupted`, and where the curve does not exist.
    pub fn of(curve: &'a C, interrupt: Interrupt<'a>) -> Result<Self> {
        let (start, end) = curve.t_span();
        Self::between(curve, start.min(end), start.max(end), interrupt)
    }

    /// From `start` to `end >= start`.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument`, and those of [`ArcLength::of`].
    pub fn between(curve: &'a C, start: f64, end: f64, interrupt: Interrupt<'a>) -> Result<Self> {
        check_parameter(start)?;
        check_parameter(end)?;
        if end < start {
            return Err(Error::InvalidArgument {
                name: "t1",
                requirement: "at least t0",
                found: end,
            });
        }
        // Where there is no curve, the error is about the given time.
        for t in [start, end] {
            curve.point(t)?;
        }
        let mut length = ArcLength {
            curve,
            rule: Rule::new(),
            panels: Vec::new(),
            total: 0.0,
            interrupt,
        };
        let inner = curve.breakpoints().into_iter();
        let mut ends: Vec<f64> = inner.filter(|t| start < *t && *t < end).collect();
        ends.push(end);
        length.build(start, &ends)?;
        Ok(length)
    }

    fn build(&mut self, start: f64, ends: &[f64]) -> Result<()> {
        let starts = std::iter::once(start).chain(ends.iter().copied());
        let intervals: Vec<[f64; 2]> = starts.zip(ends).map(|(from, to)| [from, *to]).collect();
        let lengths = self.in_blocks(&intervals, |[from, to], speed| {
            self.rule.integral(*from, *to, |t| speed.at(t))
        })?;
        // A first estimate of the whole tells what a panel may miss.
        let whole: f64 = lengths.iter().sum();
        if !whole.is_finite() {
            return Err(Error::Overflow { quantity: "length" });
        }
        let noise = match ends.last() {
            Some(end) if *end > start => ROUND_OFF / (end - start),
            _ => 0.0,
        };
        let allowed = Allowed {
            whole: TOLERANCE * whole,
            noise,
        };
        let estimates: Vec<_> = intervals.into_iter().zip(lengths).collect();
        let panels = self.in_blocks(&estimates, |([from, to], length), speed| {
            self.panels_of(*from, *to, *length, &allowed, speed)
        })?;
        for [start, end, length] in panels.into_iter().flatten() {
            self.accept(start, end, length);
        }
        if self.total.is_finite() {
            return Ok(());
        }
        Err(Error::Overflow { quantity: "length" })
    }

    /// What `work` makes of each item, blocks of them on one thread each.
    fn in_blocks<T: Sync, R: Send>(
        &self,
        items: &[T],
        work: impl Fn(&T, &mut Speed<'_, C>) -> Result<R> + Sync,
    ) -> Result<Vec<R>> {
        let block = |items: &[T]| -> Result<Vec<R>> {
            let mut speed = Speed::new(self.curve)?;
            items
                .iter()
                .map(|item| {
                    self.interrupt.check(SOLVER)?;
                    work(item, &mut speed)
                })
                .collect()
        };
        if items.len() <= BLOCK {
            return block(items);
        }
        let parts: Vec<Vec<R>> = items.par_chunks(BLOCK).map(block).collect::<Result<_>>()?;
        Ok(parts.into_iter().flatten().collect())
    }

    /// Start, end and length of the panels of an interval of about the given length.
    fn panels_of(
        &self,
        from: f64,
        to: f64,
        length: f64,
        allowed: &Allowed,
        speed: &mut Speed<'_, C>,
    ) -> Result<Vec<[f64; 3]>> {
        let mut panels = Vec::new();
        let mut waiting = vec![(from, to, length, 0)];
        while let Some((a, b, length, halvings)) = waiting.pop() {
            self.interrupt.check(SOLVER)?;
            let middle = 0.5 * (a + b);
            let mut half = |a, b| self.rule.guarded(a, b, |t| speed.at(t));
            let [left_half, right_half] = [half(a, middle)?, half(middle, b)?];
            let ([left, left_miss, left_change], [right, right_miss, right_change]) =
                (left_half, right_half);
            let change = (left + right - length).abs().max(left_miss).max(right_miss);
            // Far from zero the nodes are where the spacing of numbers allows.
            let spacing = f64::EPSILON * a.abs().max(b.abs());
            let allowed = allowed.whole.max(TOLERANCE * (left + right))
                + allowed.noise * (b - a)
                + spacing * (left_change + right_change);
            if change <= allowed || middle <= a || middle >= b {
                panels.extend([[a, middle, left], [middle, b, right]]);
                continue;
            }
            if halvings == MAX_HALVINGS || panels.len() + waiting.len() >= MAX_PANELS {
                return Err(not_converged(halvings, change, allowed));
            }
            waiting.push((middle, b, right, halvings + 1));
            waiting.push((a, middle, left, halvings + 1));
        }
        Ok(panels)
    }

    fn accept(&mut self, start: f64, end: f64, length: f64) {
        self.panels.push(Panel {
            start,
            end,
            before: self.total,
            length,
        });
        self.total += length;
    }

    /// The length of the whole interval.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// The parameter at which the length from the start is `length`.
    ///
    /// Where the curve rests there are many: one of them.
    ///
    /// # Errors
    /// `NonFinite`; `InvalidArgument` unless `0 <= length <= total` (to round-off).
    pub fn parameter(&self, length: f64) -> Result<f64> {
        Ok(self.parameters(&[length])?[0])
    }

    /// [`ArcLength::parameter`] of many lengths.
    ///
    /// # Errors
    /// As [`ArcLength::parameter`], with the index of a length that is not finite; `Interrupted`.
    pub fn parameters(&self, lengths: &[f64]) -> Result<Vec<f64>> {
        let slack = 4.0 * TOLERANCE * self.total;
        for (index, &length) in lengths.iter().enumerate() {
            if !length.is_finite() {
                return Err(Error::NonFinite {
                    name: "length",
                    index,
                });
            }
            if length < -slack || length > self.total + slack {
                return Err(Error::InvalidArgument {
                    name: "length",
                    requirement: "from 0 to the length of the curve",
                    found: length,
                });
            }
        }
        self.in_blocks(lengths, |length, speed| self.invert(*length, speed))
    }

    /// Parameters of `count` points at equal lengths, the first and the last one at the ends of the interval.
    ///
    /// For a curve that does not move, equal steps of the parameter.
    ///
    /// # Errors
    /// `InvalidArgument` for fewer than two, or more than fit in memory; `Interrupted`.
    pub fn equal(&self, count: usize) -> Result<Vec<f64>> {
        if count < 2 {
            return Err(Error::InvalidArgument {
                name: "count",
                requirement: "at least 2",
                found: count as f64,
            });
        }
        // Lengths, parameters, and the parts that these are put together from.
        if Vec::<[f64; 3]>::new().try_reserve_exact(count).is_err() {
            return Err(Error::InvalidArgument {
                name: "count",
                requirement: "few enough points for them to fit in memory",
                found: count as f64,
            });
        }
        let (start, end) = self.interval();
        let share = |i: usize| i as f64 / (count - 1) as f64;
        if self.total <= ROUND_OFF {
            return Ok((0..count)
                .map(|i| start + share(i) * (end - start))
                .collect());
        }
        let lengths: Vec<f64> = (0..count).map(|i| share(i) * self.total).collect();
        let mut parameters = self.parameters(&lengths)?;
        (parameters[0], parameters[count - 1]) = (start, end);
        Ok(parameters)
    }

    /// The curve at constant speed, sampled: its positions at [`ArcLength::equal`] parameters.
    ///
    /// # Errors
    /// As [`ArcLength::equal`] and [`Curve::sample`].
    pub fn sample(&self, count: usize) -> Result<Samples> {
        let parameters = self.equal(count)?;
        self.curve
            .sample(&parameters, Quantity::Derivative(0), self.interrupt)
    }

    fn interval(&self) -> (f64, f64) {
        let (first, last) = (&self.panels[0], &self.panels[self.panels.len() - 1]);
        (first.start, last.end)
    }

    /// Newton's method, kept between bounds by bisection.
    fn invert(&self, length: f64, speed: &mut Speed<'_, C>) -> Result<f64> {
        let ahead = self
            .panels
            .partition_point(|panel| panel.before + panel.length < length);
        let panel = &self.panels[ahead.min(self.panels.len() - 1)];
        let wanted = length - panel.before;
        if wanted <= 0.0 || wanted >= panel.length {
            return Ok(if wanted <= 0.0 {
                panel.start
            } else {
                panel.end
            });
        }
        let (mut low, mut high) = (panel.start, panel.end);
        let mut t = low + (high - low) * wanted / panel.length;
        for _ in 0..MAX_STEPS {
            let excess = self.rule.integral(panel.start, t, |t| speed.at(t))? - wanted;
            if excess > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let newton = t - excess / speed.at(t)?;
            let spacing = 2.0 * f64::EPSILON * t.abs().max(panel.end - panel.start);
            if excess.abs() <= f64::EPSILON * self.total || (newton - t).abs() <= spacing {
                break;
            }
            t = if low < newton && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            if high - low <= spacing {
                break;
            }
        }
        Ok(t)
    }
}

fn not_converged(iterations: usize, residual: f64, tolerance: f64) -> Error {
    Error::NoConvergence {
        solver: SOLVER,
        report: SolverReport {
            converged: false,
            iterations,
            residual,
            tolerance,
            reason: StopReason::MaxIterations,
        },
    }
}
