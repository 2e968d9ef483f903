//! A curve made of consecutive pieces.

use std::sync::Arc;

use faer::MatRef;

use crate::curve::sampling::{check_parameter, rounded_to_end};
use crate::curve::{Curve, DerivativeBounds, Quantity, Samples};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::MatrixJet;
use crate::linalg::lanes::LANES;
use crate::linalg::product::{mul_into, scale};
use crate::space::Quotient;
use crate::threads::{self, ALWAYS};

/// Consecutive curves on `[0, 1]`, each traversed between two knots.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Interrupt};
/// use stiefel_rs::spline::geometric_hermite;
/// // On the circle, at rest at every knot: by the angle 3 t^2 - 2 t^3, and back.
/// let points = [0.0_f64, 1.0, 0.0].map(|a| mat![[a.cos()], [a.sin()]]);
/// let rest = mat![[0.0], [0.0]];
/// let views = points.each_ref().map(|point| point.as_ref());
/// let curve = geometric_hermite(&[0.0, 1.0, 3.0], &views, &[rest.as_ref(); 3])?;
/// assert_eq!((curve.pieces().len(), curve.t_span()), (2, (0.0, 3.0)));
/// // The cost of a piece, 12, over the cube of its length.
/// assert!((curve.cost(Interrupt::NEVER)? - (12.0 + 12.0 / 8.0)).abs() < 1e-10);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
///
/// Clones share the pieces.
#[derive(Debug)]
pub struct Piecewise<C> {
    knots: Arc<[f64]>,
    pieces: Arc<[C]>,
    outside: Outside,
}

impl<C> Clone for Piecewise<C> {
    fn clone(&self) -> Self {
        Piecewise {
            knots: Arc::clone(&self.knots),
            pieces: Arc::clone(&self.pieces),
            outside: self.outside,
        }
    }
}

/// Behaviour of a curve outside its interval.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Curve;
/// use stiefel_rs::spline::{Outside, geometric_hermite};
/// // On the circle at unit speed.
/// let point = |a: f64| mat![[a.cos()], [a.sin()]];
/// let velocity = |a: f64| mat![[-a.sin()], [a.cos()]];
/// let (s, v) = ([point(0.0), point(1.0)], [velocity(0.0), velocity(1.0)]);
/// let (s, v) = (s.each_ref().map(|s| s.as_ref()), v.each_ref().map(|v| v.as_ref()));
/// let curve = geometric_hermite(&[0.0, 1.0], &s, &v)?;
/// assert!(curve.point(1.5).is_err());
/// let longer = curve.with_outside(Outside::Continued);
/// assert!((longer.point(1.5)? - point(1.5)).norm_l2() < 1e-13);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// Such times are errors, except within four units in the last place of an end, which count as that end.
    Refused,
    /// The first and the last piece are extrapolated.
    Continued,
}

impl<C: Curve> Piecewise<C> {
    /// There is one more knot than pieces; the caller has checked the knots.
    pub(super) fn new(knots: Vec<f64>, pieces: Vec<C>) -> Self {
        debug_assert_eq!(knots.len(), pieces.len() + 1);
        Piecewise {
            knots: knots.into(),
            pieces: pieces.into(),
            outside: Outside::Refused,
        }
    }

    /// The same curve with another behaviour outside its interval.
    pub fn with_outside(self, outside: Outside) -> Self {
        Piecewise { outside, ..self }
    }

    /// Behaviour of the curve outside its interval.
    pub fn outside(&self) -> Outside {
        self.outside
    }

    /// The times at which the pieces join, including both ends.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The pieces, each on `[0, 1]`.
    pub fn pieces(&self) -> &[C] {
        &self.pieces
    }

    /// The piece at a time; at an interior knot, the later one.
    fn find(&self, t: f64) -> Result<usize> {
        check_parameter(t)?;
        let (first, last) = Curve::t_span(self);
        let t = self.snapped(t);
        if self.outside == Outside::Refused && !(first..=last).contains(&t) {
            return Err(Error::InvalidArgument {
                name: "t",
                requirement: "between the first and the last knot (or enable extrapolation)",
                found: t,
            });
        }
        let after = self.knots.partition_point(|knot| *knot <= t);
        Ok(after.clamp(1, self.pieces.len()) - 1)
    }

    fn length(&self, piece: usize) -> f64 {
        self.knots[piece + 1] - self.knots[piece]
    }

    /// The time, or the end that it misses only by rounding if times outside are errors.
    fn snapped(&self, t: f64) -> f64 {
        match self.outside {
            Outside::Refused => rounded_to_end(t, Curve::t_span(self)),
            Outside::Continued => t,
        }
    }

    pub(super) fn local(&self, piece: usize, t: f64) -> f64 {
        (self.snapped(t) - self.knots[piece]) / self.length(piece)
    }

    /// Writes Taylor coefficients of one piece with respect to the time of the whole curve.
    fn jets_of_piece(
        &self,
        which: usize,
        t: &[f64],
        order: usize,
        work: &mut PiecewiseWorkspace<C::Workspace>,
        out: &mut [MatrixJet],
    ) -> Result<()> {
        let (piece, k) = (&self.pieces[which], self.k());
        let rows = piece.frame().map_or(self.n(), |frame| frame.ncols());
        let (_, inner, jets) = match &mut work.last {
            Some(last) if last.0 == which => last,
            last => last.insert((which, piece.workspace(), Vec::new())),
        };
        for (t, out) in t.chunks(LANES).zip(out.chunks_mut(LANES)) {
            if jets.len() < t.len() {
                jets.resize_with(t.len(), || MatrixJet::zeros(rows, k));
            }
            let mut local = [0.0; LANES];
            for (local, t) in local.iter_mut().zip(t) {
                *local = self.local(which, *t);
            }
            let jets = &mut jets[..t.len()];
            piece.jets_into(&local[..t.len()], order, inner, jets)?;
            let rate = 1.0 / self.length(which);
            for (out, jet) in out.iter_mut().zip(jets) {
                for (j, (to, from)) in out.c.iter_mut().zip(&jet.c).take(order + 1).enumerate() {
                    let factor = rate.powi(j as i32);
                    match piece.frame() {
                        Some(frame) => mul_into(to, factor, frame, from),
                        None => {
                            to.copy_from(from);
                            scale(to, factor);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Maximal runs of parameters in one piece: piece, first parameter, one past the last.
    pub(super) fn runs(&self, t: &[f64]) -> Result<Vec<(usize, usize, usize)>> {
        let mut runs: Vec<(usize, usize, usize)> = Vec::new();
        for (i, &t) in t.iter().enumerate() {
            let piece = match self.find(t) {
                Err(Error::NonFinite { name, .. }) => {
                    return Err(Error::NonFinite { name, index: i });
                }
                other => other?,
            };
            match runs.last_mut() {
                Some(run) if run.0 == piece => run.2 = i + 1,
                _ => runs.push((piece, i, i + 1)),
            }
        }
        Ok(runs)
    }
}

/// Number of entries of a result from which evaluation is parallel: waking threads takes as long as computing some
/// thousand entries.
const SHARED: usize = 1 << 14;

/// Converts derivatives of a piece on `[0, 1]` to those of one that takes `length`.
fn slow_down(values: &mut [f64], length: f64, order: usize) -> Result<()> {
    if order == 0 {
        return Ok(());
    }
    let factor = length.powi(-(order as i32));
    if factor.is_normal() {
        values.iter_mut().for_each(|value| *value *= factor);
    } else {
        // Divide repeatedly: zeros stay zero, and the power may overflow where the result does not.
        for value in values.iter_mut() {
            *value = (0..order).fold(*value, |value, _| value / length);
        }
    }
    if values.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(Error::Overflow {
        quantity: "derivative of a spline",
    })
}

/// The piece that was evaluated last, and its buffers.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::curve::{Curve, de_casteljau};
/// use stiefel_rs::linalg::jet::MatrixJet;
/// use stiefel_rs::spline::{geometric_hermite, piecewise::PiecewiseWorkspace};
/// // On the circle, from rest to rest: the angle is 3 t^2 - 2 t^3.
/// let points = [0.0_f64, 1.0].map(|a| mat![[a.cos()], [a.sin()]]);
/// let rest = mat![[0.0], [0.0]];
/// let views = points.each_ref().map(|point| point.as_ref());
/// let curve = geometric_hermite(&[0.0, 1.0], &views, &[rest.as_ref(); 2])?;
/// let mut work: PiecewiseWorkspace<de_casteljau::DeCasteljauWorkspace> = curve.workspace();
/// let mut jet = MatrixJet::zeros(2, 1);
/// curve.coordinates_into(0.5, 1, &mut work, &mut jet)?;
/// assert!((jet.c[1].norm_l2() - 1.5).abs() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct PiecewiseWorkspace<W> {
    last: Option<(usize, W, Vec<MatrixJet>)>,
}

impl<C: Curve> Curve for Piecewise<C> {
    type Workspace = PiecewiseWorkspace<C::Workspace>;

    fn n(&self) -> usize {
        self.pieces[0].n()
    }

    fn k(&self) -> usize {
        self.pieces[0].k()
    }

    fn quotient(&self) -> Quotient {
        self.pieces[0].quotient()
    }

    fn continued(&self) -> Option<Self> {
        Some(self.clone().with_outside(Outside::Continued))
    }

    fn t_span(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.pieces.len()])
    }

    fn breakpoints(&self) -> Vec<f64> {
        self.knots.to_vec()
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        None
    }

    fn workspace(&self) -> Self::Workspace {
        PiecewiseWorkspace { last: None }
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Self::Workspace,
        out: &mut MatrixJet,
    ) -> Result<()> {
        self.jets_into(&[t], order, work, std::slice::from_mut(out))
    }

    fn jets_into(
        &self,
        t: &[f64],
        order: usize,
        work: &mut Self::Workspace,
        out: &mut [MatrixJet],
    ) -> Result<()> {
        debug_assert_eq!(t.len(), out.len());
        let (mut t, mut out) = (t, out);
        while let Some(&first) = t.first() {
            let piece = self.find(first)?;
            let same = |t: &&f64| self.find(**t).is_ok_and(|other| other == piece);
            let (run, others) = t.split_at(t.iter().take_while(same).count());
            let (target, rest) = out.split_at_mut(run.len());
            self.jets_of_piece(piece, run, order, work, target)?;
            (t, out) = (others, rest);
        }
        Ok(())
    }

    fn sample(&self, t: &[f64], quantity: Quantity, interrupt: Interrupt<'_>) -> Result<Samples> {
        let runs = self.runs(t)?;
        let part = |(): &mut (), run: usize| {
            let (piece, from, to) = runs[run];
            let local: Vec<f64> = t[from..to].iter().map(|t| self.local(piece, *t)).collect();
            let found = self.pieces[piece].sample(&local, quantity, interrupt)?;
            let mut values = found.into_entries();
            slow_down(&mut values, self.length(piece), quantity.order())?;
            Ok(values)
        };
        let each = match t.len() * self.n() * self.k() < SHARED {
            true => 0.0,
            false => ALWAYS,
        };
        let parts = threads::map(runs.len(), each, || (), part)?;
        Ok(Samples::from_entries(self.n(), self.k(), parts.concat()))
    }

    fn cost(&self, interrupt: Interrupt<'_>) -> Result<f64> {
        let mut sum = 0.0;
        for (i, piece) in self.pieces.iter().enumerate() {
            // The square of a second derivative, integrated over time.
            sum += piece.cost(interrupt)? * self.length(i).powi(-3);
        }
        if sum.is_finite() {
            return Ok(sum);
        }
        Err(Error::Overflow { quantity: "cost" })
    }

    fn derivative_bounds(&self, interrupt: Interrupt<'_>) -> Result<DerivativeBounds> {
        let of_piece = |(): &mut (), piece: usize| {
            let bounds = self.pieces[piece].derivative_bounds(interrupt)?;
            bounds.slowed(self.length(piece))
        };
        let all = threads::map(self.pieces.len(), ALWAYS, || (), of_piece)?;
        let first = all[0];
        Ok(all.into_iter().fold(first, DerivativeBounds::max))
    }
}
