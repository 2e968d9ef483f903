//! De Casteljau's algorithm at one parameter, including all special cases and derivatives.

use crate::error::Result;
use crate::linalg::jet::MatrixJet;
use crate::manifold::QuasiGeodesic;
use crate::manifold::quasi_geodesic::{EndpointProblem, Evaluation};
use crate::manifold::quasi_geodesic_jet::MovingQuasiGeodesic;
use crate::space::Quotient;

/// The stages of the algorithm, with buffers for one shape and degree.
///
/// Frames are joined by quasi-geodesics. Bases of subspaces are joined by geodesics `e^{tX} Y`, each in terms of the
/// basis at its start: the result is a smooth basis of the point, but not the one that rotates as little as possible
/// along the curve.
pub(super) struct Stages {
    quotient: Quotient,
    stages: Vec<MatrixJet>,
    next: MatrixJet,
    evaluation: Evaluation,
    joining: QuasiGeodesic,
    problem: EndpointProblem,
    moving: Option<Box<MovingQuasiGeodesic>>,
    least_cosine: f64,
}

impl Stages {
    pub(super) fn new(quotient: Quotient, [r, k]: [usize; 2], degree: usize) -> Self {
        Stages {
            quotient,
            stages: (0..degree).map(|_| MatrixJet::zeros(r, k)).collect(),
            next: MatrixJet::zeros(r, k),
            evaluation: Evaluation::new(k),
            joining: QuasiGeodesic::zeros(r, k),
            problem: EndpointProblem::new(r, k),
            moving: None,
            least_cosine: 1.0,
        }
    }

    /// Compute Taylor coefficients at `t`, up to the given order, for the legs between consecutive control points.
    ///
    /// # Errors
    /// An error if intermediate points cannot be joined.
    pub(super) fn compute(&mut self, legs: &[QuasiGeodesic], t: f64, order: usize) -> Result<()> {
        self.least_cosine = 1.0;
        for (leg, stage) in legs.iter().zip(&mut self.stages) {
            leg.jet_into(t, order, &mut self.evaluation, stage)?;
        }
        for level in (1..legs.len()).rev() {
            for i in 0..level {
                match (self.quotient, order) {
                    (Quotient::Frames, 0) => self.advance(i, t)?,
                    _ => self.advance_jet(i, t, order)?,
                }
            }
        }
        Ok(())
    }

    /// The last computed Taylor coefficients.
    pub(super) fn value(&self) -> &MatrixJet {
        &self.stages[0]
    }

    /// The least cosine of a principal angle between intermediate subspaces, in the last computation.
    pub(super) fn least_cosine(&self) -> f64 {
        self.least_cosine
    }

    fn advance(&mut self, i: usize, t: f64) -> Result<()> {
        let [from, to] = [i, i + 1].map(|j| self.stages[j].c[0].as_ref());
        self.joining.join(from, to, &mut self.problem)?;
        self.joining
            .jet_into(t, 0, &mut self.evaluation, &mut self.stages[i])
    }

    fn advance_jet(&mut self, i: usize, t: f64, order: usize) -> Result<()> {
        let [from, to] = [i, i + 1].map(|j| &self.stages[j]);
        let moving = self.moving.get_or_insert_with(|| {
            let (r, k) = from.c[0].shape();
            Box::new(MovingQuasiGeodesic::new(r, k))
        });
        match self.quotient {
            Quotient::Frames => moving.jet_into(from, to, t, order, &mut self.next)?,
            Quotient::Subspaces => {
                let cosine = moving.span_jet_into(from, to, t, order, &mut self.next)?;
                self.least_cosine = self.least_cosine.min(cosine);
            }
        }
        std::mem::swap(&mut self.stages[i], &mut self.next);
        Ok(())
    }
}
