//! The map from initial `(x', x'')` to the end of the curve, as used by the solvers of boundary value problems: block
//! sizes are hidden, work is counted.

use faer::Mat;

use super::shooting::SingleShooting;
use crate::cubic::boundary::end_equations::Target;
use crate::cubic::taylor::blocks::BlockSizes;
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::work::Work;
use crate::error::Result;
use crate::report::SolverReport;
use crate::shooting::StartResponse;

/// The interface of a boundary value problem for Newton's method and continuation.
pub(crate) trait EndMap {
    /// Replaces the boundary data.
    fn set_target(&mut self, target: &Target);

    /// Damped Newton from `y`, in place; if `y` is the start of a chain at rest, steps with the chain's response come
    /// first.
    fn solve(
        &mut self,
        y: &mut [f64],
        response: Option<&StartResponse>,
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<SolverReport>;

    /// The equations at `y`, and the distance of the end from its target.
    fn equations(&mut self, y: &[f64], accuracy: Accuracy) -> Result<(Vec<f64>, f64)>;

    /// The derivative of the equations, shape `(2d, 2d)`, and the equations.
    fn derivative(&mut self, y: &[f64], accuracy: Accuracy) -> Result<(Mat<f64>, Vec<f64>)>;

    /// The end of the curve of `y`: point and velocity, shape `(r, k)` each.
    fn end(&mut self, y: &[f64], accuracy: Accuracy) -> Result<[Mat<f64>; 2]>;

    /// The work done, and its limit.
    fn work(&self) -> &Work;
}

impl<B: BlockSizes, const N: usize> EndMap for SingleShooting<'_, B, N> {
    fn set_target(&mut self, target: &Target) {
        self.target.clone_from(target);
    }

    fn solve(
        &mut self,
        y: &mut [f64],
        response: Option<&StartResponse>,
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<SolverReport> {
        SingleShooting::solve(self, y, response, tolerance, max_iterations)
    }

    fn equations(&mut self, y: &[f64], accuracy: Accuracy) -> Result<(Vec<f64>, f64)> {
        let found = self.residual(y, accuracy)?;
        Ok((found.equations, found.distance))
    }

    fn derivative(&mut self, y: &[f64], accuracy: Accuracy) -> Result<(Mat<f64>, Vec<f64>)> {
        self.jacobian(y, accuracy)
    }

    fn end(&mut self, y: &[f64], accuracy: Accuracy) -> Result<[Mat<f64>; 2]> {
        self.residual(y, accuracy)?;
        let (m, k) = (self.blocks.normals(), self.blocks.k());
        let (rows, normals) = (self.blocks.r::<f64>(), self.blocks.m::<f64>());
        let (r, series) = (m + k, &self.plain.series);
        let s = Mat::from_fn(r, k, |i, j| series.s()[i + rows * j]);
        let e = Mat::from_fn(r, m, |i, j| series.e()[i + rows * j]);
        let omega = Mat::from_fn(k, k, |i, j| series.omega(0)[i + k * j]);
        let b = Mat::from_fn(m, k, |i, j| series.b(0)[i + normals * j]);
        let v = &s * omega + e * b;
        Ok([s, v])
    }

    fn work(&self) -> &Work {
        &self.work
    }
}
