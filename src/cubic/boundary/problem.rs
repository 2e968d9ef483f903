//! Boundary data in coordinates in which the start is the first columns of the identity, and the inverse
//! transformation.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::guess::{FlatData, FlatWork};
use super::relative_ends::RelativeEnds;
use super::short_legs::ShortLegs;
use crate::cubic::boundary_options::BoundaryOptions;
use crate::cubic::riemannian_cubic::RiemannianCubic;
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
use crate::linalg::product::{mul_add, product};
use crate::linalg::structure::{identity_columns, symmetric_part};
use crate::manifold::Grassmann;
use crate::manifold::grassmann::alignment::{alignment, unique_alignment};
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel};
use crate::manifold::tangent::check_vector;
use crate::report::SolverReport;
use crate::shooting::LeastCost;
use crate::space::{Kind, Quotient, ScalarField, Shape};

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
    /// End point and end velocity; for subspaces, in the basis nearest to that at the start.
    pub(crate) end: [Mat<f64>; 2],
    /// The larger of the end speeds, in the Frobenius norm.
    pub(crate) speed: f64,
    pub(crate) tension: f64,
    kind: Kind,
}

impl BoundaryProblem {
    /// # Errors
    /// The errors of [`check_data`]; `RightAngle` for subspaces.
    pub(crate) fn new(data: [MatRef<'_, f64>; 4], options: &BoundaryOptions<'_>) -> Result<Self> {
        let (kind, field) = (options.kind(), options.field);
        check_data(kind.quotient, data)?;
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
        let mut velocity = Horizontal::of_components(components(v0).as_ref());
        let mut end = corrected(kind.quotient, [s1, v1].map(components));
        if kind.quotient == Quotient::Subspaces {
            let first = identity_columns(end[0].nrows(), end[0].ncols());
            let (turn, _) = unique_alignment(first.as_ref(), end[0].as_ref())?;
            end = end.map(|a| a * &turn);
            velocity.omega.fill(0.0);
        }
        Ok(BoundaryProblem {
            n: s0.nrows(),
            k: s0.ncols(),
            frame: span.into_basis(),
            g,
            speed: largest_speed(&velocity, &end),
            velocity,
            end,
            tension: options.tension,
            kind,
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

    /// Whether the cubic of flat space with the given displacement is near the solution: displacement and speeds are at
    /// most 2 in the canonical metric of the real matrices, and displacements of subspaces at most 1.4 or, if they are
    /// complex, 1.7. If lengths of complex frames up to 2 were measured in their own
    /// metric, the solution from the flat start would not be the cheapest in 17 of 420 complex problems between the two
    /// bounds, and the others would take longer.
    pub(crate) fn is_moderate(&self, flat: &FlatData) -> bool {
        let vectors = [&flat.displacement, &self.velocity, &flat.end_velocity];
        let nearest = match (self.kind.quotient, self.kind.field) {
            (Quotient::Frames, _) => MODERATE,
            (Quotient::Subspaces, ScalarField::Real) => OF_SUBSPACES,
            (Quotient::Subspaces, ScalarField::Complex) => OF_COMPLEX_SUBSPACES,
        };
        let mut pairs = vectors.iter().zip([nearest, MODERATE, MODERATE]);
        pairs.all(|(v, bound)| v.inner(v).sqrt() <= bound)
    }

    /// The meaning of the points and their scalars.
    pub(crate) fn kind(&self) -> Kind {
        self.kind
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
        let flat = match FlatData::new(self.end[0].as_ref(), self.end[1].as_ref(), work) {
            Err(Error::NoJoiningCurve { .. } | Error::OutsideLogDomain { .. }) => return Ok(None),
            other => other?,
        };
        Ok(Some(match self.kind.quotient {
            Quotient::Frames => flat,
            Quotient::Subspaces => flat.without_turns(),
        }))
    }

    /// `(x', x'')` of the cubic of flat space; zeros if there is no displacement.
    pub(crate) fn flat_start(&self, flat: Option<&FlatData>) -> Vec<f64> {
        flat.map_or_else(|| vec![0.0; self.unknowns()], |flat| self.start_of(flat))
    }

    /// `(x', x'')` of the cubic of flat space with the given displacement and end velocity.
    pub(crate) fn start_of(&self, flat: &FlatData) -> Vec<f64> {
        let start = flat.start(&self.velocity, &FlatCoefficients::new(self.tension));
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
        self.kind.field.check([a, j])?;
        let horizontal = |name, v: MatRef<'_, f64>| {
            check_vector(self.kind.quotient, name, s0, v)?;
            let low = self
                .frame
                .as_ref()
                .map_or(v.to_owned(), |e| e.transpose() * v);
            Result::Ok(Horizontal::of_tangent(self.g.as_ref(), low.as_ref()))
        };
        let (a, j) = (horizontal("A", a)?, horizontal("J", j)?);
        // The coordinates of subspaces leave out the part that turns bases.
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
        let mut taylor = PiecewiseTaylor::at(self.start(y), Accuracy::FULL);
        taylor.extend_to(1.0, interrupt)?;
        Ok(taylor)
    }

    /// The state at the start with the given `(x', x'')`.
    pub(crate) fn start(&self, y: &[f64]) -> State {
        let [a, second] = unpack(y, self.blocks());
        self.state_of(&self.g, [&self.velocity, &a, &second])
    }

    fn state_of(&self, frame: &Mat<f64>, vectors: [&Horizontal; 3]) -> State {
        let Sizes { m, k, quotient, .. } = self.blocks();
        let state = State::in_blocks(Sizes::new(m, k, quotient), frame, vectors);
        state.in_tension(self.tension)
    }

    /// The curve of a chain of legs of unit duration at rest, and the largest distance between points where legs meet.
    ///
    /// # Errors
    /// As [`BoundaryProblem::integrated`].
    pub(crate) fn integrated_legs(
        &self,
        chain: &LeastCost,
        interrupt: Interrupt<'_>,
    ) -> Result<(PiecewiseTaylor, f64)> {
        let legs = chain.legs();
        let state = |frame: &Mat<f64>, vectors: &[f64]| {
            let vectors = unpack::<3>(vectors, self.blocks());
            self.state_of(&(&self.g * frame), vectors.each_ref())
        };
        let legs = ShortLegs {
            chain,
            between: [0, legs],
            h: legs as f64,
            state: &state,
        };
        let (taylor, [gap, ..]) = legs.together(interrupt)?;
        Ok((taylor, gap))
    }

    /// The curve with the given polynomials in the coordinates of the span.
    pub(crate) fn curve(&self, taylor: PiecewiseTaylor, report: SolverReport) -> RiemannianCubic {
        let frame = self.frame.clone().map(Arc::new);
        RiemannianCubic::of_taylor(self.n, self.k, frame, taylor, Some(report))
    }
}

impl BoundaryProblem {
    /// The larger distance of an end of a curve, as it is evaluated, from the given one: point, and velocity in its
    /// unit. NaN is propagated.
    pub(crate) fn distance(&self, taylor: &PiecewiseTaylor) -> f64 {
        if self.kind.quotient == Quotient::Subspaces && self.unknowns() == 0 {
            // There is only one subspace.
            return 0.0;
        }
        let (rows, r, k) = (taylor.rows(), self.g.nrows(), self.k);
        let start = self.initial();
        let ends = [(0.0, &start), (1.0, &self.end)];
        let [mut point, mut velocity] = [(); 2].map(|()| vec![0.0; rows * k]);
        let distances = ends.map(|(t, given)| {
            taylor.points_into(t, &mut [&mut point, &mut velocity]);
            let [mut s, mut v] = given.each_ref().map(|x| &self.g * x);
            let [found, rate] = [&point, &velocity]
                .map(|x| MatRef::from_column_major_slice(x, rows, k).subrows(0, r));
            if self.kind.quotient == Quotient::Subspaces && t > 0.0 {
                let Ok(turn) = alignment(found, s.as_ref()) else {
                    return f64::INFINITY;
                };
                [s, v] = [s, v].map(|x| x * &turn);
            }
            let rate = (rate - v).norm_l2() / velocity_unit(self.speed);
            (found - s).norm_l2().hypot(rate)
        });
        larger(distances[0], distances[1])
    }
}

/// Up to this bound, no solution cheaper than the one from the flat start is known for any of 400 random problems
/// (`docs/boundary_cost.md`). From rest to rest at distances of 2 to 2.79, for 5 of 40 problems on St(3,2) the flat
/// start leads to a solution that costs at least ten times as much.
const MODERATE: f64 = 2.0;

/// The same for displacements of real and of complex subspaces. Of 640 real problems up to this bound with speeds up to 2
/// on Gr(3,2), (4,2), (5,2) and (6,3), the flat start leads to a dearer solution in one, with speeds of 3 to 6 in 27 of 480.
/// Of 270 complex ones on Gr(2,1), (4,2) and (6,2) with speeds up to 1.5 in their own metric, it does in none for
/// displacements up to 1.2 there, and in 7 of 90 at 1.4.
const OF_SUBSPACES: f64 = 1.4;
const OF_COMPLEX_SUBSPACES: f64 = 1.7;

/// Check that `[S0, V0, S1, V1]` are points and tangent vectors at them; horizontal ones for subspaces.
///
/// # Errors
/// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `NotHorizontal`.
pub(crate) fn check_data(quotient: Quotient, [s0, v0, s1, v1]: [MatRef<'_, f64>; 4]) -> Result<()> {
    match quotient {
        Quotient::Frames => {
            let manifold = Stiefel::of("S0", s0)?;
            manifold.check_point("S0", s0, POINT_TOLERANCE)?;
            manifold.check_point("S1", s1, POINT_TOLERANCE)?;
        }
        Quotient::Subspaces => {
            let manifold = Grassmann::of("S0", s0)?;
            manifold.check_point("S0", s0, POINT_TOLERANCE)?;
            manifold.check_point("S1", s1, POINT_TOLERANCE)?;
        }
    }
    check_vector(quotient, "V0", s0, v0)?;
    check_vector(quotient, "V1", s1, v1)
}

/// Speeds up to this are matched to an absolute tolerance, larger ones to a relative one.
const ABSOLUTE_SPEED: f64 = 10.0;

/// The exact point and tangent vector nearest to data that satisfy the constraints only to the tolerance, such as
/// rounded decimals.
fn corrected(quotient: Quotient, [s, mut v]: [Mat<f64>; 2]) -> [Mat<f64>; 2] {
    // A step of Newton's method for the polar factor: it squares the defect, which is below the tolerance for points.
    let mut defect = product(s.transpose(), &s);
    for i in 0..defect.nrows() {
        defect[(i, i)] -= 1.0;
    }
    let mut point = s.clone();
    mul_add(&mut point, -0.5, &s, &defect);
    let inner = product(point.transpose(), &v);
    let normal = match quotient {
        Quotient::Frames => symmetric_part(inner.as_ref()),
        Quotient::Subspaces => inner,
    };
    mul_add(&mut v, -1.0, &point, normal);
    [point, v]
}

/// The larger of the end speeds, in the Frobenius norm.
pub(crate) fn largest_speed(velocity: &Horizontal, end: &[Mat<f64>; 2]) -> f64 {
    let first = velocity.omega.norm_l2().hypot(velocity.normal.norm_l2());
    first.max(end[1].norm_l2())
}

/// Unit in which end velocities are compared: their round-off grows with the speed.
pub(crate) fn velocity_unit(speed: f64) -> f64 {
    if speed > ABSOLUTE_SPEED { speed } else { 1.0 }
}
