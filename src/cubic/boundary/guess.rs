//! The start of Newton's method: the cubic of flat space, transferred along the quasi-geodesic between the end points.
//!
//! ```math
//! a_0 = 6 \Delta - 4 V_0 - 2\,PT(V_1),\qquad j_0 = -12 \Delta + 6 V_0 + 6\,PT(V_1)
//! ```
//!
//! with `Delta` the initial velocity of the quasi-geodesic and `PT(V) = e^{-X} V e^{-Omega}`. It is exact in flat
//! space. In tension the coefficients are those of [`FlatCoefficients`].

use std::f64::consts::TAU;

use faer::{Mat, MatRef, Scale};

use crate::cubic::taylor::initial::Horizontal;
use crate::cubic::tension::FlatCoefficients;
use crate::error::{Error, Result};
use crate::linalg::decomp::Svd;
use crate::linalg::structure::identity_columns;
use crate::manifold::QuasiGeodesic;
use crate::manifold::carrier::carried;
use crate::manifold::quasi_geodesic::EndpointProblem;

/// Length by which the end point is moved along a unit tangent vector if no quasi-geodesic leads to it.
const DETOUR: f64 = 0.05;

/// Principal angles that differ by less than this count as equal: for complex subspaces, to round-off of their cosines
/// near 1.
const EQUAL_ANGLES: f64 = 1e-7;

/// Buffers for quasi-geodesics from the first columns of the identity, for one shape.
pub(crate) struct FlatWork {
    start: Mat<f64>,
    curve: QuasiGeodesic,
    endpoints: EndpointProblem,
}

impl FlatWork {
    pub(crate) fn new(r: usize, k: usize) -> Self {
        FlatWork {
            start: identity_columns(r, k),
            curve: QuasiGeodesic::zeros(r, k),
            endpoints: EndpointProblem::new(r, k),
        }
    }
}

/// Displacement and end velocity as tangent vectors at the start, in `m`.
pub(crate) struct FlatData {
    pub(crate) displacement: Horizontal,
    pub(crate) end_velocity: Horizontal,
}

impl FlatData {
    /// Computed from an end `(s1, v1)` in coordinates in which the start is the first `k` columns of the identity.
    ///
    /// # Errors
    /// `DifferentComponents`; `NoJoiningCurve` or `OutsideLogDomain` if no quasi-geodesic leads even to a nearby point.
    pub(crate) fn new(
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        work: &mut FlatWork,
    ) -> Result<Self> {
        let first = match Self::join(s1, v1, work) {
            Err(error @ (Error::NoJoiningCurve { .. } | Error::OutsideLogDomain { .. })) => error,
            other => return other,
        };
        // The cut locus has no interior: some nearby point can be joined.
        for attempt in 0..8_u32 {
            let end = detour(s1, v1, attempt)?;
            if let Ok(data) = Self::join(end.as_ref(), v1, work) {
                return Ok(data);
            }
        }
        Err(first)
    }

    fn join(s1: MatRef<'_, f64>, v1: MatRef<'_, f64>, work: &mut FlatWork) -> Result<Self> {
        let FlatWork {
            start,
            curve,
            endpoints,
        } = work;
        curve.join(start.as_ref(), s1, endpoints)?;
        Ok(FlatData {
            displacement: Horizontal::of_components(curve.initial_velocity().as_ref()),
            end_velocity: Horizontal::of_components(carried(curve, v1, -1.0)?.as_ref()),
        })
    }

    /// The part of the data that moves the span of the columns.
    pub(crate) fn without_turns(mut self) -> Self {
        self.displacement.omega.fill(0.0);
        self.end_velocity.omega.fill(0.0);
        self
    }

    /// The data with `turns` additional full turns, forwards and backwards: in each principal direction, then in each
    /// plane in which the columns rotate among themselves.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(crate) fn turned(&self, turns: f64) -> Result<Vec<Self>> {
        let Horizontal { omega, normal } = &self.displacement;
        let (m, k) = normal.shape();
        let mut directions = Vec::new();
        if m > 0 {
            let mut svd = Svd::new(m, k);
            svd.compute(normal.as_ref())?;
            directions.extend((0..m.min(k)).map(|i| Horizontal {
                omega: Mat::zeros(k, k),
                normal: svd.u().col(i) * svd.v().col(i).transpose(),
            }));
        }
        let mut svd = Svd::new(k, k);
        svd.compute(omega.as_ref())?;
        // Singular values of a skew matrix come in pairs, one pair for each plane.
        for i in (0..k / 2).map(|pair| 2 * pair).filter(|&i| svd.s(i) > 0.0) {
            let plane = svd.u().col(i) * svd.v().col(i).transpose();
            directions.push(Horizontal {
                omega: &plane - plane.transpose(),
                normal: Mat::zeros(m, k),
            });
        }
        Ok(self.with_turns(&directions, turns))
    }

    /// The data with additional full turns of all principal directions with equal angles together, if several are
    /// equal. For complex subspaces each angle occurs twice, and turning only one of the two leaves the complex
    /// subspaces.
    ///
    /// # Errors
    /// `Decomposition`.
    pub(crate) fn turned_together(&self, turns: f64) -> Result<Vec<Self>> {
        let Horizontal { omega, normal } = &self.displacement;
        let (m, k) = normal.shape();
        let mut svd = Svd::new(m, k);
        svd.compute(normal.as_ref())?;
        let (mut directions, mut first) = (Vec::new(), 0);
        for last in 1..=m.min(k) {
            if last < m.min(k) && svd.s(last - 1) - svd.s(last) <= EQUAL_ANGLES {
                continue;
            }
            if last - first > 1 {
                let [u, v] = [svd.u(), svd.v()].map(|x| x.subcols(first, last - first));
                directions.push(Horizontal {
                    omega: Mat::zeros(omega.nrows(), omega.ncols()),
                    normal: u * v.transpose(),
                });
            }
            first = last;
        }
        Ok(self.with_turns(&directions, turns))
    }

    /// Adds turns forwards and backwards along each of the given directions.
    fn with_turns(&self, directions: &[Horizontal], turns: f64) -> Vec<Self> {
        let both = directions
            .iter()
            .flat_map(|direction| [-turns, turns].map(|turns| (direction, turns * TAU)));
        both.map(|(direction, turn)| FlatData {
            displacement: self.displacement.clone().plus(turn, direction),
            end_velocity: self.end_velocity.clone(),
        })
        .collect()
    }

    /// Position and velocity of the cubic of flat space at a time in `[0, 1]`, from its initial velocity.
    pub(crate) fn at(&self, t: f64, velocity: &Horizontal) -> [Horizontal; 2] {
        let (one, two) = (t * t, t * t * t);
        [
            self.combined(
                velocity,
                [3.0 * one - 2.0 * two, t - 2.0 * one + two, two - one],
            ),
            self.combined(
                velocity,
                [
                    6.0 * (t - one),
                    1.0 - 4.0 * t + 3.0 * one,
                    3.0 * one - 2.0 * t,
                ],
            ),
        ]
    }

    /// A bound on its speed: the larger one of both ends and the middle, for a quadratic velocity.
    pub(crate) fn largest_speed(&self, velocity: &Horizontal) -> f64 {
        let [_, middle] = self.at(0.5, velocity);
        let speeds = [velocity, &self.end_velocity, &middle].map(Horizontal::norm);
        speeds.into_iter().fold(0.0, f64::max)
    }

    /// A linear combination of displacement, initial and end velocity.
    fn combined(&self, velocity: &Horizontal, [delta, first, last]: [f64; 3]) -> Horizontal {
        let zero = self
            .displacement
            .clone()
            .plus(delta - 1.0, &self.displacement);
        zero.plus(first, velocity).plus(last, &self.end_velocity)
    }

    /// `x'` and `x''` at the start, from the velocity there.
    pub(crate) fn start(&self, velocity: &Horizontal, flat: &FlatCoefficients) -> [Horizontal; 2] {
        let part = |pick: fn(&Horizontal) -> &Mat<f64>| {
            let [delta, v0, v1] = [&self.displacement, velocity, &self.end_velocity].map(pick);
            [flat.second, flat.third].map(|[by_point, by_velocity]| {
                delta * Scale(by_point) - v0 * Scale(by_point + by_velocity)
                    + v1 * Scale(by_velocity)
            })
        };
        let [[omega_a, omega_j], [normal_a, normal_j]] = [part(|v| &v.omega), part(|v| &v.normal)];
        let acceleration = Horizontal {
            omega: omega_a,
            normal: normal_a,
        };
        let jerk = Horizontal {
            omega: omega_j,
            normal: normal_j,
        };
        // j = x'' + [x, x']_m / 2.
        let second = jerk.plus_bracket(-0.5, velocity, &acceleration);
        [acceleration, second]
    }
}

/// A point near `s`: first along the velocity there, then along other directions.
fn detour(s: MatRef<'_, f64>, v: MatRef<'_, f64>, attempt: u32) -> Result<Mat<f64>> {
    let (r, k) = s.shape();
    let direction = Mat::from_fn(r, k, |i, j| {
        let along = if attempt == 0 { v[(i, j)] } else { 0.0 };
        along + 1e-3 * ((1 + attempt) as f64 * (1.0 + i as f64 + 3.0 * j as f64)).sin()
    });
    let normal = &direction - s * (s.transpose() * &direction);
    let inner = s.transpose() * &direction;
    let tangent = normal + s * (&inner - inner.transpose()) * Scale(0.5);
    let size = tangent.norm_l2();
    let scale = if size > 0.0 { DETOUR / size } else { 0.0 };
    QuasiGeodesic::from_velocity(s, (tangent * Scale(scale)).as_ref())
        .map(|curve| crate::curve::Curve::point(&curve, 1.0))?
}
