//! Consistent bases along consecutive curves of subspaces.

use faer::{Mat, MatRef};

use crate::cubic::RiemannianCubic;
use crate::curve::Curve;
use crate::error::Result;
use crate::linalg::decomp::polar_factor;
use crate::manifold::grassmann::alignment::alignment;
use crate::space::Quotient;

/// Expresses each of several consecutive curves of subspaces in the basis that the previous one reaches; the first one
/// is multiplied by an orthogonal matrix. With known matrices that turn the first basis of the next curve to the reached one,
/// no curve is evaluated: evaluated, a spline through 12 subspaces of dimension 6 in `R^2000` takes 1.5 times as long.
///
/// # Errors
/// An error if a curve cannot be evaluated; `Decomposition`.
pub(super) fn joined(
    quotient: Quotient,
    first: Option<MatRef<'_, f64>>,
    mut pieces: Vec<RiemannianCubic>,
    known: Option<&[Mat<f64>]>,
) -> Result<Vec<RiemannianCubic>> {
    if quotient == Quotient::Frames {
        return Ok(pieces);
    }
    let k = pieces[0].k();
    let mut turn = first.map_or_else(|| Mat::identity(k, k), |first| first.to_owned());
    if first.is_some() {
        pieces[0] = pieces[0].in_terms_of(turn.as_ref());
    }
    for piece in 1..pieces.len() {
        turn = match known {
            Some(known) => {
                polar_factor("the basis of a piece", (&known[piece - 1] * turn).as_ref())?
            }
            None => {
                let reached = pieces[piece - 1].point(1.0)?;
                alignment(reached.as_ref(), pieces[piece].point(0.0)?.as_ref())?
            }
        };
        pieces[piece] = pieces[piece].in_terms_of(turn.as_ref());
    }
    Ok(pieces)
}
