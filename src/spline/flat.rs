//! The equations of a cubic spline of flat space, in tangent spaces.
//!
//! ```math
//! \frac{2 v_{i-1} + 4 v_i}{h_-} + \frac{4 v_i + 2 v_{i+1}}{h_+}
//!     = 6 \Bigl( \frac{\Delta_-}{h_-^2} + \frac{\Delta_+}{h_+^2} \Bigr)
//! ```
//!
//! Displacements are the initial velocities of the quasi-geodesics between neighbours, along which vectors are carried
//! from knot to knot. Carried to one knot, the equations have a tridiagonal matrix of numbers, so the Thomas algorithm
//! applies, with vectors as right-hand sides.

use faer::{MatMut, MatRef};

use super::links::Links;
use crate::legs::{End, Knots};
use crate::linalg::field::add;
use crate::linalg::product::axpy;
use crate::solve::tridiagonal::Isometries;

/// The right-hand sides of a spline, of `n k` entries per knot; given velocities and accelerations enter the equations of
/// their knots.
pub(super) fn right_sides(links: &Links, knots: &Knots<'_>) -> Vec<f64> {
    let (count, size) = (knots.count(), links.size());
    let mut right = vec![0.0; count * size];
    for (leg, h) in knots.lengths.iter().enumerate() {
        for (knot, displacement) in [
            (leg, links.first(leg)),
            ((leg + 1) % count, links.last(leg)),
        ] {
            let here = &mut right[knot * size..][..size];
            axpy(
                matrix_mut(here, displacement.shape()),
                6.0 / (h * h),
                displacement,
            );
        }
    }
    for (knot, right) in right.chunks_exact_mut(size).enumerate() {
        match knots.end_at(knot) {
            Some((End::Velocity(v), _)) => right.copy_from_slice(v),
            Some((End::Acceleration(a), sign)) => add(right, -sign, a),
            None => {}
        }
    }
    right
}

/// The entries of a vector as a matrix, in column-major order.
pub(super) fn matrix(entries: &[f64], shape: (usize, usize)) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(entries, shape.0, shape.1)
}

/// As [`matrix`], mutable.
pub(super) fn matrix_mut(entries: &mut [f64], shape: (usize, usize)) -> MatMut<'_, f64> {
    MatMut::from_column_major_slice_mut(entries, shape.0, shape.1)
}
