//! A cubic on `[0, 1]`, linearised: the response to displacements `u` and changes `w` of the velocities at its ends.
//!
//! The second derivative of half the cost is the matrix of four by four blocks
//!
//! ```math
//! \tfrac12 J:\qquad \text{gradient}\ (x''_0,\,-x'_0,\,-x''_1,\,x'_1)\ \text{by}\ (u_0, w_0, u_1, w_1)
//! ```
//!
//! It is symmetric except for the blocks of two displacements of the same end, which do not commute, and, in tension, for
//! the blocks of `x''` by `w` at the same end: the gradient contains `x'' - tau x` there.
//!
//! A curve that is one leg is solved [for the changes at its middle](super::linear_middle); longer ones, and those whose ends
//! may be conjugate, [for the changes at the start](super::linear_legs).

use std::sync::Arc;

use super::linear_leg::{LinearLeg, State};
use super::linear_legs::of_legs;
use super::linear_middle::{LARGE, at_middle};
use crate::curve::barycentric::Barycentric;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::lanes::{LANES, Lanes};
use crate::space::{Homogeneous, Shape, in_space};

/// The response of a cubic. Frames are relative to the one at the start; matrices in row-major order.
#[derive(Debug, Default)]
pub(crate) struct LinearCurve {
    /// The frame at the end.
    pub(crate) frame: Vec<f64>,
    /// The second derivative of half the cost, shape `(4 d, 4 d)`.
    pub(crate) stiffness: Vec<f64>,
    /// Empty if points cannot move, or if their displacements are not wanted.
    pub(crate) parts: Vec<Part>,
}

/// The points of a part of the curve, through which frames and displacements are interpolated.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) start: f64,
    pub(crate) length: f64,
    pub(crate) through: Arc<Barycentric>,
    /// Frames at the points, shape `(r, r)` each.
    pub(crate) frames: Vec<f64>,
    /// Displacements of the points, shape `(d, 4 d)` each.
    pub(crate) displacements: Vec<f64>,
}

/// Fewer curves than this, and curves in larger dimensions, are linearised one by one, since their buffers would be eight
/// times as large.
const FEW: usize = 3;

/// Dimension up to which many curves keep the displacements of their points: above it they would take more memory and time than
/// everything else.
pub(crate) const DENSE: usize = 64;

/// Solver named in errors.
pub(super) const SOLVER: &str = "linearised cubic";

impl LinearCurve {
    /// Built from coordinates of `x, x', x''` at the start.
    ///
    /// # Errors
    /// `ConjugateEnds`, `Overflow`, `Decomposition`; `InvalidArgument` if a leg would take too much memory, `TooManySteps` if
    /// all of them would; `Interrupted`.
    pub(crate) fn new(
        shape: Shape,
        start: State<f64>,
        tension: f64,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        in_space!(shape, |space| of_legs(
            space, start, tension, true, interrupt
        ))
    }

    /// Several curves, eight at once if a single leg is enough for each; without points in more than [`DENSE`] dimensions.
    ///
    /// # Errors
    /// As [`LinearCurve::new`].
    pub(crate) fn abreast(
        shape: Shape,
        starts: Vec<State<f64>>,
        tensions: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Self>> {
        in_space!(shape, |space| {
            let mut curves = Vec::new();
            let groups = starts.chunks(LANES).zip(tensions.chunks(LANES));
            for (starts, tensions) in groups {
                interrupt.check(SOLVER)?;
                let found = abreast(space, starts, tensions);
                for ((found, start), tension) in found.into_iter().zip(starts).zip(tensions) {
                    curves.push(match found {
                        Some(found) => found,
                        None => {
                            let has_points = space.dim() <= DENSE;
                            of_legs(space, start.clone(), *tension, has_points, interrupt)?
                        }
                    });
                }
            }
            Ok(curves)
        })
    }
}

/// Curves of one leg each; `None` for those that are not, or whose ends may be conjugate.
fn abreast(
    space: impl Homogeneous,
    starts: &[State<f64>],
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
    let state: State<Lanes> = std::array::from_fn(|level| {
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
