//! De Casteljau's algorithm with quasi-geodesics: geometric polynomials of any degree on `St(n, k)`.
//!
//! Quasi-geodesics replace the straight lines of the Euclidean algorithm; for degree three:
//!
//! ```text
//! S0 --- S1 --- S2 --- S3      control points
//!    b01    b12    b23         quasi-geodesics, fixed
//!       b012   b123            quasi-geodesics at the same t
//!           gamma
//! ```
//!
//! Positions and derivatives, for which every stage is differentiated, are computed at eight parameters at once
//! ([`crate::manifold`], `lane_join` and `lane_moving_join`) or, if a stage comes near the edge of its domain, by a
//! slower method one parameter at a time.
//!
//! # Source
//! Krakowski, Machado, Silva Leite, Batista (2017); arXiv 2404.19407, section on the adjusted algorithm. Deviation: the
//! computation takes place in the `min(n, (degree + 1) k)` dimensions spanned by the control points, which is exact.

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef};

use super::branch;
use super::curve::Curve;
use super::sampling::check_parameter;
use super::span::{self, Span};
use super::stages::Stages;
use crate::error::{Error, Result};
use crate::linalg::jet::MatrixJet;
use crate::linalg::lane_jet::LaneJet;
use crate::linalg::lane_matrix::LaneMatrix;
use crate::linalg::lanes::{LANES, Lanes};
use crate::linalg::simd::{Eight, Width};
use crate::manifold::QuasiGeodesic;
use crate::manifold::lane_join::LaneJoin;
use crate::manifold::lane_leg::{LaneLeg, LaneLegWork};
use crate::manifold::lane_margin::Margin;
use crate::manifold::lane_moving_join::LaneMovingJoin;
use crate::space::Quotient;

/// Beyond this distance from `[0, 1]` the weights of the two ends cancel, and parameters are evaluated one at a time.
const LANE_RANGE: f64 = 2.0;

/// Number of columns above which the blocked factorisations of a single matrix are faster than eight at once (measured:
/// 1.6 times slower at k = 40, 1.4 times faster at k = 100).
const LANE_COLUMNS: usize = 64;

/// The same for derivatives, where eight are also computed for one. Second derivatives, eight at once, alone, and by the
/// slower method: 40, 313, 469 us at k = 6; 236, 1821, 946 us at k = 10; 549, 4441, 1386 us at k = 16.
const DERIVATIVE_COLUMNS: usize = 10;

/// A geometric polynomial: the curve of de Casteljau's algorithm on `[0, 1]` with quasi-geodesics as pieces.
///
/// It passes through its first and last control point; its end velocities are `degree` times those of the first and the
/// last leg. Degree 1 is the quasi-geodesic, degree 3 the [`GeometricCubic`](super::GeometricCubic).
///
/// # Domain
/// The construction joins points by principal quasi-geodesics, so the curve is smooth as long as relative rotations and
/// principal angles between all intermediate points stay below pi. Control points for which one of them reaches pi
/// inside `[0, 1]` are refused (`BranchJump`). Outside `[0, 1]` the curve may jump to another principal branch.
///
/// # Accuracy
/// Orthonormality defect at most `32 eps k degree` in `[0, 1]`, asserted in `tests/de_casteljau.rs`.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, GeometricPolynomial};
/// let [x, y, z] = [mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]], mat![[0.0], [0.0], [1.0]]];
/// let curve = GeometricPolynomial::new(&[x.as_ref(), y.as_ref(), z.as_ref()])?;
/// assert_eq!(curve.degree(), 2);
/// assert!((curve.point(1.0)? - z).norm_l2() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct GeometricPolynomial {
    /// The control points in the coordinates of the frame.
    points: Vec<Mat<f64>>,
    /// Orthonormal basis of the span of the control points, if the span is smaller than `R^n`.
    frame: Option<Mat<f64>>,
    /// The quasi-geodesics between consecutive control points, in the coordinates of the frame.
    legs: Vec<QuasiGeodesic>,
    lane_legs: Vec<LaneLeg>,
}

impl GeometricPolynomial {
    /// The curve with the given control points, at least two, each of shape `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents` if two
    /// consecutive points cannot be joined; `BranchJump` if intermediate points cannot.
    pub fn new(points: &[MatRef<'_, f64>]) -> Result<Self> {
        let (_, span, low) = span::control_points(points)?;
        let legs = low
            .windows(2)
            .map(|pair| QuasiGeodesic::joining(pair[0].as_ref(), pair[1].as_ref()))
            .collect::<Result<_>>()?;
        Self::of_legs(low, span, legs)
    }

    /// Built from control points and legs in the coordinates of the span.
    pub(super) fn of_legs(
        points: Vec<Mat<f64>>,
        span: Span,
        legs: Vec<QuasiGeodesic>,
    ) -> Result<Self> {
        let curve = Self::unchecked(points, span.into_basis(), legs)?;
        curve.check_branch()?;
        Ok(curve)
    }

    /// Built from control points and legs in the coordinates of a frame, without checking for jumps.
    pub(super) fn unchecked(
        points: Vec<Mat<f64>>,
        frame: Option<Mat<f64>>,
        legs: Vec<QuasiGeodesic>,
    ) -> Result<Self> {
        let lane_legs = legs.iter().map(LaneLeg::new).collect::<Result<_>>()?;
        Ok(GeometricPolynomial {
            points,
            frame,
            legs,
            lane_legs,
        })
    }

    /// Return `BranchJump` if the curve jumps inside `[0, 1]`.
    pub(super) fn check_branch(&self) -> Result<()> {
        if branch::is_short(self.largest_leg_speed(), self.degree()) {
            return Ok(());
        }
        let mut work = self.workspace();
        branch::check(self.degree(), |t| self.margins(t, &mut work))
    }

    /// Replaces an inner control point, given in the coordinates of the frame, and its two legs, without checking for
    /// jumps.
    pub(super) fn replace_point(&mut self, i: usize, point: &Mat<f64>) -> Result<()> {
        self.points[i].copy_from(point);
        for leg in [i - 1, i] {
            let [from, to] = [leg, leg + 1].map(|j| self.points[j].as_ref());
            self.legs[leg] = QuasiGeodesic::joining(from, to)?;
            self.lane_legs[leg] = LaneLeg::new(&self.legs[leg])?;
        }
        Ok(())
    }

    /// Copies an inner control point and its two legs from a curve with the same other control points.
    pub(super) fn restore_point(&mut self, i: usize, from: &Self) {
        self.points[i].copy_from(&from.points[i]);
        self.legs[i - 1..=i].clone_from_slice(&from.legs[i - 1..=i]);
        self.lane_legs[i - 1..=i].clone_from_slice(&from.lane_legs[i - 1..=i]);
    }

    /// The curve with the same coordinates in a span.
    pub(super) fn lifted_by(self, span: Span) -> Self {
        let frame = span.into_basis();
        GeometricPolynomial { frame, ..self }
    }

    /// The control points in the coordinates of the frame.
    pub(super) fn reduced_points(&self) -> &[Mat<f64>] {
        &self.points
    }

    /// The control points, each of shape `(n, k)`; they are lifted from the frame, so they equal the given ones up to
    /// round-off.
    pub fn control_points(&self) -> Vec<Mat<f64>> {
        span::lifted(self.frame.as_ref(), &self.points)
    }

    /// The quasi-geodesics between consecutive control points, in the coordinates of the frame.
    #[cfg(any(feature = "python", feature = "serde"))]
    pub(super) fn legs(&self) -> &[QuasiGeodesic] {
        &self.legs
    }

    /// One less than the number of control points.
    pub fn degree(&self) -> usize {
        self.legs.len()
    }

    /// How close the intermediate points at eight parameters in `[0, 1]` come to a change of branch.
    fn margins(&self, t: Lanes, work: &mut DeCasteljauWorkspace) -> Lanes {
        self.lane_points(t, &mut work.lanes).least
    }

    /// A bound on the spectral norm of the velocity along all legs.
    fn largest_leg_speed(&self) -> f64 {
        let speeds = self.lane_legs.iter().map(LaneLeg::speed_bound);
        speeds.fold(0.0, f64::max)
    }

    /// Rows of a point in the coordinates of the frame.
    fn reduced_rows(&self) -> usize {
        self.legs[0].n()
    }

    /// Computes the points at eight parameters in the first stage.
    fn lane_points(&self, t: Lanes, work: &mut LaneWork) -> Margin {
        Eight::run(
            #[inline(always)]
            || {
                let mut margin = Margin::WIDE;
                for (leg, stage) in self.lane_legs.iter().zip(&mut work.stages) {
                    leg.points_into(t, &mut work.leg, stage);
                }
                for level in (1..self.degree()).rev() {
                    for i in 0..level {
                        let (from, to) = work.stages.split_at_mut(i + 1);
                        work.join.advance(&mut from[i], &to[0], t, &mut margin);
                    }
                }
                margin
            },
        )
    }

    /// Computes Taylor coefficients at eight parameters in the first stage.
    #[inline(always)]
    fn lane_jets(
        &self,
        t: Lanes,
        order: usize,
        leg: &mut LaneLegWork,
        work: &mut LaneJetWork,
    ) -> Margin {
        let mut margin = Margin::WIDE;
        for (fixed, stage) in self.lane_legs.iter().zip(&mut work.stages) {
            fixed.jets_into(t, order, leg, stage);
        }
        for level in (1..self.degree()).rev() {
            for i in 0..level {
                let (from, to) = work.stages.split_at_mut(i + 1);
                work.join
                    .advance(&mut from[i], &to[0], t, order, &mut margin);
            }
        }
        margin
    }

    /// Writes Taylor coefficients at up to eight parameters; returns `true` for those that must be recomputed one at a
    /// time.
    fn lane_jets_into(
        &self,
        t: &[f64],
        order: usize,
        work: &mut LaneWork,
        out: &mut [MatrixJet],
    ) -> [bool; LANES] {
        let inside = |t: f64| t.abs() <= 1.0;
        let mut lanes = Lanes::ZERO;
        for (lane, &t) in lanes.0.iter_mut().zip(t).filter(|(_, t)| inside(**t)) {
            *lane = t;
        }
        let LaneWork { leg, jets, .. } = work;
        let jets = jets.get_or_insert_with(|| {
            let (rows, k) = (self.reduced_rows(), self.k());
            Box::new(LaneJetWork::new(rows, k, self.degree()))
        });
        let mut hard = Eight::run(
            #[inline(always)]
            || self.lane_jets(lanes, order, leg, jets),
        )
        .hard;
        for (lane, (&t, out)) in t.iter().zip(out).enumerate() {
            hard[lane] |= !inside(t);
            for (to, from) in out.c[..=order].iter_mut().zip(&jets.stages[0].c) {
                from.lane_into(lane, to.as_mut());
            }
        }
        hard
    }

    /// Writes points at up to eight parameters, side by side in `out`; returns `true` for those that must be recomputed
    /// one at a time.
    fn lane_block(&self, t: &[f64], work: &mut LaneWork, out: MatMut<'_, f64>) -> [bool; LANES] {
        let mut lanes = Lanes::splat(t[0]);
        lanes.0[..t.len()].copy_from_slice(t);
        let margin = self.lane_points(lanes, work);
        let (k, mut out) = (self.k(), out);
        for lane in 0..t.len() {
            for j in 0..k {
                let target = out.rb_mut().col_mut(lane * k + j);
                let target = target.try_as_col_major_mut();
                let column = work.stages[0].col(j);
                match target {
                    Some(target) => {
                        for (x, entry) in target.as_slice_mut().iter_mut().zip(column) {
                            *x = entry.0[lane];
                        }
                    }
                    None => {
                        for (i, entry) in column.iter().enumerate() {
                            out[(i, lane * k + j)] = entry.0[lane];
                        }
                    }
                }
            }
        }
        margin.hard
    }
}

impl Curve for GeometricPolynomial {
    type Workspace = DeCasteljauWorkspace;

    fn n(&self) -> usize {
        span::rows(self.frame.as_ref(), &self.points)
    }

    fn k(&self) -> usize {
        self.points[0].ncols()
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        self.frame.as_ref().map(|frame| frame.as_ref())
    }

    fn workspace(&self) -> DeCasteljauWorkspace {
        DeCasteljauWorkspace {
            lanes: LaneWork::new(self.reduced_rows(), self.k(), self.degree()),
            careful: None,
        }
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut DeCasteljauWorkspace,
        out: &mut MatrixJet,
    ) -> Result<()> {
        check_parameter(t)?;
        let careful = work.careful(self);
        careful.compute(&self.legs, t, order)?;
        out.copy_from(careful.value(), order);
        Ok(())
    }

    fn jets_into(
        &self,
        t: &[f64],
        order: usize,
        work: &mut DeCasteljauWorkspace,
        out: &mut [MatrixJet],
    ) -> Result<()> {
        for (t, out) in t.chunks(LANES).zip(out.chunks_mut(LANES)) {
            let mut hard = [true; LANES];
            if order > 0 && self.k() <= DERIVATIVE_COLUMNS {
                hard = self.lane_jets_into(t, order, &mut work.lanes, out);
            }
            for ((&t, out), _) in t.iter().zip(out).zip(hard).filter(|(_, hard)| *hard) {
                self.coordinates_into(t, order, work, out)?;
            }
        }
        Ok(())
    }

    fn positions_into(
        &self,
        t: &[f64],
        work: &mut DeCasteljauWorkspace,
        _: &mut Option<MatrixJet>,
        mut out: MatMut<'_, f64>,
    ) -> Result<()> {
        let k = self.k();
        let mut hard = [false; LANES];
        for (block, t) in t.chunks(LANES).enumerate() {
            let mut target = out.rb_mut().subcols_mut(LANES * k * block, k * t.len());
            if k <= LANE_COLUMNS && t.iter().all(|t| t.abs() <= LANE_RANGE) {
                hard = self.lane_block(t, &mut work.lanes, target.rb_mut());
            } else {
                hard.fill(true);
            }
            for (lane, &t) in t.iter().enumerate().filter(|(lane, _)| hard[*lane]) {
                check_parameter(t)?;
                let careful = work.careful(self);
                careful.compute(&self.legs, t, 0)?;
                let point = careful.value().c[0].as_ref();
                target.rb_mut().subcols_mut(lane * k, k).copy_from(point);
            }
        }
        Ok(())
    }
}

/// Buffers for evaluating geometric polynomials of one shape and degree.
///
/// # Examples
/// ```
/// use faer::{Mat, mat};
/// use stiefel_rs::curve::de_casteljau::DeCasteljauWorkspace;
/// use stiefel_rs::linalg::jet::MatrixJet;
/// use stiefel_rs::{Curve, GeometricPolynomial};
/// let points: [Mat<f64>; 3] = [0.0_f64, 0.4, 1.0].map(|a| mat![[a.cos()], [a.sin()]]);
/// let curve = GeometricPolynomial::try_from(&points[..])?;
/// let (mut work, mut jet): (DeCasteljauWorkspace, MatrixJet) = (curve.workspace(), MatrixJet::zeros(2, 1));
/// for t in [0.0, 0.5, 1.0_f64] {
///     curve.coordinates_into(t, 1, &mut work, &mut jet)?;
///     // On the circle the angle is the polynomial with the control points 0, 0.4, 1.
///     let speed = 0.8 * (1.0 - t) + 1.2 * t;
///     assert!((jet.c[1].norm_l2() - speed).abs() < 1e-14);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct DeCasteljauWorkspace {
    lanes: LaneWork,
    careful: Option<Box<Stages>>,
}

impl DeCasteljauWorkspace {
    fn careful(&mut self, curve: &GeometricPolynomial) -> &mut Stages {
        self.careful.get_or_insert_with(|| {
            let shape = [curve.reduced_rows(), curve.k()];
            Box::new(Stages::new(Quotient::Frames, shape, curve.degree()))
        })
    }
}

struct LaneWork {
    stages: Vec<LaneMatrix>,
    leg: LaneLegWork,
    join: LaneJoin,
    jets: Option<Box<LaneJetWork>>,
}

/// Buffers for derivatives.
struct LaneJetWork {
    stages: Vec<LaneJet>,
    join: LaneMovingJoin,
}

impl LaneJetWork {
    fn new(r: usize, k: usize, degree: usize) -> Self {
        LaneJetWork {
            stages: (0..degree).map(|_| LaneJet::zeros(r, k)).collect(),
            join: LaneMovingJoin::new(r, k),
        }
    }
}

impl LaneWork {
    fn new(r: usize, k: usize, degree: usize) -> Self {
        LaneWork {
            stages: (0..degree).map(|_| LaneMatrix::zeros(r, k)).collect(),
            leg: LaneLegWork::new(k),
            join: LaneJoin::new(r, k),
            jets: None,
        }
    }
}

/// For an array of control points.
impl TryFrom<&[Mat<f64>]> for GeometricPolynomial {
    type Error = Error;

    fn try_from(points: &[Mat<f64>]) -> Result<Self> {
        let points: Vec<_> = points.iter().map(|point| point.as_ref()).collect();
        Self::new(&points)
    }
}
