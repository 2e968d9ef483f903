//! Consistent bases along consecutive curves of subspaces.

use faer::MatRef;

use crate::cubic::RiemannianCubic;
use crate::curve::Curve;
use crate::error::Result;
use crate::manifold::grassmann::alignment::alignment;
use crate::space::Quotient;

/// Expresses each of several consecutive curves of subspaces in the basis that the previous one reaches; the first one
/// is multiplied by an orthogonal matrix.
///
/// # Errors
/// An error if a curve cannot be evaluated.
pub(super) fn joined(
    quotient: Quotient,
    first: Option<MatRef<'_, f64>>,
    mut pieces: Vec<RiemannianCubic>,
) -> Result<Vec<RiemannianCubic>> {
    if quotient == Quotient::Frames {
        return Ok(pieces);
    }
    if let Some(turn) = first {
        pieces[0] = pieces[0].in_terms_of(turn);
    }
    for piece in 1..pieces.len() {
        let reached = pieces[piece - 1].point(1.0)?;
        let turn = alignment(reached.as_ref(), pieces[piece].point(0.0)?.as_ref())?;
        pieces[piece] = pieces[piece].in_terms_of(turn.as_ref());
    }
    Ok(pieces)
}
