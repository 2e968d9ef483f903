//! The principal vectors of eight pairs of frames at once.

use faer::Mat;

use super::lane_margin::{DETERMINED, LOWEST_COSINE, Margin, TINY};
use crate::linalg::lane_matrix::{LaneMatrix, determinant_signs, dot, orthogonalise_columns};
use crate::linalg::lanes::{LANES, Lanes, Mask};

/// Magnitude of a principal cosine below which its direction is too inaccurate in the Jacobi factorisation.
const SMALL_COSINE: f64 = 0.02;

/// `S0^T S1 = U diag(c) Z^T` with `det(U Z^T) = 1`; the smallest cosine is negative if the determinant is.
pub(crate) struct LanePrincipal {
    /// `S0^T S1`, to be set by the caller.
    pub(super) gram: LaneMatrix,
    pub(super) u: LaneMatrix,
    pub(super) z: LaneMatrix,
    /// `U Z^T`.
    pub(super) rotation: LaneMatrix,
    pub(super) cosines: Vec<Lanes>,
    single: Mat<f64>,
}

impl LanePrincipal {
    pub(super) fn new(k: usize) -> Self {
        let square = || LaneMatrix::zeros(k, k);
        LanePrincipal {
            gram: square(),
            u: square(),
            z: square(),
            rotation: square(),
            cosines: vec![Lanes::ZERO; k],
            single: Mat::zeros(k, k),
        }
    }

    /// As [`LanePrincipal::factor`] for any number of columns, also where a cosine of one or two columns vanishes.
    #[inline(always)]
    pub(super) fn factor_any(&mut self, rows: usize, margin: &mut Margin) {
        match self.cosines.len() {
            1 => self.factor_one(margin),
            2 => self.factor_two(rows, margin),
            _ => self.factor(rows, margin),
        }
    }

    #[inline(always)]
    fn factor_one(&mut self, margin: &mut Margin) {
        let cosine = self.gram.at(0, 0);
        self.cosines[0] = cosine;
        for one in [&mut self.u, &mut self.z, &mut self.rotation] {
            one.set(0, 0, Lanes::ONE);
        }
        let low = Lanes::splat(LOWEST_COSINE).greater(cosine);
        margin.see(Lanes::ONE + cosine, low);
    }

    /// In closed form: a matrix is `q` times the rotation by `alpha`, plus `r` times the reflection at half the angle `beta`;
    /// its cosines are `q + r` and `q - r`, and the rotations `U` and `Z` have the angles `(beta + alpha) / 2` and
    /// `(beta - alpha) / 2`.
    #[inline(always)]
    fn factor_two(&mut self, rows: usize, margin: &mut Margin) {
        let half = Lanes::splat(0.5);
        let entry = |i: usize, j: usize| self.gram.at(i, j) * half;
        let (m00, m01, m10, m11) = (entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1));
        let (alpha, q) = direction(m00 + m11, m10 - m01);
        let (beta, r) = direction(m00 - m11, m10 + m01);
        let z = half_angle(
            beta.0 * alpha.0 + beta.1 * alpha.1,
            beta.1 * alpha.0 - beta.0 * alpha.1,
        );
        let u = (alpha.0 * z.0 - alpha.1 * z.1, alpha.1 * z.0 + alpha.0 * z.1);
        for (out, (cos, sin)) in [
            (&mut self.z, z),
            (&mut self.u, u),
            (&mut self.rotation, alpha),
        ] {
            out.set(0, 0, cos);
            out.set(1, 0, sin);
            out.set(0, 1, -sin);
            out.set(1, 1, cos);
        }
        let smaller = q - r;
        (self.cosines[0], self.cosines[1]) = (q + r, smaller);
        let sum = q + q;
        let least = (Lanes::ONE + smaller).min(sum);
        margin.see(least, Lanes::splat(LOWEST_COSINE).greater(smaller));
        margin.see(least, Lanes::splat(DETERMINED).greater(sum));
        // O(2) has two components.
        if rows == 2 {
            margin.see(least, Lanes::ZERO.greater(smaller));
        }
    }

    /// `gram = U diag(c) Z^T` with `det(U Z^T) = 1`, and the rotation `U Z^T`.
    #[inline(always)]
    pub(super) fn factor(&mut self, rows: usize, margin: &mut Margin) {
        let k = self.cosines.len();
        self.u.copy_from(&self.gram);
        let converged = orthogonalise_columns(&mut self.u, &mut self.z);
        let mut smallest = [Lanes::splat(2.0); 2];
        for i in 0..k {
            let column = self.u.col_mut(i);
            let cosine = dot(column, column).sqrt();
            let inverse = Lanes::ONE / cosine.max(Lanes::splat(TINY));
            for x in column {
                *x = *x * inverse;
            }
            self.cosines[i] = cosine;
            smallest = [
                smallest[0].min(cosine),
                smallest[1].min(smallest[0].max(cosine)),
            ];
        }
        let mut hard = Lanes::splat(SMALL_COSINE).greater(smallest[0]);
        let signs = self.signs();
        for lane in (0..LANES).filter(|&lane| signs[lane] < 0.0) {
            hard.0[lane] |= rows == k;
            self.change_branch(lane);
            smallest[0].0[lane] = -smallest[0].0[lane];
        }
        self.rotation.set_product_nt(&self.u, &self.z);
        let least = (Lanes::ONE + smallest[0]).min(if rows == k {
            Lanes::splat(2.0)
        } else {
            smallest[0] + smallest[1]
        });
        margin.see(least, hard);
        margin.see(least, Lanes::splat(LOWEST_COSINE).greater(smallest[0]));
        margin.see(least, Lanes::splat(DETERMINED).greater(least));
        margin.see(least, Mask([!converged; LANES]));
    }

    /// Signs of `det(gram)`, which are also those of `det(U Z^T)`.
    fn signs(&mut self) -> [f64; LANES] {
        let k = self.cosines.len();
        let mut distance = Lanes::ZERO;
        for j in 0..k {
            for i in 0..k {
                let gap = self.gram.at(i, j) - if i == j { Lanes::ONE } else { Lanes::ZERO };
                distance += gap * gap;
            }
        }
        // |M - I| < 1: every matrix on the way to the identity is regular.
        if !distance.greater(Lanes::splat(0.99)).any() {
            return [1.0; LANES];
        }
        determinant_signs(&self.gram, &mut self.single)
    }

    /// Changes the sign of one lane's smallest cosine and of its left vector.
    fn change_branch(&mut self, lane: usize) {
        let mut smallest = 0;
        for i in 1..self.cosines.len() {
            if self.cosines[i].0[lane] < self.cosines[smallest].0[lane] {
                smallest = i;
            }
        }
        self.cosines[smallest].0[lane] *= -1.0;
        for x in self.u.col_mut(smallest) {
            x.0[lane] *= -1.0;
        }
    }
}

/// The cosine and sine of the angle of a vector, and its length; an angle of zero for a vector without a direction.
#[inline(always)]
fn direction(x: Lanes, y: Lanes) -> ((Lanes, Lanes), Lanes) {
    let length = (x * x + y * y).sqrt();
    let determined = length.greater(Lanes::splat(TINY));
    let inverse = Lanes::ONE / determined.select(length, Lanes::ONE);
    let cos = determined.select(x * inverse, Lanes::ONE);
    let sin = determined.select(y * inverse, Lanes::ZERO);
    ((cos, sin), length)
}

/// The cosine and sine of half the angle given by its cosine and sine, without cancellation: the larger of both, then the
/// other one.
#[inline(always)]
fn half_angle(cos: Lanes, sin: Lanes) -> (Lanes, Lanes) {
    let half = Lanes::splat(0.5);
    let large = ((Lanes::ONE + cos.abs()) * half).sqrt();
    let small = sin.abs() * half / large;
    let acute = cos.greater(Lanes::ZERO);
    (
        acute.select(large, small),
        acute.select(small, large).copysign(sin),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest error of `U diag(c) Z^T = M`, of `U Z^T` and of the determinants of both, for one matrix a lane.
    fn errors_of_two(matrices: [[f64; 4]; LANES]) -> f64 {
        let mut principal = LanePrincipal::new(2);
        for (lane, m) in matrices.iter().enumerate() {
            for (place, x) in m.iter().enumerate() {
                let mut entry = principal.gram.at(place / 2, place % 2);
                entry.0[lane] = *x;
                principal.gram.set(place / 2, place % 2, entry);
            }
        }
        let mut margin = Margin::WIDE;
        principal.factor_two(3, &mut margin);
        let LanePrincipal {
            u,
            z,
            rotation,
            cosines,
            gram,
            ..
        } = &principal;
        let mut errors = Vec::new();
        let mut see = |error: Lanes| errors.extend(error.0);
        for i in 0..2 {
            for j in 0..2 {
                let (u, z) = ([u.at(i, 0), u.at(i, 1)], [z.at(j, 0), z.at(j, 1)]);
                see(u[0] * cosines[0] * z[0] + u[1] * cosines[1] * z[1] - gram.at(i, j));
                see(u[0] * z[0] + u[1] * z[1] - rotation.at(i, j));
            }
        }
        for a in [u, z] {
            see(a.at(0, 0) * a.at(1, 1) - a.at(0, 1) * a.at(1, 0) - Lanes::ONE);
        }
        assert!(errors.iter().all(|x| x.is_finite()), "{matrices:?}");
        errors.iter().fold(0.0, |most, x| x.abs().max(most))
    }

    /// The largest error is 7.8e-16.
    #[test]
    fn two_principal_vectors_are_rotations() {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for _ in 0..100 {
            let matrices = [(); LANES].map(|()| [(); 4].map(|()| uniform()));
            let error = errors_of_two(matrices);
            assert!(error < 2e-15, "{matrices:?}: {error:e}");
        }
    }

    /// Equal cosines, a negative one, zeros of both signs, and reflections of the size of round-off; the largest error is
    /// 2.2e-16.
    #[test]
    fn two_principal_vectors_of_special_matrices_are_rotations() {
        let matrices = [
            [1.0, 0.0, 0.0, 1.0],
            [0.6, -0.8, 0.8, 0.6],
            [0.5, 0.0, 0.0, 1.0],
            [0.5, -0.0, 0.0, 1.0],
            [0.5, 0.0, -0.0, 1.0],
            [0.9, 1e-17, 0.0, 0.9],
            [0.9, 1e-17, 1e-17, 0.9 - 1.2e-16],
            [1.0, 0.0, 0.0, -0.4],
        ];
        let error = errors_of_two(matrices);
        assert!(error < 1e-15, "{error:e}");
        // No rotation is nearest to a reflection, and none to zero; the vectors are rotations nevertheless.
        let undetermined = [
            [1.0, 0.0, 0.0, -1.0],
            [0.0, 1.0, 1.0, 0.0],
            [0.3, 0.1, 0.1, -0.3],
            [0.0; 4],
        ];
        for m in undetermined {
            let error = errors_of_two([m; LANES]);
            assert!(error < 1e-15, "{m:?}: {error:e}");
        }
    }
}
