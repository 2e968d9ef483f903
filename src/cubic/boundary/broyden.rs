//! Broyden's method for the equations of shooting, from one of three initial Jacobians.

use faer::Mat;

use crate::cubic::boundary::end_equations::flat_inverse;
use crate::linalg::decomp::solve_square;
use crate::shooting::StartResponse;
use crate::solve::broyden::Updates;

/// Maximal number of stored updates.
const MAX_UPDATES: usize = 30;

/// An initial Jacobian and the steps since.
pub(crate) struct Broyden<'a> {
    pub(crate) start: InitialJacobian<'a>,
    updates: Updates<f64>,
}

/// The source of the initial inverse Jacobian.
pub(crate) enum InitialJacobian<'a> {
    /// The inverse in flat space.
    Flat,
    /// The derivative of the equations.
    Jacobian(Mat<f64>),
    /// The response of a chain of legs at rest.
    Response(&'a StartResponse),
}

impl<'a> Broyden<'a> {
    pub(crate) fn new(start: InitialJacobian<'a>) -> Self {
        Broyden {
            start,
            updates: Updates::new(MAX_UPDATES),
        }
    }

    /// The next step; `None` if a Jacobian is singular, or the step is not finite.
    pub(crate) fn step(&mut self, equations: &[f64]) -> Option<Vec<f64>> {
        let mut step = match &self.start {
            InitialJacobian::Flat => flat_inverse(equations),
            InitialJacobian::Jacobian(jacobian) => solve_square(jacobian.as_ref(), equations)?,
            // The response is to a motion of the end; the equations have the opposite sign.
            InitialJacobian::Response(response) => response.change(equations),
        };
        if !matches!(self.start, InitialJacobian::Response(_)) {
            step.iter_mut().for_each(|s| *s = -*s);
        }
        self.updates.correct(&mut step);
        step.iter().all(|s| s.is_finite()).then_some(step)
    }
}
