//! Gaussian elimination for systems of compile-time size.

use nalgebra::SMatrix;

/// Solves `A x = b` by elimination with partial pivoting and stores `x` in `b`; `false` if `A` is singular.
pub(super) fn solve_in_place<const N: usize, const M: usize>(
    mut a: SMatrix<f64, N, N>,
    b: &mut SMatrix<f64, N, M>,
) -> bool {
    for j in 0..N {
        let pivot = (j..N).fold(j, |best, i| {
            if a[(i, j)].abs() > a[(best, j)].abs() {
                i
            } else {
                best
            }
        });
        if a[(pivot, j)] == 0.0 || !a[(pivot, j)].is_finite() {
            return false;
        }
        a.swap_rows(j, pivot);
        b.swap_rows(j, pivot);
        for i in j + 1..N {
            let factor = a[(i, j)] / a[(j, j)];
            if factor != 0.0 {
                for l in j + 1..N {
                    a[(i, l)] -= factor * a[(j, l)];
                }
                for l in 0..M {
                    b[(i, l)] -= factor * b[(j, l)];
                }
            }
        }
    }
    for l in 0..M {
        for i in (0..N).rev() {
            let tail: f64 = (i + 1..N).map(|j| a[(i, j)] * b[(j, l)]).sum();
            b[(i, l)] = (b[(i, l)] - tail) / a[(i, i)];
        }
    }
    true
}
