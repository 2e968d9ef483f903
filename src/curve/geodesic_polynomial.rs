//! De Casteljau's algorithm with geodesics of the canonical metric: the generalised Bezier curves of the literature.
//!
//! # Source
//! Park, Ravani (1995), "Bezier curves on Riemannian manifolds and Lie groups with kinematics applications"; Popiel,
//! Noakes (2007), "Bezier curves and C2 interpolation in Riemannian manifolds".

use faer::{Mat, MatRef};

use super::span;
use super::{Curve, check_parameter};
use crate::error::{Error, Result};
use crate::linalg::jet::Jet;
use crate::linalg::product::mul_into;
use crate::manifold::exponential::Flow;
use crate::manifold::geodesic_jet::MovingGeodesic;
use crate::manifold::{Geodesic, Stiefel, normal_frame};

/// A Bezier curve on `[0, 1]` whose pieces are the shortest geodesics of the canonical metric.
///
/// Beside [`GeometricPolynomial`](super::GeometricPolynomial), whose pieces are quasi-geodesics in closed form, every
/// point solves `degree (degree - 1) / 2` logarithms, and derivatives a linear system of the dimension of the manifold
/// (at most `St((degree + 1) k, k)`) for each.
///
/// # Domain
/// Consecutive control points must be closer than the known bound of the injectivity radius
/// ([`Stiefel::injectivity_bound`]): then so are all intermediate points, by the triangle inequality, every geodesic is
/// the unique shortest one, and the curve is smooth.
#[derive(Debug, Clone)]
pub struct GeodesicPolynomial {
    /// The control points in the coordinates of the frame.
    points: Vec<Mat<f64>>,
    frame: Option<Mat<f64>>,
    legs: Vec<Geodesic>,
    reduced: Stiefel,
}

impl GeodesicPolynomial {
    /// The curve with the given control points, two or more, each of shape `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`; `BeyondInjectivity` where two consecutive points are too far apart, and
    /// those of [`Stiefel::log`].
    pub fn new(points: &[MatRef<'_, f64>]) -> Result<Self> {
        let (manifold, span, low) = span::control_points(points)?;
        let bound = manifold.injectivity_bound();
        let leg = |(index, pair): (usize, &[Mat<f64>])| {
            let leg = Geodesic::between(pair[0].as_ref(), pair[1].as_ref())?;
            let distance = leg.length();
            if distance < bound {
                return Ok(leg);
            }
            Err(Error::BeyondInjectivity {
                index,
                distance,
                bound,
            })
        };
        Ok(GeodesicPolynomial {
            legs: low.windows(2).enumerate().map(leg).collect::<Result<_>>()?,
            reduced: Stiefel::new(low[0].nrows(), manifold.k())?,
            points: low,
            frame: span.into_basis(),
        })
    }

    /// The control points, each of shape `(n, k)`; lifted from the frame, so as given to round-off.
    pub fn control_points(&self) -> Vec<Mat<f64>> {
        span::lifted(self.frame.as_ref(), &self.points)
    }

    /// One less than the number of control points.
    pub fn degree(&self) -> usize {
        self.legs.len()
    }
}

impl Curve for GeodesicPolynomial {
    type Workspace = Workspace;

    fn n(&self) -> usize {
        span::rows(self.frame.as_ref(), &self.points)
    }

    fn k(&self) -> usize {
        self.reduced.k()
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        self.frame.as_ref().map(|frame| frame.as_ref())
    }

    fn workspace(&self) -> Workspace {
        let (r, k) = (self.reduced.n(), self.k());
        Workspace {
            stages: (0..self.degree()).map(|_| Jet::zeros(r, k)).collect(),
            next: Jet::zeros(r, k),
            flow: Flow::new(&self.legs[0]),
            coordinates: Jet::zeros(k + normal_frame::normal_rank(r, k), k),
            moving: None,
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
        for (i, leg) in self.legs.iter().enumerate() {
            work.put(i, leg, t, order)?;
        }
        for level in (1..self.degree()).rev() {
            for i in 0..level {
                work.advance(i, &self.reduced, t, order)?;
            }
        }
        out.copy_from(&work.stages[0], order);
        Ok(())
    }
}

/// Buffers for evaluating geodesic polynomials of one shape and degree.
pub struct Workspace {
    stages: Vec<Jet>,
    next: Jet,
    flow: Flow,
    coordinates: Jet,
    moving: Option<Box<MovingGeodesic>>,
}

impl Workspace {
    /// A geodesic at `t` becomes a stage.
    fn put(&mut self, i: usize, curve: &Geodesic, t: f64, order: usize) -> Result<()> {
        curve.coordinates_into(t, order, &mut self.flow, &mut self.coordinates)?;
        for j in 0..=order {
            let target = &mut self.stages[i].c[j];
            mul_into(target, 1.0, curve.frame(), &self.coordinates.c[j]);
        }
        Ok(())
    }

    /// The geodesic from a stage to the next one, at `t`, takes the place of the first.
    fn advance(&mut self, i: usize, manifold: &Stiefel, t: f64, order: usize) -> Result<()> {
        let [from, to] = [i, i + 1].map(|j| &self.stages[j]);
        if order == 0 {
            let piece = manifold.geodesic_between(from.c[0].as_ref(), to.c[0].as_ref())?;
            return self.put(i, &piece, t, 0);
        }
        let moving = match &mut self.moving {
            Some(moving) => moving,
            empty => empty.insert(Box::new(MovingGeodesic::new(manifold.n(), manifold.k())?)),
        };
        moving.jet_into(from, to, t, order, &mut self.next)?;
        std::mem::swap(&mut self.stages[i], &mut self.next);
        Ok(())
    }
}

/// Convenience for a whole array of control points.
impl TryFrom<&[Mat<f64>]> for GeodesicPolynomial {
    type Error = Error;

    fn try_from(points: &[Mat<f64>]) -> Result<Self> {
        let points: Vec<_> = points.iter().map(|point| point.as_ref()).collect();
        Self::new(&points)
    }
}
