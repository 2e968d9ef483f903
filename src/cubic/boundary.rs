//! Riemannian cubics from boundary data.

use faer::{Mat, MatRef};

use super::guess::FlatData;
use super::initial::{Horizontal, complete};
use super::path::{Path, State};
use super::reduced::{Blocks, Fixed, Sized};
use super::riemannian_cubic::RiemannianCubic;
use super::shooting::{SOLVER, Shooting, Target};
use super::taylor::Accuracy;
use crate::curve::span::Span;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};
use crate::report::SolverReport;

/// How a boundary value problem is solved.
#[derive(Clone, Copy)]
pub struct BoundaryOptions<'a> {
    /// Converged once `(|S(1) - S1|^2 + |V(1) - V1|^2)^(1/2)` is at most this.
    pub tolerance: f64,
    /// Newton steps at the most, for one start.
    pub max_iterations: usize,
    /// Asked before every step.
    pub interrupt: Interrupt<'a>,
}

impl Default for BoundaryOptions<'_> {
    /// Residual `1e-12`, at most 50 steps.
    fn default() -> Self {
        BoundaryOptions {
            tolerance: 1e-12,
            max_iterations: 50,
            interrupt: Interrupt::NEVER,
        }
    }
}

impl RiemannianCubic {
    /// A Riemannian cubic on `[0, 1]` with end points `s0, s1` and end velocities `v0, v1`, all of shape `(n, k)`.
    ///
    /// Cubics with given ends are stationary, not unique. This one is found by Newton's method from the cubic of flat space.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`, `InvalidArgument`, `DifferentComponents`, `NoConvergence`, `Interrupted`.
    pub fn from_boundary(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
        options: &BoundaryOptions<'_>,
    ) -> Result<Self> {
        if !(options.tolerance >= 0.0 && options.tolerance.is_finite()) {
            return Err(Error::InvalidArgument {
                name: "tolerance",
                requirement: "finite and not negative",
                found: options.tolerance,
            });
        }
        let problem = Problem::new(s0, v0, s1, v1)?;
        let mut y = problem.flat_start()?;
        let report = problem.shoot(&mut y, options)?;
        if !report.converged {
            return Err(Error::NoConvergence {
                solver: SOLVER,
                report,
            });
        }
        problem.curve(&y, report, options.interrupt)
    }
}

/// Boundary data in coordinates in which the start is the first columns of the identity.
struct Problem {
    n: usize,
    k: usize,
    /// Orthonormal basis of the span of the data, where that is smaller than `R^n`.
    frame: Option<Mat<f64>>,
    /// Orthogonal, its first columns the start.
    g: Mat<f64>,
    velocity: Horizontal,
    /// End point and end velocity.
    end: [Mat<f64>; 2],
    target: Target,
}

impl Problem {
    fn new(
        s0: MatRef<'_, f64>,
        v0: MatRef<'_, f64>,
        s1: MatRef<'_, f64>,
        v1: MatRef<'_, f64>,
    ) -> Result<Self> {
        let manifold = Stiefel::of("S0", s0)?;
        manifold.check_point("S0", s0, POINT_TOLERANCE)?;
        manifold.check_point("S1", s1, POINT_TOLERANCE)?;
        manifold.check_tangent("V0", s0, v0, TANGENT_TOLERANCE)?;
        manifold.check_tangent("V1", s1, v1, TANGENT_TOLERANCE)?;
        let span = Span::of(&[s0, v0, s1, v1]);
        let g = complete(span.down(s0).as_ref());
        let velocity = Horizontal::of_tangent(g.as_ref(), span.down(v0).as_ref());
        let end = [s1, v1].map(|a| g.transpose() * span.down(a));
        let target = Target {
            velocity: [entries(&velocity.omega), entries(&velocity.normal)],
            end: [entries(&end[0]), entries(&end[1])],
        };
        Ok(Problem {
            n: s0.nrows(),
            k: s0.ncols(),
            frame: span.into_basis(),
            g,
            velocity,
            end,
            target,
        })
    }

    /// `(x', x'')` of the cubic of flat space.
    fn flat_start(&self) -> Result<Vec<f64>> {
        let flat = FlatData::new(self.end[0].as_ref(), self.end[1].as_ref())?;
        let [a, second] = flat.start(&self.velocity);
        let mut y = Vec::new();
        for vector in [a, second] {
            for col in 0..self.k {
                y.extend((0..col).map(|row| vector.omega[(row, col)]));
            }
            y.extend(entries(&vector.normal));
        }
        Ok(y)
    }

    fn shoot(&self, y: &mut [f64], options: &BoundaryOptions<'_>) -> Result<SolverReport> {
        let (m, k) = (self.g.nrows() - self.k, self.k);
        match (m, k) {
            (1, 1) => self.shoot_in::<_, 2>(Fixed::<1, 1>, y, options),
            (2, 1) => self.shoot_in::<_, 4>(Fixed::<2, 1>, y, options),
            (3, 1) => self.shoot_in::<_, 6>(Fixed::<3, 1>, y, options),
            (1, 2) => self.shoot_in::<_, 6>(Fixed::<1, 2>, y, options),
            _ => self.shoot_in::<_, 8>(Sized { m, k }, y, options),
        }
    }

    fn shoot_in<B: Blocks, const N: usize>(
        &self,
        blocks: B,
        y: &mut [f64],
        options: &BoundaryOptions<'_>,
    ) -> Result<SolverReport> {
        Shooting::<B, N>::new(blocks, &self.target, options.interrupt).solve(
            y,
            options.tolerance,
            options.max_iterations,
        )
    }

    /// The curve from `y = (x', x'')`.
    fn curve(
        self,
        y: &[f64],
        report: SolverReport,
        interrupt: Interrupt<'_>,
    ) -> Result<RiemannianCubic> {
        let (r, k) = (self.g.nrows(), self.k);
        let vector = |y: &[f64]| {
            let (upper, lower) = y.split_at(k * (k - 1) / 2);
            let omega = Mat::from_fn(k, k, |i, j| match i.cmp(&j) {
                std::cmp::Ordering::Less => upper[j * (j - 1) / 2 + i],
                std::cmp::Ordering::Equal => 0.0,
                std::cmp::Ordering::Greater => -upper[i * (i - 1) / 2 + j],
            });
            [entries(&omega), lower.to_vec()]
        };
        let (first, second) = y.split_at(y.len() / 2);
        let ([omega1, b1], [omega2, b2]) = (vector(first), vector(second));
        let [omega, b] = self.target.velocity;
        let g = entries(&self.g);
        let (s, e) = g.split_at(r * k);
        let state = State {
            time: 0.0,
            s: s.to_vec(),
            e: e.to_vec(),
            omega: [omega, omega1, omega2],
            b: [b, b1, b2],
        };
        let mut path = Path::at(state, k, Accuracy::FULL);
        path.extend_to(1.0, interrupt)?;
        Ok(RiemannianCubic::of_path(
            self.n,
            k,
            self.frame,
            path,
            Some(report),
        ))
    }
}

fn entries(a: &Mat<f64>) -> Vec<f64> {
    a.col_iter().flat_map(|c| c.iter().copied()).collect()
}
