//! The length of a curve from its speed, by quadrature on panels that are halved until they are accurate.

use super::gauss_legendre::{PANEL, POINTS};
use super::length_inverse::{LengthPart, VALUES};
use super::norms::{NormEvaluation, Norms};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::report::{SolverReport, StopReason};
use crate::threads::{self, ALWAYS};

const SOLVER: &str = "arc length quadrature";

/// Relative error of the length of the whole curve; each panel is allowed its share by length.
pub(super) const TOLERANCE: f64 = 1e-13;

/// Round-off of the velocity, in radians over the interval: a shorter curve counts as not moving.
pub(super) const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// Maximal number of times a panel is halved. If the speed vanishes it has a corner, and each halving removes three
/// quarters of the error.
const MAX_HALVINGS: usize = 40;

/// Maximal number of panels between two breakpoints.
const MAX_PANELS: usize = 1 << 16;

/// Maximal number of parts of a panel for the inversion. A corner of the speed takes up to 19, at 40 places tried.
const MAX_PARTS: usize = 1 << 10;

/// Number of intervals or panels processed together on one thread.
const BLOCK: usize = 64;

/// Number of lengths inverted together on one thread: two milliseconds of work, between two questions for Ctrl-C.
const LENGTHS: usize = 4096;

/// The lengths of consecutive panels, from the start of an interval.
pub(super) struct Length {
    rule: Rule,
    panels: Vec<Panel>,
    total: f64,
    allowed: Allowed,
}

/// A part of the interval on which a single application of the rule is accurate.
struct Panel {
    start: f64,
    end: f64,
    /// Length before it.
    before: f64,
    length: f64,
    /// At its start, at its end, and at the nodes.
    speeds: [f64; VALUES],
}

/// The rule applied to an interval.
struct SampledLength {
    length: f64,
    /// A bound on the error caused by a corner between an end and the nearest node.
    miss: f64,
    /// The difference between the largest and the smallest speed.
    variation: f64,
    speeds: [f64; VALUES],
}

/// Allowed error of the length of a panel.
#[derive(Clone, Copy, Default)]
struct Allowed {
    /// For any panel.
    whole: f64,
    /// Per unit of the panel's parameter length.
    noise: f64,
}

impl Allowed {
    /// For a panel with the given ends and difference between its largest and its smallest speed.
    fn on(self, [a, b]: [f64; 2], variation: f64) -> f64 {
        // Far from zero, the spacing of floating-point numbers limits the accuracy of the nodes.
        let spacing = f64::EPSILON * a.abs().max(b.abs());
        self.whole + self.noise * (b - a) + spacing * variation
    }
}

/// A quadrature rule.
struct Rule {
    nodes: Vec<f64>,
    weights: Vec<f64>,
    /// Factors of the values at the nodes that evaluate their polynomial at the end of the panel; mirrored, at its
    /// start.
    continuation: Vec<f64>,
}

impl Rule {
    fn new() -> Self {
        let (nodes, weights) = PANEL.clone();
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

    /// The integral, with a guard against corners near an end.
    ///
    /// No node sees such a corner, but the polynomial through the nodes misses the value at the end by twice the slope
    /// times the distance of the corner from the end, and the integral by the slope times the square of that distance.
    fn guarded(
        &self,
        a: f64,
        b: f64,
        speed: &mut Norms<impl NormEvaluation>,
    ) -> Result<SampledLength> {
        let mut t = [a; VALUES];
        t[1] = b;
        self.places_into(a, b, &mut t[2..]);
        let mut speeds = [0.0; VALUES];
        speed.speeds(&t, &mut speeds)?;
        let (ends, inner) = speeds.split_at(2);
        let (mut integral, mut at_start, mut at_end) = (0.0, 0.0, 0.0);
        for (place, value) in inner.iter().enumerate() {
            integral += self.weights[place] * value;
            at_end += self.continuation[place] * value;
            at_start += self.continuation[POINTS - 1 - place] * value;
        }
        let miss = (at_start - ends[0]).abs().max((at_end - ends[1]).abs());
        // Distance of the outermost node from the end, as a fraction of the panel.
        let gap = 0.5 * (1.0 - self.nodes[0].abs());
        Ok(SampledLength {
            length: 0.5 * (b - a) * integral,
            miss: 0.5 * miss * gap * (b - a),
            variation: variation(&speeds),
            speeds,
        })
    }

    fn integral(&self, a: f64, b: f64, speed: &mut Norms<impl NormEvaluation>) -> Result<f64> {
        let (mut t, mut values) = ([0.0; POINTS], [0.0; POINTS]);
        self.places_into(a, b, &mut t);
        speed.speeds(&t, &mut values)?;
        let sum: f64 = values.iter().zip(&self.weights).map(|(x, w)| w * x).sum();
        Ok(0.5 * (b - a) * sum)
    }

    /// The nodes in a panel.
    fn places_into(&self, a: f64, b: f64, out: &mut [f64]) {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        for (t, x) in out.iter_mut().zip(&self.nodes) {
            *t = middle + half * x;
        }
    }
}

impl Length {
    /// The lengths from `start` to `end`, with panels that end at the breakpoints in between; `speed` creates the norms of
    /// a thread.
    ///
    /// # Errors
    /// `NoConvergence`, `Overflow`, `Interrupted`, and an error if the curve does not exist somewhere.
    pub(super) fn between<F: NormEvaluation>(
        start: f64,
        end: f64,
        breakpoints: Vec<f64>,
        speed: impl Fn() -> Result<Norms<F>> + Sync,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let mut length = Length {
            rule: Rule::new(),
            panels: Vec::new(),
            total: 0.0,
            allowed: Allowed::default(),
        };
        let inner = breakpoints.into_iter();
        let mut ends: Vec<f64> = inner.filter(|t| start < *t && *t < end).collect();
        ends.push(end);
        length.build(start, &ends, speed, interrupt)?;
        Ok(length)
    }

    fn build<F: NormEvaluation>(
        &mut self,
        start: f64,
        ends: &[f64],
        speed: impl Fn() -> Result<Norms<F>> + Sync,
        interrupt: Interrupt<'_>,
    ) -> Result<()> {
        let starts = std::iter::once(start).chain(ends.iter().copied());
        let intervals: Vec<[f64; 2]> = starts.zip(ends).map(|(from, to)| [from, *to]).collect();
        let lengths = in_blocks(&intervals, &speed, interrupt, |[from, to], speed| {
            self.rule.integral(*from, *to, speed)
        })?;
        // A first estimate of the total length determines the allowed error of a panel.
        let whole: f64 = lengths.iter().sum();
        if !whole.is_finite() {
            return Err(Error::Overflow { quantity: "length" });
        }
        let noise = match ends.last() {
            Some(end) if *end > start => ROUND_OFF / (end - start),
            _ => 0.0,
        };
        self.allowed = Allowed {
            whole: TOLERANCE * whole,
            noise,
        };
        let estimates: Vec<_> = intervals.into_iter().zip(lengths).collect();
        let panels = in_blocks(
            &estimates,
            &speed,
            interrupt,
            |([from, to], length), speed| self.panels_of([*from, *to], *length, speed, interrupt),
        )?;
        for panel in panels.into_iter().flatten() {
            let before = self.total;
            self.total += panel.length;
            self.panels.push(Panel { before, ..panel });
        }
        if self.total.is_finite() {
            return Ok(());
        }
        Err(Error::Overflow { quantity: "length" })
    }

    /// The panels of an interval, given an estimate of its length.
    fn panels_of<F: NormEvaluation>(
        &self,
        [from, to]: [f64; 2],
        length: f64,
        speed: &mut Norms<F>,
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Panel>> {
        let mut panels = Vec::new();
        let mut waiting = vec![(from, to, length, 0)];
        while let Some((a, b, length, halvings)) = waiting.pop() {
            interrupt.check(SOLVER)?;
            let middle = 0.5 * (a + b);
            let mut half = |a, b| self.rule.guarded(a, b, speed);
            let (left, right) = (half(a, middle)?, half(middle, b)?);
            let both = left.length + right.length;
            let change = (both - length).abs().max(left.miss).max(right.miss);
            let allowed = Allowed {
                whole: self.allowed.whole.max(TOLERANCE * both),
                ..self.allowed
            };
            let allowed = allowed.on([a, b], left.variation + right.variation);
            if change <= allowed || middle <= a || middle >= b {
                for (start, end, half) in [(a, middle, left), (middle, b, right)] {
                    panels.push(Panel {
                        start,
                        end,
                        before: 0.0,
                        length: half.length,
                        speeds: half.speeds,
                    });
                }
                continue;
            }
            if halvings == MAX_HALVINGS || panels.len() + waiting.len() >= MAX_PANELS {
                return Err(not_converged(halvings, change, allowed));
            }
            waiting.push((middle, b, right.length, halvings + 1));
            waiting.push((a, middle, left.length, halvings + 1));
        }
        Ok(panels)
    }

    /// The length of the whole interval.
    pub(super) fn total(&self) -> f64 {
        self.total
    }

    /// Start and end.
    pub(super) fn interval(&self) -> (f64, f64) {
        let (first, last) = (&self.panels[0], &self.panels[self.panels.len() - 1]);
        (first.start, last.end)
    }

    /// The parameters at which the length from the start is one of `lengths`.
    ///
    /// # Errors
    /// `Interrupted`, and an error if the curve does not exist somewhere.
    pub(super) fn parameters<F: NormEvaluation>(
        &self,
        lengths: &[f64],
        speed: impl Fn() -> Result<Norms<F>> + Sync,
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<f64>> {
        let panels: Vec<usize> = lengths
            .iter()
            .map(|length| self.panel_of(*length))
            .collect();
        let mut wanted = panels.clone();
        wanted.sort_unstable();
        wanted.dedup();
        let parts = in_blocks(&wanted, &speed, interrupt, |panel, speed| {
            self.parts_of(&self.panels[*panel], speed, interrupt)
        })?;
        let parameter = |(length, panel): (&f64, &usize)| {
            let known = wanted.partition_point(|other| other < panel);
            self.parameter(*length, &self.panels[*panel], &parts[known])
        };
        let blocks: Vec<_> = lengths
            .chunks(LENGTHS)
            .zip(panels.chunks(LENGTHS))
            .collect();
        let some = |(): &mut (), block: usize| -> Result<Vec<f64>> {
            interrupt.check(SOLVER)?;
            let (lengths, panels) = blocks[block];
            Ok(lengths.iter().zip(panels).map(parameter).collect())
        };
        let found = threads::map(blocks.len(), ALWAYS, || (), some)?;
        Ok(found.concat())
    }

    /// The panel that contains the point at a length from the start.
    fn panel_of(&self, length: f64) -> usize {
        let ahead = self
            .panels
            .partition_point(|panel| panel.before + panel.length < length);
        ahead.min(self.panels.len() - 1)
    }

    /// A panel in parts on which the speed is a polynomial, to the accuracy of the whole length or to the round-off of
    /// the speeds: below that, halving would not end.
    fn parts_of(
        &self,
        panel: &Panel,
        speed: &mut Norms<impl NormEvaluation>,
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<LengthPart>> {
        let mut parts = Vec::new();
        let mut waiting = vec![(panel.start, panel.end, panel.speeds)];
        while let Some((a, b, speeds)) = waiting.pop() {
            interrupt.check(SOLVER)?;
            let part = LengthPart::new([a, b], &speeds);
            let middle = 0.5 * (a + b);
            let allowed = self.allowed.on([a, b], variation(&speeds));
            let is_full = parts.len() + waiting.len() >= MAX_PARTS;
            if part.error() <= allowed || middle <= a || middle >= b || is_full {
                parts.push(part);
                continue;
            }
            for [a, b] in [[middle, b], [a, middle]] {
                waiting.push((a, b, self.rule.guarded(a, b, speed)?.speeds));
            }
        }
        Ok(parts)
    }

    /// The parameter at a length from the start, in a panel with the given parts.
    fn parameter(&self, length: f64, panel: &Panel, parts: &[LengthPart]) -> f64 {
        let mut wanted = length - panel.before;
        if wanted <= 0.0 {
            return panel.start;
        }
        for part in parts {
            if wanted < part.total() {
                return part.parameter(wanted, f64::EPSILON * self.total);
            }
            wanted -= part.total();
        }
        panel.end
    }
}

/// The difference between the largest and the smallest speed.
fn variation(speeds: &[f64]) -> f64 {
    let [low, high] = speeds.iter().fold([f64::INFINITY, 0.0], |[low, high], x| {
        [x.min(low), x.max(high)]
    });
    high - low
}

/// Applies `work` to each item, with blocks of items on one thread each.
fn in_blocks<T: Sync, R: Send, F: NormEvaluation>(
    items: &[T],
    speed: impl Fn() -> Result<Norms<F>> + Sync,
    interrupt: Interrupt<'_>,
    work: impl Fn(&T, &mut Norms<F>) -> Result<R> + Sync,
) -> Result<Vec<R>> {
    let blocks: Vec<&[T]> = items.chunks(BLOCK).collect();
    let some = |(): &mut (), block: usize| -> Result<Vec<R>> {
        let mut speed = speed()?;
        blocks[block]
            .iter()
            .map(|item| {
                interrupt.check(SOLVER)?;
                work(item, &mut speed)
            })
            .collect()
    };
    let parts = threads::map(blocks.len(), ALWAYS, || (), some)?;
    Ok(parts.into_iter().flatten().collect())
}

fn not_converged(iterations: usize, residual: f64, tolerance: f64) -> Error {
    Error::NoConvergence {
        solver: SOLVER,
        report: SolverReport::new(StopReason::MaxIterations, iterations, residual, tolerance),
    }
}
