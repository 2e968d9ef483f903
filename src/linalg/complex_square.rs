//! Square complex buffers, stored as two real ones: real and imaginary part.
//!
//! The loops are those of real buffers, applied to both parts. A product takes three real products (Gauss), of which
//! only half is computed if it is known to be Hermitian or skew-Hermitian. For small sizes, where products do not
//! dominate the cost, it takes four.
//!
//! # Source
//! Products from three real ones, and their normwise stability: Higham (1992), SIAM J. Matrix Anal. Appl. 13, 681-687.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::prelude::*;
use faer::{Accum, MatMut, MatRef, Par, c64};

use super::simd::vectorised;
use super::square::{LANES, Square, Symmetry, Tile, transposed};
use super::structure::{SAFE_SQUARES, norm};

/// Size from which a product takes three real ones.
const THREE: usize = 24;

/// `sqrt(2) - 1`.
const DIAGONAL: f64 = std::f64::consts::SQRT_2 - 1.0;

/// `m x m`: the real part and the imaginary part.
pub struct ComplexSquare {
    pub(super) parts: [Square; 2],
}

/// Buffers for products of one size.
pub struct Scratch {
    sums: [Square; 2],
    products: [Square; 2],
}

impl Scratch {
    pub(crate) fn new(m: usize) -> Self {
        let size = if m < THREE { 0 } else { m };
        let two = || [Square::new(size), Square::new(size)];
        Scratch {
            sums: two(),
            products: two(),
        }
    }
}

/// A factor of a product, or its adjoint.
#[derive(Clone, Copy)]
pub(crate) struct Factor<'a> {
    square: &'a ComplexSquare,
    adjoint: bool,
}

impl<'a> Factor<'a> {
    fn views(self) -> [MatRef<'a, f64>; 2] {
        let views = self.square.parts.each_ref().map(Square::view);
        self.turned(views)
    }

    fn turned<const N: usize>(self, views: [MatRef<'a, f64>; N]) -> [MatRef<'a, f64>; N] {
        if self.adjoint {
            views.map(MatRef::transpose)
        } else {
            views
        }
    }

    /// Sign of the imaginary part.
    fn sign(self) -> f64 {
        if self.adjoint { -1.0 } else { 1.0 }
    }

    /// Writes real part plus imaginary part, before transposition.
    fn write_sum(self, sum: &mut Square) {
        let [re, im] = &self.square.parts;
        let (sign, sum) = (self.sign(), sum.lanes_mut());
        vectorised(
            #[inline(always)]
            || {
                for ((sum, re), im) in sum.iter_mut().zip(re.lanes()).zip(im.lanes()) {
                    for l in 0..LANES {
                        sum[l] = re[l] + sign * im[l];
                    }
                }
            },
        );
    }
}

impl ComplexSquare {
    pub(crate) fn new(m: usize) -> Self {
        ComplexSquare {
            parts: [Square::new(m), Square::new(m)],
        }
    }

    /// The matrix as a factor of a product.
    pub(crate) fn factor(&self) -> Factor<'_> {
        Factor {
            square: self,
            adjoint: false,
        }
    }

    /// The adjoint as a factor of a product.
    pub(crate) fn adjoint(&self) -> Factor<'_> {
        Factor {
            square: self,
            adjoint: true,
        }
    }

    pub(crate) fn get(&self, i: usize, j: usize) -> c64 {
        c64::new(self.parts[0].col(j)[i], self.parts[1].col(j)[i])
    }

    pub(crate) fn set(&mut self, i: usize, j: usize, x: c64) {
        self.parts[0].col_mut(j)[i] = x.re;
        self.parts[1].col_mut(j)[i] = x.im;
    }

    /// The largest absolute value of a real or an imaginary part.
    pub(crate) fn largest_part(&self) -> f64 {
        let entries = self
            .parts
            .iter()
            .flat_map(|part| part.lanes().as_flattened());
        entries.fold(0.0, |largest: f64, x| largest.max(x.abs()))
    }

    /// Copies a matrix of the same size.
    pub(crate) fn read(&mut self, a: MatRef<'_, c64>) {
        let [re, im] = &mut self.parts;
        for j in 0..a.ncols() {
            let (re, im) = (re.col_mut(j), im.col_mut(j));
            for i in 0..a.nrows() {
                (re[i], im[i]) = (a[(i, j)].re, a[(i, j)].im);
            }
        }
    }

    /// Copies into `out`, of the same size.
    pub(crate) fn write(&self, mut out: MatMut<'_, c64>) {
        let [re, im] = &self.parts;
        for j in 0..out.ncols() {
            let entries = re.col(j).iter().zip(im.col(j));
            match out.rb_mut().col_mut(j).try_as_col_major_mut() {
                Some(target) => {
                    for (target, (re, im)) in target.as_slice_mut().iter_mut().zip(entries) {
                        *target = c64::new(*re, *im);
                    }
                }
                None => {
                    for (i, (re, im)) in entries.enumerate() {
                        out[(i, j)] = c64::new(*re, *im);
                    }
                }
            }
        }
    }

    /// `alpha (A - A^H) / 2`, halved first, so that no intermediate result overflows; returns the sum of squares of
    /// `(A + A^H) / 2`.
    pub(crate) fn set_skew_part(&mut self, alpha: f64, a: MatRef<'_, c64>) -> f64 {
        let mut squares = [0.0; LANES];
        let [re, im] = &mut self.parts;
        vectorised(
            #[inline(always)]
            || {
                for j in 0..re.tiles() {
                    for i in j..re.tiles() {
                        let below = tiles_of(a, i, j);
                        let above = tiles_of(a, j, i).map(|tile| transposed(&tile));
                        // An off-diagonal tile counts twice.
                        let weight = if i == j { 1.0 } else { 2.0 };
                        let mut skew = [[[0.0; LANES]; LANES]; 2];
                        for c in 0..LANES {
                            for l in 0..LANES {
                                let (x, y) = (0.5 * below[0][c][l], 0.5 * above[0][c][l]);
                                let (u, v) = (0.5 * below[1][c][l], 0.5 * above[1][c][l]);
                                skew[0][c][l] = alpha * (x - y);
                                skew[1][c][l] = alpha * (u + v);
                                squares[l] += weight * ((x + y) * (x + y) + (u - v) * (u - v));
                            }
                        }
                        re.set_tile(i, j, &skew[0]);
                        im.set_tile(i, j, &skew[1]);
                        if i > j {
                            let opposite = transposed(&skew[0]).map(|column| column.map(|x| -x));
                            re.set_tile(j, i, &opposite);
                            im.set_tile(j, i, &transposed(&skew[1]));
                        }
                    }
                }
            },
        );
        squares.iter().sum()
    }

    /// `(A - A^H) / 2`.
    pub(crate) fn set_skew_part_of(&mut self, a: &ComplexSquare) {
        self.parts[0].set_skew_part(1.0, a.parts[0].view());
        self.parts[1].set_symmetric_part(&a.parts[1]);
    }

    /// A bound on the largest column sum of moduli, at most 9 percent above it, and the Frobenius norm.
    pub(crate) fn norms(&self) -> (f64, f64) {
        let (mut largest_sum, mut squares) = (0.0_f64, [0.0; LANES]);
        let [re, im] = &self.parts;
        let tiles = re.tiles().max(1);
        vectorised(
            #[inline(always)]
            || {
                let columns = re.lanes().chunks_exact(tiles);
                for (re, im) in columns.zip(im.lanes().chunks_exact(tiles)) {
                    let mut sums = [0.0; LANES];
                    for (re, im) in re.iter().zip(im) {
                        for l in 0..LANES {
                            let (x, y) = (re[l].abs(), im[l].abs());
                            let (large, small) = if x > y { (x, y) } else { (y, x) };
                            sums[l] += large + DIAGONAL * small;
                            squares[l] += x * x + y * y;
                        }
                    }
                    largest_sum = largest_sum.max(sums.iter().sum());
                }
            },
        );
        let square: f64 = squares.iter().sum();
        // If squares overflow or underflow, use the slow, scaled sum.
        let frobenius = if SAFE_SQUARES.contains(&square) {
            square.sqrt()
        } else {
            norm(re.view()).hypot(norm(im.view()))
        };
        (largest_sum, frobenius)
    }

    /// `alpha A B`, optionally added.
    pub(crate) fn multiply(
        &mut self,
        beta: Accum,
        alpha: f64,
        a: Factor<'_>,
        b: Factor<'_>,
        scratch: &mut Scratch,
    ) {
        self.product(false, beta, alpha, a, b, scratch);
    }

    /// `alpha A B` (optionally added), known to be Hermitian or skew-Hermitian. The part above the diagonal is only
    /// defined after calling `reflect_product`.
    pub(crate) fn set_product(
        &mut self,
        beta: Accum,
        alpha: f64,
        a: Factor<'_>,
        b: Factor<'_>,
        scratch: &mut Scratch,
    ) {
        let half = self.parts[0].halves_products();
        self.product(half, beta, alpha, a, b, scratch);
    }

    fn product(
        &mut self,
        half: bool,
        beta: Accum,
        alpha: f64,
        a: Factor<'_>,
        b: Factor<'_>,
        scratch: &mut Scratch,
    ) {
        let ([a_re, a_im], [b_re, b_im]) = (a.views(), b.views());
        let [re, im] = &mut self.parts;
        let signed = alpha * a.sign() * b.sign();
        if a_re.ncols() < THREE {
            let add = Accum::Add;
            real_product(re, half, beta, alpha, a_re, b_re);
            real_product(re, half, add, -signed, a_im, b_im);
            real_product(im, half, beta, alpha * b.sign(), a_re, b_im);
            return real_product(im, half, add, alpha * a.sign(), a_im, b_re);
        }
        let Scratch { sums, products } = scratch;
        a.write_sum(&mut sums[0]);
        let mut same = false;
        if std::ptr::eq(a.square, b.square) && a.adjoint == b.adjoint {
            same = true;
        } else {
            b.write_sum(&mut sums[1]);
        }
        let [a_sum] = a.turned([sums[0].view()]);
        let [b_sum] = b.turned([sums[usize::from(!same)].view()]);
        let [first, second] = products;
        real_product(first, half, Accum::Replace, alpha, a_re, b_re);
        real_product(second, half, Accum::Replace, signed, a_im, b_im);
        real_product(im, half, beta, alpha, a_sum, b_sum);
        let old = if beta == Accum::Replace { 0.0 } else { 1.0 };
        vectorised(
            #[inline(always)]
            || {
                let targets = re.lanes_mut().iter_mut().zip(im.lanes_mut());
                let terms = first.lanes().iter().zip(second.lanes());
                for ((re, im), (x, y)) in targets.zip(terms) {
                    for l in 0..LANES {
                        re[l] = old * re[l] + (x[l] - y[l]);
                        im[l] -= x[l] + y[l];
                    }
                }
            },
        );
    }

    /// Fills the part above the diagonal from the part below, after a product of which only half was computed.
    pub(crate) fn reflect_product(&mut self, symmetry: Symmetry) {
        if self.parts[0].halves_products() {
            self.reflect(symmetry);
        }
    }

    /// Fills the part above the diagonal of a Hermitian or skew-Hermitian matrix from the part below.
    pub(crate) fn reflect(&mut self, symmetry: Symmetry) {
        let opposite = match symmetry {
            Symmetry::Symmetric => Symmetry::Skew,
            Symmetry::Skew => Symmetry::Symmetric,
        };
        self.parts[0].reflect(symmetry);
        self.parts[1].reflect(opposite);
    }

    /// `self = E + T` from the lower triangles of the Hermitian `E` (in `self`) and the skew-Hermitian `T`.
    pub(crate) fn add_skew(&mut self, skew: &ComplexSquare) {
        self.parts[0].add_skew(&skew.parts[0]);
        // The imaginary part of E is skew, and the imaginary part of T is symmetric.
        add_opposite(&mut self.parts[1], &skew.parts[1]);
    }
}

/// `alpha A B`, or half of it.
fn real_product(
    out: &mut Square,
    half: bool,
    beta: Accum,
    alpha: f64,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
) {
    if !half {
        return matmul(out.view_mut(), beta, a, b, alpha, Par::Seq);
    }
    triangular::matmul(
        out.view_mut(),
        BlockStructure::TriangularLower,
        beta,
        a,
        BlockStructure::Rectangular,
        b,
        BlockStructure::Rectangular,
        alpha,
        Par::Seq,
    );
}

/// `out = K + S` from the lower triangles of the skew `K` (in `out`) and the symmetric `S`.
fn add_opposite(out: &mut Square, symmetric: &Square) {
    vectorised(
        #[inline(always)]
        || {
            for j in 0..out.tiles() {
                for i in j..out.tiles() {
                    let (skew, other) = (out.tile(i, j), symmetric.tile(i, j));
                    let (mut sum, mut difference) = (other, other);
                    for c in 0..LANES {
                        for l in 0..LANES {
                            sum[c][l] = other[c][l] + skew[c][l];
                            difference[c][l] = other[c][l] - skew[c][l];
                        }
                    }
                    if i > j {
                        out.set_tile(i, j, &sum);
                        out.set_tile(j, i, &transposed(&difference));
                        continue;
                    }
                    for c in 0..LANES {
                        sum[c][c] = other[c][c];
                        for l in c + 1..LANES {
                            sum[l][c] = difference[c][l];
                        }
                    }
                    out.set_tile(j, j, &sum);
                }
            }
        },
    );
}

/// Real and imaginary part of a tile of a matrix, padded with zeros.
#[inline(always)]
fn tiles_of(a: MatRef<'_, c64>, i: usize, j: usize) -> [Tile; 2] {
    let (top, left) = (i * LANES, j * LANES);
    let height = LANES.min(a.nrows() - top);
    let mut tiles = [[[0.0; LANES]; LANES]; 2];
    let [re, im] = &mut tiles;
    for c in 0..LANES.min(a.ncols() - left) {
        match a.col(left + c).try_as_col_major() {
            Some(column) => {
                let source = &column.as_slice()[top..top + height];
                for (l, x) in source.iter().enumerate() {
                    (re[c][l], im[c][l]) = (x.re, x.im);
                }
            }
            None => {
                for l in 0..height {
                    let x = a[(top + l, left + c)];
                    (re[c][l], im[c][l]) = (x.re, x.im);
                }
            }
        }
    }
    tiles
}
