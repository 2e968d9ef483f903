//! Pseudo-arclength continuation of solutions of boundary value problems along a [family](super::homotopy) of data.
//!
//! The solutions `(y, lambda)` of `F(y, lambda) = 0` form a curve. It is followed by arclength, in tangent steps with
//! Newton corrections orthogonal to them, so `lambda` may decrease along it. Each crossing of `lambda = 1` gives a
//! solution of the problem.
//!
//! # Source
//! Keller (1977), "Numerical solution of bifurcation and nonlinear eigenvalue problems", in: Applications of Bifurcation
//! Theory, 359-384; Allgower, Georg (2003), "Introduction to Numerical Continuation Methods", ch. 2 and 6.

use faer::Mat;

use super::homotopy::Homotopy;
use super::shooting::SingleShooting;
use crate::cubic::taylor::march::Accuracy;
use crate::error::{Result, unless_interrupted};
use crate::linalg::decomp::solve_square;
use crate::solve::gmres::{dot, norm};

/// Maximal number of steps along the curve.
const MAX_STEPS: usize = 150;

/// The first, longest and shortest step, in units in which `lambda` and the scaled `y` change by 1.
const STEP: [f64; 3] = [0.1, 0.4, 1e-4];

/// Maximal number of Newton corrections per step.
const MAX_CORRECTIONS: usize = 4;

/// A point counts as on the curve once a correction is at most this; it only has to be close enough to continue.
const CORRECTED: f64 = 2e-3;

/// Largest ratio of the first correction to the step, and of each further correction to the previous one.
const CONTRACTION: f64 = 0.5;

/// Smallest cosine of the angle by which the tangent may turn in one step.
const MAX_TURN: f64 = 0.8;

/// The curve is abandoned where an entry of the scaled `y` exceeds this.
const FAR: f64 = 8.0;

/// The curve is abandoned where `lambda` leaves this range.
const RANGE: std::ops::Range<f64> = -1.5..2.5;

/// Truncation error of integrations during continuation, relative to the state.
const ACCURACY: f64 = 1e-7;

/// Half the step in `lambda` for differencing the data. The difference only predicts the direction.
const DIFFERENCE: f64 = 1e-3;

/// A point on the curve of solutions: scaled `y`, then `lambda`.
struct FamilyPoint {
    place: Vec<f64>,
    tangent: Vec<f64>,
}

/// Follows the curve of solutions of a family.
pub(crate) struct Tracer<'a, 'i> {
    map: &'a mut SingleShooting<'i>,
    homotopy: &'a Homotopy,
    /// Scale of `y`.
    scale: f64,
    /// Newton corrections so far.
    pub(crate) corrections: usize,
    /// Steps along the curve so far.
    steps: usize,
}

impl<'a, 'i> Tracer<'a, 'i> {
    pub(crate) fn new(map: &'a mut SingleShooting<'i>, homotopy: &'a Homotopy, scale: f64) -> Self {
        Tracer {
            map,
            homotopy,
            scale: scale.max(1.0),
            corrections: 0,
            steps: 0,
        }
    }

    /// Starts from a solution at `lambda = 0`; `arrive` receives an approximate solution at each crossing of `lambda = 1`
    /// and returns whether a solution was found from it; if not, the crossing is approached more closely.
    ///
    /// # Errors
    /// `Interrupted`, the errors of `arrive`, and an error if the family has no member at a parameter. Losing the curve
    /// is not an error.
    pub(crate) fn run(
        &mut self,
        start: &[f64],
        mut arrive: impl FnMut(&mut SingleShooting<'i>, &[f64]) -> Result<bool>,
    ) -> Result<()> {
        let [mut step, longest, shortest] = STEP;
        let Some(mut from) = self.first(start)? else {
            return Ok(());
        };
        while self.steps < MAX_STEPS && step >= shortest && !self.map.work.is_done() {
            self.steps += 1;
            let Some((to, corrections)) = self.advance(&from, step)? else {
                step *= 0.4;
                continue;
            };
            if let Some(y) = self.crossing(&from, &to)
                && !arrive(self.map, &y)?
            {
                step *= 0.4;
                continue;
            }
            from = to;
            let (lambda, y) = from.place.split_last().expect("there is lambda");
            if !RANGE.contains(lambda) || y.iter().any(|x| x.abs() > FAR) {
                break;
            }
            if corrections <= 2 {
                step = (2.0 * step).min(longest);
            }
        }
        Ok(())
    }

    fn first(&mut self, start: &[f64]) -> Result<Option<FamilyPoint>> {
        let mut place: Vec<f64> = start.iter().map(|y| y / self.scale).collect();
        place.push(0.0);
        let mut forward = vec![0.0; place.len()];
        forward[start.len()] = 1.0;
        let Some((matrix, _)) = self.system(&place, &forward)? else {
            return Ok(None);
        };
        Ok(tangent(&matrix).map(|tangent| FamilyPoint { place, tangent }))
    }

    /// The point one step further, and the number of corrections used.
    fn advance(&mut self, from: &FamilyPoint, step: f64) -> Result<Option<(FamilyPoint, usize)>> {
        let pairs = from.place.iter().zip(&from.tangent);
        let mut place: Vec<f64> = pairs.map(|(p, t)| p + step * t).collect();
        let mut allowed = CONTRACTION * step;
        for correction in 1..=MAX_CORRECTIONS {
            let Some((matrix, right)) = self.system(&place, &from.tangent)? else {
                return Ok(None);
            };
            let Some(change) = solve_square(matrix.as_ref(), &right) else {
                return Ok(None);
            };
            self.corrections += 1;
            let size = norm(&change);
            if size > allowed.max(CORRECTED) {
                return Ok(None);
            }
            for (p, c) in place.iter_mut().zip(&change) {
                *p -= c;
            }
            if size <= CORRECTED {
                let tangent = tangent(&matrix).filter(|t| dot(t, &from.tangent) > MAX_TURN);
                return Ok(tangent.map(|tangent| (FamilyPoint { place, tangent }, correction)));
            }
            allowed = CONTRACTION * size;
        }
        Ok(None)
    }

    /// The derivative of the equations with the row `direction` appended, and the equations; `None` if the flow cannot
    /// be integrated.
    fn system(&mut self, place: &[f64], direction: &[f64]) -> Result<Option<(Mat<f64>, Vec<f64>)>> {
        let last = place.len() - 1;
        let y: Vec<f64> = place[..last].iter().map(|y| y * self.scale).collect();
        let lambda = place[last];
        let accuracy = Accuracy::of_tolerance(ACCURACY);
        let mut beside = [Vec::new(), Vec::new()];
        for (equations, side) in beside.iter_mut().zip([-DIFFERENCE, DIFFERENCE]) {
            self.map.target = self.homotopy.target(lambda + side)?;
            let Some(found) = unless_interrupted(self.map.residual(&y, accuracy))? else {
                return Ok(None);
            };
            *equations = found.equations;
        }
        self.map.target = self.homotopy.target(lambda)?;
        let Some((jacobian, mut right)) = unless_interrupted(self.map.derivative(&y, accuracy))?
        else {
            return Ok(None);
        };
        right.push(0.0);
        let matrix = Mat::from_fn(last + 1, last + 1, |i, j| {
            if i == last {
                direction[j]
            } else if j == last {
                (beside[1][i] - beside[0][i]) / (2.0 * DIFFERENCE)
            } else {
                jacobian[(i, j)] * self.scale
            }
        });
        Ok(Some((matrix, right)))
    }

    /// `y` at `lambda = 1` on the line between two points.
    fn crossing(&self, from: &FamilyPoint, to: &FamilyPoint) -> Option<Vec<f64>> {
        let last = from.place.len() - 1;
        let (a, b) = (from.place[last] - 1.0, to.place[last] - 1.0);
        if (a < 0.0) == (b < 0.0) {
            return None;
        }
        let share = a / (a - b);
        let pairs = from.place[..last].iter().zip(&to.place);
        let y = pairs.map(|(p, q)| ((1.0 - share) * p + share * q) * self.scale);
        Some(y.collect())
    }
}

/// The unit vector in the kernel of all rows but the last, oriented along the last row.
fn tangent(matrix: &Mat<f64>) -> Option<Vec<f64>> {
    let mut right = vec![0.0; matrix.nrows()];
    *right.last_mut()? = 1.0;
    let solution = solve_square(matrix.as_ref(), &right)?;
    let size = norm(&solution);
    (size.is_finite() && size > 0.0).then(|| solution.iter().map(|x| x / size).collect())
}
