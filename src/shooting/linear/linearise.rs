//! Linearises cubics on `[0, 1]`.
//!
//! A curve that is one leg is solved [for the changes at its middle](super::linear_middle), eight curves at once; longer ones,
//! and those whose ends may be conjugate, [for the changes at the start](super::linear_legs).

use super::linear_curve::{LinearCurve, SOLVER};
use super::linear_leg::{LinearLeg, VectorsAt};
use super::linear_legs::of_legs;
use super::linear_middle::at_middle;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::lanes::{LANES, Lanes};
use crate::space::{Homogeneous, Shape, in_space};

/// Fewer curves than this, and curves in larger dimensions, are linearised one by one, since their buffers would be eight
/// times as large.
const FEW: usize = 3;

/// Dimension up to which many curves keep the displacements of their points: above it they would take more memory and time than
/// everything else.
pub(crate) const DENSE: usize = 64;

/// Largest number of dimensions in which a single leg is solved at its middle. The derivative of a spline through 25 points, by
/// the changes at the start instead, takes 1.33 times as long on St(4,3) (6 dimensions), 1.27 on St(5,3) (9), 1.16 on St(6,3)
/// (12), but 0.87 times on St(7,4) (18) and 0.88 on St(9,4) (26).
const LARGE: usize = 15;

/// Linearises the curve with the given coordinates of `x, x', x''` at its start.
///
/// # Errors
/// `ConjugateEnds`, `Overflow`, `Decomposition`; `InvalidArgument` if a leg would take too much memory, `TooManySteps` if all of
/// them would; `Interrupted`.
pub(crate) fn linearise(
    shape: Shape,
    start: VectorsAt<f64>,
    tension: f64,
    interrupt: Interrupt<'_>,
) -> Result<LinearCurve> {
    in_space!(shape, |space| alone(space, start, tension, true, interrupt))
}

/// Linearises several curves; without points in more than [`DENSE`] dimensions.
///
/// # Errors
/// As [`linearise`].
pub(crate) fn linearise_all(
    shape: Shape,
    starts: Vec<VectorsAt<f64>>,
    tensions: &[f64],
    interrupt: Interrupt<'_>,
) -> Result<Vec<LinearCurve>> {
    in_space!(shape, |space| {
        let has_points = space.dim() <= DENSE;
        let mut curves = Vec::new();
        let groups = starts.chunks(LANES).zip(tensions.chunks(LANES));
        for (starts, tensions) in groups {
            interrupt.check(SOLVER)?;
            let found = abreast(space, starts, tensions);
            for ((found, start), tension) in found.into_iter().zip(starts).zip(tensions) {
                curves.push(match found {
                    Some(found) => found,
                    None => alone(space, start.clone(), *tension, has_points, interrupt)?,
                });
            }
        }
        Ok(curves)
    })
}

/// One curve, as a single leg if that is possible.
fn alone(
    space: impl Homogeneous,
    start: VectorsAt<f64>,
    tension: f64,
    has_points: bool,
    interrupt: Interrupt<'_>,
) -> Result<LinearCurve> {
    if (1..=LARGE).contains(&space.dim()) {
        let tau = (tension != 0.0).then_some(tension);
        let leg = LinearLeg::from_start(space, &start, tau, true);
        let curves = leg.map(|leg| at_middle(space, &leg, 1));
        if let Some(curve) = curves.into_iter().flatten().flatten().next() {
            return Ok(curve);
        }
    }
    of_legs(space, start, tension, has_points, interrupt)
}

/// Curves of one leg each; `None` for those that are not, or whose ends may be conjugate.
fn abreast(
    space: impl Homogeneous,
    starts: &[VectorsAt<f64>],
    tensions: &[f64],
) -> Vec<Option<LinearCurve>> {
    let count = starts.len();
    let none = || (0..count).map(|_| None).collect();
    if count < FEW || space.dim() == 0 || space.dim() > LARGE {
        return none();
    }
    // The last one fills unused lanes.
    let lanes =
        |of: &dyn Fn(usize) -> f64| Lanes(std::array::from_fn(|lane| of(lane.min(count - 1))));
    let state: VectorsAt<Lanes> = std::array::from_fn(|level| {
        let entry = |p: usize| lanes(&|lane| starts[lane][level][p]);
        (0..space.dim()).map(entry).collect()
    });
    let tension = lanes(&|lane| tensions[lane]);
    let has_tension = tensions.iter().any(|tension| *tension != 0.0);
    match LinearLeg::from_start(space, &state, has_tension.then_some(tension), true) {
        Some(leg) => at_middle(space, &leg, count),
        None => none(),
    }
}
