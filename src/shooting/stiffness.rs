//! How the accelerations at the ends of a leg change with the knots there.

use super::leg::{Leg, Scratch};
use super::leg_equations::{combined, residual_into, set_equations};
use super::variation::Variation;
use crate::linalg::field::{Field, accumulate, factor, multiply, substitute};
use crate::space::Homogeneous;

/// The linear equations `C dm + E z = -b` for the change `dm` of a leg's middle, where `z` holds changes `(p, v)` of the knots
/// at both ends, a displacement and a velocity each, and `b` is what is left of the leg's own equations; and the changes of
/// `(x'', x')` at both ends that follow from `dm` and `z`.
///
/// For cubics of the space the matrix is that of the second derivative of the cost of a leg, up to signs:
///
/// ```math
/// \tfrac12 \int |x'|^2 ds,\qquad \text{gradient}\ (x''_0, -x'_0, -x''_1, x'_1)\ \text{by}\ (p_0, v_0, p_1, v_1)
/// ```
#[derive(Clone)]
pub(super) struct Stiffness<T> {
    /// Factors of `C`, shape `(3 d, 3 d)`, and `C^{-1} E`, shape `(3 d, 4 d)`.
    factors: Vec<T>,
    by_knots: Vec<T>,
    /// Changes of `x''_0, x'_0, x''_1, x'_1` by `(p_0, v_0, p_1, v_1)`, shape `(4 d, 4 d)`; by the middle, shape `(4 d, 3 d)`.
    pub(super) matrix: Vec<T>,
    by_middle: Vec<T>,
}

/// Buffers that legs share.
#[derive(Clone)]
pub(super) struct StiffnessScratch<T> {
    /// Of the series of the derivative, after the three given ones; there is room for so many as there were at first.
    pub(super) terms: usize,
    variation: Variation<3, T>,
    direct: Vec<T>,
    vectors: Vec<T>,
}

impl<T: Field> StiffnessScratch<T> {
    pub(super) fn new(space: impl Homogeneous, terms: usize) -> Self {
        let (d, square) = (space.dim(), space.size() * space.size());
        StiffnessScratch {
            terms,
            variation: Variation::new(space, terms),
            direct: vec![T::ZERO; (d + space.isotropy_dim()) * d],
            vectors: vec![T::ZERO; (2 * square).max(7 * d)],
        }
    }
}

impl<T: Field> Stiffness<T> {
    pub(super) fn new(space: impl Homogeneous) -> Self {
        let square = space.dim().pow(2);
        let zeros = |count: usize| vec![T::ZERO; count * square];
        Stiffness {
            factors: zeros(9),
            by_knots: zeros(12),
            matrix: zeros(16),
            by_middle: zeros(12),
        }
    }

    /// At the present state of a leg.
    #[inline(always)]
    pub(super) fn set(
        &mut self,
        space: impl Homogeneous,
        leg: &Leg<'_, T>,
        scratch: &mut Scratch<T>,
        own: &mut StiffnessScratch<T>,
    ) {
        let (d, wide) = (space.dim(), 3 * space.dim());
        let StiffnessScratch {
            terms,
            variation,
            direct,
            vectors,
        } = own;
        let terms = (*terms).min(leg.order);
        set_equations(space, leg, terms, scratch, variation, &mut self.factors);
        let [_, slope, bend] = &variation.ends;
        factor(wide, &mut self.factors);
        let block = wide * d;
        let outputs = &mut self.by_middle;
        outputs[..block].copy_from_slice(&bend[0]);
        outputs[block..2 * block].copy_from_slice(&slope[0]);
        space.turn_columns(
            leg.holonomy,
            &bend[1],
            wide,
            &mut outputs[2 * block..3 * block],
        );
        space.turn_columns(leg.holonomy, &slope[1], wide, &mut outputs[3 * block..]);
        // A displacement of the first knot as it arrives at the last one.
        let square = space.size() * space.size();
        let (reached, transposed) = vectors.split_at_mut(square);
        multiply(space.size(), leg.target, leg.holonomy, reached);
        for i in 0..space.size() {
            for j in 0..space.size() {
                transposed[j * space.size() + i] = reached[i * space.size() + j];
            }
        }
        space.adjoint_into(transposed, direct);
        self.set_by_knots(space, leg, direct, vectors);
        substitute(wide, &self.factors, 4 * d, &mut self.by_knots);
        self.set_matrix(space, leg, direct, vectors);
    }

    /// `E`, where its product with the inverse goes.
    #[inline(always)]
    fn set_by_knots(
        &mut self,
        space: impl Homogeneous,
        leg: &Leg<'_, T>,
        direct: &[T],
        vectors: &mut [T],
    ) {
        let d = space.dim();
        let wide = 4 * d;
        // Rows of the point, of the first and of the last velocity.
        let (unit, turned) = vectors.split_at_mut(d);
        self.by_knots.fill(T::ZERO);
        let (points, velocities) = self.by_knots.split_at_mut(d * wide);
        let (first, last) = velocities.split_at_mut(d * wide);
        for q in 0..d {
            unit.fill(T::ZERO);
            unit[q] = T::constant(1.0);
            space.turn_back_into(leg.holonomy, unit, turned);
            for p in 0..d {
                points[p * wide + q] = direct[p * d + q];
                points[p * wide + 2 * d + q] = -turned[p];
                last[p * wide + 3 * d + q] = -turned[p];
            }
            first[q * wide + d + q] = T::constant(-1.0);
        }
        add_turning(space, leg.reached[0], direct, wide, last);
        for row in 0..d {
            for column in 0..wide {
                let at = row * wide + column;
                let combined = combined(points[at], [first[at], last[at]]);
                [points[at], first[at], last[at]] = combined;
            }
        }
    }

    #[inline(always)]
    fn set_matrix(
        &mut self,
        space: impl Homogeneous,
        leg: &Leg<'_, T>,
        direct: &[T],
        vectors: &mut [T],
    ) {
        let d = space.dim();
        let wide = 4 * d;
        self.matrix.fill(T::ZERO);
        accumulate(
            &self.by_middle,
            3 * d,
            &self.by_knots,
            wide,
            &mut self.matrix,
        );
        for x in &mut self.matrix {
            *x = -*x;
        }
        // What is turned with the frame by a displacement of the first knot.
        let (turns, rest) = vectors.split_at_mut(d);
        let turned = &mut rest[..d];
        for (block, vector) in [(2, &*leg.reached[2]), (3, &*leg.reached[1])] {
            for column in 0..d {
                turns.fill(T::ZERO);
                add_turning_of(space, vector, direct, column, turns);
                space.turn_into(leg.holonomy, turns, turned);
                for p in 0..d {
                    self.matrix[(block * d + p) * wide + column] += turned[p];
                }
            }
        }
    }

    /// `x''_0, x'_0, x''_1, x'_1` after a step that solves the leg's own equations, with the knots where they are.
    #[inline(always)]
    pub(super) fn corrected_into(&self, space: impl Homogeneous, leg: &Leg<'_, T>, out: &mut [T]) {
        let d = space.dim();
        for (i, vectors) in [&leg.thirds, &leg.accelerations].into_iter().enumerate() {
            for (end, vector) in vectors.iter().enumerate() {
                out[(2 * end + i) * d..][..d].copy_from_slice(vector);
            }
        }
        let mut right = vec![T::ZERO; 3 * d];
        self.correction_into(leg, &mut right);
        accumulate(&self.by_middle, 3 * d, &right, 1, out);
    }

    /// The change of the middle that solves the leg's own equations, for changes `z` of the knots.
    #[inline(always)]
    pub(super) fn step_into(&self, leg: &Leg<'_, T>, z: &[T], out: &mut [T]) {
        self.correction_into(leg, out);
        let mut change = vec![T::ZERO; out.len()];
        accumulate(&self.by_knots, z.len(), z, 1, &mut change);
        for (out, change) in out.iter_mut().zip(&change) {
            *out -= *change;
        }
    }

    /// The same with the knots where they are.
    #[inline(always)]
    fn correction_into(&self, leg: &Leg<'_, T>, out: &mut [T]) {
        residual_into(leg, out);
        substitute(out.len(), &self.factors, 1, out);
        for x in out {
            *x = -*x;
        }
    }
}

/// `out += [eta_h, vector]` for the columns of `eta`, the first ones of `out`, which has more.
#[inline(always)]
fn add_turning<T: Field>(
    space: impl Homogeneous,
    vector: &[T],
    eta: &[T],
    wide: usize,
    out: &mut [T],
) {
    let d = space.dim();
    let mut turned = vec![T::ZERO; d];
    for column in 0..d {
        turned.fill(T::ZERO);
        add_turning_of(space, vector, eta, column, &mut turned);
        for (p, x) in turned.iter().enumerate() {
            out[p * wide + column] += *x;
        }
    }
}

/// `out += [eta_h, vector]` for one of `d` columns of `eta`.
#[inline(always)]
fn add_turning_of<T: Field>(
    space: impl Homogeneous,
    vector: &[T],
    eta: &[T],
    column: usize,
    out: &mut [T],
) {
    let (d, h, r) = (space.dim(), space.isotropy_dim(), space.size());
    if h == 0 {
        return;
    }
    let mut matrix = vec![T::ZERO; r * r];
    space.matrix_into(vector, &mut matrix);
    let isotropy: Vec<T> = (0..h).map(|p| -eta[(d + p) * d + column]).collect();
    space.subtract_action(&isotropy, &matrix, out);
}
