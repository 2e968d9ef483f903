//! The response of the accelerations at the ends of a leg to changes of the knots there.

use crate::linalg::field::{Field, accumulate, factor, multiply, substitute, substitute_rows};
use crate::shooting::taylor::leg::{LegScratch, SeriesLeg};
use crate::shooting::taylor::leg_equations::{combined, residual_into, set_equations, uncombined};
use crate::shooting::taylor::variation::MiddleVariation;
use crate::space::Homogeneous;

/// The linear equations `C dm + E z = -b` for the change `dm` of a leg's middle, where `z` contains changes `(p, v)` of
/// the knots at both ends (a displacement and a velocity each) and `b` is the residual of the leg's own equations; and
/// the resulting changes of `(x'', x')` at both ends.
///
/// For cubics of the space the matrix is the second derivative of the cost of a leg, up to signs:
///
/// ```math
/// \tfrac12 \int |x'|^2 ds,\qquad \text{gradient}\ (x''_0, -x'_0, -x''_1, x'_1)\ \text{by}\ (p_0, v_0, p_1, v_1)
/// ```
///
/// In tension the cost is `int |x'|^2 + tau |x|^2 ds / 2`, and `x'' - tau x` takes the place of `x''`.
#[derive(Clone)]
pub(crate) struct Stiffness<T> {
    /// Factors of `C`, shape `(3 d, 3 d)`.
    factors: Vec<T>,
    /// Changes of `x''_0, x'_0, x''_1, x'_1`, for fixed `x` at the ends, caused by the residual of the leg's equations,
    /// shape `(4 d, 3 d)`.
    by_equations: Vec<T>,
    /// A displacement of the first knot as it arrives at the last one, and the resulting rotation of the velocity
    /// there, shape `(2 d, d)`.
    by_first: Vec<T>,
    /// The second derivative of the cost with respect to `(p_0, v_0, p_1, v_1)`, shape `(4 d, 4 d)`.
    pub(crate) matrix: Vec<T>,
}

/// Buffers shared by all legs.
#[derive(Clone)]
pub(crate) struct StiffnessScratch<T: Field> {
    /// Number of terms of the series of the derivative, after the three given ones.
    pub(crate) terms: usize,
    variation: MiddleVariation<T>,
    direct: Vec<T>,
    vectors: Vec<T>,
    /// Changes caused by the residuals of the point and of the last velocity, shape `(4 d, 2 d)`, and by a displacement
    /// of the first knot, shape `(4 d, d)`.
    by_last: Vec<T>,
    by_displacement: Vec<T>,
}

impl<T: Field> StiffnessScratch<T> {
    pub(crate) fn new(space: impl Homogeneous, terms: usize) -> Self {
        let (d, square) = (space.dim(), space.size() * space.size());
        let zeros = |count: usize| vec![T::ZERO; count];
        StiffnessScratch {
            terms,
            variation: MiddleVariation::new(space, 3, terms),
            direct: zeros((d + space.isotropy_dim()) * d),
            vectors: zeros((2 * square).max(2 * d * d)),
            by_last: zeros(8 * d * d),
            by_displacement: zeros(4 * d * d),
        }
    }
}

impl<T: Field> Stiffness<T> {
    pub(crate) fn new(space: impl Homogeneous) -> Self {
        let square = space.dim().pow(2);
        let zeros = |count: usize| vec![T::ZERO; count * square];
        Stiffness {
            factors: zeros(9),
            by_equations: zeros(12),
            by_first: zeros(2),
            matrix: zeros(16),
        }
    }

    /// Computes the stiffness at the current state of a leg.
    #[inline(always)]
    pub(crate) fn set(
        &mut self,
        space: impl Homogeneous,
        leg: &SeriesLeg<'_, T>,
        scratch: &mut LegScratch<T>,
        own: &mut StiffnessScratch<T>,
    ) {
        let (d, wide) = (space.dim(), 3 * space.dim());
        let terms = own.terms.min(leg.order);
        let variation = &mut own.variation;
        set_equations(space, leg, terms, scratch, variation, &mut self.factors);
        let (slope, derivative) = (&variation.ends[1], &variation.ends[2]);
        factor(wide, &mut self.factors);
        let block = wide * d;
        let outputs = &mut self.by_equations;
        outputs[..block].copy_from_slice(&derivative[0]);
        outputs[block..2 * block].copy_from_slice(&slope[0]);
        space.turn_columns(
            leg.holonomy,
            &derivative[1],
            wide,
            &mut outputs[2 * block..3 * block],
        );
        space.turn_columns(leg.holonomy, &slope[1], wide, &mut outputs[3 * block..]);
        // Convert functions of the middle to functions of the equations.
        substitute_rows(wide, &self.factors, outputs);
        self.set_by_first(space, leg, own);
        self.set_matrix(space, leg, own);
        self.symmetrise(d);
    }

    /// Also sets `direct`, the displacement with its part in `h`.
    #[inline(always)]
    fn set_by_first(
        &mut self,
        space: impl Homogeneous,
        leg: &SeriesLeg<'_, T>,
        own: &mut StiffnessScratch<T>,
    ) {
        let (d, r) = (space.dim(), space.size());
        let (reached, transposed) = own.vectors.split_at_mut(r * r);
        multiply(r, leg.target, leg.holonomy, reached);
        for i in 0..r {
            for j in 0..r {
                transposed[j * r + i] = reached[i * r + j];
            }
        }
        space.adjoint_into(transposed, &mut own.direct);
        let (displacement, turned) = self.by_first.split_at_mut(d * d);
        displacement.copy_from_slice(&own.direct[..d * d]);
        turned.fill(T::ZERO);
        space.add_turning(leg.reached[0], &own.direct, d, turned);
    }

    /// Changes of `x''_0, x'_0, x''_1, x'_1` for `(p_0, v_0, p_1, v_1)`.
    #[inline(always)]
    fn set_matrix(
        &mut self,
        space: impl Homogeneous,
        leg: &SeriesLeg<'_, T>,
        own: &mut StiffnessScratch<T>,
    ) {
        let d = space.dim();
        let StiffnessScratch {
            direct,
            vectors,
            by_last,
            by_displacement,
            ..
        } = own;
        let rows = self.by_equations.chunks_exact(3 * d);
        let outs = self.matrix.chunks_exact_mut(4 * d);
        for ((row, out), by_last) in rows.zip(outs).zip(by_last.chunks_exact_mut(2 * d)) {
            let (by_point, by_velocity) = by_last.split_at_mut(d);
            for p in 0..d {
                let parts = [row[p], row[d + p], row[2 * d + p]];
                let [point, first, last] = uncombined(parts);
                (by_point[p], out[d + p], by_velocity[p]) = (point, first, last);
            }
            // A product with the inverse of an isometry from the right is the isometry applied to the row.
            space.turn_into(leg.holonomy, by_point, &mut out[2 * d..3 * d]);
            space.turn_into(leg.holonomy, by_velocity, &mut out[3 * d..]);
        }
        by_displacement.fill(T::ZERO);
        accumulate(by_last, 2 * d, &self.by_first, d, by_displacement);
        for x in &mut *by_displacement {
            *x = -*x;
        }
        // The rotation with the frame caused by a displacement of the first knot.
        let (turns, turned) = vectors.split_at_mut(d * d);
        let turned = &mut turned[..d * d];
        for (block, vector) in [(2, &*leg.reached[2]), (3, &*leg.reached[1])] {
            turns.fill(T::ZERO);
            space.add_turning(vector, direct, d, turns);
            space.turn_columns(leg.holonomy, turns, d, turned);
            let sums = by_displacement[block * d * d..].iter_mut();
            for (sum, turned) in sums.zip(&*turned) {
                *sum += *turned;
            }
        }
        let columns = by_displacement.chunks_exact(d);
        for (out, column) in self.matrix.chunks_exact_mut(4 * d).zip(columns) {
            out[..d].copy_from_slice(column);
        }
        if let Some(tension) = leg.tension {
            for p in 0..d {
                self.matrix[p * 4 * d + d + p] -= tension;
                self.matrix[(2 * d + p) * 4 * d + 3 * d + p] -= tension;
            }
        }
    }

    /// Converts to the derivative of the gradient: accelerations at the first knot and third vectors at the last one
    /// change sign. It is symmetric up to residual and truncation errors.
    #[inline(always)]
    fn symmetrise(&mut self, d: usize) {
        let wide = 4 * d;
        let sign = |row: usize| [0.5, -0.5, -0.5, 0.5][row / d];
        for row in 0..wide {
            for column in 0..=row {
                let [at, other] = [row * wide + column, column * wide + row];
                let entry = self.matrix[at] * sign(row) + self.matrix[other] * sign(column);
                (self.matrix[at], self.matrix[other]) = (entry, entry);
            }
        }
    }

    /// `x''_0, x'_0, x''_1, x'_1`, with `x'' - tau x` in place of `x''` in tension, after a step that solves the leg's
    /// own equations for fixed knots.
    #[inline(always)]
    pub(crate) fn corrected_into(
        &self,
        space: impl Homogeneous,
        leg: &SeriesLeg<'_, T>,
        out: &mut [T],
    ) {
        let d = space.dim();
        for (i, vectors) in [&leg.thirds, &leg.accelerations].into_iter().enumerate() {
            for (end, vector) in vectors.iter().enumerate() {
                out[(2 * end + i) * d..][..d].copy_from_slice(vector);
            }
        }
        if let Some(tension) = leg.tension {
            for (at, velocity) in [(0, &leg.velocity), (2 * d, &leg.last_velocity)] {
                for (out, v) in out[at..].iter_mut().zip(&**velocity) {
                    *out -= tension * *v;
                }
            }
        }
        let mut left = vec![T::ZERO; 3 * d];
        residual_into(leg, &mut left);
        for x in &mut left {
            *x = -*x;
        }
        accumulate(&self.by_equations, 3 * d, &left, 1, out);
    }

    /// The change of the middle that solves the leg's own equations, for changes `z` of the knots.
    #[inline(always)]
    pub(crate) fn step_into(
        &self,
        space: impl Homogeneous,
        leg: &SeriesLeg<'_, T>,
        z: &[T],
        out: &mut [T],
    ) {
        let d = space.dim();
        let mut arriving = vec![T::ZERO; 2 * d];
        accumulate(&self.by_first, d, &z[..d], 1, &mut arriving);
        let mut turned = vec![T::ZERO; 2 * d];
        let (point, velocity) = turned.split_at_mut(d);
        space.turn_back_into(leg.holonomy, &z[2 * d..3 * d], point);
        space.turn_back_into(leg.holonomy, &z[3 * d..], velocity);
        residual_into(leg, out);
        for p in 0..d {
            let point = arriving[p] - turned[p];
            let last = arriving[d + p] - turned[d + p];
            let rows = combined(point, [-z[d + p], last]);
            for (i, row) in rows.into_iter().enumerate() {
                out[i * d + p] += row;
            }
        }
        substitute(out.len(), &self.factors, 1, out);
        for x in out {
            *x = -*x;
        }
    }
}
