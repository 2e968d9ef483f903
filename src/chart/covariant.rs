//! Conversion between states of a chart and point, velocity, covariant acceleration and covariant jerk.
//!
//! With the coordinate fields `d_i S` of the embedding and the canonical metric,
//!
//! ```math
//! p_{\dot q, i} = \langle \partial_i S, A \rangle,\qquad
//! p_{q, i} = \Gamma^k_{ij} \dot q^j p_{\dot q, k} - \langle \partial_i S, J \rangle
//! ```
//!
//! The first term of `p_q` is `-H_qdot / 2` at `p_q = 0`.
//!
//! # Source
//! From the definition of the momenta ([`Chart::momenta`]) and the covariant derivative of `p_qdot`.

use faer::{Mat, MatRef};
use nalgebra::SVector;

use super::chart::Chart;
use crate::error::{Error, Result};
use crate::manifold::covariant::christoffel;
use crate::manifold::stiefel::{POINT_TOLERANCE, Stiefel, TANGENT_TOLERANCE};

/// Point, velocity, covariant acceleration and covariant jerk of a curve at one time, each of shape `(3, k)`.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Interrupt;
/// use stiefel_rs::chart::{CovariantData, Sphere, covariant_from_state, reference, state_from_covariant};
/// let start = CovariantData {
///     point: mat![[1.0], [0.0], [0.0]],
///     velocity: mat![[0.0], [1.0], [0.0]],
///     acceleration: mat![[0.0], [0.0], [2.0]],
///     jerk: mat![[0.0], [3.0], [0.0]],
/// };
/// let state = state_from_covariant(&Sphere, &start)?;
/// let later = covariant_from_state(&Sphere, &reference(&Sphere, &state, &[0.5], Interrupt::NEVER)?[0])?;
/// for (before, after) in start.spatial_momentum().iter().zip(later.spatial_momentum()) {
///     assert!((before - after).abs() < 1e-12);
/// }
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CovariantData {
    /// The point `S`.
    pub point: Mat<f64>,
    /// `S'`.
    pub velocity: Mat<f64>,
    /// `D_t S'`.
    pub acceleration: Mat<f64>,
    /// `D_t^2 S'`.
    pub jerk: Mat<f64>,
}

impl CovariantData {
    /// Checks shapes `(3, k)`, finiteness, and that the vectors are tangent at the point.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`.
    pub fn check(&self, k: usize) -> Result<()> {
        let manifold = Stiefel::new(3, k)?;
        let point = self.point.as_ref();
        manifold.check_point("S", point, POINT_TOLERANCE)?;
        let vectors = [
            ("V", &self.velocity),
            ("A", &self.acceleration),
            ("J", &self.jerk),
        ];
        for (name, vector) in vectors {
            manifold.check_tangent(name, point, vector.as_ref(), TANGENT_TOLERANCE)?;
        }
        Ok(())
    }

    /// The momentum of the rotations of space about the three axes, which is constant along every Riemannian cubic.
    ///
    /// ```math
    /// \mu_i = \langle A, D_V \xi_i \rangle - \langle J, \xi_i \rangle,\qquad \xi_i = e_i \times S
    /// ```
    pub fn spatial_momentum(&self) -> [f64; 3] {
        let (s, v) = (self.point.as_ref(), self.velocity.as_ref());
        std::array::from_fn(|axis| {
            let field = cross(axis, s);
            let along = cross(axis, v) + christoffel(s, v, field.as_ref());
            inner(s, self.acceleration.as_ref(), along.as_ref())
                - inner(s, self.jerk.as_ref(), field.as_ref())
        })
    }

    /// The same data after `turns` rotations that map the first axis to the second and the second to the third.
    pub(super) fn turned(&self, turns: usize) -> Self {
        let turn =
            |m: &Mat<f64>| Mat::from_fn(3, m.ncols(), |i, j| m[((i + 3 - turns % 3) % 3, j)]);
        CovariantData {
            point: turn(&self.point),
            velocity: turn(&self.velocity),
            acceleration: turn(&self.acceleration),
            jerk: turn(&self.jerk),
        }
    }
}

/// The chart state of the cubic with these data.
///
/// # Arguments
/// * `data` - shapes `(3, K)`, orthonormal and tangent to 1e-9
/// # Errors
/// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`; `OutsideChart` at a pole; `Overflow` next to one.
pub fn state_from_covariant<C: Chart<X, Z>, const X: usize, const Z: usize>(
    chart: &C,
    data: &CovariantData,
) -> Result<SVector<f64, Z>> {
    data.check(C::K)?;
    let d = X / 2;
    let s = data.point.as_ref();
    let mut z = SVector::<f64, Z>::zeros();
    z.as_mut_slice()[..d].copy_from_slice(&coordinates(s)[..d]);
    chart.check("point", z.as_slice())?;
    let fields = coordinate_fields::<C, X, Z>(chart, &z)?;
    let lowered = |w: &Mat<f64>| -> Vec<f64> {
        let one = |field: &Mat<f64>| inner(s, field.as_ref(), w.as_ref());
        fields.iter().map(one).collect()
    };
    let velocity = raised::<C, X, Z>(chart, &z, &lowered(&data.velocity))?;
    z.as_mut_slice()[d..X].copy_from_slice(&velocity);
    z.as_mut_slice()[X + d..].copy_from_slice(&lowered(&data.acceleration));
    let (transport, jerk) = (chart.gradient(&z), lowered(&data.jerk));
    for i in 0..d {
        z[X + i] = -0.5 * transport[d + i] - jerk[i];
    }
    finite(z.as_slice())?;
    Ok(z)
}

/// The inverse of [`state_from_covariant`].
///
/// # Errors
/// `NonFinite`, `OutsideChart`; `Overflow` next to a pole.
pub fn covariant_from_state<C: Chart<X, Z>, const X: usize, const Z: usize>(
    chart: &C,
    z: &SVector<f64, Z>,
) -> Result<CovariantData> {
    chart.check("z", z.as_slice())?;
    let d = X / 2;
    let (q, qdot) = (&z.as_slice()[..d], &z.as_slice()[d..X]);
    let acceleration = raised::<C, X, Z>(chart, z, &z.as_slice()[X + d..])?;
    let mut rest = *z;
    rest.as_mut_slice()[X..X + d].fill(0.0);
    let transport = chart.gradient(&rest);
    let lowered: Vec<f64> = (0..d).map(|i| -0.5 * transport[d + i] - z[X + i]).collect();
    let jerk = raised::<C, X, Z>(chart, z, &lowered)?;
    Ok(CovariantData {
        point: chart.embed(q)?,
        velocity: chart.embed_velocity(q, qdot)?,
        acceleration: chart.embed_velocity(q, &acceleration)?,
        jerk: chart.embed_velocity(q, &jerk)?,
    })
}

/// `(theta, phi, psi)` of a point; a point of the sphere has the direction of the meridian as its second column.
fn coordinates(s: MatRef<'_, f64>) -> [f64; 3] {
    let (x, y, z) = (s[(0, 0)], s[(1, 0)], s[(2, 0)]);
    let (theta, phi) = (x.hypot(y).atan2(z), y.atan2(x));
    if s.ncols() == 1 {
        return [theta, phi, 0.0];
    }
    let ((st, ct), (sf, cf)) = (theta.sin_cos(), phi.sin_cos());
    let along = |e: [f64; 3]| -> f64 { (0..3).map(|i| e[i] * s[(i, 1)]).sum() };
    let psi = along([-sf, cf, 0.0]).atan2(along([ct * cf, ct * sf, -st]));
    [theta, phi, psi]
}

/// The coordinate fields `d_i S`.
fn coordinate_fields<C: Chart<X, Z>, const X: usize, const Z: usize>(
    chart: &C,
    z: &SVector<f64, Z>,
) -> Result<Vec<Mat<f64>>> {
    let d = X / 2;
    let q = &z.as_slice()[..d];
    (0..d)
        .map(|i| {
            let mut unit = vec![0.0; d];
            unit[i] = 1.0;
            chart.embed_velocity(q, &unit)
        })
        .collect()
}

/// Raises the index of a covector: the inverse metric is a block of the Hessian of the Hamiltonian.
fn raised<C: Chart<X, Z>, const X: usize, const Z: usize>(
    chart: &C,
    z: &SVector<f64, Z>,
    covector: &[f64],
) -> Result<Vec<f64>> {
    let d = X / 2;
    let hessian = chart.hessian(z);
    let vector: Vec<f64> = (0..d)
        .map(|i| {
            (0..d)
                .map(|j| hessian[(X + d + i, X + d + j)] * covector[j])
                .sum()
        })
        .collect();
    finite(&vector)?;
    Ok(vector)
}

fn finite(x: &[f64]) -> Result<()> {
    if x.iter().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(Error::Overflow { quantity: "state" })
    }
}

/// `e_axis x` every column.
fn cross(axis: usize, s: MatRef<'_, f64>) -> Mat<f64> {
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    Mat::from_fn(3, s.ncols(), |i, j| {
        if i == next {
            -s[(last, j)]
        } else if i == last {
            s[(next, j)]
        } else {
            0.0
        }
    })
}

/// The canonical metric `tr V^T (I - S S^T / 2) W`.
fn inner(s: MatRef<'_, f64>, v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> f64 {
    let dot = |a: MatRef<'_, f64>, i: usize, b: MatRef<'_, f64>, j: usize| -> f64 {
        (0..3).map(|r| a[(r, i)] * b[(r, j)]).sum()
    };
    let k = s.ncols();
    let mut sum = 0.0;
    for j in 0..k {
        sum += dot(v, j, w, j);
        for i in 0..k {
            sum -= 0.5 * dot(s, i, v, j) * dot(s, i, w, j);
        }
    }
    sum
}
