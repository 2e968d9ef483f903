//! The equations of a smoothing spline, whose knots are unknowns too, and their solution.

use faer::Mat;

use super::flat_smoothing::FlatSmoothing;
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::work::Work;
use crate::error::{Result, unless_interrupted};
use crate::legs::{End, Ends, Knots};
use crate::linalg::field::add;
use crate::manifold::Grassmann;
use crate::manifold::Stiefel;
use crate::report::{SolverReport, StopReason};
use crate::solve::anderson::Anderson;
use crate::solve::gmres::norm;
use crate::solve::line_search::backtracked;
use crate::solve::newton_krylov::newton_step;
use crate::space::Quotient;
use crate::spline::chains::chain::{LegEnds, Movable, square};
use crate::spline::chains::motion::Motion;
use crate::threads;

/// Microseconds of a logarithm of a rotation; 17 on St(4,2).
const LOGARITHM: f64 = 3.0;

/// Vectors computed per leg: point defect, velocity defect, acceleration, third vector.
const VECTORS: usize = 4;

/// Number of past steps used by Anderson mixing.
const DEPTH: usize = 6;

/// Integration accuracy of residuals, relative to the previous residual.
const ACCURACY_SHARE: f64 = 2e-5;

/// Integration accuracy of difference quotients.
const DIFFERENCE_ACCURACY: f64 = 1e-13;

/// Relative residual to which GMRES solves the linear equations.
const KRYLOV_SHARE: f64 = 1e-2;

/// Number of lengths of a Newton step that are tried.
const STEP_LENGTHS: i32 = 8;

/// Number of consecutive steps that may leave more than half of the smallest residual so far.
const PATIENCE: usize = 8;

/// Number of consecutive Newton steps that may leave more than half of the shortest flat step so far. Without a limit,
/// 100 unequal times on St(4, 2) with a weight near zero take 200 steps and 31 s before they are refused, with it 4 s;
/// two of 62 solutions for six points 2 to 2.5 apart, which took 44 and 51 steps, are no longer found.
const NEWTON_PATIENCE: usize = 12;

/// Round-off of a position, in units of the number of legs to the power 3/2: errors of unit steps accumulate in the
/// velocity, and again in the position. Up to 0.8 of this value is observed for 10 to 4000 unequal legs.
const ROUND_OFF: f64 = 0.5 * f64::EPSILON;

/// The data, sorted by knots.
pub(crate) struct SmoothingData {
    points: Vec<Mat<f64>>,
    knots: Vec<usize>,
    pub(crate) weights: Vec<f64>,
}

impl SmoothingData {
    pub(crate) fn new(points: Vec<Mat<f64>>, knots: Vec<usize>, weights: Vec<f64>) -> Self {
        SmoothingData {
            points,
            knots,
            weights,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    pub(crate) fn point(&self, datum: usize) -> &Mat<f64> {
        &self.points[datum]
    }

    /// The sum of weights times squared distances between the data and the points at the knots.
    ///
    /// # Errors
    /// The errors of a logarithm.
    pub(crate) fn misfit(
        &self,
        manifold: &Stiefel,
        points: &[Mat<f64>],
        quotient: Quotient,
    ) -> Result<f64> {
        let squares = threads::map(
            self.len(),
            LOGARITHM,
            || (),
            |(), i| {
                let reached = points[self.knots[i]].as_ref();
                let datum = self.points[i].as_ref();
                let distance = match quotient {
                    Quotient::Frames => manifold.dist(reached, datum)?,
                    Quotient::Subspaces => {
                        Grassmann::new(manifold.n(), manifold.k())?.dist(reached, datum)?
                    }
                };
                Ok(self.weights[i] * distance * distance)
            },
        )?;
        Ok(squares.iter().sum())
    }

    /// The sum of weights times squared distances between the data and the knots of a chain.
    ///
    /// # Errors
    /// As [`SmoothingData::displacements`].
    pub(crate) fn misfit_of<C: Movable>(&self, chain: &C, work: &Work) -> Result<f64> {
        Ok(self.squares(chain, &self.displacements(chain, work)?))
    }

    fn squares<C: Movable>(&self, chain: &C, displacements: &[Vec<f64>]) -> f64 {
        let each = self.knots.iter().zip(&self.weights).zip(displacements);
        each.map(|((&knot, weight), away)| weight * chain.square(knot, away))
            .sum()
    }

    /// The knot of each datum.
    pub(crate) fn knots(&self) -> &[usize] {
        &self.knots
    }

    /// The sum of the weights at each knot.
    pub(crate) fn weight_of_knots(&self) -> Vec<f64> {
        let count = self.knots.last().map_or(0, |last| last + 1);
        let mut sums = vec![0.0; count];
        for (&knot, weight) in self.knots.iter().zip(&self.weights) {
            sums[knot] += weight;
        }
        sums
    }

    /// The logarithms of the data at the knots of a chain, one after another.
    ///
    /// # Errors
    /// An error wrapped in `AtKnot` if a logarithm does not exist.
    pub(crate) fn displacements<C: Movable>(
        &self,
        chain: &C,
        work: &Work,
    ) -> Result<Vec<Vec<f64>>> {
        let is_far = |knot: usize, away: &[f64]| chain.square(knot, away) > FAR * FAR;
        // All of them are computed even if one fails, so that the counted work does not depend on the threads.
        let all = threads::map(
            self.len(),
            LOGARITHM,
            || (),
            |(), i| {
                let knot = self.knots[i];
                let found = chain.towards(knot, &self.points[i]);
                if found.as_ref().map_or(true, |away| is_far(knot, away)) {
                    work.count(SEARCHES * chain.work_of_knot());
                }
                Ok(found.map_err(|error| error.at_knot(knot)))
            },
        )?;
        all.into_iter().collect()
    }
}

/// Distance beyond which, or after a failure, the logarithm searches for the shortest geodesic. That takes about as
/// long as moving a knot this many times: half as long as that on St(9,7), 5 to 11 times on St(8,4) and St(12,4), 17
/// times on St(10,3).
const FAR: f64 = 2.8;
const SEARCHES: f64 = 8.0;

/// Work of evaluating the residuals of the equations.
pub(crate) fn work_of_residual<C: Movable>(chain: &C) -> f64 {
    chain.lengths().len() as f64 * (chain.work_of_leg() + chain.work_of_knot())
}

/// A chain and a motion along it.
struct SmoothingState<C> {
    chain: C,
    motion: Motion,
}

impl<C: Movable> SmoothingState<C> {
    /// Number of coordinates of all positions, or of all velocities.
    fn count(&self) -> usize {
        self.chain.size() * (self.chain.lengths().len() + 1)
    }
}

/// The equations at the current state of the iteration for a smoothing spline.
///
/// Steps are changes of positions, of velocities, and of accelerations and third vectors; the last two are
/// [scaled](SmoothingEquations::stretch).
pub(crate) struct SmoothingEquations<'d, C> {
    state: SmoothingState<C>,
    data: &'d SmoothingData,
    /// Without acceleration.
    ends: Ends,
    flat: FlatSmoothing,
    misfit: f64,
    work: &'d Work,
}

/// Residuals of the equations, and the step that would solve them in flat space.
struct SmoothingResidual {
    step: Vec<f64>,
    size: f64,
    misfit: f64,
}

impl<'d, C: Movable> SmoothingEquations<'d, C> {
    /// Starts with the smoothing spline of flat space, for a chain through points near the data.
    ///
    /// # Errors
    /// An error if the knots cannot be moved there.
    pub(crate) fn new(
        chain: C,
        data: &'d SmoothingData,
        flat: FlatSmoothing,
        work: &'d Work,
    ) -> Result<Self> {
        let motion = Motion::zeros(chain.size(), chain.lengths().len() + 1);
        let mut equations = Self::near(chain, motion, data, flat, work);
        let leg_ends = LegEnds::at_rest(&equations.state.chain, VECTORS)?;
        let start = equations.residual_of(&equations.state, leg_ends)?;
        equations.state = equations.advanced(1.0, &start.step)?;
        Ok(equations)
    }

    /// Starts with a motion along a chain.
    pub(crate) fn near(
        chain: C,
        motion: Motion,
        data: &'d SmoothingData,
        flat: FlatSmoothing,
        work: &'d Work,
    ) -> Self {
        SmoothingEquations {
            work,
            ends: Ends::Open([(); 2].map(|()| End::Acceleration(vec![0.0; chain.size()]))),
            state: SmoothingState { chain, motion },
            data,
            flat,
            misfit: 0.0,
        }
    }

    pub(crate) fn chain(&self) -> &C {
        &self.state.chain
    }

    pub(crate) fn motion(&self) -> &Motion {
        &self.state.motion
    }

    /// `sum w d^2` at the last evaluated state.
    pub(crate) fn misfit(&self) -> f64 {
        self.misfit
    }

    /// Iterates the step of flat space, with Anderson mixing; if that stalls, uses Newton's method.
    ///
    /// # Errors
    /// An error if the start cannot be integrated; `Interrupted`.
    pub(crate) fn solve(&mut self, tolerance: f64, max_iterations: usize) -> Result<SolverReport> {
        let legs = self.state.chain.lengths().len() as f64;
        let tolerance = tolerance.max(ROUND_OFF * legs * legs.sqrt());
        let mut accuracy = Accuracy::of_tolerance(ACCURACY_SHARE);
        let mut found = self.residual(&self.state, accuracy)?;
        let (mut mixing, mut newton, mut iterations) = (Anderson::new(DEPTH), false, 0);
        let (mut least, mut failures) = (found.size, 0);
        let reason = loop {
            if found.size <= tolerance && accuracy.truncation > Accuracy::FULL.truncation {
                accuracy = Accuracy::FULL;
                found = self.residual(&self.state, accuracy)?;
                continue;
            }
            if found.size <= tolerance {
                break StopReason::Converged;
            }
            if iterations == max_iterations {
                break StopReason::MaxIterations;
            }
            if self.work.is_done() {
                break StopReason::WorkLimit;
            }
            iterations += 1;
            let share = ACCURACY_SHARE * found.size.min(1.0);
            accuracy = accuracy.finer(Accuracy::of_tolerance(share));
            if newton {
                accuracy = accuracy.finer(Accuracy::of_tolerance(DIFFERENCE_ACCURACY));
                match self.descended(accuracy, &found)? {
                    Some((state, nearer)) if failures < NEWTON_PATIENCE => {
                        (self.state, found) = (state, nearer);
                        failures = if norm(&found.step) > 0.5 * least {
                            failures + 1
                        } else {
                            0
                        };
                        least = least.min(norm(&found.step));
                    }
                    _ if self.work.is_done() => break StopReason::WorkLimit,
                    _ => break StopReason::Stagnated,
                }
                continue;
            }
            match self.tried(accuracy, 1.0, &mixing.increment(found.step.clone()))? {
                Some((state, next)) if failures < PATIENCE => {
                    (self.state, found) = (state, next);
                    failures = if found.size > 0.5 * least {
                        failures + 1
                    } else {
                        0
                    };
                    least = least.min(found.size);
                }
                _ => (newton, least, failures) = (true, norm(&found.step), 0),
            }
        };
        self.misfit = found.misfit;
        Ok(SolverReport::new(reason, iterations, found.size, tolerance))
    }

    /// `None` if the state cannot be integrated, or its knots cannot be joined.
    fn tried(
        &self,
        accuracy: Accuracy,
        share: f64,
        step: &[f64],
    ) -> Result<Option<(SmoothingState<C>, SmoothingResidual)>> {
        let moved = self.advanced(share, step);
        let found = moved.and_then(|state| {
            let found = self.residual(&state, accuracy)?;
            Ok((state, found))
        });
        let found = unless_interrupted(found)?;
        Ok(found.filter(|(_, found)| found.size.is_finite()))
    }

    /// The state after a fraction of a step: knots moved with their velocities, and the motion changed.
    fn advanced(&self, share: f64, step: &[f64]) -> Result<SmoothingState<C>> {
        let SmoothingState { chain, motion } = &self.state;
        let (shifts, change) = step.split_at(self.state.count());
        let shifts: Vec<f64> = shifts.iter().map(|x| share * x).collect();
        let (velocities, derivatives) = change.split_at(self.state.count());
        let stretch = self.stretch();
        let mut motion = motion.clone();
        motion.add(share, velocities);
        motion.add_derivatives(share / stretch, derivatives);
        let chain = chain.moved(&shifts, &mut motion)?;
        Ok(SmoothingState { chain, motion })
    }

    /// The state after a Newton step, which is shortened until the flat step decreases. The flat step is the
    /// preconditioner of the linear equations, which are solved with difference quotients.
    fn descended(
        &self,
        accuracy: Accuracy,
        here: &SmoothingResidual,
    ) -> Result<Option<(SmoothingState<C>, SmoothingResidual)>> {
        let base = self.residual(&self.state, accuracy)?.step;
        let size = norm(&self.state.motion.entries);
        let step = newton_step(&base, size, KRYLOV_SHARE, |share, direction| {
            if self.work.is_done() {
                return Ok(None);
            }
            let beside = self.advanced(share, direction)?;
            Ok(Some(self.residual(&beside, accuracy)?.step))
        })?;
        let Some(step) = step else { return Ok(None) };
        let found = backtracked(norm(&here.step), STEP_LENGTHS, |share| {
            if self.work.is_done() {
                return Ok(None);
            }
            let tried = self.tried(accuracy, share, &step)?;
            Ok(tried.map(|(state, found)| (norm(&found.step), (state, found))))
        })?;
        Ok(found.map(|(state, _)| state))
    }

    /// Factor by which accelerations and third vectors are multiplied in steps. If the weight of the cost is large,
    /// they are small, but they must balance the data accurately. Data along `N` legs bend a curve by `N^2 / lambda`
    /// times their distances from it.
    fn stretch(&self) -> f64 {
        let legs = self.state.chain.lengths().len() as f64;
        (self.flat.lambda() / (legs * legs)).max(1.0)
    }

    fn residual(&self, state: &SmoothingState<C>, accuracy: Accuracy) -> Result<SmoothingResidual> {
        let chain = &state.chain;
        let legs = chain.lengths().len() as f64;
        self.work.count(legs * chain.work_of_knot());
        let leg_ends = LegEnds::of(chain, &state.motion, VECTORS, accuracy, self.work)?;
        self.residual_of(state, leg_ends)
    }

    fn residual_of(
        &self,
        state: &SmoothingState<C>,
        leg_ends: LegEnds,
    ) -> Result<SmoothingResidual> {
        let SmoothingState { chain, motion } = state;
        let (d, lengths) = (chain.size(), chain.lengths());
        let mut pulls = vec![0.0; state.count()];
        let displacements = self.data.displacements(chain, self.work)?;
        let misfit = self.data.squares(chain, &displacements);
        let weights = self.data.knots.iter().zip(&self.data.weights);
        for ((&knot, weight), away) in weights.zip(&displacements) {
            add(&mut pulls[d * knot..], *weight, away);
        }
        let (mut step, change) = self.flat.step(chain, motion, &leg_ends, &pulls)?;
        let knots = Knots::of_points(lengths, &self.ends);
        let accelerations = |leg: usize| [&motion.derivatives(leg)[..d], leg_ends.vector(leg, 2)];
        let jumps = knots.jumps::<f64>(d, accelerations);
        let mut size = leg_ends.defect;
        let each = jumps.chunks_exact(d).zip(step.chunks_exact(d)).enumerate();
        for (knot, (jump, shift)) in each {
            let h = knots.shortest(knot);
            // NaN is propagated.
            for part in [square(shift).sqrt(), h * h * square(jump).sqrt()] {
                size = if part <= size { size } else { part };
            }
        }
        let (velocities, derivatives) = change.entries.split_at(state.count());
        let stretch = self.stretch();
        step.extend(velocities);
        step.extend(derivatives.iter().map(|x| stretch * x));
        Ok(SmoothingResidual { step, size, misfit })
    }
}
