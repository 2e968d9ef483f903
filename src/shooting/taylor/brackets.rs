//! Coefficients of brackets of series: sums over pairs of skew matrices, in row-major order, converted to coordinates.

use std::ops::Mul;

use crate::linalg::dual::Number;
use crate::linalg::field::Field;
use crate::space::{Brackets, Homogeneous, RowProducts, write_row};

/// `out = -(sum weight [x, y])_m`.
#[inline(always)]
pub(crate) fn minus_bracket_into<'a, X, Y>(
    space: impl Homogeneous,
    pairs: impl Iterator<Item = (f64, &'a [X], &'a [Y])> + Clone,
    out: &mut [X],
) where
    X: Field + Mul<Y, Output = X>,
    Y: Number,
{
    if space.is_symmetric() {
        return out.fill(X::ZERO);
    }
    // Coordinates are the negated entries of a row.
    space.each_run(
        #[inline(always)]
        |p, row, column, count| {
            write_bracket(space, pairs.clone(), [row, column], &mut out[p..][..count]);
        },
    );
}

/// `out = (sum weight [x, y])_h`.
#[inline(always)]
pub(crate) fn isotropy_bracket_into<'a, X, Y>(
    space: impl Homogeneous,
    pairs: impl Iterator<Item = (f64, &'a [X], &'a [Y])> + Clone,
    out: &mut [X],
) where
    X: Field + Mul<Y, Output = X>,
    Y: Number,
{
    space.each_isotropy_run(
        #[inline(always)]
        |p, row, column, count| {
            let out = &mut out[p..][..count];
            write_bracket(space, pairs.clone(), [row, column], out);
            for z in out {
                *z = -*z;
            }
        },
    );
}

/// Coordinates of entries of a row of a sum of weighted brackets, starting at a column; with the sign of the entries.
#[inline(always)]
fn write_bracket<'a, X, Y>(
    space: impl Homogeneous,
    pairs: impl Iterator<Item = (f64, &'a [X], &'a [Y])> + Clone,
    [row, column]: [usize; 2],
    out: &mut [X],
) where
    X: Field + Mul<Y, Output = X>,
    Y: Number,
{
    let brackets = Brackets {
        r: space.size(),
        inner: space.row_len(row).min(space.row_len(column)),
        row,
        pairs,
    };
    write_row(&brackets, column, out);
    for (c, entry) in out.iter_mut().enumerate() {
        *entry = *entry * space.scale(row, column + c);
    }
}

/// `out -= sum [z, x]` over pairs `(x, z)`, `x` in `m` and `z` in `h`, where `product` multiplies an entry of `x` and
/// an entry of `z`; `run` holds a vector.
#[inline(always)]
pub(crate) fn subtract_action<'a, A, B, X: Field>(
    space: impl Homogeneous,
    pairs: impl Iterator<Item = (&'a [A], &'a [B])> + Clone,
    multiply: impl Fn(A, B) -> X + Copy,
    run: &mut [X],
    out: &mut [X],
) where
    A: Copy + 'a,
    B: Copy + 'a,
{
    space.each_turned_run(
        #[inline(always)]
        |p, row, column, count| {
            let products = RowProducts {
                r: space.size(),
                inner: space.isotropy_range(),
                row,
                pairs: pairs.clone(),
                multiply,
            };
            write_row(&products, column, &mut run[..count]);
            for (out, turned) in out[p..].iter_mut().zip(&run[..count]) {
                *out -= *turned;
            }
            let inner = space.column_isotropy_range();
            if inner.is_empty() {
                return;
            }
            // A row of `z x`, the other term of `[z, x]`.
            let products = RowProducts {
                r: space.size(),
                inner,
                row,
                pairs: pairs.clone().map(
                    #[inline(always)]
                    |(x, z)| (z, x),
                ),
                multiply: move |z: B, x: A| multiply(x, z),
            };
            write_row(&products, column, &mut run[..count]);
            for (out, turned) in out[p..].iter_mut().zip(&run[..count]) {
                *out += *turned;
            }
        },
    );
}
