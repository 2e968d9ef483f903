//! Stored form of splines.

use super::piecewise::{Outside, Piecewise};
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::stored::{Fields, Stored, StoredPiece, refusal};

/// Allowed deviation of the interval of a piece from `[0, 1]`.
const UNIT_TOLERANCE: f64 = 1e-12;

impl<C: Curve + StoredPiece> Stored for Piecewise<C> {
    const KIND: &'static str = C::SPLINE;

    fn store(&self, fields: &mut Fields) {
        C::store_all(self.pieces(), fields);
        fields.put_flat("t", self.knots().to_vec());
        let continued = usize::from(self.outside() == Outside::Continued);
        fields.put_whole("extrapolate", [continued]);
    }

    fn restore(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Self> {
        let knots = fields.take("t")?.entries;
        let outside = match fields.some_whole("extrapolate")? {
            [0] => Outside::Refused,
            [1] => Outside::Continued,
            [other] => return Err(refusal(format!("extrapolate: {other} is neither 0 nor 1"))),
        };
        let pieces = C::restore_all(fields, interrupt)?;
        check_knots(&knots, pieces.len())?;
        for (i, piece) in pieces.iter().enumerate() {
            let (start, end) = piece.t_span();
            if start.abs() > UNIT_TOLERANCE || (end - 1.0).abs() > UNIT_TOLERANCE {
                let problem = format!("piece {i} runs from {start} to {end}, not from 0 to 1");
                return Err(refusal(problem));
            }
        }
        Ok(Piecewise::new(knots, pieces).with_outside(outside))
    }
}

/// Return an error unless there is at least one piece, one more knot than pieces, and times increase.
fn check_knots(knots: &[f64], pieces: usize) -> Result<()> {
    if pieces == 0 || knots.len() != pieces + 1 {
        let found = knots.len();
        return Err(refusal(format!("{found} knots of {pieces} pieces")));
    }
    let increases = |pair: &[f64]| pair[0] < pair[1] && (pair[1] - pair[0]).is_finite();
    match knots.windows(2).position(|pair| !increases(pair)) {
        None => Ok(()),
        Some(knot) => Err(refusal(format!(
            "knot {} is not later than the one before it",
            knot + 1
        ))),
    }
}
