//! Taylor series of a leg about its middle.

use crate::linalg::field::{Field, transposed_multiply};
use crate::space::Homogeneous;

/// Coefficients of `x` and of the frame `g` in powers of `s`, the time from the middle of the leg.
#[derive(Clone)]
pub(super) struct Series<T> {
    /// Coordinates, `order + 3` vectors, and the same as skew matrices.
    pub(super) x: Vec<T>,
    pub(super) matrices: Vec<T>,
    /// Those of `x''`.
    seconds: Vec<T>,
    /// Of `[x, x']_h`, coordinates in `h`.
    pub(super) isotropy: Vec<T>,
    /// Matrices row by row, as many.
    pub(super) frames: Vec<T>,
}

/// Values of vectors or matrices at both ends of a leg.
pub(super) type AtEnds<'a, T> = [&'a mut [T]; 2];

impl<T: Field> Series<T> {
    /// Room for series up to an order.
    pub(super) fn new(space: impl Homogeneous, order: usize) -> Self {
        let (d, h, square) = (
            space.dim(),
            space.isotropy_dim(),
            space.size() * space.size(),
        );
        Series {
            x: vec![T::ZERO; (order + 3) * d],
            matrices: vec![T::ZERO; (order + 3) * square],
            seconds: vec![T::ZERO; (order + 1) * square],
            isotropy: vec![T::ZERO; order * h],
            frames: vec![T::ZERO; (order + 3) * square],
        }
    }

    /// Those of `x` up to an order, from `x, x', x''` in the middle, and the tension of the curve.
    #[inline(always)]
    pub(super) fn set_curve(
        &mut self,
        space: impl Homogeneous,
        middle: [&[T]; 3],
        tension: Option<T>,
        order: usize,
    ) {
        let (d, h, square) = (
            space.dim(),
            space.isotropy_dim(),
            space.size() * space.size(),
        );
        for (k, (x, factor)) in middle.into_iter().zip([1.0, 1.0, 0.5]).enumerate() {
            for p in 0..d {
                self.x[k * d + p] = x[p] * factor;
            }
            self.set_matrix(space, k);
        }
        for k in 0..order {
            if h > 0 {
                self.set_isotropy(space, k);
            }
            let (known, next) = self.x.split_at_mut((k + 3) * d);
            let next = &mut next[..d];
            let late = self.seconds.chunks_exact(square).take(k + 1);
            let early = self.matrices[..(k + 1) * square].chunks_exact(square);
            let pairs = late.zip(early.rev());
            if space.size() == 3 {
                let product = cross_products(pairs);
                space.each_entry(
                    #[inline(always)]
                    |p, i, j| next[p] = product[i * 3 + j],
                );
            } else {
                space.each_entry(
                    #[inline(always)]
                    |p, i, j| {
                        let mut sum = T::ZERO;
                        for (late, early) in pairs.clone() {
                            sum += space.commutator_entry(late, early, [i, j]);
                        }
                        next[p] = sum;
                    },
                );
            }
            if h > 0 {
                for i in 0..=k {
                    let z = &self.isotropy[i * h..];
                    space.subtract_action(z, &self.matrices[(k - i) * square..], next);
                }
            }
            if let Some(tension) = tension {
                for (next, x) in next.iter_mut().zip(&known[(k + 1) * d..]) {
                    *next += tension * *x * (k + 1) as f64;
                }
            }
            let factor = 1.0 / ((k + 3) * (k + 2) * (k + 1)) as f64;
            for x in next {
                *x = *x * factor;
            }
            self.set_matrix(space, k + 3);
        }
    }

    /// Those of the frames up to a power, after those of `x`.
    #[inline(always)]
    pub(super) fn set_frames(&mut self, space: impl Homogeneous, power: usize) {
        let r = space.size();
        let square = r * r;
        self.frames[..square].fill(T::ZERO);
        for i in 0..r {
            self.frames[i * r + i] = T::constant(1.0);
        }
        for k in 0..power {
            let (known, next) = self.frames.split_at_mut((k + 1) * square);
            add_product_of_series(space, known, &self.matrices, next);
            let factor = 1.0 / (k + 1) as f64;
            for entry in &mut next[..square] {
                *entry = *entry * factor;
            }
        }
    }

    /// The frame at the last end relative to that at the first, after the series of `x`.
    #[inline(always)]
    pub(super) fn reached_into(&mut self, space: impl Homogeneous, order: usize, out: &mut [T]) {
        let r = space.size();
        let square = r * r;
        if r == 3 {
            self.set_quaternions(order);
            let [mut first, mut last] = [[T::ZERO; 4]; 2];
            let quaternions = &self.frames[..(order + 1) * 4];
            at_ends(quaternions, 4, 0, [&mut first, &mut last]);
            return write_rotation(relative(&first, &last), out);
        }
        self.set_frames(space, order);
        let (mut first, mut last) = (vec![T::ZERO; square], vec![T::ZERO; square]);
        let frames = &self.frames[..(order + 1) * square];
        at_ends(frames, square, 0, [&mut first, &mut last]);
        transposed_multiply(r, &first, &last, out);
    }

    /// Unit quaternions in place of rotations in space: `p' = p x / 2`.
    #[inline(always)]
    fn set_quaternions(&mut self, order: usize) {
        self.frames[0] = T::constant(1.0);
        self.frames[1..4].fill(T::ZERO);
        for k in 0..order {
            let mut sums = [T::ZERO; 4];
            let known = self.frames[..(k + 1) * 4].chunks_exact(4);
            let late = self.matrices[..(k + 1) * 9].chunks_exact(9).rev();
            for (p, x) in known.zip(late) {
                let [x, y, z] = axis(x);
                sums[0] -= p[1] * x;
                sums[1] += p[0] * x;
                sums[2] += p[0] * y;
                sums[3] += p[0] * z;
                sums[0] -= p[2] * y;
                sums[1] += p[2] * z;
                sums[2] += p[3] * x;
                sums[3] += p[1] * y;
                sums[0] -= p[3] * z;
                sums[1] -= p[3] * y;
                sums[2] -= p[1] * z;
                sums[3] -= p[2] * x;
            }
            let factor = 0.5 / (k + 1) as f64;
            for (p, sum) in self.frames[(k + 1) * 4..].iter_mut().zip(sums) {
                *p = sum * factor;
            }
        }
    }

    /// A coefficient of `x` as a skew matrix, and that of `x''` which it makes.
    #[inline(always)]
    fn set_matrix(&mut self, space: impl Homogeneous, k: usize) {
        let (d, square) = (space.dim(), space.size() * space.size());
        let matrix = &mut self.matrices[k * square..][..square];
        space.matrix_into(&self.x[k * d..], matrix);
        if k >= 2 {
            let factor = (k * (k - 1)) as f64;
            let second = self.seconds[(k - 2) * square..].iter_mut();
            for (second, entry) in second.zip(matrix) {
                *second = *entry * factor;
            }
        }
    }

    /// A coefficient of `[x, x']_h`.
    #[inline(always)]
    fn set_isotropy(&mut self, space: impl Homogeneous, k: usize) {
        let (h, square) = (space.isotropy_dim(), space.size() * space.size());
        let now = &mut self.isotropy[k * h..][..h];
        now.fill(T::ZERO);
        for i in 0..=k {
            let late = &self.matrices[(k - i + 1) * square..];
            let early = &self.matrices[i * square..];
            space.add_isotropy_bracket(early, late, (k - i + 1) as f64, now);
        }
    }

    /// `x` or one of its derivatives at both ends, from `count` coefficients.
    #[inline(always)]
    pub(super) fn at_ends(&self, d: usize, count: usize, derivative: usize, out: AtEnds<'_, T>) {
        at_ends(&self.x[..count * d], d, derivative, out);
    }

    /// The largest entry of what the last two terms contribute to `x'` and to the frame's derivative at the ends, after
    /// [`Series::reached_into`].
    #[inline(always)]
    pub(super) fn tail(&self, space: impl Homogeneous, order: usize) -> T {
        let (d, r) = (space.dim(), space.size());
        let size = if r == 3 { 4 } else { r * r };
        let power = 0.5_f64.powi(order as i32);
        let curve = 0.5 * power * (order + 2) as f64;
        let frame = 2.0 * power * order as f64;
        let mut tail = T::ZERO;
        for x in &self.x[(order + 1) * d..][..2 * d] {
            tail = tail.larger(*x * curve);
        }
        for x in &self.frames[(order - 1) * size..][..2 * size] {
            tail = tail.larger(*x * frame);
        }
        tail
    }
}

/// The sum of `a b - b a` for pairs of skew matrices of size three.
#[inline(always)]
fn cross_products<'a, T: Field>(pairs: impl Iterator<Item = (&'a [T], &'a [T])>) -> [T; 9] {
    let mut sums = [T::ZERO; 3];
    for (a, b) in pairs {
        let ([ax, ay, az], [bx, by, bz]) = (axis(a), axis(b));
        sums[0] += ay * bz;
        sums[1] += az * bx;
        sums[2] += ax * by;
        sums[0] -= az * by;
        sums[1] -= ax * bz;
        sums[2] -= ay * bx;
    }
    let ([x, y, z], zero) = (sums, T::ZERO);
    [zero, -z, y, z, zero, -x, -y, x, zero]
}

/// The axis of a skew matrix of size three.
#[inline(always)]
fn axis<T: Field>(a: &[T]) -> [T; 3] {
    [a[7], a[2], a[3]]
}

/// `a^{-1} b` for unit quaternions.
#[inline(always)]
fn relative<T: Field>(a: &[T; 4], b: &[T; 4]) -> [T; 4] {
    [
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3],
        a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
        a[0] * b[2] - a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
        a[0] * b[3] - a[3] * b[0] - a[1] * b[2] + a[2] * b[1],
    ]
}

/// The rotation of a unit quaternion.
#[inline(always)]
fn write_rotation<T: Field>([w, x, y, z]: [T; 4], out: &mut [T]) {
    let one = T::constant(1.0);
    out[0] = one - (y * y + z * z) * 2.0;
    out[1] = (x * y - w * z) * 2.0;
    out[2] = (x * z + w * y) * 2.0;
    out[3] = (x * y + w * z) * 2.0;
    out[4] = one - (x * x + z * z) * 2.0;
    out[5] = (y * z - w * x) * 2.0;
    out[6] = (x * z - w * y) * 2.0;
    out[7] = (y * z + w * x) * 2.0;
    out[8] = one - (x * x + y * y) * 2.0;
}

/// The value or a derivative at `s = -1/2` and `1/2` of polynomials with the given coefficients, vectors of a size.
#[inline(always)]
pub(super) fn at_ends<T: Field>(
    coefficients: &[T],
    size: usize,
    derivative: usize,
    [first, last]: AtEnds<'_, T>,
) {
    for p in 0..size {
        let mut parts = [T::ZERO; 2];
        let mut weight = 1.0;
        for (k, c) in coefficients.chunks_exact(size).enumerate().skip(derivative) {
            let power = k - derivative;
            let factor = (power + 1..=k).map(|i| i as f64).product::<f64>();
            parts[power % 2] += c[p] * (factor * weight);
            weight *= 0.5;
        }
        let [even, odd] = parts;
        (first[p], last[p]) = (even - odd, even + odd);
    }
}

/// Entries of a row that are summed abreast at most.
const ABREAST: usize = 4;

/// The next coefficient of the product of a series of frames, whose coefficients are all taken, with one of skew matrices of `m`.
#[inline(always)]
fn add_product_of_series<T: Field>(space: impl Homogeneous, frames: &[T], x: &[T], out: &mut [T]) {
    let r = space.size();
    for row in 0..r {
        let mut first = 0;
        while first < r {
            // As many entries of a column of `x` as of a row may differ from zero.
            let inner = space.row_len(first);
            let alike = (first..r).take_while(|column| space.row_len(*column) == inner);
            let count = alike.count().min(ABREAST);
            let shape = [r, inner];
            match count {
                1 => add_entries::<1, T>(shape, frames, x, [row, first], out),
                2 => add_entries::<2, T>(shape, frames, x, [row, first], out),
                3 => add_entries::<3, T>(shape, frames, x, [row, first], out),
                _ => add_entries::<4, T>(shape, frames, x, [row, first], out),
            }
            first += count;
        }
    }
}

/// `N` of its entries in a row, from columns of `x` with so many first entries.
#[inline(always)]
fn add_entries<const N: usize, T: Field>(
    [r, inner]: [usize; 2],
    frames: &[T],
    x: &[T],
    [row, first]: [usize; 2],
    out: &mut [T],
) {
    let square = r * r;
    let mut sums = [T::ZERO; N];
    let late = x[..frames.len()].chunks_exact(square).rev();
    for (frame, x) in frames.chunks_exact(square).zip(late) {
        let entries = &frame[row * r..][..inner];
        for (entry, x) in entries.iter().zip(x.chunks_exact(r)) {
            for (sum, x) in sums.iter_mut().zip(&x[first..][..N]) {
                *sum += *entry * *x;
            }
        }
    }
    out[row * r + first..][..N].copy_from_slice(&sums);
}
