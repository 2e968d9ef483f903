//! Broyden's method: a Jacobian corrected by the steps taken so far.
//!
//! # Source
//! Kelley (1995), "Iterative Methods for Linear and Nonlinear Equations", chapter 7 (the storage of Broyden's updates).

use faer::Mat;

use super::end_equations::flat_inverse;
use crate::linalg::decomp::solve_square;
use crate::shooting::StartResponse;

/// The steps of Broyden's method and its initial Jacobian.
#[derive(Default)]
pub(super) struct Updates<'a> {
    pub(super) start: Start<'a>,
    pub(super) steps: Vec<Vec<f64>>,
}

/// The source of the initial inverse Jacobian.
#[derive(Default)]
pub(super) enum Start<'a> {
    /// The inverse in flat space.
    #[default]
    Flat,
    /// The derivative of the equations.
    Jacobian(Mat<f64>),
    /// The response of a chain of legs at rest.
    Response(&'a StartResponse),
}

impl<'a> Updates<'a> {
    pub(super) fn of_response(response: Option<&'a StartResponse>) -> Self {
        Updates {
            start: response.map_or(Start::Flat, Start::Response),
            steps: Vec::new(),
        }
    }

    pub(super) fn has_response(&self) -> bool {
        matches!(self.start, Start::Response(_))
    }

    pub(super) fn clear(&mut self) {
        *self = Updates::default();
    }

    /// The next step: the initial inverse, corrected by all steps so far; `None` if the corrected one is singular.
    pub(super) fn step(&self, equations: &[f64]) -> Option<Vec<f64>> {
        let mut step = match &self.start {
            Start::Flat => flat_inverse(equations),
            Start::Jacobian(jacobian) => solve_square(jacobian.as_ref(), equations)?,
            // The response maps a motion of the end; the equations have the opposite sign.
            Start::Response(response) => {
                response.change(&equations.iter().map(|f| -f).collect::<Vec<_>>())
            }
        };
        step.iter_mut().for_each(|s| *s = -*s);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for pair in self.steps.windows(2) {
            let factor = dot(&pair[0], &step) / dot(&pair[0], &pair[0]);
            for (s, next) in step.iter_mut().zip(&pair[1]) {
                *s += factor * next;
            }
        }
        if let Some(last) = self.steps.last() {
            let factor = 1.0 - dot(last, &step) / dot(last, last);
            step.iter_mut().for_each(|s| *s /= factor);
        }
        step.iter().all(|s| s.is_finite()).then_some(step)
    }
}
