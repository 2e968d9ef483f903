//! The Riemannian cubic as a curve: from initial data, evaluated from stored Taylor polynomials.

use faer::{Mat, MatMut, MatRef, Scale};

use super::boundary::BoundaryReport;
use super::initial::{Horizontal, InitialData};
use super::path::{Path, State};
use super::taylor::Accuracy;
use crate::curve::{Curve, check_parameter};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::{Jet, ORDER};
use crate::linalg::product::mul_into;
use crate::linalg::simd::vectorised;
use crate::linalg::structure::check_finite_scalar;
use crate::report::SolverReport;

/// How an initial value problem is solved.
#[derive(Clone, Copy)]
pub struct IntegrationOptions<'a> {
    /// The curve is made for the times between 0 and this one, which may be negative.
    pub t_end: f64,
    /// What a step of the Taylor method leaves out, relative to the state, in `[1e-17, 0.1]`.
    pub tolerance: f64,
    /// Asked every few steps.
    pub interrupt: Interrupt<'a>,
}

impl Default for IntegrationOptions<'_> {
    /// `[0, 1]`, to round-off.
    fn default() -> Self {
        IntegrationOptions {
            t_end: 1.0,
            tolerance: Accuracy::FULL.truncation,
            interrupt: Interrupt::NEVER,
        }
    }
}

/// A Riemannian cubic: a critical curve of the squared covariant acceleration.
///
/// ```math
/// D_t^3 S' + R(D_t S', S')\,S' = 0,\qquad J = \int |D_t S'|^2\, dt
/// ```
///
/// Stored as a piecewise Taylor polynomial of order 20 in the `min(n, 4k)` dimensions that its initial data span, so that a
/// point costs `20 r k` multiplications and its share of one product to lift. Outside of
/// [`t_span`](Curve::t_span) the curve is integrated on when it is asked for a point there.
///
/// # Accuracy
/// Positions at most `1e-14` from the exact solution for curves of the size of the paper's (asserted in
/// `tests/riemannian_cubic.rs` against 40-digit data); the orthonormality defect is of that size too.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, RiemannianCubic};
/// use stiefel_rs::cubic::IntegrationOptions;
/// let (s, v) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (a, j) = (mat![[0.0], [0.0], [2.0]], mat![[0.0], [0.0], [0.0]]);
/// let options = IntegrationOptions::default();
/// let curve = RiemannianCubic::from_initial(s.as_ref(), v.as_ref(), a.as_ref(), j.as_ref(), &options)?;
/// assert!((curve.acceleration(0.0)? - a).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct RiemannianCubic {
    n: usize,
    k: usize,
    frame: Option<Mat<f64>>,
    path: Path,
    span: (f64, f64),
    report: Option<BoundaryReport>,
}

impl RiemannianCubic {
    /// From point, velocity, covariant acceleration and covariant jerk at time 0, all of shape `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `InvalidArgument` (`t_end` zero, tolerance); `NoConvergence` (more
    /// than 1e5 steps: too long or too fast), `Overflow`, `Interrupted`.
    pub fn from_initial(
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        a: MatRef<'_, f64>,
        j: MatRef<'_, f64>,
        options: &IntegrationOptions<'_>,
    ) -> Result<Self> {
        check_finite_scalar("t_end", options.t_end)?;
        if options.t_end == 0.0 {
            return Err(Error::InvalidArgument {
                name: "t_end",
                requirement: "not zero",
                found: 0.0,
            });
        }
        let range = Accuracy::FULL.truncation..=0.1;
        if !range.contains(&options.tolerance) {
            return Err(Error::InvalidArgument {
                name: "tolerance",
                requirement: "between 1e-17 and 0.1",
                found: options.tolerance,
            });
        }
        let data = InitialData::new(s, v, a, j)?;
        let accuracy = Accuracy::of_tolerance(options.tolerance);
        let mut path = Path::at(State::of_data(&data), s.ncols(), accuracy);
        path.extend_to(options.t_end, options.interrupt)?;
        Ok(Self::of_path(s.nrows(), s.ncols(), data.frame, path, None))
    }

    /// A path in the coordinates of a frame, and how it was found.
    pub(super) fn of_path(
        n: usize,
        k: usize,
        frame: Option<Mat<f64>>,
        path: Path,
        report: Option<BoundaryReport>,
    ) -> Self {
        RiemannianCubic {
            n,
            k,
            frame,
            span: path.covered(),
            path,
            report,
        }
    }

    /// How the boundary value problem was solved, for a curve that comes from one.
    pub fn report(&self) -> Option<&SolverReport> {
        self.report.as_ref().map(|report| &report.solver)
    }

    /// The same with the way on which the solution was found.
    pub fn boundary_report(&self) -> Option<&BoundaryReport> {
        self.report.as_ref()
    }

    /// The same curve, made for another interval: a part of it, or more.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument` (`start >= end`), and where the curve cannot be integrated on.
    pub fn restricted(&self, start: f64, end: f64, interrupt: Interrupt<'_>) -> Result<Self> {
        check_interval(start, end)?;
        let mut out = self.clone();
        out.path.extend_to(start, interrupt)?;
        out.path.extend_to(end, interrupt)?;
        out.span = (start, end);
        Ok(out)
    }

    /// The same points at other times: the interval of the curve becomes `[start, end]`.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument` (`start >= end`).
    pub fn reparametrised(&self, start: f64, end: f64) -> Result<Self> {
        check_interval(start, end)?;
        let scale = (end - start) / (self.span.1 - self.span.0);
        Ok(self.mapped(scale, start - scale * self.span.0, (start, end)))
    }

    /// The curve run backwards over the same interval.
    pub fn reversed(&self) -> Self {
        self.mapped(-1.0, self.span.0 + self.span.1, self.span)
    }

    fn mapped(&self, scale: f64, shift: f64, span: (f64, f64)) -> Self {
        RiemannianCubic {
            n: self.n,
            k: self.k,
            frame: self.frame.clone(),
            path: self.path.reparametrised(scale, shift),
            span,
            report: self.report,
        }
    }

    /// The conserved energy.
    ///
    /// ```math
    /// H = \tfrac12 |D_t S'|^2 - \langle x'', x \rangle
    ///   = \tfrac12 |D_t S'|^2 - \langle D_t D_t S', S' \rangle
    /// ```
    pub fn energy(&self) -> f64 {
        let [x, a, second] = self.vectors();
        0.5 * a.inner(&a) - second.inner(&x)
    }

    /// The conserved spatial momentum `g mu g^T`, skew, shape `(n, n)`.
    ///
    /// ```math
    /// \mu = -x'' + [x, x']_h
    /// ```
    pub fn momentum(&self) -> Mat<f64> {
        let (r, k) = (self.path.r(), self.k);
        let [x, a, second] = self.vectors();
        let turning = &a.normal * x.normal.transpose() - &x.normal * a.normal.transpose();
        let mu = Mat::from_fn(r, r, |i, j| match (i < k, j < k) {
            (true, true) => -second.omega[(i, j)],
            (false, true) => -second.normal[(i - k, j)],
            (true, false) => second.normal[(j - k, i)],
            (false, false) => turning[(i - k, j - k)],
        });
        let start = self.path.first();
        let g = Mat::from_fn(r, r, |i, j| match j.checked_sub(k) {
            None => start.s[i + r * j],
            Some(j) => start.e[i + r * j],
        });
        let g = self.frame.as_ref().map_or(g.clone(), |frame| frame * &g);
        &g * mu * g.transpose()
    }

    /// `x, x', x''` at the start of the path.
    fn vectors(&self) -> [Horizontal; 3] {
        let (k, m) = (self.k, self.path.r() - self.k);
        let start = self.path.first();
        std::array::from_fn(|i| Horizontal {
            omega: Mat::from_fn(k, k, |row, col| start.omega[i][row + k * col]),
            normal: Mat::from_fn(m, k, |row, col| start.b[i][row + m * col]),
        })
    }
}

/// Error unless `start < end`, both finite.
fn check_interval(start: f64, end: f64) -> Result<()> {
    check_finite_scalar("start", start)?;
    check_finite_scalar("end", end)?;
    if start < end && (end - start).is_finite() {
        return Ok(());
    }
    Err(Error::InvalidArgument {
        name: "end",
        requirement: "greater than the start",
        found: end,
    })
}

impl Curve for RiemannianCubic {
    type Workspace = Workspace;

    fn n(&self) -> usize {
        self.n
    }

    fn k(&self) -> usize {
        self.k
    }

    fn t_span(&self) -> (f64, f64) {
        self.span
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        self.frame.as_ref().map(|frame| frame.as_ref())
    }

    fn workspace(&self) -> Workspace {
        let size = self.path.r() * self.k;
        Workspace {
            beyond: None,
            coefficients: std::array::from_fn(|_| vec![0.0; size]),
        }
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Workspace,
        out: &mut Jet,
    ) -> Result<()> {
        check_parameter(t)?;
        let Workspace {
            beyond,
            coefficients,
        } = work;
        let path = reaching(&self.path, t, beyond)?;
        let mut targets: [&mut [f64]; ORDER + 1] =
            coefficients.each_mut().map(|c| c.as_mut_slice());
        path.points_into(t, &mut targets[..=order]);
        for (target, source) in out.c.iter_mut().zip(&targets[..=order]) {
            let (r, k) = target.shape();
            target.copy_from(MatRef::from_column_major_slice(source, r, k));
        }
        Ok(())
    }

    fn positions_into(
        &self,
        t: &[f64],
        work: &mut Workspace,
        _: &mut Option<Jet>,
        mut out: MatMut<'_, f64>,
    ) -> Result<()> {
        let Workspace {
            beyond,
            coefficients: [point, ..],
        } = work;
        let (r, k) = (self.path.r(), self.k);
        vectorised(
            #[inline(always)]
            || {
                for (i, &t) in t.iter().enumerate() {
                    check_parameter(t)?;
                    reaching(&self.path, t, beyond)?.points_into(t, &mut [point]);
                    for j in 0..k {
                        for l in 0..r {
                            out[(l, i * k + j)] = point[l + r * j];
                        }
                    }
                }
                Ok(())
            },
        )
    }

    fn cost_interruptible(&self, _: Interrupt<'_>) -> Result<f64> {
        let cost = self.path.cost(self.span.0, self.span.1);
        if cost.is_finite() {
            return Ok(cost);
        }
        Err(Error::Overflow { quantity: "cost" })
    }
}

/// The path, or, for times outside of what it covers, a copy that is integrated on.
fn reaching<'a>(path: &'a Path, t: f64, beyond: &'a mut Option<Path>) -> Result<&'a Path> {
    let (start, end) = path.covered();
    if t >= start && t <= end {
        return Ok(path);
    }
    let longer = beyond.get_or_insert_with(|| path.clone());
    longer.extend_to(t, Interrupt::NEVER)?;
    Ok(longer)
}

/// Buffers for evaluating Riemannian cubics of one shape.
pub struct Workspace {
    /// The path continued beyond its ends, as far as it was asked for.
    beyond: Option<Path>,
    coefficients: [Vec<f64>; ORDER + 1],
}

impl Horizontal {
    /// `<a, b> = tr(omega_a^T omega_b) / 2 + tr(b_a^T b_b)`.
    pub(crate) fn inner(&self, other: &Self) -> f64 {
        let product = |a: &Mat<f64>, b: &Mat<f64>| {
            a.col_iter()
                .zip(b.col_iter())
                .map(|(a, b)| a.transpose() * b)
                .sum::<f64>()
        };
        0.5 * product(&self.omega, &other.omega) + product(&self.normal, &other.normal)
    }

    /// `[a, b]_m`.
    pub(crate) fn bracket(&self, other: &Self) -> Self {
        let (a, b) = (self, other);
        let (k, m) = (a.omega.nrows(), a.normal.nrows());
        let mut square = Mat::zeros(k, k);
        mul_into(&mut square, 1.0, &a.omega, &b.omega);
        square -= a.normal.transpose() * &b.normal;
        let mut normal = Mat::zeros(m, k);
        mul_into(&mut normal, 1.0, &a.normal, &b.omega);
        normal -= &b.normal * &a.omega;
        Horizontal {
            omega: &square - square.transpose() * Scale(1.0),
            normal,
        }
    }
}
