//! Curves on the manifold: one protocol for evaluation, derivatives, covariant quantities and cost.
//!
//! A curve lives in the span of a few columns (its frame); points are computed there and lifted by one product
//! for a whole block of parameters. Blocks have a fixed size, so results do not depend on the number of threads.

mod acceleration_residual;
pub mod arc_length;
mod branch;
mod collocation;
pub(crate) mod cost;
pub mod de_casteljau;
pub mod derivative_bounds;
mod end_legs;
mod geodesic;
pub mod geodesic_polynomial;
pub mod geometric_cubic;
pub mod minimal_cost;
mod quasi_geodesic;
pub mod quintic;
pub(crate) mod span;
#[cfg(any(feature = "python", feature = "serde"))]
mod stored;

pub use arc_length::ArcLength;
pub use de_casteljau::GeometricPolynomial;
pub use derivative_bounds::{DerivativeBounds, Guarantee};
pub use geodesic_polynomial::GeodesicPolynomial;
pub use geometric_cubic::GeometricCubic;

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::{Jet, ORDER};
use crate::linalg::product::{mul_into, scale};
use crate::linalg::structure::{check_finite_scalar, check_range};
use crate::manifold::covariant;

/// Parameters per block: enough for an efficient product, few enough to share out evenly.
const BLOCK: usize = 64;

/// Rows of one piece of a lift: with some tens of columns of the frame it fits into the second cache.
const LIFT_ROWS: usize = 512;

/// Coordinates below this lift without overflow.
const HUGE: f64 = 1e300;

/// What to sample along a curve.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Interrupt, Quantity, QuasiGeodesic};
/// // A great circle at speed 2: it accelerates towards the centre, and not at all along the sphere.
/// let circle = QuasiGeodesic::from_velocity(mat![[1.0], [0.0]].as_ref(), mat![[0.0], [2.0]].as_ref())?;
/// let at = |quantity| circle.sample(&[0.0], quantity, Interrupt::NEVER);
/// assert!((at(Quantity::Derivative(2))?.get(0) - mat![[-4.0], [0.0]]).norm_l2() < 1e-14);
/// assert!(at(Quantity::Acceleration)?.get(0).norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The ambient derivative of this order, 0 (position) to 3.
    Derivative(usize),
    /// The covariant acceleration `D_t S'`.
    Acceleration,
    /// The covariant jerk `D_t D_t S'`.
    Jerk,
}

impl Quantity {
    /// Derivatives with respect to the parameter that it has.
    pub(crate) fn order(self) -> usize {
        match self {
            Quantity::Derivative(order) => order,
            Quantity::Acceleration => 2,
            Quantity::Jerk => 3,
        }
    }

    /// The quantity from Taylor coefficients of the curve, in the coordinates of its frame.
    fn read_into(self, jet: &Jet, mut out: MatMut<'_, f64>) {
        let c = |j: usize| jet.c[j].as_ref();
        let d = |j: usize, factorial: f64| &jet.c[j] * faer::Scale(factorial);
        match self {
            Quantity::Derivative(order) => {
                out.copy_from(c(order));
                scale(out, [1.0, 1.0, 2.0, 6.0][order]);
            }
            Quantity::Acceleration => {
                out.copy_from(covariant::acceleration(c(0), c(1), d(2, 2.0).as_ref()))
            }
            Quantity::Jerk => {
                out.copy_from(covariant::jerk(
                    c(0),
                    c(1),
                    d(2, 2.0).as_ref(),
                    d(3, 6.0).as_ref(),
                ));
            }
        }
    }
}

/// Values of a curve at many parameters.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Curve, Interrupt, Quantity, QuasiGeodesic};
/// let circle = QuasiGeodesic::from_velocity(mat![[1.0], [0.0]].as_ref(), mat![[0.0], [1.0]].as_ref())?;
/// let t = [0.0, 0.1, 0.2, 0.3];
/// let points = circle.sample(&t, Quantity::Derivative(0), Interrupt::NEVER)?;
/// assert_eq!((points.len(), points.get(2).shape()), (4, (2, 1)));
/// for (t, point) in t.iter().zip(points.iter()) {
///     assert!((point - mat![[t.cos()], [t.sin()]]).norm_l2() < 1e-14);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    n: usize,
    k: usize,
    entries: Vec<f64>,
}

impl Samples {
    /// From the entries of all values, each column by column.
    pub(crate) fn from_entries(n: usize, k: usize, entries: Vec<f64>) -> Self {
        debug_assert_eq!(entries.len() % (n * k), 0);
        Samples { n, k, entries }
    }

    fn zeros(n: usize, k: usize, len: usize) -> Result<Self> {
        let entries = zeros(n * k, len)?;
        Ok(Samples { n, k, entries })
    }

    /// How many parameters.
    pub fn len(&self) -> usize {
        self.entries.len() / (self.n * self.k)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The value at the `i`-th parameter, shape `(n, k)`.
    ///
    /// # Panics
    /// For `i >= len()`, like a slice.
    pub fn get(&self, i: usize) -> MatRef<'_, f64> {
        let size = self.n * self.k;
        MatRef::from_column_major_slice(&self.entries[i * size..(i + 1) * size], self.n, self.k)
    }

    /// All values in parameter order.
    pub fn iter(&self) -> impl Iterator<Item = MatRef<'_, f64>> {
        (0..self.len()).map(|i| self.get(i))
    }

    /// The entries, value after value, each column by column.
    pub fn into_entries(self) -> Vec<f64> {
        self.entries
    }
}

/// A smooth curve on `St(n, k)`.
///
/// An implementation gives its coordinates in a frame; everything else follows.
///
/// # Examples
/// ```
/// use faer::{MatRef, mat};
/// use stiefel_rs::linalg::jet::Jet;
/// use stiefel_rs::{Curve, Result};
/// /// The circle `(cos t, sin t)`.
/// struct Circle;
/// impl Curve for Circle {
///     type Workspace = ();
///     fn n(&self) -> usize {
///         2
///     }
///     fn k(&self) -> usize {
///         1
///     }
///     fn frame(&self) -> Option<MatRef<'_, f64>> {
///         None
///     }
///     fn workspace(&self) {}
///     fn coordinates_into(&self, t: f64, order: usize, _: &mut (), out: &mut Jet) -> Result<()> {
///         // Taylor coefficients: derivatives over factorials.
///         let ((sin, cos), factorials) = (t.sin_cos(), [1.0, 1.0, 2.0, 6.0]);
///         let derivatives = [[cos, sin], [-sin, cos], [-cos, -sin], [sin, -cos]];
///         for j in 0..=order {
///             let [x, y] = derivatives[j];
///             out.c[j].copy_from(mat![[x / factorials[j]], [y / factorials[j]]]);
///         }
///         Ok(())
///     }
/// }
/// assert!((Circle.arc_length(0.0, 2.0)? - 2.0).abs() < 1e-14);
/// assert!(Circle.acceleration(0.3)?.norm_l2() < 1e-14 && Circle.cost()? < 1e-28);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub trait Curve: Sync {
    /// Buffers for evaluation, one per thread.
    type Workspace: Send;

    /// Rows of a point.
    fn n(&self) -> usize;

    /// Columns of a point.
    fn k(&self) -> usize;

    /// The interval that the curve is made for.
    fn t_span(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    /// Where the curve may be less smooth, increasing: the ends of its interval, and the knots between them.
    fn breakpoints(&self) -> Vec<f64> {
        let (start, end) = self.t_span();
        vec![start.min(end), start.max(end)]
    }

    /// Columns that span the curve, shape `(n, r)`; `None` where coordinates are the entries themselves.
    fn frame(&self) -> Option<MatRef<'_, f64>>;

    /// Buffers for [`Curve::coordinates_into`].
    fn workspace(&self) -> Self::Workspace;

    /// Taylor coefficients in `tau` of the coordinates at `t + tau`, up to `order`, each of shape `(r, k)`.
    ///
    /// # Errors
    /// Where the curve does not exist at `t`.
    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Self::Workspace,
        out: &mut Jet,
    ) -> Result<()>;

    /// Coordinates of the positions at many parameters, side by side in `out`, shape `(r, k len)`.
    ///
    /// By default one after the other, through `scratch`; a curve that computes many at once does better.
    ///
    /// # Errors
    /// Where the curve does not exist at one of them.
    fn positions_into(
        &self,
        t: &[f64],
        work: &mut Self::Workspace,
        scratch: &mut Option<Jet>,
        mut out: MatMut<'_, f64>,
    ) -> Result<()> {
        let (rows, k) = (out.nrows(), self.k());
        let jet = scratch.get_or_insert_with(|| Jet::zeros(rows, k));
        for (i, &t) in t.iter().enumerate() {
            self.coordinates_into(t, 0, work, jet)?;
            out.rb_mut()
                .subcols_mut(i * k, k)
                .copy_from(jet.c[0].as_ref());
        }
        Ok(())
    }

    /// Position at `t`, shape `(n, k)`.
    ///
    /// # Errors
    /// `NonFinite`, and where the curve does not exist at `t`.
    fn point(&self, t: f64) -> Result<Mat<f64>> {
        self.derivative(t, 0)
    }

    /// The ambient derivative of order `nu`, 0 to 3, at `t`; shape `(n, k)`.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument` (`nu`), and where the curve does not exist at `t`.
    fn derivative(&self, t: f64, nu: usize) -> Result<Mat<f64>> {
        Ok(self
            .sample(&[t], Quantity::Derivative(nu), Interrupt::NEVER)?
            .get(0)
            .to_owned())
    }

    /// Covariant acceleration `D_t S'` at `t`, shape `(n, k)`.
    ///
    /// # Errors
    /// As [`Curve::derivative`].
    fn acceleration(&self, t: f64) -> Result<Mat<f64>> {
        Ok(self
            .sample(&[t], Quantity::Acceleration, Interrupt::NEVER)?
            .get(0)
            .to_owned())
    }

    /// Covariant jerk `D_t D_t S'` at `t`, shape `(n, k)`.
    ///
    /// # Errors
    /// As [`Curve::derivative`].
    fn jerk(&self, t: f64) -> Result<Mat<f64>> {
        Ok(self
            .sample(&[t], Quantity::Jerk, Interrupt::NEVER)?
            .get(0)
            .to_owned())
    }

    /// One quantity at many parameters, in parallel.
    ///
    /// Runs on the current rayon pool. Results are bit-identical for any number of threads, and no memory is
    /// allocated per parameter (positions and ambient derivatives).
    ///
    /// # Errors
    /// `NonFinite` (index of the parameter), `InvalidArgument` (derivative order), `Interrupted`, and where the
    /// curve does not exist at some parameter.
    fn sample(&self, t: &[f64], quantity: Quantity, interrupt: Interrupt<'_>) -> Result<Samples> {
        sample_blocks(self, t, quantity, interrupt)
    }

    /// The coordinates in the frame of one quantity at many parameters, side by side, shape `(r, k len)`; in parallel.
    ///
    /// [`lift_into`] makes values of them: in pieces, where all of them together are large.
    ///
    /// # Errors
    /// As [`Curve::sample`].
    fn sample_coordinates(
        &self,
        t: &[f64],
        quantity: Quantity,
        interrupt: Interrupt<'_>,
    ) -> Result<Mat<f64>> {
        sample_coordinate_blocks(self, t, quantity, interrupt)
    }

    /// Squared-acceleration cost over [`Curve::t_span`].
    ///
    /// ```math
    /// J = \int |D_t S'|^2\, dt
    /// ```
    ///
    /// # Accuracy
    /// Relative 1e-12, or round-off of the acceleration (`64 eps |S''|`) where that is more, by composite
    /// Gauss-Legendre quadrature with as many panels as that takes.
    /// # Errors
    /// `NoConvergence`, `Overflow`, and where the curve does not exist.
    fn cost(&self) -> Result<f64>
    where
        Self: Sized,
    {
        self.cost_interruptible(Interrupt::NEVER)
    }

    /// [`Curve::cost`] that can be stopped.
    ///
    /// # Errors
    /// As [`Curve::cost`], and `Interrupted`.
    fn cost_interruptible(&self, interrupt: Interrupt<'_>) -> Result<f64>
    where
        Self: Sized,
    {
        cost::squared_acceleration(self, interrupt)
    }

    /// Length from `t0` to `t1 >= t0` in the canonical metric; [`ArcLength`] has its inverse too.
    ///
    /// # Accuracy
    /// Relative 1e-12, or round-off of the velocity where that is more.
    /// # Errors
    /// `NonFinite`, `InvalidArgument`, `NoConvergence`, `Overflow`, and where the curve does not exist.
    fn arc_length(&self, t0: f64, t1: f64) -> Result<f64>
    where
        Self: Sized,
    {
        Ok(ArcLength::between(self, t0, t1, Interrupt::NEVER)?.total())
    }

    /// The largest norms of velocity, covariant acceleration and covariant jerk over [`Curve::t_span`].
    ///
    /// By dense sampling of each smooth piece, and refinement around the largest values ([`Guarantee::Sampling`]); a
    /// Riemannian cubic has true bounds ([`Guarantee::Enclosure`]).
    ///
    /// # Errors
    /// `Overflow`, and where the curve does not exist.
    fn derivative_bounds(&self) -> Result<DerivativeBounds> {
        self.derivative_bounds_interruptible(Interrupt::NEVER)
    }

    /// [`Curve::derivative_bounds`] that can be stopped.
    ///
    /// # Errors
    /// As [`Curve::derivative_bounds`], and `Interrupted`.
    fn derivative_bounds_interruptible(
        &self,
        interrupt: Interrupt<'_>,
    ) -> Result<DerivativeBounds> {
        derivative_bounds::sampled(self, interrupt)
    }
}

/// [`Curve::sample`] by evaluation at every parameter.
pub(crate) fn sample_blocks<C: Curve + ?Sized>(
    curve: &C,
    t: &[f64],
    quantity: Quantity,
    interrupt: Interrupt<'_>,
) -> Result<Samples> {
    let n = curve.n();
    let mut out = Samples::zeros(n, curve.k(), t.len())?;
    let entries = &mut out.entries;
    for_blocks(curve, t, quantity, interrupt, entries, n, read_lifted)?;
    Ok(out)
}

/// [`Curve::sample_coordinates`] by evaluation at every parameter.
pub(crate) fn sample_coordinate_blocks<C: Curve + ?Sized>(
    curve: &C,
    t: &[f64],
    quantity: Quantity,
    interrupt: Interrupt<'_>,
) -> Result<Mat<f64>> {
    let rows = curve.frame().map_or(curve.n(), |frame| frame.ncols());
    let mut out = zeros(rows * curve.k(), t.len())?;
    for_blocks(curve, t, quantity, interrupt, &mut out, rows, read_checked)?;
    let all = MatRef::from_column_major_slice(&out, rows, curve.k() * t.len());
    Ok(all.to_owned())
}

/// Zeros for values of `size` entries at `len` parameters, where there is memory for them.
fn zeros(size: usize, len: usize) -> Result<Vec<f64>> {
    let mut out = Vec::new();
    match size.checked_mul(len) {
        Some(total) if out.try_reserve_exact(total).is_ok() => {
            out.resize(total, 0.0);
            Ok(out)
        }
        _ => Err(Error::InvalidArgument {
            name: "t",
            requirement: "few enough parameters for the values to fit in memory",
            found: len as f64,
        }),
    }
}

/// Values from coordinates: `out = frame * coordinates`, rows in parallel.
///
/// Pieces of rows stay in the cache for all columns; each entry is computed the same way on any number of threads.
pub fn lift_into(frame: MatRef<'_, f64>, coordinates: MatRef<'_, f64>, out: MatMut<'_, f64>) {
    let n = frame.nrows();
    if n <= LIFT_ROWS {
        return mul_into(out, 1.0, frame, coordinates);
    }
    let middle = (n / 2).next_multiple_of(LIFT_ROWS);
    let (upper, lower) = out.split_at_row_mut(middle);
    let (frame_upper, frame_lower) = frame.split_at_row(middle);
    rayon::join(
        || lift_into(frame_upper, coordinates, upper),
        || lift_into(frame_lower, coordinates, lower),
    );
}

/// What one thread needs for one curve.
struct Buffers<C: Curve + ?Sized> {
    work: C::Workspace,
    jet: Option<Jet>,
    coordinates: Mat<f64>,
}

impl<C: Curve + ?Sized> Buffers<C> {
    fn new(curve: &C, len: usize) -> Self {
        let rows = curve.frame().map_or(0, |frame| frame.ncols());
        Buffers {
            work: curve.workspace(),
            jet: None,
            coordinates: Mat::zeros(rows, curve.k() * len.min(BLOCK)),
        }
    }
}

/// Hands each block of parameters, and the columns of `rows` entries that belong to it, to `one`.
fn for_blocks<C: Curve + ?Sized>(
    curve: &C,
    t: &[f64],
    quantity: Quantity,
    interrupt: Interrupt<'_>,
    out: &mut [f64],
    rows: usize,
    one: impl Fn(&C, &[f64], Quantity, &mut Buffers<C>, MatMut<'_, f64>) -> Result<()> + Sync,
) -> Result<()> {
    if quantity.order() > ORDER {
        let found = quantity.order() as f64;
        return Err(Error::InvalidArgument {
            name: "nu",
            requirement: "0, 1, 2 or 3",
            found,
        });
    }
    if let Some(index) = t.iter().position(|t| !t.is_finite()) {
        return Err(Error::NonFinite { name: "t", index });
    }
    let k = curve.k();
    let block = |buffers: &mut Buffers<C>, (out, t): (&mut [f64], &[f64])| {
        interrupt.check("curve sampling")?;
        let columns = MatMut::from_column_major_slice_mut(out, rows, k * t.len());
        one(curve, t, quantity, buffers, columns)
    };
    // A single block is not worth a trip to the pool.
    if t.len() <= BLOCK {
        return block(&mut Buffers::new(curve, t.len()), (out, t));
    }
    out.par_chunks_mut(rows * k * BLOCK)
        .zip(t.par_chunks(BLOCK))
        .try_for_each_init(|| Buffers::new(curve, t.len()), block)
}

/// One quantity at every parameter of a block, side by side, lifted.
fn read_lifted<C: Curve + ?Sized>(
    curve: &C,
    t: &[f64],
    quantity: Quantity,
    buffers: &mut Buffers<C>,
    mut columns: MatMut<'_, f64>,
) -> Result<()> {
    let Some(frame) = curve.frame() else {
        return read_checked(curve, t, quantity, buffers, columns);
    };
    let Buffers {
        work,
        jet,
        coordinates,
    } = buffers;
    let mut low = coordinates.as_mut().subcols_mut(0, curve.k() * t.len());
    read_block(curve, t, quantity, work, jet, low.rb_mut())?;
    check_range("curve", low.rb())?;
    lift_into(frame, low.rb(), columns.rb_mut());
    // The frame's columns have length one, so only sums of huge numbers can overflow.
    if low.norm_max() > HUGE {
        return check_range("curve", columns.rb());
    }
    Ok(())
}

/// One quantity at every parameter of a block, side by side, in the coordinates of the frame; finite.
fn read_checked<C: Curve + ?Sized>(
    curve: &C,
    t: &[f64],
    quantity: Quantity,
    buffers: &mut Buffers<C>,
    mut out: MatMut<'_, f64>,
) -> Result<()> {
    let Buffers { work, jet, .. } = buffers;
    read_block(curve, t, quantity, work, jet, out.rb_mut())?;
    check_range("curve", out.rb())
}

/// One quantity at every parameter of a block, side by side, in the coordinates of the frame.
fn read_block<C: Curve + ?Sized>(
    curve: &C,
    t: &[f64],
    quantity: Quantity,
    work: &mut C::Workspace,
    jet: &mut Option<Jet>,
    mut out: MatMut<'_, f64>,
) -> Result<()> {
    if quantity == Quantity::Derivative(0) {
        return curve.positions_into(t, work, jet, out);
    }
    let (rows, k) = (out.nrows(), curve.k());
    let jet = jet.get_or_insert_with(|| Jet::zeros(rows, k));
    for (i, &t) in t.iter().enumerate() {
        curve.coordinates_into(t, quantity.order(), work, jet)?;
        quantity.read_into(jet, out.rb_mut().subcols_mut(i * k, k));
    }
    Ok(())
}

/// Error `NonFinite` where a curve parameter is NaN or infinite.
pub(crate) fn check_parameter(t: f64) -> Result<()> {
    check_finite_scalar("t", t)
}
