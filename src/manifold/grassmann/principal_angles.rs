//! Principal angles from sines and cosines.

use faer::MatRef;

use super::Grassmann;
use crate::error::Result;
use crate::linalg::graded_singular_values::graded_singular_values;

/// Largest cosine, `cos(pi/6)`, for which angles are computed from cosines, to twice the round-off.
const ALL_FAR: f64 = 0.866;

impl Grassmann {
    /// The `k` principal angles between two subspaces, in `[0, pi/2]`, in decreasing order.
    ///
    /// ```math
    /// \theta_i = \mathrm{atan2}(s_i, c_i),\qquad c = \sigma(Y_0^T Y_1),\qquad s = \sigma((I - Y_0 Y_0^T) Y_1)
    /// ```
    ///
    /// At least `2k - n` of them are zero, and are exactly zero here.
    ///
    /// # Arguments
    /// * `y0`, `y1` - points, shapes `(n, k)`
    /// # Accuracy
    /// A few units of round-off. The accuracy is relative to each angle if the entries of the bases determine it, as
    /// for coordinate directions, down to 1e-300 next to angles of any size.
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `Decomposition`.
    /// # Source
    /// Knyazev, Argentati (2002), "Principal angles between subspaces in an A-based scalar product: algorithms and
    /// perturbation estimates", SIAM J. Sci. Comput. 23, 2008-2040. Deviation: plane rotations compute all sines to
    /// high relative accuracy.
    pub fn principal_angles(&self, y0: MatRef<'_, f64>, y1: MatRef<'_, f64>) -> Result<Vec<f64>> {
        let (_, alignment) = self.alignment(y0, y1)?;
        if alignment
            .cosines
            .first()
            .is_some_and(|cosine| *cosine <= ALL_FAR)
        {
            let mut angles: Vec<f64> = alignment.angles().collect();
            angles.reverse();
            return Ok(angles);
        }
        let sines = graded_singular_values(alignment.normal(y0, y1).as_ref())?;
        let largest_cosine_last = alignment.cosines.iter().rev();
        let mut angles: Vec<f64> = sines
            .iter()
            .zip(largest_cosine_last)
            .map(|(sine, cosine)| sine.atan2(*cosine))
            .collect();
        let common = (2 * self.k()).saturating_sub(self.n());
        for angle in angles.iter_mut().rev().take(common) {
            *angle = 0.0;
        }
        Ok(angles)
    }
}
