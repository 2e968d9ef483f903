//! Taylor coefficients of Riemannian cubics: block sizes and storage.

use super::embedding::Embedding;
use crate::linalg::dual::Number;
use crate::space::{Homogeneous, Kind, Quotient, ScalarField, Shape, in_space};

/// Sizes of the blocks: `omega` is `(k, k)`, `b` is `(m, k)`, `s` is `(r, k)`, `e` is `(r, m)`.
///
/// Zero rows at the end of `b`, `s` and `e`, and zero columns of `e`, are harmless padding that fills vector registers.
pub(crate) trait BlockSizes: Copy + Send + Sync {
    /// Whether the compiler knows the sizes and unrolls the loops over them.
    const UNROLLED: bool;

    fn k(self) -> usize;

    /// Rows of `b`, including padding.
    fn m<T: Number>(self) -> usize;

    /// Rows of `s` and `e`, including padding.
    fn r<T: Number>(self) -> usize;

    /// Rows of `b`, without padding.
    fn normals(self) -> usize;

    /// Whether `omega` is identically zero; `omega''` then holds the term that keeps the columns from rotating.
    fn are_subspaces(self) -> bool;

    /// Whether the blocks are those of embedded complex matrices: the second half of the columns of each follows from
    /// the first half. Rows of `s` and `e` are then in the order of the frame's columns.
    fn are_complex(self) -> bool;

    /// Conversion between complex and real coordinates of vectors.
    fn embedding(self) -> Option<Embedding>;

    /// Ratio of the squared length of a real vector to the sum of its squared coordinates.
    fn weight(self) -> f64 {
        match self.are_complex() {
            // Every entry occurs twice.
            true => 2.0,
            false => 1.0,
        }
    }
}

/// Sizes known at compile time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FixedSizes<const M: usize, const K: usize>;

impl<const M: usize, const K: usize> BlockSizes for FixedSizes<M, K> {
    const UNROLLED: bool = true;

    #[inline(always)]
    fn k(self) -> usize {
        K
    }
    #[inline(always)]
    fn m<T: Number>(self) -> usize {
        M
    }
    #[inline(always)]
    fn r<T: Number>(self) -> usize {
        (M + K).next_multiple_of(T::WIDTH)
    }
    #[inline(always)]
    fn normals(self) -> usize {
        M
    }
    #[inline(always)]
    fn are_subspaces(self) -> bool {
        false
    }
    #[inline(always)]
    fn are_complex(self) -> bool {
        false
    }
    fn embedding(self) -> Option<Embedding> {
        None
    }
}

/// Sizes known at run time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    /// Rows of `b`, without padding.
    pub(crate) m: usize,
    pub(crate) k: usize,
    pub(crate) quotient: Quotient,
    /// Scalars of the coordinates of vectors; the blocks are real, or embedded complex ones.
    pub(crate) field: ScalarField,
}

impl Sizes {
    /// Sizes of the blocks of frames.
    pub(crate) fn frames(m: usize, k: usize) -> Self {
        Sizes::new(m, k, Quotient::Frames)
    }

    /// Sizes of blocks with real coordinates.
    pub(crate) fn new(m: usize, k: usize, quotient: Quotient) -> Self {
        Sizes {
            m,
            k,
            quotient,
            field: ScalarField::Real,
        }
    }

    /// Sizes of blocks with coordinates over the field of a kind.
    pub(crate) fn of_kind(m: usize, k: usize, kind: Kind) -> Self {
        let Kind { quotient, field } = kind;
        Sizes {
            m,
            k,
            quotient,
            field,
        }
    }

    /// The squared length of the real vector with the given coordinates.
    pub(crate) fn square(self, v: &[f64]) -> f64 {
        self.weight() * v.iter().map(|x| x * x).sum::<f64>()
    }

    /// The space.
    pub(crate) fn shape(self) -> Shape {
        Shape {
            r: self.m + self.k,
            k: self.k,
            kind: self.kind(),
        }
    }

    /// The meaning and the scalars of the matrices.
    pub(crate) fn kind(self) -> Kind {
        let Sizes {
            quotient, field, ..
        } = self;
        Kind { quotient, field }
    }

    /// Number of coordinates of a vector: independent entries of `omega` and `b`.
    pub(crate) fn dim(self) -> usize {
        in_space!(self.shape(), |space| space.dim())
    }
}

impl BlockSizes for Sizes {
    const UNROLLED: bool = false;

    #[inline(always)]
    fn k(self) -> usize {
        self.k
    }
    #[inline(always)]
    fn m<T: Number>(self) -> usize {
        self.m.next_multiple_of(T::WIDTH)
    }
    #[inline(always)]
    fn r<T: Number>(self) -> usize {
        (self.m + self.k).next_multiple_of(T::WIDTH)
    }
    #[inline(always)]
    fn normals(self) -> usize {
        self.m
    }
    #[inline(always)]
    fn are_subspaces(self) -> bool {
        self.quotient == Quotient::Subspaces
    }
    #[inline(always)]
    fn are_complex(self) -> bool {
        self.field == ScalarField::Complex
    }
    fn embedding(self) -> Option<Embedding> {
        self.are_complex().then(|| Embedding::new(self.shape()))
    }
}

/// Taylor coefficients of `(s, e)` and of `x, x', x''`; the blocks of each quantity are stored one after another, by
/// columns.
#[derive(Debug, Clone)]
pub(crate) struct BlockSeries<T> {
    /// All quantities, in the order of [`SeriesParts`], in a single allocation.
    entries: Vec<T>,
    lengths: [usize; PARTS],
    /// `tau` of the additional term `tau x'` in `x'''` of a cubic in tension.
    pub(crate) tension: Option<T>,
}

const PARTS: usize = 16;

/// The quantities of a [`BlockSeries`].
pub(crate) struct SeriesParts<'a, T> {
    pub(crate) s: &'a mut [T],
    pub(crate) e: &'a mut [T],
    /// Coefficients of `omega, omega', omega''`.
    pub(crate) omega: [&'a mut [T]; 3],
    /// Coefficients of `b, b', b''`.
    pub(crate) b: [&'a mut [T]; 3],
    /// Coefficients of `b^T b`.
    pub(crate) p: &'a mut [T],
    /// Coefficients of `b'^T b`.
    pub(crate) n: &'a mut [T],
    /// Coefficients of `n - omega''`.
    pub(crate) q: &'a mut [T],
    /// Coefficients of `b` and `omega`, from the highest order down; used if the sums of the blocks [are few](are_few).
    pub(crate) b_down: &'a mut [T],
    pub(crate) omega_down: &'a mut [T],
    pub(crate) square: &'a mut [T],
    pub(crate) tall: &'a mut [T],
    pub(crate) frame: &'a mut [T],
    pub(crate) tension: Option<T>,
}

impl<T: Number> BlockSeries<T> {
    /// Zero coefficients up to the given order.
    pub(crate) fn zeros(blocks: impl BlockSizes, order: usize) -> Self {
        let (r, m, k) = (blocks.r::<T>(), blocks.m::<T>(), blocks.k());
        let series = |block: usize| block * (order + 1);
        let (square, tall) = (series(k * k), series(m * k));
        let few = are_few::<T, _>(blocks);
        let lengths = [
            series(r * k),
            series(r * m),
            square,
            square,
            square,
            tall,
            tall,
            tall,
            square,
            square,
            square,
            if few { tall } else { 0 },
            if few { square } else { 0 },
            k * k,
            m * k,
            r * m.max(k),
        ];
        BlockSeries {
            entries: vec![T::ZERO; lengths.iter().sum()],
            lengths,
            tension: None,
        }
    }

    /// Sets the tension of the curve; 0 for a cubic.
    pub(crate) fn set_tension(&mut self, tension: f64) {
        self.tension = (tension != 0.0).then(|| T::constant(tension));
    }

    #[inline(always)]
    pub(crate) fn parts(&mut self) -> SeriesParts<'_, T> {
        let mut rest = self.entries.as_mut_slice();
        let [
            s,
            e,
            o0,
            o1,
            o2,
            b0,
            b1,
            b2,
            p,
            n,
            q,
            b_down,
            omega_down,
            square,
            tall,
            frame,
        ] = self
            .lengths
            .map(|length| rest.split_off_mut(..length).expect("lengths add up"));
        SeriesParts {
            s,
            e,
            omega: [o0, o1, o2],
            b: [b0, b1, b2],
            p,
            n,
            q,
            b_down,
            omega_down,
            square,
            tall,
            frame,
            tension: self.tension,
        }
    }

    pub(crate) fn s(&self) -> &[T] {
        self.part(0)
    }

    pub(crate) fn e(&self) -> &[T] {
        self.part(1)
    }

    /// Coefficients of `omega` or a derivative.
    pub(crate) fn omega(&self, derivative: usize) -> &[T] {
        self.part(2 + derivative)
    }

    /// Coefficients of `b` or a derivative.
    pub(crate) fn b(&self, derivative: usize) -> &[T] {
        self.part(5 + derivative)
    }

    #[inline(always)]
    fn part(&self, which: usize) -> &[T] {
        let start = self.lengths[..which].iter().sum();
        &self.entries[start..][..self.lengths[which]]
    }
}

/// Whether all Cauchy sums of one order fit into registers.
#[inline(always)]
pub(crate) fn are_few<T: Number, B: BlockSizes>(blocks: B) -> bool {
    let (r, m, k) = (blocks.r::<T>(), blocks.m::<T>(), blocks.k());
    B::UNROLLED && m > 0 && r * k.max(m) <= T::REGISTERS && m * k * k <= T::REGISTERS
}

/// Range of the block of order `j`.
#[inline(always)]
pub(crate) fn block(j: usize, size: usize) -> std::ops::Range<usize> {
    j * size..(j + 1) * size
}
