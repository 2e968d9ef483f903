//! The second derivative of the cost of a cubic by points and velocities at its ends.
//!
//! With displacements `u` of the ends in their frames and `w` the variations of the velocities beside them,
//!
//! ```math
//! \tfrac12 J:\qquad \text{gradient}\ (x''_0,\,-x'_0,\,-x''_1,\,x'_1)\ \text{by}\ (u_0, w_0, u_1, w_1)
//! ```
//!
//! and its derivative is a matrix of four times four blocks. It is symmetric but for the blocks of two displacements of one end,
//! which do not commute, and in tension for those of `x''` by `w` at the same end: the gradient has `x'' - tau x` there.

use faer::{Mat, MatRef};

use super::end_response::{Response, blocks_of, row_variations, unit_variations};
use super::initial::{Horizontal, InitialData};
use super::loads::canonical;
use super::problem::pack;
use super::reduced::Sized;
use super::variation::{Slopes, vary};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;

/// Sign of the gradient, and which of `(x', x'')` it is, for each of its four parts.
const PARTS: [(f64, usize); 4] = [(1.0, 1), (-1.0, 0), (-1.0, 1), (1.0, 0)];

/// The matrix in the coordinates of [`pack`] in the frames at both ends.
#[derive(Debug, Clone)]
pub(super) struct EndStiffness {
    /// Shape `(4 d, 4 d)`.
    pub(super) matrix: Mat<f64>,
}

/// Which coordinates: those of the span, or of one row beside it.
enum Coordinates {
    Span,
    Row,
}

impl Coordinates {
    fn of(&self, vector: &Horizontal) -> Vec<f64> {
        match self {
            Coordinates::Span => pack(std::slice::from_ref(vector)),
            Coordinates::Row => {
                let (last, k) = (vector.normal.nrows() - 1, vector.normal.ncols());
                (0..k).map(|j| vector.normal[(last, j)]).collect()
            }
        }
    }
}

impl EndStiffness {
    /// In the span of the data; with the frame at the end, in the coordinates of the one at the start.
    ///
    /// # Errors
    /// `ConjugateEnds`, `Overflow`, `TooManySteps`, `Decomposition`, `Interrupted`.
    pub(super) fn in_span(
        data: &InitialData,
        duration: f64,
        interrupt: Interrupt<'_>,
    ) -> Result<(Self, Mat<f64>)> {
        let directions = unit_variations(blocks_of(data));
        let slopes = one(vary::<8>(data, 0, &directions, &[duration], interrupt)?);
        let units: Vec<&Horizontal> = directions[..directions.len() / 3]
            .iter()
            .map(|direction| &direction[0])
            .collect();
        let stiffness = Self::of(&slopes, &units, &Coordinates::Span, duration)?;
        Ok((stiffness, slopes.frame))
    }

    /// For one row outside of the span.
    ///
    /// # Errors
    /// As [`EndStiffness::in_span`].
    pub(super) fn of_row(
        data: &InitialData,
        duration: f64,
        interrupt: Interrupt<'_>,
    ) -> Result<Self> {
        let directions = row_variations(blocks_of(data));
        let slopes = one(vary::<8>(data, 1, &directions, &[duration], interrupt)?);
        let units: Vec<&Horizontal> = directions[..directions.len() / 3]
            .iter()
            .map(|direction| &direction[0])
            .collect();
        Self::of(&slopes, &units, &Coordinates::Row, duration)
    }

    fn of(
        slopes: &Slopes,
        units: &[&Horizontal],
        coordinates: &Coordinates,
        duration: f64,
    ) -> Result<Self> {
        let d = units.len();
        let flow = flow_matrix(slopes, units, coordinates);
        if d == 0 {
            return Ok(EndStiffness { matrix: flow });
        }
        let by_start = Mat::from_fn(2 * d, 3 * d, |i, j| flow[(i, d + j)]);
        let response = Response::new(&by_start, duration)?;
        // What of the end is to be made up for by `(x', x'')` at the start.
        let right = Mat::from_fn(2 * d, 4 * d, |i, j| match j.checked_sub(2 * d) {
            None => -flow[(i, j)],
            Some(j) => f64::from(u8::from(i == j)),
        });
        let solution = response.solve_all(&right)?;
        let ends = flow.submatrix(2 * d, 2 * d, 2 * d, 2 * d) * &solution;
        let matrix = Mat::from_fn(4 * d, 4 * d, |i, j| {
            let (sign, level) = PARTS[i / d];
            let row = level * d + i % d;
            let known = match j < 2 * d {
                true => flow[(2 * d + row, j)],
                false => 0.0,
            };
            match i < 2 * d {
                true => sign * solution[(row, j)],
                false => sign * (known + ends[(row, j)]),
            }
        });
        if matrix.norm_max().is_finite() {
            return Ok(EndStiffness { matrix });
        }
        Err(Error::Overflow {
            quantity: super::end_response::VARIATION,
        })
    }
}

/// Variations `(p, w, a, b)` at the end by those at the start, shape `(4 d, 4 d)`.
fn flow_matrix(slopes: &Slopes, units: &[&Horizontal], coordinates: &Coordinates) -> Mat<f64> {
    let turned: Vec<[Horizontal; 4]> = {
        // A displacement of the start is a rotation of everything.
        let (frame, k) = (&slopes.frame, slopes.points.first().map_or(0, Mat::ncols));
        let vectors = slopes.state.each_ref().map(|x| frame * x.tangent());
        let mut all = Slopes::none(blocks_of_slopes(slopes, k));
        for unit in units {
            let turn = unit.matrix();
            all.points.push(&turn * frame.subcols(0, k));
            all.velocities.push(&turn * &vectors[0]);
            all.accelerations.push(&turn * &vectors[1]);
            all.seconds.push(&turn * &vectors[2]);
        }
        all.frame = frame.clone();
        all.state = slopes.state.clone();
        canonical(&all, &(0..units.len()).collect::<Vec<_>>())
    };
    let moved = canonical(slopes, &(0..slopes.points.len()).collect::<Vec<_>>());
    let columns: Vec<Vec<f64>> = turned
        .iter()
        .chain(&moved)
        .map(|parts| parts.iter().flat_map(|part| coordinates.of(part)).collect())
        .collect();
    Mat::from_fn(4 * units.len(), columns.len(), |i, j| columns[j][i])
}

fn blocks_of_slopes(slopes: &Slopes, k: usize) -> Sized {
    Sized {
        m: slopes.frame.nrows() - k,
        k,
    }
}

fn one(slopes: Vec<Slopes>) -> Slopes {
    slopes.into_iter().next().expect("one time")
}

/// The product of a matrix with four vectors of the same coordinates.
pub(super) fn product(matrix: MatRef<'_, f64>, z: &[f64]) -> Vec<f64> {
    let column = MatRef::from_column_major_slice(z, z.len(), 1);
    let out = matrix * column;
    (0..z.len()).map(|i| out[(i, 0)]).collect()
}
