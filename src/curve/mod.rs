//! Curves on the manifold: one protocol for evaluation, derivatives, covariant quantities and cost.
//!
//! A curve lives in the span of a few columns (its frame); points are computed there and lifted by one product
//! for a whole block of parameters. Blocks have a fixed size, so results do not depend on the number of threads.

mod cost;
pub mod de_casteljau;
mod geodesic;
mod quasi_geodesic;

pub use de_casteljau::GeometricCubic;

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

/// What to sample along a curve.
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
    fn order(self) -> usize {
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
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    n: usize,
    k: usize,
    entries: Vec<f64>,
}

impl Samples {
    fn zeros(n: usize, k: usize, len: usize) -> Self {
        Samples {
            n,
            k,
            entries: vec![0.0; n * k * len],
        }
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
        let mut out = Samples::zeros(self.n(), self.k(), t.len());
        sample_into(self, t, quantity, interrupt, &mut out.entries)?;
        Ok(out)
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
}

fn sample_into<C: Curve + ?Sized>(
    curve: &C,
    t: &[f64],
    quantity: Quantity,
    interrupt: Interrupt<'_>,
    out: &mut [f64],
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
    let (n, k) = (curve.n(), curve.k());
    let buffers = || (curve.workspace(), Block::new(curve));
    let one = |(work, block): &mut (C::Workspace, Block), (out, t): (&mut [f64], &[f64])| {
        interrupt.check("curve sampling")?;
        let columns = MatMut::from_column_major_slice_mut(out, n, k * t.len());
        block.fill(curve, t, quantity, work, columns)
    };
    // A single block is not worth a trip to the pool.
    if t.len() <= BLOCK {
        return one(&mut buffers(), (out, t));
    }
    out.par_chunks_mut(n * k * BLOCK)
        .zip(t.par_chunks(BLOCK))
        .try_for_each_init(buffers, one)
}

/// Coordinates of one block of parameters, and their lift.
struct Block {
    jet: Jet,
    coordinates: Mat<f64>,
}

impl Block {
    fn new<C: Curve + ?Sized>(curve: &C) -> Self {
        let r = curve.frame().map_or(curve.n(), |frame| frame.ncols());
        let lifted = curve.frame().is_some();
        Block {
            jet: Jet::zeros(r, curve.k()),
            coordinates: Mat::zeros(r, if lifted { curve.k() * BLOCK } else { 0 }),
        }
    }

    fn fill<C: Curve + ?Sized>(
        &mut self,
        curve: &C,
        t: &[f64],
        quantity: Quantity,
        work: &mut C::Workspace,
        mut columns: MatMut<'_, f64>,
    ) -> Result<()> {
        let k = curve.k();
        for (i, &t) in t.iter().enumerate() {
            curve.coordinates_into(t, quantity.order(), work, &mut self.jet)?;
            let target = if curve.frame().is_some() {
                self.coordinates.as_mut()
            } else {
                columns.rb_mut()
            };
            quantity.read_into(&self.jet, target.subcols_mut(i * k, k));
        }
        if let Some(frame) = curve.frame() {
            let coordinates = self.coordinates.as_ref().subcols(0, k * t.len());
            mul_into(columns.rb_mut(), 1.0, frame, coordinates);
        }
        check_range("curve", columns.rb())
    }
}

/// Error `NonFinite` where a curve parameter is NaN or infinite.
pub(crate) fn check_parameter(t: f64) -> Result<()> {
    check_finite_scalar("t", t)
}
