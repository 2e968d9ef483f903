//! Initial data of a Riemannian cubic, in the coordinates of a frame of their span.

use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{ColMut, ColRef, Mat, MatMut, MatRef, Scale};

use super::blocks::Sizes;
use crate::curve::span::Span;
use crate::error::Result;
use crate::linalg::complex_embedding::{embed_into, nearest};
use crate::linalg::decomp::{thin_q, unitary_q};
use crate::linalg::product::{mul_add, mul_into, product};
use crate::linalg::structure::{dot, norm};
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel};
use crate::manifold::tangent::check_vector;
use crate::space::{Kind, Quotient, RowOrder, ScalarField};

/// A vector of `m`: `[[omega, -normal^T], [normal, 0]]` with skew `omega` of shape `(k, k)`, and `normal` of shape
/// `(r - k, k)`.
#[derive(Debug, Clone)]
pub(crate) struct Horizontal {
    pub(crate) omega: Mat<f64>,
    pub(crate) normal: Mat<f64>,
}

impl Horizontal {
    pub(crate) fn zeros(blocks: Sizes) -> Self {
        Horizontal {
            omega: Mat::zeros(blocks.k, blocks.k),
            normal: Mat::zeros(blocks.m, blocks.k),
        }
    }

    /// The vector with the entries of `omega`, then those of `normal`, both in column-major order.
    pub(crate) fn of_entries(entries: &[f64], k: usize) -> Self {
        let (omega, normal) = entries.split_at(k * k);
        let m = normal.len() / k;
        Horizontal {
            omega: MatRef::from_column_major_slice(omega, k, k).to_owned(),
            normal: MatRef::from_column_major_slice(normal, m, k).to_owned(),
        }
    }

    /// The covariant jerk `x'' + [x, x']_m / 2` for the third vector `x''`; for subspaces `[m, m]` is contained in `h`.
    pub(crate) fn jerk(quotient: Quotient, [x, a, third]: [&Self; 3]) -> Self {
        match quotient {
            Quotient::Frames => third.clone().plus_bracket(0.5, x, a),
            Quotient::Subspaces => third.clone(),
        }
    }

    /// The vector of `m` that corresponds to the tangent vector `v` at the first `k` columns of `g`; shapes `(r, r)`
    /// and `(r, k)`.
    pub(crate) fn of_tangent(g: MatRef<'_, f64>, v: MatRef<'_, f64>) -> Self {
        Self::of_components(product(g.transpose(), v).as_ref())
    }

    /// The same from `g^T v`: the horizontal part of a matrix of shape `(r, k)`.
    pub(crate) fn of_components(all: MatRef<'_, f64>) -> Self {
        let (r, k) = all.shape();
        Horizontal {
            omega: Mat::from_fn(k, k, |i, j| 0.5 * (all[(i, j)] - all[(j, i)])),
            normal: all.subrows(k, r - k).to_owned(),
        }
    }

    /// The tangent vector at the first columns of the identity, shape `(r, k)`.
    pub(crate) fn tangent(&self) -> Mat<f64> {
        let (m, k) = self.normal.shape();
        Mat::from_fn(k + m, k, |i, j| match i.checked_sub(k) {
            None => self.omega[(i, j)],
            Some(i) => self.normal[(i, j)],
        })
    }

    /// The skew matrix, shape `(r, r)`.
    pub(crate) fn matrix(&self) -> Mat<f64> {
        let (m, k) = self.normal.shape();
        Mat::from_fn(k + m, k + m, |i, j| {
            match (i.checked_sub(k), j.checked_sub(k)) {
                (None, None) => self.omega[(i, j)],
                (Some(i), None) => self.normal[(i, j)],
                (None, Some(j)) => -self.normal[(j, i)],
                _ => 0.0,
            }
        })
    }

    /// `<a, b> = tr(omega_a^T omega_b) / 2 + tr(b_a^T b_b)`.
    pub(crate) fn inner(&self, other: &Self) -> f64 {
        0.5 * dot(self.omega.as_ref(), other.omega.as_ref())
            + dot(self.normal.as_ref(), other.normal.as_ref())
    }

    /// `|a|`, without overflow or underflow.
    pub(crate) fn norm(&self) -> f64 {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        norm(self.normal.as_ref()).hypot(norm(self.omega.as_ref()) * half)
    }

    /// `a + factor b`.
    pub(crate) fn plus(mut self, factor: f64, other: &Self) -> Self {
        self.omega += &other.omega * Scale(factor);
        self.normal += &other.normal * Scale(factor);
        self
    }

    /// `[a, b]_m`.
    pub(crate) fn bracket(&self, other: &Self) -> Self {
        let (m, k) = self.normal.shape();
        let zero = Horizontal {
            omega: Mat::zeros(k, k),
            normal: Mat::zeros(m, k),
        };
        zero.plus_bracket(1.0, self, other)
    }

    /// `c + factor [a, b]_m`.
    pub(crate) fn plus_bracket(mut self, factor: f64, a: &Self, b: &Self) -> Self {
        let c = [self.omega.as_mut(), self.normal.as_mut()];
        add_bracket(c, factor, a.blocks(), b.blocks());
        self
    }

    fn blocks(&self) -> [MatRef<'_, f64>; 2] {
        [self.omega.as_ref(), self.normal.as_ref()]
    }
}

/// `c += factor [a, b]_m`, each as `omega` and `normal`.
pub(crate) fn add_bracket(
    [mut omega, mut normal]: [MatMut<'_, f64>; 2],
    factor: f64,
    [a, a_normal]: [MatRef<'_, f64>; 2],
    [b, b_normal]: [MatRef<'_, f64>; 2],
) {
    let k = a.nrows();
    let mut square = vec![0.0; k * k];
    let mut square = MatMut::from_column_major_slice_mut(&mut square, k, k);
    mul_into(square.rb_mut(), factor, a, b);
    mul_add(square.rb_mut(), -factor, a_normal.transpose(), b_normal);
    for j in 0..k {
        for i in 0..k {
            omega[(i, j)] += square[(i, j)] - square[(j, i)];
        }
    }
    mul_add(normal.rb_mut(), factor, a_normal, b);
    mul_add(normal, -factor, b_normal, a);
}

/// Point, velocity, covariant acceleration and covariant jerk of a curve.
///
/// Isometries that fix the span of all four pointwise also fix the cubic with these data, so it stays in the span.
#[derive(Debug, Clone)]
pub(crate) struct InitialData {
    /// Orthonormal basis of the span, shape `(n, r)`, `r = min(n, 4k)`; `None` if the span is all of `R^n`.
    pub(crate) frame: Option<Mat<f64>>,
    /// Orthogonal, shape `(r, r)`; the first `k` columns are the point.
    pub(crate) g: Mat<f64>,
    pub(crate) velocity: Horizontal,
    pub(crate) acceleration: Horizontal,
    pub(crate) jerk: Horizontal,
    /// Tension of the cubic.
    pub(crate) tension: f64,
    pub(crate) quotient: Quotient,
}

impl InitialData {
    /// Built from the point and the three tangent vectors at it, all of shape `(n, k)`.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`.
    pub(crate) fn new(
        s: MatRef<'_, f64>,
        v: MatRef<'_, f64>,
        a: MatRef<'_, f64>,
        j: MatRef<'_, f64>,
        quotient: Quotient,
    ) -> Result<Self> {
        check(s, [v, a, j], quotient)?;
        let kind = Kind::real(quotient);
        let data = Coordinates::of_checked([s, v, a, j], 1.0, kind);
        let (r, k) = (data.blocks.m + data.blocks.k, data.blocks.k);
        let (g, vectors) = data.entries.split_at(r * r);
        let horizontal = |i: usize| Horizontal::of_entries(&vectors[i * r * k..][..r * k], k);
        Ok(InitialData {
            velocity: horizontal(0),
            acceleration: horizontal(1),
            jerk: horizontal(2),
            g: MatRef::from_column_major_slice(g, r, r).to_owned(),
            frame: data.frame,
            tension: 0.0,
            quotient,
        })
    }

    /// The data of a curve in tension.
    pub(crate) fn in_tension(mut self, tension: f64) -> Self {
        self.tension = tension;
        self
    }

    /// `x'' = j - [v, a]_m / 2`.
    pub(crate) fn second(&self) -> Horizontal {
        let jerk = self.jerk.clone();
        match self.quotient {
            Quotient::Frames => jerk.plus_bracket(-0.5, &self.velocity, &self.acceleration),
            Quotient::Subspaces => jerk,
        }
    }
}

/// Initial data in the coordinates of their frame, in one array.
pub(crate) struct Coordinates {
    /// As in [`InitialData`].
    pub(crate) frame: Option<Mat<f64>>,
    pub(crate) blocks: Sizes,
    /// `g`, then `omega` and `normal` of velocity, acceleration and jerk, in column-major order.
    pub(crate) entries: Vec<f64>,
}

impl Coordinates {
    /// The data in their natural time, and the number of natural units per unit of time.
    ///
    /// The rate is a power of two near `max(|V|, |A|^(1/2), |J|^(1/3), tau^(1/2))`, so nothing is rounded, and only
    /// negligible numbers underflow.
    ///
    /// # Errors
    /// As [`InitialData::new`].
    pub(crate) fn in_natural_time(
        [s, v, a, j]: [MatRef<'_, f64>; 4],
        tension: f64,
        quotient: Quotient,
    ) -> Result<(Self, f64)> {
        check(s, [v, a, j], quotient)?;
        let rate = norm(v).max(norm(a).sqrt()).max(norm(j).cbrt());
        let rate = match rate {
            // A curve at rest needs no steps.
            0.0 => 0.0,
            _ => rate.max(tension.sqrt()),
        };
        let rate = match rate {
            0.0 => 1.0,
            _ => rate
                .log2()
                .round()
                .clamp(-LARGEST_POWER, LARGEST_POWER)
                .exp2(),
        };
        let kind = Kind::real(quotient);
        Ok((Self::of_checked([s, v, a, j], 1.0 / rate, kind), rate))
    }

    /// In a time whose unit is `unit` of the given one, a power of two.
    pub(crate) fn of_checked(data: [MatRef<'_, f64>; 4], unit: f64, kind: Kind) -> Self {
        let (n, k) = data[0].shape();
        let mut low = Vec::with_capacity(4 * n * k);
        for (order, matrix) in data.into_iter().enumerate() {
            for column in matrix.col_iter() {
                // Multiply one factor at a time: the product of the factors may underflow.
                low.extend(column.iter().map(|x| (0..order).fold(*x, |x, _| x * unit)));
            }
        }
        let all = MatRef::from_column_major_slice(&low, n, 4 * k);
        if kind.field == ScalarField::Complex {
            return Self::in_complex_frame(all, k, kind);
        }
        if n <= 4 * k {
            return Self::in_frame(None, all, k, kind);
        }
        let frame = thin_q(all);
        let low = frame.transpose() * all;
        Self::in_frame(Some(frame), low.as_ref(), k, kind)
    }

    /// In a frame whose first columns are the point, so that rows follow the order of the frame's columns; in its own
    /// coordinates the frame is the identity.
    fn in_complex_frame(all: MatRef<'_, f64>, k: usize, kind: Kind) -> Self {
        let parts: [MatRef<'_, f64>; 4] = std::array::from_fn(|i| all.subcols(i * k, k));
        let span = Span::over(kind.field, &parts);
        let g = complete_over(kind.field, span.down(parts[0]).as_ref());
        let frame = span.lift(g.as_ref());
        let low = frame.transpose() * all;
        Self::in_frame(Some(frame), low.as_ref(), k, kind)
    }

    /// From point, velocity, acceleration and jerk side by side, in the coordinates of a frame, shape `(r, 4k)`.
    fn in_frame(frame: Option<Mat<f64>>, all: MatRef<'_, f64>, k: usize, kind: Kind) -> Self {
        let r = all.nrows();
        let mut entries = vec![0.0; r * (r + 3 * k)];
        let (g, to) = entries.split_at_mut(r * r);
        let (s, vectors) = all.split_at_col(k);
        complete_into(MatMut::from_column_major_slice_mut(g, r, r), s);
        let g = MatRef::from_column_major_slice(g, r, r);
        let mut components = vec![0.0; 3 * r * k];
        let out = MatMut::from_column_major_slice_mut(&mut components, r, 3 * k);
        mul_into(out, 1.0, g.transpose(), vectors);
        for (to, from) in to
            .chunks_exact_mut(r * k)
            .zip(components.chunks_exact(r * k))
        {
            let (omega, normal) = to.split_at_mut(k * k);
            for j in 0..k {
                if kind.quotient == Quotient::Frames {
                    for i in 0..k {
                        omega[i + k * j] = 0.5 * (from[i + r * j] - from[j + r * i]);
                    }
                }
                normal[(r - k) * j..][..r - k].copy_from_slice(&from[r * j + k..][..r - k]);
            }
        }
        let blocks = Sizes::of_kind(r - k, k, kind);
        Coordinates {
            frame,
            blocks,
            entries,
        }
    }
}

/// Bound on the exponent for which the rate of natural time and its inverse are normal numbers.
const LARGEST_POWER: f64 = 1022.0;

fn check(s: MatRef<'_, f64>, vectors: [MatRef<'_, f64>; 3], quotient: Quotient) -> Result<()> {
    Stiefel::of("S", s)?.check_point("S", s, POINT_TOLERANCE)?;
    for (name, vector) in ["V", "A", "J"].into_iter().zip(vectors) {
        check_vector(quotient, name, s, vector)?;
    }
    Ok(())
}

/// An orthogonal matrix whose first columns are those of `s`, shape `(r, k)`, orthonormalised if necessary; its
/// determinant is 1 if `k < r`.
///
/// Householder reflections are written out here: `r` is at most `4k`, and often three.
pub(crate) fn complete(s: MatRef<'_, f64>) -> Mat<f64> {
    let mut g = Mat::zeros(s.nrows(), s.nrows());
    complete_into(g.as_mut(), s);
    g
}

/// As [`complete`], over a field: for embedded complex points the result is an embedded unitary matrix.
pub(crate) fn complete_over(field: ScalarField, s: MatRef<'_, f64>) -> Mat<f64> {
    if field == ScalarField::Real {
        return complete(s);
    }
    let (r, k) = s.shape();
    let all = unitary_q(nearest(s).as_ref(), true);
    let mut g = Mat::zeros(r, r);
    let (first, rest) = g.as_mut().split_at_col_mut(k);
    embed_into(first, all.as_ref().subcols(0, k / 2));
    embed_into(rest, all.as_ref().subcols(k / 2, (r - k) / 2));
    g
}

/// As [`complete_over`], for points relative to a frame, whose rows follow the order of the frame's columns.
pub(crate) fn complete_relative(field: ScalarField, s: MatRef<'_, f64>) -> Mat<f64> {
    if field == ScalarField::Real {
        return complete(s);
    }
    let (r, k) = s.shape();
    let rows = RowOrder { r, k };
    rows.blocks(complete_over(field, rows.halves(s).as_ref()).as_ref())
}

/// [`complete`] into zeros.
fn complete_into(mut g: MatMut<'_, f64>, s: MatRef<'_, f64>) {
    let (r, k) = s.shape();
    g.rb_mut().diagonal_mut().fill(1.0);
    let mut reflections: Vec<f64> = s
        .col_iter()
        .flat_map(|column| column.iter().copied())
        .collect();
    let mut reflections = MatMut::from_column_major_slice_mut(&mut reflections, r, k);
    for j in 0..k {
        let length = (j..r).map(|i| reflections[(i, j)].powi(2)).sum::<f64>();
        // Choose the sign that avoids cancellation; the column becomes minus that sign times its length times a unit
        // vector.
        reflections[(j, j)] += sign(reflections[(j, j)]) * length.sqrt();
        for col in j + 1..k {
            let (column, mut rest) = reflections.rb_mut().split_at_col_mut(j + 1);
            reflect(column.rb().col(j), j, rest.rb_mut().col_mut(col - j - 1));
        }
    }
    for j in (0..k).rev() {
        for col in j..r {
            reflect(reflections.rb().col(j), j, g.rb_mut().col_mut(col));
        }
    }
    // Every reflection and every change of sign reverses the orientation.
    let mut orientation = 1.0;
    for j in 0..k {
        let sign = sign(reflections[(j, j)]);
        orientation *= sign;
        for i in 0..r {
            g[(i, j)] *= -sign;
        }
    }
    if k < r {
        for i in 0..r {
            g[(i, r - 1)] *= orientation;
        }
    }
}

fn sign(x: f64) -> f64 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

/// Reflects a vector at the hyperplane orthogonal to `normal`, of which only the entries from `first` on are used.
fn reflect(normal: ColRef<'_, f64>, first: usize, mut a: ColMut<'_, f64>) {
    let r = a.nrows();
    let (mut product, mut square) = (0.0, 0.0);
    for i in first..r {
        product += normal[i] * a[i];
        square += normal[i].powi(2);
    }
    let factor = if square > 0.0 {
        2.0 * product / square
    } else {
        0.0
    };
    for i in first..r {
        a[i] -= factor * normal[i];
    }
}
