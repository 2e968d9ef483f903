//! Riemannian cubics as curves: integrated from initial data, evaluated from stored polynomials.

use std::sync::Arc;

use faer::reborrow::ReborrowMut;
use faer::{Mat, MatMut, MatRef};

use super::derivative_bounds::enclosed;
use super::integration_options::IntegrationOptions;
use super::taylor::blocks::Sizes;
use super::taylor::initial::Coordinates;
use super::taylor::lazy_taylor::LazyTaylor;
use super::taylor::march::Accuracy;
use super::taylor::piecewise_taylor::PiecewiseTaylor;
use super::taylor::state::State;
use super::tension::check_tension;
use super::time_map::TimeMap;
use crate::curve::curve::{sample_blocks, sample_coordinate_blocks};
use crate::curve::sampling::check_parameter;
use crate::curve::{Curve, DerivativeBounds, Quantity, Samples};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::{MatrixJet, ORDER};
use crate::linalg::simd::vectorised;
use crate::linalg::structure::check_finite_scalar;
use crate::report::SolverReport;
use crate::space::Quotient;

/// A Riemannian cubic: a critical curve of the squared covariant acceleration.
///
/// ```math
/// D_t^3 S' + R(D_t S', S')\,S' = 0,\qquad J = \int |D_t S'|^2\, dt
/// ```
///
/// An integrated curve is stored as one Taylor polynomial per step, of order 20 (lower for a larger tolerance), in the
/// `r <= min(n, 4k)` dimensions spanned by its initial data. A solution of a boundary value problem or a piece of a
/// spline that was found by series or collocation is one polynomial about its middle, whose order depends on how fast it
/// turns, in the `r` dimensions spanned by the knots, or by the data at its ends. With order `p`, evaluating a point costs
/// `p r k` multiplications, and one product to lift it to `n` rows.
///
/// Outside [`t_span`](Curve::t_span) the curve is extended by integration, once per call;
/// [`RiemannianCubic::restricted`] returns a curve that keeps the extension.
///
/// # Accuracy
/// Positions are within `1e-14` of the exact solution for curves of the size of the paper's (asserted in
/// `tests/riemannian_cubic/` against 40-digit data); the orthonormality defect is of the same size.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Interrupt, RiemannianCubic};
/// use stiefel_rs::cubic::IntegrationOptions;
/// let (s, v) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (a, j) = (mat![[0.0], [0.0], [2.0]], mat![[0.0], [0.0], [0.0]]);
/// let options = IntegrationOptions::default();
/// let curve =
///     RiemannianCubic::from_initial(s.as_ref(), v.as_ref(), a.as_ref(), j.as_ref(), &options, Interrupt::NEVER)?;
/// assert!((curve.acceleration(0.0)? - a).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct RiemannianCubic {
    pub(super) n: usize,
    pub(super) k: usize,
    pub(super) frame: Option<Arc<Mat<f64>>>,
    pub(super) taylor: Arc<LazyTaylor>,
    pub(super) time_map: TimeMap,
    pub(super) span: (f64, f64),
    pub(super) report: Option<SolverReport>,
}

impl RiemannianCubic {
    /// The cubic with the given point, velocity, covariant acceleration and covariant jerk at time 0, all of shape `(n,
    /// k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `InvalidArgument` (`t_end` zero, tolerance, tension);
    /// `TooManySteps` (more than 1e5 steps: too long or too fast), `Overflow`, `Interrupted`.
    pub fn from_initial(
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        a: MatRef<'_, f64>,
        j: MatRef<'_, f64>,
        options: &IntegrationOptions,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        check_duration(options.t_end)?;
        let range = Accuracy::FULL.truncation..=0.1;
        if !range.contains(&options.tolerance) {
            return Err(Error::InvalidArgument {
                name: "tolerance",
                requirement: "between 1e-17 and 0.1",
                found: options.tolerance,
            });
        }
        check_tension(options.tension)?;
        let (data, rate) =
            Coordinates::in_natural_time([s, v, a, j], options.tension, options.quotient)?;
        check_size(data.blocks)?;
        let accuracy = Accuracy::of_tolerance(options.tolerance);
        let time_map = TimeMap::new(rate);
        let state = State::of_coordinates(data.blocks, data.entries);
        let mut taylor =
            PiecewiseTaylor::at(state.in_tension(options.tension / rate / rate), accuracy);
        // Never of length zero, however short, so that there is at least one piece.
        let smallest = f64::MIN_POSITIVE.copysign(options.t_end);
        let end = match time_map.taylor_time(options.t_end) {
            end if end.abs() < f64::MIN_POSITIVE => smallest,
            end => end,
        };
        extend(&mut taylor, time_map, end, interrupt)?;
        let mut curve =
            Self::of_taylor(s.nrows(), s.ncols(), data.frame.map(Arc::new), taylor, None);
        curve.time_map = time_map;
        curve.span = (options.t_end.min(0.0), options.t_end.max(0.0));
        Ok(curve)
    }

    /// A curve from its polynomials in the coordinates of a frame, in the time of the curve, with the report of the
    /// solver that found it.
    pub(crate) fn of_taylor(
        n: usize,
        k: usize,
        frame: Option<Arc<Mat<f64>>>,
        taylor: PiecewiseTaylor,
        report: Option<SolverReport>,
    ) -> Self {
        let span = taylor.covered();
        RiemannianCubic {
            report,
            ..Self::of_leg(n, k, frame, taylor.into(), span)
        }
    }

    /// For a curve on a sphere, the curve of the lines spanned by its vectors: the same vectors, since they do not rotate.
    pub(crate) fn of_lines(&self) -> Self {
        RiemannianCubic {
            taylor: Arc::new(self.taylor.of_lines().into()),
            ..self.clone()
        }
    }

    /// The curve of subspaces with bases `Y Q` for an orthogonal `Q`, shape `(k, k)`.
    pub(crate) fn in_terms_of(&self, q: MatRef<'_, f64>) -> Self {
        let (taylor, q) = (Arc::clone(&self.taylor), q.to_owned());
        let turned = LazyTaylor::of(move || taylor.in_terms_of(q.as_ref()));
        RiemannianCubic {
            taylor: Arc::new(turned),
            ..self.clone()
        }
    }

    /// As `of_taylor`, for polynomials that may not have been computed yet, over an interval.
    pub(crate) fn of_leg(
        n: usize,
        k: usize,
        frame: Option<Arc<Mat<f64>>>,
        taylor: LazyTaylor,
        span: (f64, f64),
    ) -> Self {
        RiemannianCubic {
            n,
            k,
            frame,
            span,
            taylor: Arc::new(taylor),
            time_map: TimeMap::new(1.0),
            report: None,
        }
    }

    /// The report of the boundary value solver, for a curve that comes from one, with what found the solution.
    pub fn report(&self) -> Option<&SolverReport> {
        self.report.as_ref()
    }

    /// Truncation error per integration step, relative to the state.
    pub fn tolerance(&self) -> f64 {
        self.taylor.accuracy().truncation
    }

    /// `tau` of a cubic in tension, 0 of a cubic: the curve makes `int |D_t S'|^2 + tau |S'|^2 dt` stationary.
    pub fn tension(&self) -> f64 {
        self.time_map.derivative(self.taylor.tension(), 2)
    }

    /// Number of polynomials of the curve: the steps of its integration, or 1 for a solution of a boundary value problem or
    /// a piece of a spline that was found by series or collocation.
    pub fn steps(&self) -> usize {
        self.taylor.len()
    }
}

/// As [`PiecewiseTaylor::extend_to`]; errors report the remaining time in the time of the curve.
pub(super) fn extend(
    taylor: &mut PiecewiseTaylor,
    time_map: TimeMap,
    t: f64,
    interrupt: Interrupt<'_>,
) -> Result<()> {
    taylor.extend_to(t, interrupt).map_err(|error| match error {
        Error::TooManySteps {
            solver,
            limit,
            forecast,
            mut report,
        } => {
            report.residual = time_map.curve_length(report.residual);
            Error::TooManySteps {
                solver,
                limit,
                forecast,
                report,
            }
        }
        other => other,
    })
}

/// Return an error if the coefficients of one step would not fit into memory.
fn check_size(Sizes { m, k, .. }: Sizes) -> Result<()> {
    let (r, k) = ((m + k) as f64, k as f64);
    let numbers = (Accuracy::FULL.order + 1) as f64 * (r * r + 3.0 * r * k + 2.0 * k * k);
    if numbers <= LARGEST_STEP {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "k",
        requirement: "small enough for the Taylor coefficients of a step to fit in memory",
        found: k,
    })
}

/// Maximal number of coefficients of one step: two gigabytes.
const LARGEST_STEP: f64 = 268_435_456.0;

/// Return an error if an integration time is zero or not finite.
pub(super) fn check_duration(t_end: f64) -> Result<()> {
    check_finite_scalar("t_end", t_end)?;
    if t_end != 0.0 {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "t_end",
        requirement: "not zero",
        found: 0.0,
    })
}

impl Curve for RiemannianCubic {
    type Workspace = CubicWorkspace;

    fn n(&self) -> usize {
        self.n
    }

    fn k(&self) -> usize {
        self.k
    }

    fn quotient(&self) -> Quotient {
        self.taylor.quotient()
    }

    fn t_span(&self) -> (f64, f64) {
        self.span
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        self.frame.as_ref().map(|frame| frame.as_ref().as_ref())
    }

    fn derivative_bounds(&self, interrupt: Interrupt<'_>) -> Result<DerivativeBounds> {
        enclosed(&self.taylor, self.time_map, self.span, interrupt)
    }

    fn workspace(&self) -> CubicWorkspace {
        let size = self.taylor.rows() * self.k;
        CubicWorkspace {
            beyond: None,
            coefficients: std::array::from_fn(|_| vec![0.0; size]),
        }
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut CubicWorkspace,
        out: &mut MatrixJet,
    ) -> Result<()> {
        check_parameter(t)?;
        let CubicWorkspace {
            beyond,
            coefficients,
        } = work;
        let moment = self.time_map.taylor_time(t);
        let taylor = reaching(self, moment, beyond)?;
        let mut targets: [&mut [f64]; ORDER + 1] =
            coefficients.each_mut().map(|c| c.as_mut_slice());
        vectorised(
            #[inline(always)]
            || taylor.points_into(moment, &mut targets[..=order]),
        );
        for (j, (target, source)) in out.c.iter_mut().zip(&mut targets[..=order]).enumerate() {
            for entry in source.iter_mut() {
                *entry = self.time_map.derivative(*entry, j);
            }
            let (r, k) = target.shape();
            let rows = source.len() / k;
            let all = MatRef::from_column_major_slice(source, rows, k);
            target.copy_from(all.subrows(0, r));
        }
        Ok(())
    }

    fn positions_into(
        &self,
        t: &[f64],
        work: &mut CubicWorkspace,
        _: &mut Option<MatrixJet>,
        mut out: MatMut<'_, f64>,
    ) -> Result<()> {
        let CubicWorkspace {
            beyond,
            coefficients: [point, ..],
        } = work;
        let (r, rows, k) = (self.taylor.r(), self.taylor.rows(), self.k);
        vectorised(
            #[inline(always)]
            || {
                for (i, &t) in t.iter().enumerate() {
                    check_parameter(t)?;
                    let t = self.time_map.taylor_time(t);
                    reaching(self, t, beyond)?.point_into(t, point);
                    for j in 0..k {
                        let (to, from) = (out.rb_mut().col_mut(i * k + j), &point[rows * j..][..r]);
                        match to.try_as_col_major_mut() {
                            Some(to) => to.as_slice_mut().copy_from_slice(from),
                            None => (0..r).for_each(|l| out[(l, i * k + j)] = from[l]),
                        }
                    }
                }
                Ok(())
            },
        )
    }

    fn sample(&self, t: &[f64], quantity: Quantity, interrupt: Interrupt<'_>) -> Result<Samples> {
        let longer = self.reaching(t, interrupt)?;
        sample_blocks(longer.as_ref().unwrap_or(self), t, quantity, interrupt)
    }

    fn sample_coordinates(
        &self,
        t: &[f64],
        quantity: Quantity,
        interrupt: Interrupt<'_>,
    ) -> Result<Mat<f64>> {
        let longer = self.reaching(t, interrupt)?;
        sample_coordinate_blocks(longer.as_ref().unwrap_or(self), t, quantity, interrupt)
    }

    fn cost(&self, _: Interrupt<'_>) -> Result<f64> {
        let ends = [self.span.0, self.span.1].map(|t| self.time_map.taylor_time(t));
        let [from, to] = match self.time_map.is_forward() {
            true => ends,
            false => [ends[1], ends[0]],
        };
        // The square of a second derivative, integrated over time.
        let cost = self
            .time_map
            .derivative(self.taylor.cost(from, to), 3)
            .abs();
        if cost.is_finite() {
            return Ok(cost);
        }
        Err(Error::Overflow { quantity: "cost" })
    }
}

/// The polynomials of a curve, or an extended copy for times they do not cover.
fn reaching<'a>(
    curve: &'a RiemannianCubic,
    moment: f64,
    beyond: &'a mut Option<PiecewiseTaylor>,
) -> Result<&'a PiecewiseTaylor> {
    if curve.taylor.covers(moment) {
        return Ok(&curve.taylor);
    }
    let longer = beyond.get_or_insert_with(|| PiecewiseTaylor::clone(&curve.taylor));
    extend(longer, curve.time_map, moment, Interrupt::NEVER)?;
    Ok(longer)
}

/// Buffers for evaluating Riemannian cubics of one shape.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::IntegrationOptions;
/// use stiefel_rs::cubic::riemannian_cubic::{RiemannianCubic, CubicWorkspace};
/// use stiefel_rs::{Curve, Interrupt};
/// use stiefel_rs::linalg::jet::MatrixJet;
/// // On a circle: the angle is t + t^2 + t^3.
/// let (s, v) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]]);
/// let (a, j) = (mat![[0.0], [2.0]], mat![[0.0], [6.0]]);
/// let [s, v, a, j] = [&s, &v, &a, &j].map(|a| a.as_ref());
/// let curve = RiemannianCubic::from_initial(s, v, a, j, &IntegrationOptions::default(), Interrupt::NEVER)?;
/// let (mut work, mut jet): (CubicWorkspace, MatrixJet) = (curve.workspace(), MatrixJet::zeros(2, 1));
/// for t in [0.0, 0.5, 1.0] {
///     curve.coordinates_into(t, 1, &mut work, &mut jet)?;
///     assert!((jet.c[1].norm_l2() - (1.0 + 2.0 * t + 3.0 * t * t)).abs() < 1e-13);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub struct CubicWorkspace {
    /// The polynomials extended to the requested times beyond their ends.
    beyond: Option<PiecewiseTaylor>,
    coefficients: [Vec<f64>; ORDER + 1],
}
