//! Boundary data in coordinates in which the start is the first columns of the identity, and the inverse
//! transformation.

use faer::{Mat, MatRef};

use super::guess::{FlatData, FlatWork};
use super::relative_ends::RelativeEnds;
use crate::cubic::boundary::end_equations::Target;
use crate::cubic::boundary_options::BoundaryOptions;
use crate::cubic::taylor::blocks::{BlockSizes, Sizes};
use crate::cubic::taylor::initial::{Horizontal, complete_over};
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::packing::{pack, unpack};
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::cubic::taylor::state::State;
use crate::cubic::tension::FlatCoefficients;
use crate::curve::span::Span;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::field::larger;
use crate::linalg::product::{entries, mul_add, product};
use crate::linalg::structure::symmetric_part;
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};
use crate::shooting::ChainKnots;
use crate::space::{Kind, ScalarField, Shape};

/// A boundary value problem, reduced to the span of its data.
#[derive(Debug, Clone)]
pub(crate) struct BoundaryProblem {
    pub(crate) n: usize,
    pub(crate) k: usize,
    /// Orthonormal basis of the span of the data, if the span is smaller than `R^n`.
    pub(crate) frame: Option<Mat<f64>>,
    /// Orthogonal matrix whose first columns are the start.
    pub(crate) g: Mat<f64>,
    pub(crate) velocity: Horizontal,
    /// End point and end velocity.
    pub(crate) end: [Mat<f64>; 2],
    pub(crate) target: Target,
    field: ScalarField,
}

impl BoundaryProblem {
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`.
    pub(crate) fn new(data: [MatRef<'_, f64>; 4], options: &BoundaryOptions<'_>) -> Result<Self> {
        let BoundaryOptions { tension, field, .. } = *options;
        check_data(data)?;
        field.check(data)?;
        // Rounded decimals are accepted as complex numbers; the unknowns are complex.
        let complex =
            (field == ScalarField::Complex).then(|| data.map(|a| field.nearest(a.to_owned())));
        let data = match &complex {
            Some(complex) => complex.each_ref().map(Mat::as_ref),
            None => data,
        };
        let [s0, v0, s1, v1] = data;
        let span = Span::over(field, &data);
        let g = complete_over(field, span.down(s0).as_ref());
        // Components in the frame `g` of the span.
        let components = |a: MatRef<'_, f64>| match span.basis() {
            Some(basis) => product(g.transpose(), product(basis.transpose(), a)),
            None => product(g.transpose(), a),
        };
        let velocity = Horizontal::of_components(components(v0).as_ref());
        let end = corrected([s1, v1].map(components));
        let target = Target::new(&velocity, &end, tension);
        Ok(BoundaryProblem {
            n: s0.nrows(),
            k: s0.ncols(),
            frame: span.into_basis(),
            g,
            velocity,
            end,
            target,
            field,
        })
    }

    /// Point and velocity at the start, shape `(r, k)`: the first columns of the identity, and the tangent vector
    /// there.
    pub(crate) fn initial(&self) -> [Mat<f64>; 2] {
        self.relative_ends().initial()
    }

    /// The data at both ends, relative to the start.
    pub(crate) fn relative_ends(&self) -> RelativeEnds<'_> {
        RelativeEnds {
            velocity: &self.velocity,
            end: &self.end,
        }
    }

    /// The larger of the end speeds, in the Frobenius norm.
    pub(crate) fn speed(&self) -> f64 {
        self.target.speed
    }

    /// Whether the cubic of flat space with the given displacement is near the solution: displacement and speeds are at
    /// most 2 in the canonical metric of the real matrices. If complex lengths up to 2 were measured in their own
    /// metric, the solution from the flat start would not be the cheapest in 17 of 420 complex problems between the two
    /// bounds, and the others would take longer.
    pub(crate) fn is_moderate(&self, flat: &FlatData) -> bool {
        let vectors = [&flat.displacement, &self.velocity, &flat.end_velocity];
        vectors.iter().all(|v| v.inner(v).sqrt() <= MODERATE)
    }

    /// The meaning of the points and their scalars.
    pub(crate) fn kind(&self) -> Kind {
        Kind {
            field: self.field,
            ..Kind::REAL_FRAMES
        }
    }

    /// Whether the points are real, not embedded complex ones.
    pub(crate) fn is_real(&self) -> bool {
        self.field == ScalarField::Real
    }

    /// The space.
    pub(crate) fn shape(&self) -> Shape {
        self.blocks().shape()
    }

    /// Ratio of squared lengths of real vectors to sums of squared coordinates.
    pub(crate) fn weight(&self) -> f64 {
        self.blocks().weight()
    }

    /// Sizes of the blocks.
    pub(crate) fn blocks(&self) -> Sizes {
        Sizes::of_kind(self.g.nrows() - self.k, self.k, self.kind())
    }

    /// Number of unknowns, `2d`.
    pub(crate) fn unknowns(&self) -> usize {
        2 * self.blocks().dim()
    }

    /// Displacement and end velocity along the quasi-geodesic between the end points; `None` if no quasi-geodesic joins
    /// them.
    ///
    /// # Errors
    /// `DifferentComponents`.
    pub(crate) fn flat(&self) -> Result<Option<FlatData>> {
        let (r, k) = self.end[0].shape();
        self.flat_in(&mut FlatWork::new(r, k))
    }

    /// The same in existing buffers.
    ///
    /// # Errors
    /// `DifferentComponents`.
    pub(crate) fn flat_in(&self, work: &mut FlatWork) -> Result<Option<FlatData>> {
        match FlatData::new(self.end[0].as_ref(), self.end[1].as_ref(), work) {
            Err(Error::NoJoiningCurve { .. } | Error::OutsideLogDomain { .. }) => Ok(None),
            other => other.map(Some),
        }
    }

    /// `(x', x'')` of the cubic of flat space; zeros if there is no displacement.
    pub(crate) fn flat_start(&self, flat: Option<&FlatData>) -> Vec<f64> {
        flat.map_or_else(|| vec![0.0; self.unknowns()], |flat| self.start_of(flat))
    }

    /// `(x', x'')` of the cubic of flat space with the given displacement and end velocity.
    pub(crate) fn start_of(&self, flat: &FlatData) -> Vec<f64> {
        let start = flat.start(&self.velocity, &FlatCoefficients::new(self.target.tension));
        pack(self.blocks(), &start)
    }

    /// `(x', x'')` from covariant acceleration and jerk at the start, shape `(n, k)`; components outside the span of
    /// the data are dropped.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotTangent`.
    pub(crate) fn start_from(
        &self,
        s0: MatRef<'_, f64>,
        a: MatRef<'_, f64>,
        j: MatRef<'_, f64>,
    ) -> Result<Vec<f64>> {
        let manifold = Stiefel::of("S0", s0)?;
        self.field.check([a, j])?;
        let horizontal = |name, v: MatRef<'_, f64>| {
            manifold.check_tangent(name, s0, v, TANGENT_TOLERANCE)?;
            let low = self
                .frame
                .as_ref()
                .map_or(v.to_owned(), |e| e.transpose() * v);
            Result::Ok(Horizontal::of_tangent(self.g.as_ref(), low.as_ref()))
        };
        let (a, j) = (horizontal("A", a)?, horizontal("J", j)?);
        let second = j.plus_bracket(-0.5, &self.velocity, &a);
        Ok(pack(self.blocks(), &[a, second]))
    }

    /// The curve with `y = (x', x'')` at the start, in the coordinates of the span.
    ///
    /// # Errors
    /// `TooManySteps`, `Overflow`, `Interrupted`.
    pub(crate) fn integrated(
        &self,
        y: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<PiecewiseTaylor> {
        let [a, second] = unpack(y, self.blocks());
        let state = State::new(&self.g, [&self.velocity, &a, &second]);
        self.integrated_to(1.0, state, interrupt)
    }

    /// The curve of legs of equal durations, each integrated from its first knot, with `x'` and `x''` there, all in the
    /// time of a leg; and the largest distance between the end of a leg and the start of the next one.
    ///
    /// # Errors
    /// As [`BoundaryProblem::integrated`].
    pub(crate) fn integrated_legs(
        &self,
        knots: &ChainKnots,
        derivatives: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<(PiecewiseTaylor, f64)> {
        let (r, d) = (self.g.nrows(), self.blocks().dim());
        let legs = derivatives.len() / (2 * d);
        let rate = legs as f64;
        let leg = |leg: usize| {
            let frame = &knots.frames[leg * r * r..][..r * r];
            let frame = &self.g * MatRef::from_row_major_slice(frame, r, r);
            let velocity = &knots.velocities[leg * d..][..d];
            let all = [velocity, &derivatives[2 * leg * d..][..2 * d]].concat();
            let scaled = all.iter().enumerate();
            let scaled = scaled.map(|(i, x)| x * rate.powi(1 + (i / d) as i32));
            let [x, a, second] = unpack(&scaled.collect::<Vec<_>>(), self.blocks());
            let mut state = State::new(&frame, [&x, &a, &second]);
            state.time = leg as f64 / rate;
            self.integrated_to((leg + 1) as f64 / rate, state, interrupt)
        };
        (1..legs).try_fold((leg(0)?, 0.0), |(curve, gap), next| {
            let next = leg(next)?;
            let between = curve.last.s().iter().zip(next.first.s());
            let here = between.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            Ok((curve.followed_by(next), larger(gap, here)))
        })
    }

    fn integrated_to(
        &self,
        t: f64,
        state: State,
        interrupt: Interrupt<'_>,
    ) -> Result<PiecewiseTaylor> {
        let mut taylor = PiecewiseTaylor::at(state.in_tension(self.target.tension), Accuracy::FULL);
        taylor.extend_to(t, interrupt)?;
        Ok(taylor)
    }
}

impl BoundaryProblem {
    /// The larger distance of an end of a curve, as it is evaluated, from the given one: point, and velocity in its
    /// unit. NaN is propagated.
    pub(crate) fn distance(&self, taylor: &PiecewiseTaylor) -> f64 {
        let (rows, r, k) = (taylor.rows(), self.g.nrows(), self.k);
        let start = self.initial();
        let ends = [(0.0, &start), (1.0, &self.end)];
        let [mut point, mut velocity] = [(); 2].map(|()| vec![0.0; rows * k]);
        let distances = ends.map(|(t, given)| {
            taylor.points_into(t, &mut [&mut point, &mut velocity]);
            let [s, v] = given.each_ref().map(|x| &self.g * x);
            let [found, rate] = [&point, &velocity]
                .map(|x| MatRef::from_column_major_slice(x, rows, k).subrows(0, r));
            let rate = (rate - v).norm_l2() / self.target.velocity_unit;
            (found - s).norm_l2().hypot(rate)
        });
        larger(distances[0], distances[1])
    }
}

/// Up to this bound, no solution cheaper than the one from the flat start is known for any of 400 random problems
/// (`docs/boundary_cost.md`). From rest to rest at distances of 2 to 2.79, for 5 of 40 problems on St(3,2) the flat
/// start leads to a solution that costs at least ten times as much.
const MODERATE: f64 = 2.0;

/// Check that `[S0, V0, S1, V1]` are points and tangent vectors at them.
///
/// # Errors
/// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`.
pub(crate) fn check_data([s0, v0, s1, v1]: [MatRef<'_, f64>; 4]) -> Result<()> {
    let manifold = Stiefel::of("S0", s0)?;
    manifold.check_point("S0", s0, POINT_TOLERANCE)?;
    manifold.check_point("S1", s1, POINT_TOLERANCE)?;
    manifold.check_tangent("V0", s0, v0, TANGENT_TOLERANCE)?;
    manifold.check_tangent("V1", s1, v1, TANGENT_TOLERANCE)
}

/// Speeds up to this are matched to an absolute tolerance, larger ones to a relative one.
pub(crate) const ABSOLUTE_SPEED: f64 = 10.0;

/// The exact point and tangent vector nearest to data that satisfy the constraints only to the tolerance, such as
/// rounded decimals.
fn corrected([s, mut v]: [Mat<f64>; 2]) -> [Mat<f64>; 2] {
    // A step of Newton's method for the polar factor: it squares the defect, which is below the tolerance for points.
    let mut defect = product(s.transpose(), &s);
    for i in 0..defect.nrows() {
        defect[(i, i)] -= 1.0;
    }
    let mut point = s.clone();
    mul_add(&mut point, -0.5, &s, &defect);
    let inner = product(point.transpose(), &v);
    mul_add(&mut v, -1.0, &point, symmetric_part(inner.as_ref()));
    [point, v]
}

impl Target {
    /// Built from an initial velocity, and an end point and end velocity of shape `(r, k)`.
    pub(crate) fn new(velocity: &Horizontal, end: &[Mat<f64>; 2], tension: f64) -> Self {
        let speed = velocity
            .omega
            .norm_l2()
            .hypot(velocity.normal.norm_l2())
            .max(end[1].norm_l2());
        let (m, k) = velocity.normal.shape();
        let blocks = Sizes::frames(m, k);
        Target {
            velocity: pack(blocks, std::slice::from_ref(velocity)),
            end: [entries(&end[0]), entries(&end[1])],
            speed,
            velocity_unit: if speed > ABSOLUTE_SPEED { speed } else { 1.0 },
            tension,
        }
    }
}
