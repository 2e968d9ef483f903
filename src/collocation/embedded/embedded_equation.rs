//! The equation of cubics for the matrices `S` themselves, at eight nodes: the fourth derivative from the lower ones.
//!
//! With `V = S'`, `Omega = S^T V`, the covariant acceleration `A` and its derivative `J` in the sense of `x'` and `x''`,
//!
//! ```math
//! V' = A + V\Omega - S a,\qquad A' = J + V\Omega' - S b,\qquad
//! J' = J\,\Omega + A(\tau - a) + V b^T + S(\Omega' a - \Omega b^T - e^T)
//! ```
//!
//! where `a, b, e` are the products of the part of `V` orthogonal to `S` with those of `V, A, J`. Elimination of `A` and `J`
//! leaves `S''''` as a combination of `S, S', S'', S'''` with factors of size `k`, so it stays in the span of the data at the
//! ends, and a basis of that span is not needed: products of columns are those of coordinates with a Gram matrix.
//!
//! Of embedded complex matrices the first half of the columns is stored and computed; the others are `i` times these.

use super::embedded_products::{NodeProducts, Small, times_symmetric};
use crate::linalg::complex_embedding::times_i;
use crate::linalg::dual::Number;
use crate::linalg::field::accumulate;
use crate::linalg::lanes::Lanes;
use crate::linalg::simd::vectorised;
use crate::space::{Kind, Quotient, ScalarField};

/// Sizes, and what the equation depends on. Matrices `S` have `k` columns of `r` coordinates each, one column after
/// another.
#[derive(Debug, Clone)]
pub(crate) struct Embedded {
    pub(crate) r: usize,
    pub(crate) k: usize,
    pub(crate) kind: Kind,
    pub(crate) tension: f64,
    /// Products of the vectors of the basis, shape `(r, r)`; `None` for an orthonormal one.
    pub(crate) gram: Option<Vec<f64>>,
}

/// Buffers.
#[derive(Debug, Clone, Default)]
pub(crate) struct EquationBuffers {
    small: Vec<Lanes>,
    tall: Vec<Lanes>,
}

/// Number of small matrices; of tall ones times the Gram matrix, and times `i`.
const SMALL: usize = 22;
const MOVED: usize = 3;
const TURNED: usize = 4;

impl EquationBuffers {
    /// Makes room for the matrices of an equation.
    pub(crate) fn resize(&mut self, equation: &Embedded) {
        let (small, tall) = (equation.k * equation.k, equation.size());
        self.small.resize(SMALL * small, Lanes::ZERO);
        self.tall.resize((MOVED + TURNED) * tall, Lanes::ZERO);
    }
}

impl Embedded {
    /// Number of stored columns.
    pub(crate) fn stored(&self) -> usize {
        match self.kind.field {
            ScalarField::Real => self.k,
            ScalarField::Complex => self.k / 2,
        }
    }

    /// Number of stored entries of a matrix.
    pub(crate) fn size(&self) -> usize {
        self.r * self.stored()
    }

    /// `i x`, the other columns of an embedded complex matrix. Coordinates for a Gram matrix belong to four such matrices.
    #[inline(always)]
    fn times_i<T: Number>(&self, x: &[T], out: &mut [T]) {
        let rows = if self.gram.is_some() { self.k } else { self.r };
        times_i(x, rows, out);
    }

    /// All columns of a matrix.
    pub(crate) fn all_columns(&self, x: &[f64]) -> Vec<f64> {
        let mut all = x.to_vec();
        if self.kind.field == ScalarField::Complex {
            all.resize(2 * x.len(), 0.0);
            self.times_i(x, &mut all[x.len()..]);
        }
        all
    }

    /// `out = S''''` from `S, S', S'', S'''`.
    pub(crate) fn fourth_derivative_into(
        &self,
        s: [&[Lanes]; 4],
        buffers: &mut EquationBuffers,
        out: &mut [Lanes],
    ) {
        vectorised(
            #[inline(always)]
            || self.combine(s, buffers, out),
        );
    }

    #[inline(always)]
    fn combine(&self, s: [&[Lanes]; 4], buffers: &mut EquationBuffers, out: &mut [Lanes]) {
        let (r, k, stored, size) = (self.r, self.k, self.stored(), self.size());
        let EquationBuffers { small, tall } = buffers;
        small.fill(Lanes::ZERO);
        let (by_gram, by_i) = tall.split_at_mut(MOVED * size);
        // `S', S'', S'''` times the Gram matrix.
        let mut moved: [&[Lanes]; 4] = s;
        if let Some(gram) = &self.gram {
            let each = by_gram.chunks_exact_mut(size).zip(&s[1..]);
            for ((tall, s), moved) in each.zip(&mut moved[1..]) {
                times_symmetric(s, gram, r, tall);
                *moved = tall;
            }
        }
        let mut turned: [&[Lanes]; TURNED] = Default::default();
        if stored < k {
            let each = by_i.chunks_exact_mut(size).zip(s);
            for ((tall, s), turned) in each.zip(&mut turned) {
                self.times_i(s, tall);
                *turned = tall;
            }
        }
        let mut rest = small.chunks_exact_mut(k * k);
        let mut next = || rest.next().unwrap_or_default();
        let m = Small { k, stored };
        let gram = NodeProducts {
            s,
            turned,
            moved,
            r,
            m,
        };
        let mut factors = [next(), next(), next(), next()];
        let tension = self.tension;
        match self.kind.quotient {
            Quotient::Subspaces => factors_of_subspaces(m, tension, gram, &mut next, &mut factors),
            Quotient::Frames if r == k => {
                factors_of_squares(m, tension, gram, &mut next, &mut factors);
            }
            Quotient::Frames => factors_of_frames(m, tension, gram, &mut next, &mut factors),
        }
        for i in 0..k {
            factors[2][i * k + i] += Lanes::splat(tension);
        }
        // out = S c0 + S' c1 + S'' c2 + S''' c3, by rows of the transposes.
        out.fill(Lanes::ZERO);
        let factor = &mut next()[..stored * stored];
        for ((c, s), turned) in factors.into_iter().zip(s).zip(turned) {
            for (first, s) in (0..k).step_by(stored).zip([s, turned]) {
                for i in 0..stored {
                    for j in 0..stored {
                        factor[j * stored + i] = c[(first + i) * k + j];
                    }
                }
                accumulate(factor, stored, s, r, out);
            }
        }
    }

    /// `S^T V` for two matrices, shape `(k, k)`.
    pub(crate) fn product<'b>(
        &self,
        [s, v]: [&[Lanes]; 2],
        buffers: &'b mut EquationBuffers,
    ) -> &'b [Lanes] {
        let (r, k, stored, size) = (self.r, self.k, self.stored(), self.size());
        let EquationBuffers { small, tall } = buffers;
        let product = &mut small[..k * k];
        let (by_gram, rest) = tall.split_at_mut(size);
        let by_i = &mut rest[..size];
        vectorised(
            #[inline(always)]
            || {
                let v = match &self.gram {
                    Some(gram) => {
                        times_symmetric(v, gram, r, by_gram);
                        &*by_gram
                    }
                    None => v,
                };
                let mut turned: &[Lanes] = &[];
                if stored < k {
                    self.times_i(s, by_i);
                    turned = by_i;
                }
                Small { k, stored }.write_product([s, turned], v, r, product);
            },
        );
        product
    }

    /// The sum of the squares of all entries of a matrix.
    pub(crate) fn square(&self, v: &[Lanes]) -> Lanes {
        let mut moved = v.to_vec();
        if let Some(gram) = &self.gram {
            times_symmetric(v, gram, self.r, &mut moved);
        }
        let mut sum = Lanes::ZERO;
        for (v, moved) in v.iter().zip(&moved) {
            sum += *v * *moved;
        }
        sum * (self.k / self.stored()) as f64
    }
}

/// The factors of `S, S', S'', S'''` for horizontal curves of subspaces, without the tension of `S''`; `gram` writes the
/// products of two of these, and `next` has matrices of zeros.
#[inline(always)]
fn factors_of_subspaces<'b>(
    m: Small,
    tension: f64,
    gram: NodeProducts<'_>,
    next: &mut impl FnMut() -> &'b mut [Lanes],
    factors: &mut [&mut [Lanes]; 4],
) {
    let [c0, c1, c2, _] = factors;
    let (g11, g12, g13, g22) = (next(), next(), next(), next());
    gram.write([1, 1], g11);
    gram.write([1, 2], g12);
    gram.write([1, 3], g13);
    gram.write([2, 2], g22);
    // a = g11, b = g12, c = g22 - a a, e = g13 + a a.
    let aa = next();
    m.add(1.0, g11, g11, aa);
    for i in 0..m.k * m.k {
        c1[i] = g12[i] * -4.0;
        c2[i] = g11[i] * -2.0;
        // a (tau - a) - 3 c - 3 e - e^T.
        c0[i] = g11[i] * tension - aa[i] * 2.0 - g22[i] * 3.0 - g13[i] * 3.0;
    }
    m.add_transposed(-1.0, g13, c0);
}

/// The same for square frames: nothing is orthogonal to `S`, so `a = b = c = e = 0`. A spline through 20 points on O(9) takes
/// 0.55 to 0.66 times as long as on St(9,8), which needs all terms.
#[inline(always)]
fn factors_of_squares<'b>(
    m: Small,
    tension: f64,
    gram: NodeProducts<'_>,
    next: &mut impl FnMut() -> &'b mut [Lanes],
    factors: &mut [&mut [Lanes]; 4],
) {
    let [_, c1, c2, c3] = factors;
    let g11 = next();
    gram.write([1, 1], g11);
    let (o, g02, g03, p) = (next(), next(), next(), next());
    gram.write([0, 1], o);
    gram.write([0, 2], g02);
    gram.write([0, 3], g03);
    for i in 0..m.k * m.k {
        p[i] = g02[i] + g11[i];
    }
    let second = g03;
    m.add(-1.0, g02, o, second);
    m.add(-2.0, o, p, second);
    for i in 0..m.k * m.k {
        c1[i] = second[i] * 2.0 - o[i] * tension;
        c2[i] = p[i] * 3.0;
        c3[i] = o[i] * 2.0;
    }
    m.add(-2.0, p, o, c1);
    m.add(-1.0, o, o, c2);
}

/// The same for frames.
#[inline(always)]
fn factors_of_frames<'b>(
    m: Small,
    tension: f64,
    gram: NodeProducts<'_>,
    next: &mut impl FnMut() -> &'b mut [Lanes],
    factors: &mut [&mut [Lanes]; 4],
) {
    let [c0, c1, c2, c3] = factors;
    let (g11, g12, g13, g22) = (next(), next(), next(), next());
    gram.write([1, 1], g11);
    gram.write([1, 2], g12);
    gram.write([1, 3], g13);
    gram.write([2, 2], g22);
    let (o, g02, g03) = (next(), next(), next());
    gram.write([0, 1], o);
    gram.write([0, 2], g02);
    gram.write([0, 3], g03);
    let (a, p, b, sum, w) = (next(), next(), next(), next(), next());
    // a = g11 + o o, p = g02 + g11, w = 2 p - a.
    a.copy_from_slice(g11);
    m.add(1.0, o, o, a);
    for i in 0..m.k * m.k {
        p[i] = g02[i] + g11[i];
        w[i] = p[i] * 2.0 - a[i];
    }
    // Products of the parts orthogonal to S: g12 + o g02, g13 + o g03, g22 - g02^T g02.
    let (m12, e) = (g12, g13);
    m.add(1.0, o, g02, m12);
    m.add(1.0, o, g03, e);
    let c = g22;
    m.add_left_transposed(-1.0, g02, g02, c);
    // b = m12 - a o, c = m22 - m12^T o + o m12 - o a o, e = m13 - m12 o - a w.
    let ao = next();
    m.add(1.0, a, o, ao);
    for i in 0..m.k * m.k {
        b[i] = m12[i] - ao[i];
    }
    m.add_left_transposed(-1.0, m12, o, c);
    m.add(1.0, o, b, c);
    m.add(-1.0, m12, o, e);
    m.add(-1.0, a, w, e);
    // sum = 2 b + b^T; x'' in the part of the columns: g03 - g02 o - o w + sum.
    for i in 0..m.k * m.k {
        sum[i] = b[i] * 2.0;
    }
    m.add_transposed(1.0, b, sum);
    let second = g03;
    m.add(-1.0, g02, o, second);
    m.add(-1.0, o, w, second);
    for i in 0..m.k * m.k {
        second[i] += sum[i];
        // 2 x'' - 3 b - b^T = 2 x'' - (2 b + b^T) - b.
        c1[i] = second[i] * 2.0 - sum[i] - b[i] - o[i] * tension;
        c3[i] = o[i] * 2.0;
        c2[i] = p[i] * 3.0 - a[i] * 2.0;
        c0[i] = a[i] * tension - c[i] * 3.0 - e[i] * 2.0;
    }
    m.add(-1.0, w, o, c1);
    m.add(1.0, o, a, c1);
    m.add(-1.0, o, o, c2);
    m.add_transposed(-2.0, e, c0);
    m.add(1.0, sum, o, c0);
    m.add(-1.0, a, a, c0);
    m.add(1.0, p, a, c0);
    m.add_right_transposed(-1.0, o, b, c0);
}

#[cfg(test)]
mod tests {
    use faer::linalg::solvers::{PartialPivLu, Solve};
    use faer::{Mat, MatRef, Scale, c64};

    use super::*;
    use crate::linalg::complex_embedding::embed;
    use crate::space::{Homogeneous, RowOrder, Shape, in_space};

    /// A curve that starts at the identity with given `x, x', x''`, and its first four derivatives there.
    fn derivatives(space: impl Homogeneous, k: usize, tension: f64) -> [Mat<f64>; 5] {
        let (r, d) = (space.size(), space.dim());
        let [x, x1, x2] = [1.0, 1.7, 2.9].map(|seed: f64| {
            let x: Vec<f64> = (0..d).map(|p| (seed * (p as f64 + 1.3)).sin()).collect();
            let mut matrix = vec![0.0; r * r];
            space.matrix_into(&x, &mut matrix);
            matrix
        });
        let mut third = vec![0.0; d];
        let mut isotropy = vec![0.0; space.isotropy_dim()];
        space.add_bracket(&x2, &x, 1.0, &mut third);
        space.add_isotropy_bracket(&x, &x1, 1.0, &mut isotropy);
        space.subtract_action(&isotropy, &x, &mut third);
        let mut x3 = vec![0.0; r * r];
        space.matrix_into(&third, &mut x3);
        let [x, x1, x2, x3] =
            [x, x1, x2, x3].map(|x| MatRef::from_row_major_slice(&x, r, r).to_owned());
        let x3 = x3 + &x1 * Scale(tension);
        // Derivatives of `g' = g x` at `g = 1`.
        let square = &x * &x;
        let identity: Mat<f64> = Mat::identity(r, r);
        let second = &square + &x1;
        let third = &square * &x + &x * &x1 * Scale(2.0) + &x1 * &x + &x2;
        let fourth = &square * &square
            + &square * &x1 * Scale(3.0)
            + &x * &x1 * &x * Scale(2.0)
            + &x1 * &square
            + &x * &x2 * Scale(3.0)
            + &x1 * &x1 * Scale(3.0)
            + &x2 * &x
            + x3;
        [identity, x, second, third, fourth].map(|a| a.as_ref().subcols(0, k).to_owned())
    }

    fn lanes(a: &Mat<f64>) -> Vec<Lanes> {
        let entries = a.col_iter().flat_map(|column| column.iter());
        entries.map(|x| Lanes::splat(*x)).collect()
    }

    fn complex_kind(quotient: Quotient) -> Kind {
        let field = ScalarField::Complex;
        Kind { quotient, field }
    }

    /// The columns of an embedded matrix in blocks of `k`, each with real parts before imaginary ones.
    fn in_blocks(a: &Mat<f64>, k: usize) -> Mat<f64> {
        let (r, half) = (a.ncols(), k / 2);
        let column = |j: usize| j % k / half * (r / 2) + j / k * half + j % half;
        Mat::from_fn(r, r, |i, j| a[(i, column(j))])
    }

    /// The fourth derivative is that of the equation in frames, for coordinates in any basis.
    #[test]
    fn the_equation_agrees_with_that_in_frames() {
        let frames = [(2, 1), (3, 1), (5, 1), (3, 2), (5, 2), (7, 4), (8, 7)];
        let squares = [(2, 2), (3, 3), (6, 6)];
        let spans = [(2, 1), (4, 1), (4, 2), (5, 3), (8, 3)];
        let complex = [(2, 2), (4, 4), (4, 2), (6, 2), (8, 4)];
        let complex_spans = complex.iter().skip(2).copied();
        let complex_spans = complex_spans.map(|shape| (shape, complex_kind(Quotient::Subspaces)));
        let complex = complex.map(|shape| (shape, complex_kind(Quotient::Frames)));
        let frames = frames.into_iter().chain(squares);
        let frames = frames.map(|shape| (shape, Kind::REAL_FRAMES));
        let spans = spans.map(|shape| (shape, Kind::real(Quotient::Subspaces)));
        let all = frames.chain(spans).chain(complex).chain(complex_spans);
        for ((r, k), kind) in all {
            for (tension, share) in [(0.0, 0.0), (0.7, 0.0), (0.0, 0.1), (0.7, 0.1)] {
                // Square real matrices are frames of one column less with the last one.
                let columns = match kind.field {
                    ScalarField::Real => k.min(r - 1),
                    ScalarField::Complex => k,
                };
                let shape = Shape {
                    r,
                    k: columns,
                    kind,
                };
                let all = in_space!(shape, |space| derivatives(space, k, tension));
                let identity: Mat<f64> = Mat::identity(r, r);
                let skewed = |i: usize, j: usize| share * (1.0 + (3 * i + 5 * j) as f64).sin();
                let (all, basis) = match kind.field {
                    ScalarField::Real => (all, &identity + Mat::from_fn(r, r, skewed)),
                    ScalarField::Complex => {
                        let skewed = |i, j| c64::new(skewed(i, j), skewed(j + 2, i));
                        let basis = &identity + embed(Mat::from_fn(r / 2, r / 2, skewed).as_ref());
                        let order = RowOrder { r, k };
                        let all = all.map(|a| order.halves(a.as_ref()));
                        (
                            all,
                            if share > 0.0 {
                                in_blocks(&basis, k)
                            } else {
                                basis
                            },
                        )
                    }
                };
                let gram = basis.transpose() * &basis;
                let inverse = PartialPivLu::new(basis.as_ref()).solve(&identity);
                let entries = || (0..r * r).map(|i| gram[(i / r, i % r)]).collect();
                let equation = Embedded {
                    r,
                    k,
                    kind,
                    tension,
                    gram: (share > 0.0).then(entries),
                };
                let s = [0, 1, 2, 3].map(|level| lanes(&(&inverse * &all[level])));
                let s = s.each_ref().map(|s| &s[..equation.size()]);
                let mut found = vec![Lanes::ZERO; equation.size()];
                let mut buffers = EquationBuffers::default();
                buffers.resize(&equation);
                equation.fourth_derivative_into(s, &mut buffers, &mut found);
                let found: Vec<f64> = found.iter().map(|x| x.0[5]).collect();
                let found = equation.all_columns(&found);
                let found = &basis * MatRef::from_column_major_slice(&found, r, k);
                let (error, size) = ((found - &all[4]).norm_max(), all[4].norm_max());
                let name = format!("({r}, {k}) {kind:?} {tension} {share}");
                assert!(
                    error < 1e-14 * (1.0 + size),
                    "{name}: {error:e} of {size:e}"
                );
            }
        }
    }
}
