//! Random boundary data of Riemannian cubics.
#![allow(dead_code)] // each binary uses a part

use faer::Mat;
use stiefel_rs::cubic::BoundaryOptions;
use stiefel_rs::{Curve, Interrupt, QuasiGeodesic, Result, RiemannianCubic, Stiefel};

use crate::common::{Rng, distance, random_point, random_tangent};

/// End points and end velocities.
#[derive(Clone)]
pub struct Data {
    pub s0: Mat<f64>,
    pub v0: Mat<f64>,
    pub s1: Mat<f64>,
    pub v1: Mat<f64>,
}

impl Data {
    /// Distance and speeds uniformly distributed up to the given ones.
    pub fn random(shape: (usize, usize), farthest: f64, fastest: f64, rng: &mut Rng) -> Self {
        let s0 = random_point(shape.0, shape.1, rng);
        let v0 = random_tangent(&s0, rng.between(0.0, fastest), rng);
        let way = random_tangent(&s0, rng.between(0.0, farthest), rng);
        let manifold = Stiefel::new(shape.0, shape.1).unwrap();
        let s1 = manifold.exp(s0.as_ref(), way.as_ref()).unwrap();
        let v1 = random_tangent(&s1, rng.between(0.0, fastest), rng);
        Data { s0, v0, s1, v1 }
    }

    /// The data of the curves traversed backwards.
    pub fn reversed(&self) -> Self {
        Data {
            s0: self.s1.clone(),
            v0: -&self.v1,
            s1: self.s0.clone(),
            v1: -&self.v0,
        }
    }

    pub fn map(&self, f: impl Fn(&Mat<f64>) -> Mat<f64>) -> Self {
        Data {
            s0: f(&self.s0),
            v0: f(&self.v0),
            s1: f(&self.s1),
            v1: f(&self.v1),
        }
    }

    pub fn solve_with(
        &self,
        options: &BoundaryOptions<'_>,
        interrupt: Interrupt<'_>,
    ) -> Result<RiemannianCubic> {
        RiemannianCubic::from_boundary(
            self.s0.as_ref(),
            self.v0.as_ref(),
            self.s1.as_ref(),
            self.v1.as_ref(),
            options,
            interrupt,
        )
    }

    pub fn solve(&self) -> Result<RiemannianCubic> {
        self.solve_with(&BoundaryOptions::default(), Interrupt::NEVER)
    }

    /// Whether the velocity of the quasi-geodesic between the end points and both end velocities are at most 2.
    pub fn is_moderate(&self) -> bool {
        let [n, k] = [self.s0.nrows(), self.s0.ncols()];
        let norm = |s: &Mat<f64>, v: &Mat<f64>| {
            let manifold = Stiefel::new(n, k).unwrap();
            manifold.norm(s.as_ref(), v.as_ref()).unwrap()
        };
        let way = QuasiGeodesic::between(self.s0.as_ref(), self.s1.as_ref()).unwrap();
        let lengths = [
            norm(&self.s0, &way.initial_velocity()),
            norm(&self.s0, &self.v0),
            norm(&self.s1, &self.v1),
        ];
        lengths.iter().all(|length| *length <= 2.0)
    }

    /// The defect of a curve's end conditions.
    pub fn defect(&self, curve: &RiemannianCubic) -> f64 {
        distance(&curve.point(0.0).unwrap(), &self.s0)
            .max(distance(&curve.point(1.0).unwrap(), &self.s1))
            .max(distance(&curve.derivative(0.0, 1).unwrap(), &self.v0))
            .max(distance(&curve.derivative(1.0, 1).unwrap(), &self.v1))
    }
}

/// Allowed defect: 1e-12 for the residual of the solution, the rest for round-off of the evaluation and of the data.
pub const END: f64 = 2e-12;
