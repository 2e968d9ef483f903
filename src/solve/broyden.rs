//! Broyden's method: steps from fixed linear equations, corrected by the previous steps.
//!
//! # Source
//! Kelley (1995), "Iterative Methods for Linear and Nonlinear Equations", sec. 7.3 (the storage of Broyden's updates).

use crate::linalg::field::Field;

/// Largest ratio of successive steps along each other, where several problems are solved at once. Without this bound, a
/// converged lane jumps by its round-off and spoils the other lanes: of 4000 problems on St(3,1) 124 are not solved, with
/// it 31. A problem alone may converge slowly, with larger ratios.
const LARGEST: f64 = 0.5;

/// Steps since the linear equations were set up, for one problem or eight at once.
pub(crate) struct Updates<T> {
    /// The first `count` of them, followed by unused ones.
    steps: Vec<Vec<T>>,
    count: usize,
    most: usize,
}

impl<T: Field> Updates<T> {
    /// Stores at most the given number of steps.
    pub(crate) fn new(most: usize) -> Self {
        Updates {
            steps: Vec::new(),
            count: 0,
            most,
        }
    }

    /// Forgets the steps, because the linear equations are new or there are too many steps.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Converts a step of the fixed linear equations to the step of Broyden's method, and stores it.
    #[inline(always)]
    pub(crate) fn correct(&mut self, step: &mut [T]) {
        if self.count == self.most {
            self.clear();
        }
        for i in 0..self.count.saturating_sub(1) {
            let share = share(&self.steps[i], step);
            for (step, next) in step.iter_mut().zip(&self.steps[i + 1]) {
                *step += *next * share;
            }
        }
        if let Some(last) = self.steps[..self.count].last() {
            let rest = T::constant(1.0) - share(last, step);
            for step in &mut *step {
                *step = *step / rest;
            }
        }
        match self.steps.get_mut(self.count) {
            Some(stored) => stored.copy_from_slice(step),
            None => self.steps.push(step.to_vec()),
        }
        self.count += 1;
    }
}

/// The component of a step along another one, as a multiple of that one; zero for lanes that do not move, and for those
/// among several that move only by round-off.
#[inline(always)]
fn share<T: Field>(other: &[T], step: &[T]) -> T {
    let [mut product, mut square] = [T::ZERO; 2];
    for (a, b) in other.iter().zip(step) {
        product += *a * *b;
        square += *a * *a;
    }
    for lane in 0..T::COUNT {
        let is_round_off = T::COUNT > 1 && product.lane(lane).abs() >= LARGEST * square.lane(lane);
        if is_round_off || square.lane(lane) == 0.0 {
            product.set_lane(lane, 0.0);
            square.set_lane(lane, 1.0);
        }
    }
    product / square
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x + 0.3 (x_1 x_2, x_2 x_3, x_3 x_1) = b`.
    fn equations(x: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| x[i] + 0.3 * x[i] * x[(i + 1) % 3] - b[i])
    }

    /// Number of evaluations of the equations until round-off, with the linear equations of the start.
    fn evaluations(is_corrected: bool) -> usize {
        let (b, mut x) = ([0.9, -0.7, 0.5], [0.0; 3]);
        let mut updates = Updates::new(8);
        for count in 1..100 {
            let left = equations(&x, &b);
            if left.iter().all(|f| f.abs() < 1e-14) {
                return count;
            }
            let mut step = left.map(|f| -f);
            if is_corrected {
                updates.correct(&mut step);
            }
            for (x, step) in x.iter_mut().zip(step) {
                *x += step;
            }
        }
        panic!("no convergence");
    }

    #[test]
    fn updates_save_a_third_of_the_steps() {
        let [with, without] = [true, false].map(evaluations);
        assert!(
            3 * with < 2 * without,
            "{with} evaluations with updates, {without} without"
        );
    }

    #[test]
    fn a_lane_that_stands_still_stays_finite() {
        use crate::linalg::lanes::Lanes;
        let mut updates = Updates::<Lanes>::new(4);
        for size in [1.0, 1e-3, 1e-9] {
            let mut step = [Lanes::splat(size); 2];
            for entry in &mut step {
                entry.0[3] = 0.0;
            }
            updates.correct(&mut step);
            for entry in step {
                assert_eq!(entry.0[3], 0.0);
                assert!(entry.0.iter().all(|x| x.is_finite()), "{entry:?}");
            }
        }
    }
}
