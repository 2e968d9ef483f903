//! Small matrices of [`Lanes`]: eight matrices at once, one for each curve parameter.
//!
//! Sizes are those of a reduced problem (up to some tens), for which a product or a plane rotation of eight matrices
//! keeps the vector units busy, unlike a single matrix. Factorisations are Jacobi methods: except for the number of
//! sweeps their work does not depend on the entries, and they are accurate for every spectrum.
//!
//! # Source
//! One-sided Jacobi: Hestenes (1958); Demmel, Veselic (1992), "Jacobi's method is more accurate than QR". Two-sided:
//! Golub, Van Loan (2013), "Matrix Computations", section 8.5.

use super::lanes::{LANES, Lanes, Mask};

/// Maximal number of sweeps, more than any matrix of these sizes needs; about six are usual.
const MAX_SWEEPS: usize = 30;

/// Eight matrices of one shape, in column-major order.
#[derive(Debug, Clone)]
pub(crate) struct LaneMatrix {
    rows: usize,
    cols: usize,
    entries: Vec<Lanes>,
}

impl LaneMatrix {
    pub(crate) fn zeros(rows: usize, cols: usize) -> Self {
        LaneMatrix {
            rows,
            cols,
            entries: vec![Lanes::ZERO; rows * cols],
        }
    }

    #[inline(always)]
    pub(crate) fn cols(&self) -> usize {
        self.cols
    }

    #[inline(always)]
    pub(crate) fn at(&self, i: usize, j: usize) -> Lanes {
        self.entries[j * self.rows + i]
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, j: usize, value: Lanes) {
        self.entries[j * self.rows + i] = value;
    }

    #[inline(always)]
    pub(crate) fn col(&self, j: usize) -> &[Lanes] {
        &self.entries[j * self.rows..(j + 1) * self.rows]
    }

    #[inline(always)]
    pub(crate) fn col_mut(&mut self, j: usize) -> &mut [Lanes] {
        &mut self.entries[j * self.rows..(j + 1) * self.rows]
    }

    /// The two columns of a two-column matrix.
    #[inline(always)]
    pub(crate) fn two_columns(&mut self) -> (&mut [Lanes], &mut [Lanes]) {
        self.entries.split_at_mut(self.rows)
    }

    /// Two different columns, `i < j`.
    #[inline(always)]
    fn two_cols(&mut self, i: usize, j: usize) -> (&mut [Lanes], &mut [Lanes]) {
        let (head, tail) = self.entries.split_at_mut(j * self.rows);
        (
            &mut head[i * self.rows..(i + 1) * self.rows],
            &mut tail[..self.rows],
        )
    }

    #[inline(always)]
    pub(crate) fn copy_from(&mut self, other: &LaneMatrix) {
        self.entries.copy_from_slice(&other.entries);
    }

    pub(crate) fn set_identity(&mut self) {
        self.entries.fill(Lanes::ZERO);
        for i in 0..self.rows {
            self.set(i, i, Lanes::ONE);
        }
    }

    /// Sets one lane to a multiple of a matrix.
    pub(crate) fn set_lane(&mut self, lane: usize, alpha: f64, a: faer::MatRef<'_, f64>) {
        for j in 0..self.cols {
            let column = a.col(j);
            for (to, from) in self.col_mut(j).iter_mut().zip(column.iter()) {
                to.0[lane] = alpha * from;
            }
        }
    }

    /// The matrix of one lane.
    pub(crate) fn lane_into(&self, lane: usize, mut out: faer::MatMut<'_, f64>) {
        for j in 0..self.cols {
            for (i, entry) in self.col(j).iter().enumerate() {
                out[(i, j)] = entry.0[lane];
            }
        }
    }

    /// `self = a^T b`.
    #[inline(always)]
    pub(crate) fn set_product_tn(&mut self, a: &LaneMatrix, b: &LaneMatrix) {
        for j in 0..b.cols {
            for i in 0..a.cols {
                self.set(i, j, dot(a.col(i), b.col(j)));
            }
        }
    }

    /// `self += a^T b`.
    #[inline(always)]
    pub(crate) fn add_product_tn(&mut self, a: &LaneMatrix, b: &LaneMatrix) {
        for j in 0..b.cols {
            for i in 0..a.cols {
                self.set(i, j, self.at(i, j) + dot(a.col(i), b.col(j)));
            }
        }
    }

    /// `self = a b`.
    #[inline(always)]
    pub(crate) fn set_product(&mut self, a: &LaneMatrix, b: &LaneMatrix) {
        self.entries.fill(Lanes::ZERO);
        self.add_product(a, b);
    }

    /// `self += a b`, four rows at a time so that sums stay in registers.
    #[inline(always)]
    pub(crate) fn add_product(&mut self, a: &LaneMatrix, b: &LaneMatrix) {
        let (rows, inner) = (a.rows, a.cols);
        for j in 0..b.cols {
            let (column, out) = (b.col(j), self.col_mut(j));
            let mut i = 0;
            while i + 4 <= rows {
                let mut sum = [out[i], out[i + 1], out[i + 2], out[i + 3]];
                for l in 0..inner {
                    let (x, part) = (column[l], &a.entries[l * rows + i..l * rows + i + 4]);
                    for d in 0..4 {
                        sum[d] += part[d] * x;
                    }
                }
                out[i..i + 4].copy_from_slice(&sum);
                i += 4;
            }
            while i < rows {
                let mut sum = out[i];
                for l in 0..inner {
                    sum += a.entries[l * rows + i] * column[l];
                }
                out[i] = sum;
                i += 1;
            }
        }
    }

    /// `self = a b^T`.
    #[inline(always)]
    pub(crate) fn set_product_nt(&mut self, a: &LaneMatrix, b: &LaneMatrix) {
        self.entries.fill(Lanes::ZERO);
        self.add_scaled_product_nt(1.0, a, b);
    }

    /// `self += alpha a b^T`.
    #[inline(always)]
    pub(crate) fn add_scaled_product_nt(&mut self, alpha: f64, a: &LaneMatrix, b: &LaneMatrix) {
        for l in 0..a.cols {
            for j in 0..b.rows {
                let (x, out) = (b.at(j, l) * alpha, self.col_mut(j));
                for (target, &y) in out.iter_mut().zip(a.col(l)) {
                    *target += y * x;
                }
            }
        }
    }

    /// `self -= a b`.
    #[inline(always)]
    pub(crate) fn subtract_product(&mut self, a: &LaneMatrix, b: &LaneMatrix) {
        for j in 0..b.cols {
            for l in 0..a.cols {
                let (x, out) = (b.at(l, j), self.col_mut(j));
                for (target, &y) in out.iter_mut().zip(a.col(l)) {
                    *target -= y * x;
                }
            }
        }
    }

    /// `self += a diag(d)`.
    #[inline(always)]
    pub(crate) fn add_scaled_columns(&mut self, a: &LaneMatrix, d: &[Lanes]) {
        for (j, &x) in d.iter().enumerate() {
            for (target, &y) in self.col_mut(j).iter_mut().zip(a.col(j)) {
                *target += y * x;
            }
        }
    }

    /// `self = a^T`.
    #[inline(always)]
    pub(crate) fn set_transposed(&mut self, a: &LaneMatrix) {
        for j in 0..self.cols {
            for i in 0..self.rows {
                self.set(i, j, a.at(j, i));
            }
        }
    }

    /// `self += alpha a`.
    #[inline(always)]
    pub(crate) fn add_scaled(&mut self, alpha: f64, a: &LaneMatrix) {
        for (to, from) in self.entries.iter_mut().zip(&a.entries) {
            *to += *from * alpha;
        }
    }

    /// `self *= alpha`.
    #[inline(always)]
    pub(crate) fn scale(&mut self, alpha: f64) {
        for x in &mut self.entries {
            *x = *x * alpha;
        }
    }

    #[inline(always)]
    pub(crate) fn fill_zero(&mut self) {
        self.entries.fill(Lanes::ZERO);
    }

    #[inline(always)]
    pub(crate) fn entries(&self) -> &[Lanes] {
        &self.entries
    }

    #[inline(always)]
    pub(crate) fn entries_mut(&mut self) -> &mut [Lanes] {
        &mut self.entries
    }

    /// `self = a b` with a constant matrix `a`, in column-major order.
    #[inline(always)]
    pub(crate) fn set_constant_product(&mut self, a: &[f64], b: &LaneMatrix) {
        let (rows, inner) = (self.rows, b.rows);
        for j in 0..b.cols {
            let (column, out) = (b.col(j), self.col_mut(j));
            for (i, target) in out.iter_mut().enumerate() {
                let mut sum = Lanes::ZERO;
                for l in 0..inner {
                    sum += column[l] * a[l * rows + i];
                }
                *target = sum;
            }
        }
    }
}

/// Sum of products; two running sums hide the latency of additions.
#[inline(always)]
pub(crate) fn dot(a: &[Lanes], b: &[Lanes]) -> Lanes {
    let (mut even, mut odd) = (Lanes::ZERO, Lanes::ZERO);
    let mut pairs = a.chunks_exact(2).zip(b.chunks_exact(2));
    for (x, y) in &mut pairs {
        even += x[0] * y[0];
        odd += x[1] * y[1];
    }
    if a.len() % 2 == 1 {
        even += a[a.len() - 1] * b[b.len() - 1];
    }
    even + odd
}

/// The rotation `(cos, sin)` by an angle of at most pi/4 with `cot(2 phi) = (b - a) / (2 c)` in the lanes of `needed`;
/// the identity in the others.
#[inline(always)]
fn rotation(a: Lanes, b: Lanes, c: Lanes, needed: Mask) -> (Lanes, Lanes) {
    let twice = needed.select(c + c, Lanes::ONE);
    let cotangent = (b - a) / twice;
    let root = (Lanes::ONE + cotangent * cotangent).sqrt();
    let tangent = (Lanes::ONE / (cotangent.abs() + root)).copysign(cotangent);
    let tangent = needed.select(tangent, Lanes::ZERO);
    let cos = Lanes::ONE / (Lanes::ONE + tangent * tangent).sqrt();
    (cos, tangent * cos)
}

#[inline(always)]
fn rotate(x: &mut [Lanes], y: &mut [Lanes], cos: Lanes, sin: Lanes) {
    for (a, b) in x.iter_mut().zip(y) {
        (*a, *b) = (cos * *a - sin * *b, sin * *a + cos * *b);
    }
}

/// Orthogonalises the columns of `a` by rotations, which are accumulated in `z`: `A Z = U diag(s)`. Returns whether it
/// converged.
#[inline(always)]
pub(crate) fn orthogonalise_columns(a: &mut LaneMatrix, z: &mut LaneMatrix) -> bool {
    let k = a.cols;
    let negligible = Lanes::splat((f64::EPSILON * (k as f64).max(4.0)).powi(2));
    z.set_identity();
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        for j in 1..k {
            for i in 0..j {
                let (x, y) = a.two_cols(i, j);
                let (xx, yy, xy) = (dot(x, x), dot(y, y), dot(x, y));
                let needed = (xy * xy).greater(negligible * xx * yy);
                if needed.any() {
                    rotated = true;
                    let (cos, sin) = rotation(xx, yy, xy, needed);
                    rotate(x, y, cos, sin);
                    let (x, y) = z.two_cols(i, j);
                    rotate(x, y, cos, sin);
                }
            }
        }
        if !rotated {
            return true;
        }
    }
    false
}

/// Diagonalises the symmetric `a` by rotations, which are accumulated in `v`: `a` becomes `V^T A V`. Returns whether it
/// converged.
#[inline(always)]
pub(crate) fn diagonalise(a: &mut LaneMatrix, v: &mut LaneMatrix) -> bool {
    let k = a.cols;
    // The matrices here have spectral norm one.
    let negligible = Lanes::splat(f64::EPSILON);
    v.set_identity();
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        for j in 1..k {
            for i in 0..j {
                let off = a.at(i, j);
                let needed = off.abs().greater(negligible);
                if needed.any() {
                    rotated = true;
                    let (cos, sin) = rotation(a.at(i, i), a.at(j, j), off, needed);
                    let (x, y) = a.two_cols(i, j);
                    rotate(x, y, cos, sin);
                    for l in 0..k {
                        let (x, y) = (a.at(i, l), a.at(j, l));
                        a.set(i, l, cos * x - sin * y);
                        a.set(j, l, sin * x + cos * y);
                    }
                    let (x, y) = v.two_cols(i, j);
                    rotate(x, y, cos, sin);
                }
            }
        }
        if !rotated {
            return true;
        }
    }
    false
}

/// Signs of the determinants of square matrices, lane by lane; `work` holds one matrix.
pub(crate) fn determinant_signs(a: &LaneMatrix, work: &mut faer::Mat<f64>) -> [f64; LANES] {
    std::array::from_fn(|lane| {
        a.lane_into(lane, work.as_mut());
        super::product::determinant_sign(work.as_mut())
    })
}
