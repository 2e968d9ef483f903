//! The response of a curve of one or several legs to the data at its ends, by the changes of `x'` and `x''` at its start.
//!
//! These are scaled by the change of point and velocity that they cause in flat space, `s = a / 2 + x'' / 6` and `v = a + x''
//! / 2`. The matrix of the equations is then near the identity for slow curves, and its singular values measure the distance
//! of the ends from conjugate ones.

use faer::Mat;

use super::linear_curve::{CurvePart, LinearCurve, SOLVER};
use super::linear_leg::{LegResponse, LinearLeg, VectorsAt};
use crate::curve::barycentric::Barycentric;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::decomp::{singular_range, solve_matrix};
use crate::linalg::field::{multiply, set_identity};
use crate::linalg::structure::{check_range, row_by_row};
use crate::space::Homogeneous;

/// Maximal number of floating-point numbers of one leg, checked before it: four gigabytes.
const LARGEST_LEG: usize = 500_000_000;

/// Maximal number of floating-point numbers of all legs, checked after each leg: 0.4 gigabytes.
const LARGEST: usize = 50_000_000;

/// Ends count as conjugate if the smallest singular value is below this fraction of the largest.
///
/// Ten times the default tolerance of boundary problems: closer ends cannot be told from conjugate ones.
const CONJUGATE: f64 = 1e-11;

/// Changes of `x'` (first row) and `x''` (second row) that move the end of a curve of flat space by one unit in the
/// point and in the velocity.
const FLAT: [[f64; 2]; 2] = [[6.0, -2.0], [-12.0, 6.0]];

/// Quantity named in errors.
const VARIATION: &str = "variation of a Riemannian cubic";

/// A leg and its position on the curve.
struct Placed {
    leg: LinearLeg<f64>,
    start: f64,
    length: f64,
    /// The frame at its first end.
    frame: Vec<f64>,
    /// The displacement of its first point and the changes at its middle, by `(p, w, a, b)` at the start of the curve.
    by_start: Mat<f64>,
}

/// The curve with `x, x', x''` at its start, leg by leg.
///
/// # Errors
/// As [`linearise`](super::linearise::linearise).
pub(crate) fn of_legs(
    space: impl Homogeneous,
    mut state: VectorsAt<f64>,
    tension: f64,
    has_points: bool,
    interrupt: Interrupt<'_>,
) -> Result<LinearCurve> {
    let (d, r) = (space.dim(), space.size());
    let mut frame = vec![0.0; r * r];
    set_identity(r, &mut frame);
    if d == 0 {
        // Points cannot move: no legs.
        return Ok(LinearCurve {
            frame,
            ..LinearCurve::default()
        });
    }
    // Some 16 points, with a matrix of shape `(d + h, 3 d)` at each, and another one for displacements.
    let of_leg = 48 * (1 + usize::from(has_points)) * (d + space.isotropy_dim()) * d;
    if of_leg > LARGEST_LEG {
        return Err(Error::InvalidArgument {
            name: "curve",
            requirement: "a span small enough for its derivative by series to have at most 5e8 numbers",
            found: of_leg as f64,
        });
    }
    // The legs with points.
    let (mut legs, mut count): (Vec<Placed>, usize) = (Vec::new(), 0);
    let mut flow = Mat::identity(4 * d, 4 * d);
    let (mut start, mut length, mut numbers) = (0.0, 1.0, 0);
    while start != 1.0 {
        interrupt.check(SOLVER)?;
        let own = scaled(&state, length);
        let tau = (tension != 0.0).then_some(tension * length * length);
        let Some(leg) = LinearLeg::from_start(space, &own, tau, has_points) else {
            length *= 0.5;
            if start + length == start {
                return Err(Error::too_many_steps(
                    SOLVER,
                    [count; 2],
                    1.0 - start,
                    length,
                ));
            }
            continue;
        };
        numbers += leg.frames.len() + 4 * leg.displacements.direct.len() + 41 * d * d;
        state = scaled(&leg.last_state, 1.0 / length);
        let by_start = by_start(&leg, &flow, length)?;
        flow = past(&leg, &by_start, length);
        let last = &leg.frames[leg.frames.len() - r * r..];
        let mut next = vec![0.0; r * r];
        multiply(r, &frame, last, &mut next);
        let first = std::mem::replace(&mut frame, next);
        if has_points {
            legs.push(Placed {
                start,
                length,
                frame: first,
                by_start,
                leg,
            });
        }
        count += 1;
        start = if length == 1.0 - start {
            1.0
        } else {
            start + length
        };
        let left = 1.0 - start;
        if numbers > LARGEST && left != 0.0 {
            return Err(Error::too_many_steps(SOLVER, [count; 2], left, length));
        }
        // The same number of legs, but of equal length.
        length = left / (left / length).ceil().max(1.0);
    }
    between_ends(r, &legs, &flow, frame)
}

/// The displacement of the first point of a leg and the changes at its middle, given `(p, w, a, b)` there.
fn by_start(leg: &LinearLeg<f64>, flow: &Mat<f64>, length: f64) -> Result<Mat<f64>> {
    let d = flow.nrows() / 4;
    let own = Mat::from_fn(3 * d, 4 * d, |i, j| {
        flow[(d + i, j)] * length.powi((i / d) as i32 + 1)
    });
    let first = Mat::from_fn(3 * d, 3 * d, |i, j| leg.first[i * 3 * d + j]);
    let middle = solve_matrix(first.as_ref(), own.as_ref()).ok_or(Error::Overflow {
        quantity: VARIATION,
    })?;
    Ok(Mat::from_fn(4 * d, 4 * d, |i, j| match i.checked_sub(d) {
        None => flow[(i, j)],
        Some(i) => middle[(i, j)],
    }))
}

/// `(p, w, a, b)` at the last end of a leg.
fn past(leg: &LinearLeg<f64>, by_start: &Mat<f64>, length: f64) -> Mat<f64> {
    let d = by_start.nrows() / 4;
    let mut flow = matrix(&leg.last, d) * by_start;
    for column in flow.col_iter_mut() {
        for (i, x) in column.iter_mut().enumerate() {
            *x *= length.powi(-((i / d) as i32));
        }
    }
    flow
}

/// A response as a matrix of `4 d` columns.
fn matrix(response: &LegResponse<f64>, d: usize) -> Mat<f64> {
    let rows = response.direct.len() / d;
    Mat::from_fn(rows, 4 * d, |i, j| match j.checked_sub(d) {
        None => response.direct[i * d + j],
        Some(j) => response.bent[i * 3 * d + j],
    })
}

/// The response to the data at the ends, from the flow that maps `(p, w, a, b)` at the start to those at the end.
fn between_ends(
    r: usize,
    legs: &[Placed],
    flow: &Mat<f64>,
    frame: Vec<f64>,
) -> Result<LinearCurve> {
    let d = flow.nrows() / 4;
    let derivatives = derivatives(flow)?;
    let all = Mat::from_fn(4 * d, 4 * d, |i, j| match i.checked_sub(2 * d) {
        None => f64::from(u8::from(i == j)),
        Some(i) => derivatives[(i, j)],
    });
    let end = flow.subrows(2 * d, 2 * d) * &all;
    let stiffness = Mat::from_fn(4 * d, 4 * d, |i, j| {
        let at = (i + d) % (2 * d);
        match i / d {
            0 => derivatives[(at, j)],
            1 => -derivatives[(at, j)],
            2 => -end[(at, j)],
            _ => end[(at, j)],
        }
    });
    check_range(VARIATION, stiffness.as_ref())?;
    let part = |placed: &Placed| {
        let leg = &placed.leg;
        let displacements = matrix(&leg.displacements, d) * (&placed.by_start * &all);
        let mut frames = vec![0.0; leg.frames.len()];
        let relative = leg.frames.chunks_exact(r * r);
        for (frame, out) in relative.zip(frames.chunks_exact_mut(r * r)) {
            multiply(r, &placed.frame, frame, out);
        }
        CurvePart {
            start: placed.start,
            length: placed.length,
            through: Barycentric::of(&leg.nodes),
            frames,
            displacements: row_by_row(displacements.as_ref()).collect(),
        }
    };
    Ok(LinearCurve {
        frame,
        stiffness: row_by_row(stiffness.as_ref()).collect(),
        parts: legs.iter().map(part).collect(),
    })
}

/// The changes of `(x', x'')` at the start, shape `(2 d, 4 d)`.
///
/// # Errors
/// `ConjugateEnds`, `Overflow`, `Decomposition`.
fn derivatives(flow: &Mat<f64>) -> Result<Mat<f64>> {
    let d = flow.nrows() / 4;
    check_range(VARIATION, flow.as_ref())?;
    let unknown = Mat::from_fn(2 * d, 2 * d, |i, j| {
        let [by_a, by_b] = [2, 3].map(|level| flow[(i, level * d + j % d)]);
        FLAT[0][j / d] * by_a + FLAT[1][j / d] * by_b
    });
    // The part of the end's change that `(x', x'')` at the start must compensate.
    let right = Mat::from_fn(2 * d, 4 * d, |i, j| match j.checked_sub(2 * d) {
        None => -flow[(i, j)],
        Some(j) => f64::from(u8::from(i == j)),
    });
    // The last columns are the inverse. They bound the condition number without singular values, which would take
    // longer than everything else here.
    let bound = |found: &Mat<f64>| {
        let inverse = found.subcols(2 * d, 2 * d);
        (unknown.norm_l2() * inverse.norm_l2()).recip()
    };
    let found = match solve_matrix(unknown.as_ref(), right.as_ref()) {
        Some(found) if bound(&found) > CONJUGATE => found,
        found => {
            let [smallest, largest] = singular_range(unknown.as_ref())?;
            match found {
                Some(found) if smallest > CONJUGATE * largest => found,
                _ => return Err(Error::ConjugateEnds { smallest, largest }),
            }
        }
    };
    Ok(Mat::from_fn(2 * d, 4 * d, |i, j| {
        let [point, velocity] = [0, d].map(|part| found[(part + i % d, j)]);
        FLAT[i / d][0] * point + FLAT[i / d][1] * velocity
    }))
}

/// `x, x', x''` in another unit of time.
fn scaled(state: &VectorsAt<f64>, unit: f64) -> VectorsAt<f64> {
    std::array::from_fn(|i| {
        let factor = unit.powi(i as i32 + 1);
        state[i].iter().map(|x| x * factor).collect()
    })
}
