//! The search for a short geodesic in the coordinates of the frame: from a close start first, then from distant ones.

use std::f64::consts::PI;

use faer::{Mat, MatRef};

use super::descent::{GeodesicDescent, GeodesicStart};
use super::report::{LogReport, SOLVER, no_convergence, not_joined};
use super::shooting::{CLOSE_CONTRACTION, CLOSE_STEPS, GeodesicShooting, ShootingOutcome};
use super::shortening::Path;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::SkewSchur;
use crate::manifold::metric::Metric;
use crate::manifold::stiefel::Stiefel;

/// Each step from a good start must reduce the residual by this factor.
pub(super) const CONTRACTION: f64 = 0.7;

/// Maximal number of Newton steps from a good start: for conjugate points, convergence is linear.
const MAX_STEPS: usize = 30;

/// Maximal number of damped steps.
const DAMPED_STEPS: usize = 80;

/// Smallest step along the family of metrics.
const FINEST: f64 = 1.0 / 64.0;

/// Sum of the two largest angles of a generator below which the search ends: the largest eigenvalue of `ad_L` is below pi,
/// so the second derivative over the fibre is positive.
///
/// Of 54 000 pairs on nine shapes from St(8,4) to St(50,5), at distances of 0.89 to 1.8 pi (random directions, equal
/// angles, sparse directions), 11 000 had a geodesic from a close start, 941 of them below this sum; the search found a
/// shorter one for none of these, for none of 3169 with a sum of up to 7/6 pi, and for 83 of 6890 beyond. Of 49 500 other
/// pairs, on eleven shapes, none got a longer geodesic with this end of the search than without it. The whole search takes
/// 20 to 60 times as long as the close start.
const ISOLATED: f64 = PI;

/// Fraction of the conjectured injectivity radius up to which a geodesic from a close start is accepted without further
/// search.
const REACH: f64 = 0.85;

/// A geodesic longer than its initial path by this factor is not the one to which the path leads.
const LONGER: f64 = 1.0 + 1e-6;

/// Ratio of lengths below which a geodesic counts as shorter, beyond round-off.
const SHORTER: f64 = 1.0 - 1e-13;

/// Completions whose lengths differ by a smaller relative amount count as the same.
const SAME: f64 = 1e-9;

/// Corner angles of a path, relative to the length of a piece, at which Newton's method is tried.
const CORNERS: [f64; 3] = [0.1, 0.02, 2e-3];

/// Numbers of pieces of a path: four are enough for most, eight for the others.
const PIECES: [usize; 2] = [4, 8];

/// An angle of the generator within this times the size of pi counts as pi, given the accuracy of a logarithm there.
const NOT_UNIQUE: f64 = 32.0 * f64::EPSILON;

/// A geodesic in the coordinates of the frame.
pub(super) struct FoundGeodesic {
    /// `[[A, ..], [B, ..]]`.
    generator: Mat<f64>,
    k: usize,
    pub(super) report: LogReport,
}

impl FoundGeodesic {
    pub(super) fn a(&self) -> MatRef<'_, f64> {
        self.generator.as_ref().submatrix(0, 0, self.k, self.k)
    }

    pub(super) fn b(&self) -> MatRef<'_, f64> {
        let p = self.generator.nrows() - self.k;
        self.generator.as_ref().submatrix(self.k, 0, p, self.k)
    }
}

/// Return an error if the frame is rotated by pi in some plane: rotating by -pi gives another geodesic of the same
/// length, or the geodesic is not the shortest.
fn check_unique(canonical: MatRef<'_, f64>) -> Result<()> {
    let m = canonical.nrows();
    let mut schur = SkewSchur::new(m);
    schur.compute(canonical)?;
    match schur.angles().first() {
        Some(&angle) if PI - angle <= NOT_UNIQUE * m as f64 => Err(Error::NoJoiningCurve { angle }),
        _ => Ok(()),
    }
}

pub(super) struct Search<'a> {
    manifold: &'a Stiefel,
    target: &'a Mat<f64>,
    interrupt: Interrupt<'a>,
    tolerance: f64,
    iterations: usize,
    shooting: GeodesicShooting,
    best: Option<FoundGeodesic>,
    /// The shortest geodesic of the canonical metric, and its length.
    canonical: Option<(f64, Mat<f64>)>,
    /// Lengths of the completions whose paths have been shortened.
    seen: Vec<f64>,
    last: ShootingOutcome,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        manifold: &'a Stiefel,
        target: &'a Mat<f64>,
        interrupt: Interrupt<'a>,
    ) -> Self {
        Search {
            manifold,
            target,
            interrupt,
            tolerance: manifold.tolerance(target),
            iterations: 0,
            shooting: GeodesicShooting::new(target, manifold.metric().weight()),
            best: None,
            canonical: None,
            seen: Vec::new(),
            last: ShootingOutcome::NONE,
        }
    }

    pub(super) fn run(mut self) -> Result<FoundGeodesic> {
        self.shooting.start_close();
        let close = self
            .shooting
            .run(self.tolerance, CLOSE_CONTRACTION, CLOSE_STEPS)?;
        self.iterations = close.iterations;
        if close.converged {
            let isolated = self.is_isolated()?;
            let certain =
                self.length() < self.manifold.injectivity_bound() || isolated && self.is_rotation();
            let found = self.found(close.residual, certain);
            if certain || isolated || self.length() < self.reach() {
                return Ok(found);
            }
            self.best = Some(found);
        }
        self.far()
    }

    /// Length up to which a close geodesic is accepted, for a metric without a known bound.
    ///
    /// The minimum of half the shortest closed geodesics (`sqrt(2 w) pi` and `pi`) and of `pi` over the square root of
    /// the curvature of planes of `A` and `B`, for large `w` about `w / 2`. Among 60 random geodesics for each of eight
    /// weights `w` from 0.03 to 40, on St(4,2) and St(6,3), with lengths of 0.75 to 0.95 of this minimum, none was
    /// longer than another geodesic with the same ends.
    fn reach(&self) -> f64 {
        match self.manifold.metric() {
            Metric::CANONICAL | Metric::EUCLIDEAN => 0.0,
            metric => {
                let w = metric.weight();
                REACH * PI * (2.0 * w).min(2.0 / w).min(1.0).sqrt()
            }
        }
    }

    /// Whether the current geodesic of the canonical metric is a strict minimum over the fibre, since the two largest
    /// angles of its generator add up to less than [`ISOLATED`].
    fn is_isolated(&self) -> Result<bool> {
        if self.manifold.metric() != Metric::CANONICAL {
            return Ok(false);
        }
        let mut schur = SkewSchur::new(self.target.nrows());
        schur.compute(self.shooting.generator.as_ref())?;
        Ok(schur.angles().iter().take(2).sum::<f64>() < ISOLATED)
    }

    /// With one normal direction and the canonical metric, the fibre is a point, and the frames form `SO(n)`.
    fn is_rotation(&self) -> bool {
        self.manifold.k() + 1 == self.manifold.n() && self.manifold.metric() == Metric::CANONICAL
    }

    /// The shortest geodesic found from the completions of the target; the search ends after the first one that is
    /// certainly shortest or isolated.
    fn far(mut self) -> Result<FoundGeodesic> {
        let k = self.target.ncols();
        let mut descent = GeodesicDescent::new(k, self.target.nrows() - k);
        let before = self.iterations;
        let (starts, symmetric) = match descent.starts(self.target) {
            Ok(starts) => starts,
            Err(error) => {
                let best = self.best.take().filter(|_| !self.is_rotation());
                return best.ok_or_else(|| not_joined(error));
            }
        };
        for mut start in starts {
            self.iterations = before + descent.run(&mut start, self.interrupt)?;
            if self.attempt(&mut descent, &mut start)? {
                break;
            }
        }
        if let Some((_, generator)) = &self.canonical {
            let certain = self.best.as_ref().is_some_and(FoundGeodesic::is_certain);
            if !certain && (self.weight() == 0.5 || !symmetric) {
                check_unique(generator.as_ref())?;
            }
        }
        let (last, tolerance) = (self.last, self.tolerance);
        self.best.ok_or_else(|| no_convergence(last, tolerance))
    }

    /// Searches for geodesics from a start; returns whether the search may end, since one is certainly the shortest, or
    /// the first one from here is isolated.
    fn attempt(
        &mut self,
        descent: &mut GeodesicDescent,
        start: &mut GeodesicStart,
    ) -> Result<bool> {
        let canonical = self.weight() == 0.5;
        let mut generator = self.connect(start.log())?;
        if !canonical && let Some(generator) = &generator {
            let outcome = self.follow(generator)?;
            self.consider(outcome);
        }
        let certain = self.best.as_ref().is_some_and(FoundGeodesic::is_certain);
        if certain || generator.is_some() && self.is_isolated()? {
            return Ok(true);
        }
        let steps = descent.settle(start, self.interrupt)?;
        if steps > 0 || generator.is_none() {
            self.iterations += steps;
            generator = self.connect(start.log())?.or(generator);
        }
        if !canonical && self.is_new(start.length()) {
            let along = generator.as_ref().map_or(start.log(), Mat::as_ref);
            let outcome = self.shorten(along)?;
            self.consider(outcome);
        }
        Ok(self.best.as_ref().is_some_and(FoundGeodesic::is_certain))
    }

    /// A geodesic of the canonical metric, from a completion.
    fn connect(&mut self, start: MatRef<'_, f64>) -> Result<Option<Mat<f64>>> {
        self.shooting = GeodesicShooting::new(self.target, 0.5);
        self.shooting.start_from(start);
        let outcome = self.shooting.run(self.tolerance, CONTRACTION, MAX_STEPS)?;
        Ok(self.keep(outcome))
    }

    /// Stores a canonical geodesic that was found, and returns its generator.
    fn keep(&mut self, outcome: ShootingOutcome) -> Option<Mat<f64>> {
        self.last = outcome;
        if !outcome.converged {
            return None;
        }
        let (a, b) = self.shooting.norms();
        let length = b.hypot(a * 0.5_f64.sqrt());
        let generator = self.shooting.generator.clone();
        let shorter = |(shortest, _): &(f64, _)| length < SHORTER * shortest;
        if self.canonical.as_ref().is_none_or(shorter) {
            self.canonical = Some((length, generator.clone()));
        }
        if self.weight() == 0.5 {
            self.consider(outcome);
        } else {
            self.iterations += outcome.iterations;
        }
        Some(generator)
    }

    /// Stores the current geodesic if it is the shortest so far.
    fn consider(&mut self, outcome: ShootingOutcome) {
        self.iterations += outcome.iterations;
        self.last = outcome;
        let length = self.length();
        let shorter = |best: &FoundGeodesic| length < SHORTER * best.report.length;
        if outcome.converged && self.best.as_ref().is_none_or(shorter) {
            let certain = length < self.manifold.injectivity_bound() || self.is_rotation();
            self.best = Some(self.found(outcome.residual, certain));
        }
    }

    /// Follows the geodesic along the family of metrics, from the canonical one to that of the manifold.
    fn follow(&mut self, start: &Mat<f64>) -> Result<ShootingOutcome> {
        let weight = self.weight();
        let (mut reached, mut step, mut iterations) = (0.0, 1.0_f64, 0);
        self.shooting = GeodesicShooting::new(self.target, weight);
        self.shooting.set_weight(0.5);
        self.shooting.start_from(start.as_ref());
        loop {
            self.interrupt.check(SOLVER)?;
            let kept = self.shooting.generator.clone();
            let kept_weight = 0.5 * (2.0 * weight).powf(reached);
            let next = (reached + step).min(1.0);
            self.shooting.set_weight(0.5 * (2.0 * weight).powf(next));
            let contraction = if next < 1.0 {
                CLOSE_CONTRACTION
            } else {
                CONTRACTION
            };
            let outcome = self.shooting.run(self.tolerance, contraction, MAX_STEPS)?;
            iterations += outcome.iterations;
            if outcome.converged {
                reached = next;
                step *= 2.0;
            } else {
                step *= 0.5;
                self.shooting.set_weight(kept_weight);
                self.shooting.start_from(kept.as_ref());
            }
            if reached == 1.0 || step < FINEST {
                return Ok(ShootingOutcome {
                    converged: outcome.converged && reached == 1.0,
                    iterations,
                    residual: outcome.residual,
                });
            }
        }
    }

    /// The geodesic obtained by shortening the path along a canonical geodesic.
    fn shorten(&mut self, canonical: MatRef<'_, f64>) -> Result<ShootingOutcome> {
        let weight = self.weight();
        self.shooting = GeodesicShooting::new(self.target, weight);
        self.shooting.set_weight(0.5);
        self.shooting.start_from(canonical);
        self.shooting.set_weight(weight);
        let mut iterations = 0;
        for pieces in PIECES {
            let mut path = Path::along(self.target, canonical, weight, pieces)?;
            let mut short = true;
            for corner in CORNERS {
                let Some(start) = path.shorten(corner, self.interrupt)? else {
                    short = false;
                    break;
                };
                self.shooting.start_from(start.generator.as_ref());
                let outcome = self.shooting.run(self.tolerance, CONTRACTION, MAX_STEPS)?;
                iterations += outcome.iterations;
                // A longer geodesic is not the one to which the path leads, but a saddle that the path has left.
                if outcome.converged && self.length() <= LONGER * start.length {
                    return Ok(ShootingOutcome {
                        iterations,
                        ..outcome
                    });
                }
                self.shooting.start_from(start.generator.as_ref());
            }
            if short {
                break;
            }
        }
        let damped = self.shooting.run_damped(self.tolerance, DAMPED_STEPS)?;
        Ok(ShootingOutcome {
            iterations: iterations + damped.iterations,
            ..damped
        })
    }

    /// Whether no earlier start led to a canonical geodesic of this length.
    fn is_new(&mut self, length: f64) -> bool {
        let new = self.seen.iter().all(|x| (x - length).abs() > SAME * x);
        self.seen.push(length);
        new
    }

    fn weight(&self) -> f64 {
        self.manifold.metric().weight()
    }

    /// Length of the current geodesic.
    fn length(&self) -> f64 {
        let (a, b) = self.shooting.norms();
        b.hypot(a * self.weight().sqrt())
    }

    fn found(&self, residual: f64, certainly_shortest: bool) -> FoundGeodesic {
        let k = self.target.ncols();
        let twice = 2.0 * self.weight();
        let mut generator = self.shooting.generator.clone();
        for j in 0..k {
            for i in 0..k {
                generator[(i, j)] /= twice;
            }
        }
        FoundGeodesic {
            generator,
            k,
            report: LogReport {
                converged: true,
                iterations: self.iterations,
                residual,
                length: self.length(),
                certainly_shortest,
            },
        }
    }
}

impl FoundGeodesic {
    fn is_certain(&self) -> bool {
        self.report.certainly_shortest
    }
}
