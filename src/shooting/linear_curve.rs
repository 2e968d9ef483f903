//! A cubic on `[0, 1]`, linearised leg by leg from its start, with the composed maps of the legs.

use faer::{Mat, MatRef};

use super::linear_leg::{LinearLeg, State};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::field::multiply;
use crate::linalg::lanes::{LANES, Lanes};
use crate::report::{SolverReport, StopReason};
use crate::space::{Homogeneous, Shape, in_space};

/// Maximal number of floating-point numbers of one leg, checked before it: four gigabytes.
const LARGEST_LEG: usize = 500_000_000;

/// Maximal number of floating-point numbers of all legs, checked after each leg: 0.4 gigabytes.
const LARGEST: usize = 50_000_000;

/// Variations `(p, w, a, b)` of a cubic, as linear functions of those at its start.
///
/// Frames are relative to the one at the start, in row-major order.
#[derive(Debug)]
pub(crate) struct LinearCurve {
    shape: Shape,
    /// Empty if points cannot move.
    legs: Vec<Placed>,
    /// The map from the start to the end.
    pub(crate) flow: Mat<f64>,
    /// The frame at the end.
    pub(crate) frame: Vec<f64>,
}

/// Fewer legs than this, and legs in larger dimensions, are linearised one by one, since their buffers would be eight
/// times as large. Eight at once, with frames as quaternions, reduced the derivative of a spline of 200 rotations from
/// 61 ms to 38 ms in the test profile; the limits themselves are not measured.
const FEW: usize = 3;
const LARGE: usize = 30;

/// Solver named in errors.
const SOLVER: &str = "linearised cubic";

/// A leg and its position on the curve.
#[derive(Debug)]
struct Placed {
    leg: LinearLeg<f64>,
    start: f64,
    length: f64,
    /// The frame at the middle.
    frame: Vec<f64>,
    /// The map from `(p, w, a, b)` at the start of the curve to those at the middle, in the time of the leg.
    middle: Mat<f64>,
}

impl LinearCurve {
    /// Built from coordinates of `x, x', x''` at the start.
    ///
    /// # Errors
    /// `InvalidArgument` if a leg would take too much memory, `TooManySteps` if all of them would; `Interrupted`.
    pub(crate) fn new(
        shape: Shape,
        start: [Vec<f64>; 3],
        tension: f64,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        in_space!(shape, |space| walk(space, shape, start, tension, interrupt))
    }

    /// Several curves, eight at once if a single leg is enough for each.
    ///
    /// # Errors
    /// As [`LinearCurve::new`].
    pub(crate) fn abreast(
        shape: Shape,
        starts: Vec<[Vec<f64>; 3]>,
        tensions: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Self>> {
        in_space!(shape, |space| {
            let mut curves = Vec::new();
            let groups = starts.chunks(LANES).zip(tensions.chunks(LANES));
            for (starts, tensions) in groups {
                interrupt.check(SOLVER)?;
                match legs_abreast(space, starts, tensions) {
                    Some(legs) => curves.extend((0..starts.len()).map(|lane| {
                        let mut curve = LinearCurve::at_start(space, shape);
                        curve.push(space, legs.lane(lane), 0.0, 1.0);
                        curve
                    })),
                    None => {
                        for (start, tension) in starts.iter().zip(tensions) {
                            curves.push(walk(space, shape, start.clone(), *tension, interrupt)?);
                        }
                    }
                }
            }
            Ok(curves)
        })
    }

    /// A curve without legs.
    fn at_start(space: impl Homogeneous, shape: Shape) -> Self {
        let (wide, r) = (4 * space.dim(), space.size());
        LinearCurve {
            shape,
            legs: Vec::new(),
            flow: Mat::identity(wide, wide),
            frame: (0..r * r)
                .map(|i| f64::from(u8::from(i % (r + 1) == 0)))
                .collect(),
        }
    }

    /// The displacement and the frame at a time, for `(p, w, a, b)` at the start.
    pub(crate) fn displacement(&self, t: f64, start: &[f64]) -> (Vec<f64>, Vec<f64>) {
        if self.legs.is_empty() {
            return (Vec::new(), self.frame.clone());
        }
        let (placed, s) = self.at(t);
        let start = MatRef::from_column_major_slice(start, start.len(), 1);
        let middle = &placed.middle * start;
        in_space!(self.shape, |space| {
            let displaced = placed.leg.displacement(space, s, middle.col_as_slice(0));
            (displaced, placed.frame_at(space, s))
        })
    }

    /// The frame at a time.
    pub(crate) fn frame_at(&self, t: f64) -> Vec<f64> {
        if self.legs.is_empty() {
            return self.frame.clone();
        }
        let (placed, s) = self.at(t);
        in_space!(self.shape, |space| placed.frame_at(space, s))
    }

    /// The gradient with respect to `(p, w, a, b)` at the start of the sum of products of cotangents, sorted by time
    /// after the start, with displacements; in coordinates of the frames at those times.
    pub(crate) fn pull_back(&self, loads: &[(f64, Vec<f64>)]) -> Vec<f64> {
        let mut gradient = vec![0.0; self.flow.nrows()];
        if self.legs.is_empty() {
            return gradient;
        }
        for loads in loads.chunk_by(|one, other| self.leg_at(one.0) == self.leg_at(other.0)) {
            let (placed, _) = self.at(loads[0].0);
            let local = loads.iter().map(|(t, load)| (self.at(*t).1, load.clone()));
            let by_middle = in_space!(self.shape, |space| placed.leg.pull_back(space, local));
            let by_middle = MatRef::from_column_major_slice(&by_middle, by_middle.len(), 1);
            let by_start = placed.middle.transpose() * by_middle;
            for (sum, x) in gradient.iter_mut().zip(by_start.col_as_slice(0)) {
                *sum += x;
            }
        }
        gradient
    }

    fn leg_at(&self, t: f64) -> usize {
        let after = |placed: &Placed| placed.start <= t;
        self.legs.partition_point(after).saturating_sub(1)
    }

    /// The leg at a time, and the time within it.
    fn at(&self, t: f64) -> (&Placed, f64) {
        let placed = &self.legs[self.leg_at(t)];
        (placed, (t - placed.start) / placed.length - 0.5)
    }
}

impl Placed {
    fn frame_at(&self, space: impl Homogeneous, s: f64) -> Vec<f64> {
        product(space.size(), &self.frame, &self.leg.frame_at(space, s))
    }
}

fn walk(
    space: impl Homogeneous,
    shape: Shape,
    mut state: State<f64>,
    tension: f64,
    interrupt: Interrupt<'_>,
) -> Result<LinearCurve> {
    let d = space.dim();
    let mut curve = LinearCurve::at_start(space, shape);
    if d == 0 {
        // Points cannot move: no legs.
        return Ok(curve);
    }
    // At least 16 nodes, with a matrix of shape `(d + h, 3 d)` at each.
    let of_leg = 48 * (d + space.isotropy_dim()) * d;
    if of_leg > LARGEST_LEG {
        return Err(Error::InvalidArgument {
            name: "curve",
            requirement: "a span small enough for its derivative by series to have at most 5e8 numbers",
            found: of_leg as f64,
        });
    }
    let (mut start, mut length, mut numbers) = (0.0, 1.0, 0);
    while start != 1.0 {
        interrupt.check(SOLVER)?;
        let own = scaled(&state, length);
        let tau = (tension != 0.0).then_some(tension * length * length);
        let Some(leg) = LinearLeg::from_start(space, &own, tau) else {
            length *= 0.5;
            if start + length == start {
                return Err(too_many(curve.legs.len(), 1.0 - start, length));
            }
            continue;
        };
        numbers += leg.len() + 16 * d * d;
        state = scaled(&leg.last, 1.0 / length);
        curve.push(space, leg, start, length);
        start = if length == 1.0 - start {
            1.0
        } else {
            start + length
        };
        let left = 1.0 - start;
        if numbers > LARGEST && left != 0.0 {
            return Err(too_many(curve.legs.len(), left, length));
        }
        // The same number of legs, but of equal length.
        length = left / (left / length).ceil().max(1.0);
    }
    Ok(curve)
}

impl LinearCurve {
    fn push(&mut self, space: impl Homogeneous, mut leg: LinearLeg<f64>, start: f64, length: f64) {
        let (d, r) = (space.dim(), space.size());
        let units = |power: i32| (0..4 * d).map(move |i| length.powi(power * (i / d) as i32));
        let [mut middle, to_last] = [&leg.from_first, &leg.to_last]
            .map(|map| Mat::from_fn(4 * d, 4 * d, |i, j| map[i * 4 * d + j]));
        for (column, unit) in middle.col_iter_mut().zip(units(1)) {
            column.iter_mut().for_each(|x| *x *= unit);
        }
        // Only their products are needed.
        (leg.from_first, leg.to_last) = (Vec::new(), Vec::new());
        if !self.legs.is_empty() {
            middle = middle * &self.flow;
        }
        self.flow = to_last * &middle;
        for column in self.flow.col_iter_mut() {
            for (x, unit) in column.iter_mut().zip(units(-1)) {
                *x *= unit;
            }
        }
        let first = transposed(r, &leg.frame_at(space, -0.5));
        let frame = product(r, &self.frame, &first);
        self.frame = product(r, &frame, &leg.frame_at(space, 0.5));
        self.legs.push(Placed {
            leg,
            start,
            length,
            frame,
            middle,
        });
    }
}

/// Legs of unit duration, where the last start fills unused lanes; `None` if some legs are too long for one series, or
/// if there are few of them or they are large.
fn legs_abreast(
    space: impl Homogeneous,
    starts: &[State<f64>],
    tensions: &[f64],
) -> Option<LinearLeg<Lanes>> {
    if starts.len() < FEW || space.dim() == 0 || space.dim() > LARGE {
        return None;
    }
    let last = starts.len() - 1;
    let lanes = |of: &dyn Fn(usize) -> f64| Lanes(std::array::from_fn(|lane| of(lane.min(last))));
    let state: State<Lanes> = std::array::from_fn(|level| {
        let entry = |p: usize| lanes(&|lane| starts[lane][level][p]);
        (0..space.dim()).map(entry).collect()
    });
    let tension = lanes(&|lane| tensions[lane]);
    let has_tension = tensions.iter().any(|tension| *tension != 0.0);
    LinearLeg::from_start(space, &state, has_tension.then_some(tension))
}

/// The error after `legs` legs with `left` time remaining, if the next leg has the given length.
fn too_many(legs: usize, left: f64, length: f64) -> Error {
    let report = SolverReport {
        converged: false,
        iterations: legs,
        residual: left,
        tolerance: 0.0,
        reason: StopReason::MaxIterations,
    };
    Error::TooManySteps {
        solver: SOLVER,
        limit: legs,
        forecast: (left / length).min(f64::MAX).ceil(),
        report,
    }
}

/// `x, x', x''` in another unit of time.
fn scaled(state: &State<f64>, unit: f64) -> State<f64> {
    std::array::from_fn(|i| {
        let factor = unit.powi(i as i32 + 1);
        state[i].iter().map(|x| x * factor).collect()
    })
}

fn product(r: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; r * r];
    multiply(r, a, b, &mut out);
    out
}

fn transposed(r: usize, a: &[f64]) -> Vec<f64> {
    (0..r * r).map(|i| a[i % r * r + i / r]).collect()
}
