//! Splines near the ends of descents: chains of short legs that pass through the knots and have free knots
//! in between.

use faer::Mat;

use super::chain::Chain as _;
use super::descent_end;
use super::flat_spline::flat_spline;
use super::framed::Framed;
use super::motion::Motion;
use super::solution::{ChainSolution, Effort};
use crate::cubic::boundary::descent_start::DescentStart;
use crate::cubic::boundary::guess::FlatData;
use crate::cubic::boundary::relative_ends::RelativeEnds;
use crate::cubic::taylor::initial::Horizontal;
use crate::cubic::taylor::packing::unpack;
use crate::cubic::taylor::work::of_products;
use crate::error::{Result, unless_interrupted};
use crate::legs::Options;
use crate::linalg::lanes::Lanes;
use crate::linalg::structure::{identity_columns, row_by_row};
use crate::manifold::grassmann::alignment::alignment;
use crate::shooting::{
    ChainKnots, ChainLayout, DescentProblem, Held, products_of_step, stationary_end,
};
use crate::solve::direction::Direction;
use crate::space::{Quotient, in_space};
use crate::spline::ends::{End, Ends, gives_velocity};

/// Norm of the gradient at which descents stop, in the time of a leg.
const TOLERANCE: f64 = 1e-6;

/// Maximal number of steps of a descent. Of 120 splines through 8 to 30 random rotations, at times whose intervals
/// differ by a factor of up to 100, 9 are not solved; with 100 steps 16, without [`NEAR`] 19, with neither 27.
const MAX_STEPS: usize = 300;

/// Norm of the gradient, in the time of a leg, at the end of a descent from which Newton's method is tried. If curves
/// are long and fast, descents end above [`TOLERANCE`], where the predicted decrease is below the accuracy of the cost.
const NEAR: f64 = 1e-2;

/// A descent begins only if at least this many steps fit into the remaining work.
const FEWEST_STEPS: f64 = 20.0;

/// Minimal number of legs of a chain: the equations of a closed one are cyclic from three on.
const FEWEST_LEGS: usize = 3;

/// The curves along which a descent starts.
pub(crate) enum Course {
    /// Those that roll from knot to knot with the velocities of a motion.
    Rolling(Motion),
    /// For a chain of one leg, the cubic of flat space with other data.
    Along(FlatData),
}

/// The starts of descents: curves that roll with the velocities of the flat spline, with none except where velocities are
/// given and, for open chains without given velocities, with those of the flat spline whose ends are at rest. If velocities
/// are given at both ends of a single leg, the first two are the same, and the cubic of flat space takes the place of the
/// first.
///
/// Of 102 splines through distant knots with given accelerations and uneven times, 19 are not solved without the first
/// one; of 102 through random knots with end velocities up to 6, ten cost up to 2.7 times as much without the second
/// one; of 253 natural ones and such with given accelerations, through points 1.6 to 2.8 apart on St(3,1) to St(10,9), 17 cost
/// up to 1.8 times as much without the third one, which takes 5 % of the time.
///
/// # Errors
/// Velocities of the flat spline.
pub(crate) fn starts(chain: &Framed<'_>, ends: &Ends) -> Result<Vec<Course>> {
    let first = match flat_data(chain, ends)? {
        Some(flat) => Course::Along(flat),
        None => Course::Rolling(flat_spline(chain, ends)?),
    };
    let mut starts = vec![first, Course::Rolling(resting(chain, ends))];
    if matches!(ends, Ends::Open(_)) && !gives_velocity(ends) {
        let at_rest = [(); 2].map(|()| End::Velocity(vec![0.0; chain.size()]));
        let flat = flat_spline(chain, &Ends::Open(at_rest))?;
        starts.push(Course::Rolling(flat));
    }
    Ok(starts)
}

/// The motion whose velocities are zero except where velocities are given.
fn resting(chain: &Framed<'_>, ends: &Ends) -> Motion {
    let knots = chain.lengths().len() + 1;
    let mut resting = Motion::zeros(chain.size(), knots);
    if let Ends::Open(ends) = ends {
        for (knot, end) in [0, knots - 1].into_iter().zip(ends) {
            if let Some(velocity) = end.velocity() {
                resting.velocity_mut(knot).copy_from_slice(velocity);
            }
        }
    }
    resting
}

/// Displacement and end velocity of the only leg along the curve that joins its ends; `None` for several legs, or if
/// not both velocities are given.
///
/// # Errors
/// The errors of carrying.
fn flat_data(chain: &Framed<'_>, ends: &Ends) -> Result<Option<FlatData>> {
    let ([h], Ends::Open([End::Velocity(_), End::Velocity(v)])) = (chain.lengths(), ends) else {
        return Ok(None);
    };
    let [mut displacement, mut carried] = [(); 2].map(|()| vec![0.0; chain.size()]);
    chain.displacement_into(0, &mut displacement);
    let v: Vec<f64> = v.iter().map(|v| h * v).collect();
    chain.carry_into(
        &mut chain.worker(),
        0,
        Direction::Backward,
        &v,
        &mut carried,
    )?;
    let [[displacement], [end_velocity]] =
        [displacement, carried].map(|entries| unpack(&entries, chain.blocks()));
    Ok(Some(FlatData {
        displacement,
        end_velocity,
    }))
}

impl Course {
    /// The solution near the end of a descent from here; not converged if it ends far from rest.
    ///
    /// # Errors
    /// `Interrupted`.
    pub(crate) fn end(
        &self,
        chain: &Framed<'_>,
        ends: &Ends,
        effort: Effort<'_>,
    ) -> Result<ChainSolution> {
        let kind = chain.blocks().kind();
        match self {
            Course::Rolling(start) => {
                let start = FreeKnots::new(chain, ends, start, |leg, ends| {
                    DescentStart::rolling(kind, ends, fewest_parts(chain, leg))
                });
                nearest(chain, start, effort)
            }
            Course::Along(flat) => {
                let start = FreeKnots::new(chain, ends, &resting(chain, ends), |_, ends| {
                    DescentStart::along_flat(kind, ends, flat)
                });
                nearest(chain, start, effort)
            }
        }
    }
}

/// Minimal number of parts of a leg: in tension, deviations grow at most by a factor of `e` along one.
fn fewest_parts(chain: &Framed<'_>, leg: usize) -> usize {
    let growth = chain.lengths()[leg] * chain.tension().sqrt();
    FEWEST_LEGS
        .div_ceil(chain.lengths().len())
        .max(growth.ceil() as usize)
}

/// The solution near the end of a descent.
///
/// # Errors
/// `Interrupted`.
fn nearest(
    chain: &Framed<'_>,
    start: Result<FreeKnots>,
    effort: Effort<'_>,
) -> Result<ChainSolution> {
    let Some(start) = unless_interrupted(start)? else {
        return Ok(ChainSolution::unsolved(effort));
    };
    let legs = start.layout.lengths.len();
    let step = in_space!(chain.shape(), |space| products_of_step(space, legs));
    if FEWEST_STEPS * of_products(step) > effort.work.left() {
        effort.work.refuse();
        return Ok(ChainSolution::unsolved(effort));
    }
    let FreeKnots { knots, layout, at } = start;
    let problem = DescentProblem {
        layout,
        tension: chain.tension(),
        below: f64::INFINITY,
        known: &[],
    };
    let may_go_on = |products| effort.work.may_go_on(products);
    let options = effort.options(&may_go_on);
    let descending = Options {
        tolerance: TOLERANCE,
        max_iterations: MAX_STEPS,
        ..effort.options(&may_go_on)
    };
    let found = in_space!(chain.shape(), |space| stationary_end::<Lanes, _>(
        space,
        knots,
        problem,
        (&descending, NEAR),
        &options
    ))?;
    match found.report.converged {
        true => descent_end::solution(chain, &at, &found, effort),
        false => Ok(ChainSolution::none(found.report)),
    }
}

/// A chain whose legs subdivide those of another one.
struct FreeKnots {
    knots: ChainKnots,
    layout: ChainLayout,
    /// Indices of those knots that belong to the other chain.
    at: Vec<usize>,
}

impl FreeKnots {
    /// Built from one curve per leg of a chain, with the velocities of a motion at its knots.
    ///
    /// # Errors
    /// An error if a curve does not exist.
    fn new(
        chain: &Framed<'_>,
        ends: &Ends,
        motion: &Motion,
        curve: impl Fn(usize, RelativeEnds<'_>) -> Result<DescentStart>,
    ) -> Result<Self> {
        let (all, lengths) = (chain.frames(), chain.lengths());
        let last = lengths.len();
        let mut knots = FreeKnots {
            knots: ChainKnots::default(),
            layout: layout(ends),
            at: Vec::new(),
        };
        for (leg, h) in lengths.iter().enumerate() {
            let (velocity, end) = relative_ends(chain, leg, motion)?;
            let relative = RelativeEnds {
                velocity: &velocity,
                end: &end,
            };
            let curve = curve(leg, relative)?;
            let rate = curve.legs() as f64 / h;
            knots.push(
                row_by_row(all[leg].as_ref()),
                motion.velocity(leg),
                Held::Point,
            );
            for i in 1..curve.legs() {
                let (frame, velocity) = curve.at(i);
                let velocity: Vec<f64> = velocity.iter().map(|v| rate * v).collect();
                knots.push(
                    row_by_row((&all[leg] * frame).as_ref()),
                    &velocity,
                    Held::Nothing,
                );
            }
            let parts = std::iter::repeat_n(rate.recip(), curve.legs());
            knots.layout.lengths.extend(parts);
        }
        knots.push(
            row_by_row(all[last].as_ref()),
            motion.velocity(last),
            Held::Point,
        );
        if let Ends::Open(ends) = ends {
            for (knot, end) in [0, knots.at[last]].into_iter().zip(ends) {
                if end.velocity().is_some() {
                    knots.layout.held[knot] = Held::All;
                }
            }
        }
        Ok(knots)
    }

    fn push(&mut self, frame: impl Iterator<Item = f64>, velocity: &[f64], held: Held) {
        if held == Held::Point {
            self.at.push(self.layout.held.len());
        }
        self.knots.frames.extend(frame);
        self.knots.velocities.extend(velocity);
        self.layout.held.push(held);
    }
}

/// A layout without legs.
fn layout(ends: &Ends) -> ChainLayout {
    let acceleration = |end: &End| end.acceleration().map_or(Vec::new(), <[f64]>::to_vec);
    ChainLayout {
        lengths: Vec::new(),
        held: Vec::new(),
        is_closed: matches!(ends, Ends::Periodic),
        accelerations: match ends {
            Ends::Open(ends) => ends.each_ref().map(acceleration),
            Ends::Periodic => [Vec::new(), Vec::new()],
        },
    }
}

/// The velocity at the start of a leg, and point and velocity at its end, in the time of the leg and the frame at its
/// start.
fn relative_ends(
    chain: &Framed<'_>,
    leg: usize,
    motion: &Motion,
) -> Result<(Horizontal, [Mat<f64>; 2])> {
    let (frames, blocks, h) = (chain.frames(), chain.blocks(), chain.lengths()[leg]);
    let velocity = |knot: usize| {
        let v: Vec<f64> = motion.velocity(knot).iter().map(|v| h * v).collect();
        let [velocity] = unpack(&v, blocks);
        velocity
    };
    let target = frames[leg].transpose() * &frames[leg + 1];
    let mut end = [
        target.as_ref().subcols(0, blocks.k).to_owned(),
        &target * velocity(leg + 1).tangent(),
    ];
    if blocks.quotient == Quotient::Subspaces {
        // Expressed in the basis nearest to the one at the start.
        let first = identity_columns(target.nrows(), blocks.k);
        let turn = alignment(first.as_ref(), end[0].as_ref())?;
        end = end.map(|a| a * &turn);
    }
    Ok((velocity(leg), end))
}
