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

    /// In closed form: `M` is `q` times a rotation by `a`, plus `r` times a reflection at half the angle `b`, so its singular
    /// values are `q + r` and `q - r`, and its principal vectors have the angles `(b + a) / 2` and `(b - a) / 2`.
    #[inline(always)]
    fn factor_two(&mut self, rows: usize, margin: &mut Margin) {
        let half = Lanes::splat(0.5);
        let [a, b, c, d] = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]| self.gram.at(i, j) * half);
        let (turn, reflection) = ((a + d, b - c), (a - d, b + c));
        let length = |(x, y): (Lanes, Lanes)| (x * x + y * y).sqrt();
        let (q, r) = (length(turn), length(reflection));
        let inverse = Lanes::ONE / q.max(Lanes::splat(TINY));
        let (cos, sin) = (turn.0 * inverse, turn.1 * inverse);
        // The angle b - a of twice the right vectors; any angle where both cosines are the same.
        let (x, y) = reflection;
        let (x, y) = (x * cos + y * sin, y * cos - x * sin);
        let differ = r.greater(Lanes::splat(TINY));
        let inverse = Lanes::ONE / differ.select(r, Lanes::ONE);
        let (x, y) = (
            differ.select(x * inverse, Lanes::ONE),
            differ.select(y * inverse, Lanes::ZERO),
        );
        // The larger of the sine and cosine of half the angle, then the other one.
        let large = ((Lanes::ONE + x.abs()) * half).sqrt();
        let small = y.abs() * half / large;
        let acute = x.greater(Lanes::ZERO);
        let (zx, zy) = (
            acute.select(large, small),
            acute.select(small, large).copysign(y),
        );
        let (ux, uy) = (cos * zx - sin * zy, sin * zx + cos * zy);
        for (out, x, y) in [
            (&mut self.z, zx, zy),
            (&mut self.u, ux, uy),
            (&mut self.rotation, cos, sin),
        ] {
            out.set(0, 0, x);
            out.set(1, 0, y);
            out.set(0, 1, -y);
            out.set(1, 1, x);
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
