//! The trait of all curves: evaluation, derivatives, covariant quantities, length and cost.

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef};

use super::cost::squared_acceleration;
use super::derivative_bounds::{DerivativeBounds, sampled_bounds};
use super::length::Length;
use super::norms::{NormEvaluation, Norms};
use super::quantity::Quantity;
use super::sampling::{self, Request, Samples, check_parameter};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::jet::MatrixJet;
use crate::linalg::lanes::LANES;
use crate::space::Quotient;

/// A smooth curve on `St(n, k)`.
///
/// An implementation provides its coordinates in a frame; all other methods have defaults.
///
/// # Examples
/// ```
/// use faer::{MatRef, mat};
/// use stiefel_rs::linalg::jet::MatrixJet;
/// use stiefel_rs::{Curve, Interrupt, Result};
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
///     fn coordinates_into(&self, t: f64, order: usize, _: &mut (), out: &mut MatrixJet) -> Result<()> {
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
/// assert!((Circle.arc_length(0.0, 2.0, Interrupt::NEVER)? - 2.0).abs() < 1e-14);
/// assert!(Circle.acceleration(0.3)?.norm_l2() < 1e-14 && Circle.cost(Interrupt::NEVER)? < 1e-28);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub trait Curve: Send + Sync {
    /// Buffers for evaluation, one per thread.
    type Workspace: Send;

    /// Rows of a point.
    fn n(&self) -> usize;

    /// Columns of a point.
    fn k(&self) -> usize;

    /// The meaning of the points: frames, or the spans of their columns.
    fn quotient(&self) -> Quotient {
        Quotient::Frames
    }

    /// The same curve, extrapolated outside its interval; `None` for a curve that always extrapolates.
    fn continued(&self) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }

    /// The interval on which the curve is defined.
    fn t_span(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    /// Parameters where the curve may be less smooth, in increasing order: the ends of its interval, and the knots
    /// between them.
    fn breakpoints(&self) -> Vec<f64> {
        let (start, end) = self.t_span();
        vec![start.min(end), start.max(end)]
    }

    /// Orthonormal columns that span the curve, shape `(n, r)`; `None` if the coordinates are the entries themselves.
    fn frame(&self) -> Option<MatRef<'_, f64>>;

    /// Buffers for [`Curve::coordinates_into`].
    fn workspace(&self) -> Self::Workspace;

    /// Writes Taylor coefficients in `tau` of the coordinates at `t + tau`, up to `order`, each of shape `(r, k)`. Those above
    /// `order` must not be written: `out` may have no room for them.
    ///
    /// # Errors
    /// An error if the curve does not exist at `t`.
    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut Self::Workspace,
        out: &mut MatrixJet,
    ) -> Result<()>;

    /// Writes Taylor coefficients of the coordinates at many parameters, one polynomial for each.
    ///
    /// By default they are computed one after another; curves that compute many at once override this.
    ///
    /// # Errors
    /// An error if the curve does not exist at one of them.
    fn jets_into(
        &self,
        t: &[f64],
        order: usize,
        work: &mut Self::Workspace,
        out: &mut [MatrixJet],
    ) -> Result<()> {
        for (&t, out) in t.iter().zip(out) {
            self.coordinates_into(t, order, work, out)?;
        }
        Ok(())
    }

    /// Writes coordinates of the positions at many parameters, side by side in `out`, shape `(r, k len)`.
    ///
    /// By default they are computed one after another, using `scratch`; curves that compute many at once override this.
    ///
    /// # Errors
    /// An error if the curve does not exist at one of them.
    fn positions_into(
        &self,
        t: &[f64],
        work: &mut Self::Workspace,
        scratch: &mut Option<MatrixJet>,
        mut out: MatMut<'_, f64>,
    ) -> Result<()> {
        let (rows, k) = (out.nrows(), self.k());
        let jet = scratch.get_or_insert_with(|| MatrixJet::zeros(rows, k));
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
    /// `NonFinite`, and an error if the curve does not exist at `t`.
    fn point(&self, t: f64) -> Result<Mat<f64>> {
        self.derivative(t, 0)
    }

    /// The ambient derivative of order `nu` at `t`, 0 to 3; shape `(n, k)`.
    ///
    /// # Errors
    /// `NonFinite`, `InvalidArgument` (`nu`), and an error if the curve does not exist at `t`.
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

    /// Samples one quantity at many parameters, in parallel.
    ///
    /// Runs on the current rayon pool. Results are bit-identical for any number of threads; for positions and ambient
    /// derivatives, no memory is allocated per parameter.
    ///
    /// # Errors
    /// `NonFinite` (index of the parameter), `InvalidArgument` (derivative order), `Interrupted`, and an error if the
    /// curve does not exist at some parameter.
    fn sample(&self, t: &[f64], quantity: Quantity, interrupt: Interrupt<'_>) -> Result<Samples> {
        sample_blocks(self, t, quantity, interrupt)
    }

    /// Samples the coordinates of one quantity in the frame, side by side, shape `(r, k len)`; in parallel.
    ///
    /// [`lift_into`](super::lift_into) converts them to values, piecewise if all of them together are too large.
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

    /// The cost: the integral of the squared acceleration over [`Curve::t_span`]. For cubics in tension, and splines of
    /// them, the functional that they make stationary:
    ///
    /// ```math
    /// J = \int |D_t S'|^2\, dt,\qquad J_\tau = \int |D_t S'|^2 + \tau |S'|^2\, dt
    /// ```
    ///
    /// # Accuracy
    /// Accurate to 1e-12 relative, or to the round-off of the acceleration (`64 eps |S''|`) if that is larger, by
    /// composite Gauss-Legendre quadrature with as many panels as necessary.
    /// # Errors
    /// `NoConvergence`, `Overflow`, `Interrupted`, and an error if the curve does not exist somewhere.
    fn cost(&self, interrupt: Interrupt<'_>) -> Result<f64>
    where
        Self: Sized,
    {
        let mut norms = norms_of(self, "cost")?;
        squared_acceleration(&mut norms, self.t_span(), self.k(), interrupt)
    }

    /// Length from `t0` to `t1 >= t0` in the canonical metric; [`ArcLength`](super::ArcLength) also computes its
    /// inverse.
    ///
    /// # Accuracy
    /// Accurate to 1e-12 relative, or to the round-off of the velocity or of the parameter if that is larger.
    /// # Errors
    /// `NonFinite`, `InvalidArgument`, `NoConvergence`, `Overflow`, `Interrupted`, and an error if the curve does not
    /// exist somewhere.
    fn arc_length(&self, t0: f64, t1: f64, interrupt: Interrupt<'_>) -> Result<f64>
    where
        Self: Sized,
    {
        Ok(length_between(self, t0, t1, interrupt)?.total())
    }

    /// The largest norms of velocity, covariant acceleration and covariant jerk over [`Curve::t_span`].
    ///
    /// Found by dense sampling of each smooth piece and refinement near the largest values
    /// ([`Guarantee::Sampling`](super::Guarantee::Sampling)); for a Riemannian cubic they are strict bounds
    /// ([`Guarantee::Enclosure`](super::Guarantee::Enclosure)).
    ///
    /// # Errors
    /// `Overflow`, `Interrupted`, and an error if the curve does not exist somewhere.
    fn derivative_bounds(&self, interrupt: Interrupt<'_>) -> Result<DerivativeBounds> {
        let mut norms = norms_of(self, "derivative bounds")?;
        sampled_bounds(&mut norms, &self.breakpoints(), interrupt)
    }
}

/// Shape of the coordinates of a curve.
pub(super) fn coordinate_shape<C: Curve + ?Sized>(curve: &C) -> [usize; 2] {
    let rows = curve.frame().map_or(curve.n(), |frame| frame.ncols());
    [rows, curve.k()]
}

/// The norms along a curve, for a result of the given name, with a workspace allocated once.
fn norms_of<C: Curve + ?Sized>(
    curve: &C,
    result: &'static str,
) -> Result<Norms<impl NormEvaluation>> {
    let mut work = curve.workspace();
    let evaluate = move |t: &[f64], order: usize, out: &mut [MatrixJet]| {
        curve.jets_into(t, order, &mut work, out)
    };
    Norms::new(coordinate_shape(curve), curve.quotient(), result, evaluate)
}

/// The norms of which a length is computed.
pub(super) fn speed_of<C: Curve + ?Sized>(curve: &C) -> Result<Norms<impl NormEvaluation>> {
    norms_of(curve, "arc length")
}

/// The length of a curve from `start` to `end >= start`.
///
/// # Errors
/// `NonFinite`, `InvalidArgument`, `NoConvergence`, `Overflow`, `Interrupted`, and an error if the curve does not exist
/// somewhere.
pub(super) fn length_between<C: Curve>(
    curve: &C,
    start: f64,
    end: f64,
    interrupt: Interrupt<'_>,
) -> Result<Length> {
    check_parameter(start)?;
    check_parameter(end)?;
    if end < start {
        return Err(Error::InvalidArgument {
            name: "t1",
            requirement: "at least t0",
            found: end,
        });
    }
    // If the curve does not exist there, the error names the given time.
    for t in [start, end] {
        curve.point(t)?;
    }
    let speed = || speed_of(curve);
    Length::between(start, end, curve.breakpoints(), speed, interrupt)
}

/// [`Curve::sample`] by evaluation at every parameter.
pub(crate) fn sample_blocks<C: Curve + ?Sized>(
    curve: &C,
    t: &[f64],
    quantity: Quantity,
    interrupt: Interrupt<'_>,
) -> Result<Samples> {
    let request = Request {
        t,
        order: quantity.order(),
        interrupt,
    };
    let shape = [curve.n(), curve.k()];
    sampling::values(shape, curve.frame(), request, || reader(curve, quantity))
}

/// [`Curve::sample_coordinates`] by evaluation at every parameter.
pub(crate) fn sample_coordinate_blocks<C: Curve + ?Sized>(
    curve: &C,
    t: &[f64],
    quantity: Quantity,
    interrupt: Interrupt<'_>,
) -> Result<Mat<f64>> {
    let request = Request {
        t,
        order: quantity.order(),
        interrupt,
    };
    sampling::coordinates(coordinate_shape(curve), request, || reader(curve, quantity))
}

/// Returns a closure that reads one quantity at every parameter of a block, side by side, in the coordinates of the
/// frame.
fn reader<C: Curve + ?Sized>(
    curve: &C,
    quantity: Quantity,
) -> impl FnMut(&[f64], MatMut<'_, f64>) -> Result<()> {
    let (mut work, mut jet, mut jets) = (curve.workspace(), None, Vec::new());
    let mut covariant = None;
    move |t, mut out| {
        if quantity == Quantity::Derivative(0) {
            return curve.positions_into(t, &mut work, &mut jet, out);
        }
        let (rows, k) = (out.nrows(), curve.k());
        if jets.len() < t.len().min(LANES) {
            let jet = || MatrixJet::zeros_up_to(quantity.order(), rows, k);
            jets.resize_with(t.len().min(LANES), jet);
        }
        for (block, t) in t.chunks(LANES).enumerate() {
            let jets = &mut jets[..t.len()];
            curve.jets_into(t, quantity.order(), &mut work, jets)?;
            let out = out.rb_mut().subcols_mut(LANES * block * k, k * t.len());
            quantity.read_into(curve.quotient(), jets, &mut covariant, out);
        }
        Ok(())
    }
}
