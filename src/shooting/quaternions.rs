//! Unit quaternions in place of rotations in space: how far a leg turns from its start to its end, and its frames about the middle.

use crate::linalg::field::Field;
use crate::space::axis;

/// How far a leg turns from `-s` to `s`, `y(s) = p(-s)^{-1} p(s)` for the quaternion `p` of its frame, as a Taylor series.
///
/// Since `y(-s)` is the inverse of `y(s)`, its scalar part `e` has even powers only, its vector part `o` odd ones; with the even and
/// the odd part of `x`
///
/// ```math
/// e' = -x_{even} \cdot o,\qquad o' = e\,x_{even} + o \times x_{odd}
/// ```
///
/// which takes a quarter of the products of the series of `p`.
#[derive(Clone)]
pub(super) struct Turn<T> {
    /// Of the powers 0, 2, 4, ...
    scalars: Vec<T>,
    /// Of the powers 1, 3, 5, ...
    vectors: Vec<[T; 3]>,
}

impl<T: Field> Turn<T> {
    /// Room for series up to an odd power.
    pub(super) fn new(power: usize) -> Self {
        let count = power.div_ceil(2);
        Turn {
            scalars: vec![T::ZERO; count],
            vectors: vec![[T::ZERO; 3]; count],
        }
    }

    /// Up to the given number of powers of each kind, from coefficients of `x` as skew matrices, of which there may be fewer.
    #[inline(always)]
    pub(super) fn set(&mut self, x: &[T], count: usize) {
        self.scalars[0] = T::constant(1.0);
        for i in 0..count {
            if i > 0 {
                let sum = self.dots(x, i);
                self.scalars[i] = sum * (-1.0 / (2 * i) as f64);
            }
            let sum = self.products(x, i);
            let factor = 1.0 / (2 * i + 1) as f64;
            self.vectors[i] = sum.map(
                #[inline(always)]
                |x| x * factor,
            );
        }
    }

    /// `x_even . o` of power `2 i - 1`.
    #[inline(always)]
    fn dots(&self, x: &[T], i: usize) -> T {
        let mut sums = [T::ZERO; 3];
        let evens = x.chunks(18);
        for (x, o) in evens.zip(self.vectors[..i].iter().rev()) {
            for (sum, (x, o)) in sums.iter_mut().zip(axis(x).into_iter().zip(o)) {
                *sum += x * *o;
            }
        }
        sums[0] + sums[1] + sums[2]
    }

    /// `e x_even + o x x_odd` of power `2 i`.
    #[inline(always)]
    fn products(&self, x: &[T], i: usize) -> [T; 3] {
        let mut sums = [T::ZERO; 3];
        let evens = x.chunks(18);
        for (x, e) in evens.zip(self.scalars[..=i].iter().rev()) {
            for (sum, x) in sums.iter_mut().zip(axis(x)) {
                *sum += x * *e;
            }
        }
        let odds = x[9..].chunks(18);
        for (x, [ox, oy, oz]) in odds.zip(self.vectors[..i].iter().rev()) {
            let [x, y, z] = axis(x);
            sums[0] += *oy * z;
            sums[1] += *oz * x;
            sums[2] += *ox * y;
            sums[0] -= *oz * y;
            sums[1] -= *ox * z;
            sums[2] -= *oy * x;
        }
        sums
    }

    /// The unit quaternion from the start of the leg to its end.
    #[inline(always)]
    pub(super) fn of_leg(&self, count: usize) -> [T; 4] {
        let (mut scalar, mut vector) = (T::ZERO, [T::ZERO; 3]);
        let mut weight = 1.0;
        for (e, o) in self.scalars.iter().zip(&self.vectors).take(count) {
            scalar += *e * weight;
            for (sum, o) in vector.iter_mut().zip(o) {
                *sum += *o * (0.5 * weight);
            }
            weight *= 0.25;
        }
        let [x, y, z] = vector;
        [scalar, x, y, z]
    }

    /// The largest entry of what the last two terms contribute to it.
    #[inline(always)]
    pub(super) fn tail(&self, count: usize) -> T {
        let power = 2 * count - 1;
        let weight = 0.5_f64.powi(power as i32);
        let mut tail = T::ZERO.larger(self.scalars[count - 1] * (2.0 * weight));
        for x in self.vectors[count - 1] {
            tail = tail.larger(x * weight);
        }
        tail
    }
}

/// Coefficients of the quaternion of the frame, which is 1 in the middle, up to a power, from those of `x` as skew matrices:
/// `p' = p x / 2`.
#[inline(always)]
pub(super) fn set_frames<T: Field>(x: &[T], power: usize, out: &mut [[T; 4]]) {
    let (zero, one) = (T::ZERO, T::constant(1.0));
    out[0] = [one, zero, zero, zero];
    for k in 0..power {
        let mut sums = [T::ZERO; 4];
        let late = x[..(k + 1) * 9].chunks_exact(9).rev();
        for (p, x) in out[..=k].iter().zip(late) {
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
        for (p, sum) in out[k + 1].iter_mut().zip(sums) {
            *p = sum * factor;
        }
    }
}

/// The value of a series of quaternions.
#[inline(always)]
pub(super) fn value<T: Field>(coefficients: &[[T; 4]], s: f64) -> [T; 4] {
    let mut sum = [T::ZERO; 4];
    let mut power = 1.0;
    for c in coefficients {
        for (sum, c) in sum.iter_mut().zip(c) {
            *sum += *c * power;
        }
        power *= s;
    }
    sum
}

/// `a^{-1} b` for unit quaternions.
#[inline(always)]
pub(super) fn relative<T: Field>(a: &[T; 4], b: &[T; 4]) -> [T; 4] {
    [
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3],
        a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
        a[0] * b[2] - a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
        a[0] * b[3] - a[3] * b[0] - a[1] * b[2] + a[2] * b[1],
    ]
}

/// The rotation of a unit quaternion.
#[inline(always)]
pub(super) fn write_rotation<T: Field>([w, x, y, z]: [T; 4], out: &mut [T]) {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The turn of a leg beside its frames at both ends, with coefficients of `x` that have nothing to do with a curve.
    #[test]
    fn the_turn_is_that_between_the_frames_at_both_ends() {
        let (count, power) = (12, 23);
        let mut x = vec![0.0; 24 * 9];
        for (k, x) in x.chunks_exact_mut(9).enumerate() {
            let [a, b, c] =
                [1.0, 2.0, 3.0].map(|i: f64| (1.7 * k as f64 + i).sin() * 0.5_f64.powi(k as i32));
            (x[7], x[2], x[3]) = (a, b, c);
            (x[5], x[6], x[1]) = (-a, -b, -c);
        }
        let mut turn = Turn::new(power);
        turn.set(&x, count);
        let mut frames = vec![[0.0; 4]; power + 1];
        set_frames(&x, power, &mut frames);
        let wanted = relative(&value(&frames, -0.5), &value(&frames, 0.5));
        for (found, wanted) in turn.of_leg(count).into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-13, "{found} {wanted}");
        }
    }
}
