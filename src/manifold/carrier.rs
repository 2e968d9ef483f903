//! Vectors carried along a quasi-geodesic by the rotations that generate it.

use faer::prelude::*;
use faer::{Mat, MatMut, MatRef};

use super::QuasiGeodesic;
use crate::error::Result;
use crate::linalg::SkewExp;
use crate::linalg::product::{mul_add, mul_into, product};
use crate::solve::direction::Direction;

/// `V -> e^{X} V e^{Omega}` and its inverse, for the factors of one quasi-geodesic, with buffers allocated once per
/// shape.
///
/// ```math
/// e^{X} V = V + F \begin{pmatrix} \cos\Sigma - I & -\sin\Sigma \\ \sin\Sigma & \cos\Sigma - I \end{pmatrix} F^T V,\qquad
/// F = [S W, Q]
/// ```
///
/// This is an isometry of the tangent spaces at both ends that carries the velocity of the curve along. It also maps
/// the start to the end. Cost `O(n k^2)`.
pub(crate) struct Carrier {
    exp: SkewExp,
    /// `e^{Omega}`.
    turn: Mat<f64>,
    /// `cos - 1` and `sin` of the angles.
    planes: Vec<[f64; 2]>,
    components: Mat<f64>,
    moved: Mat<f64>,
}

impl Carrier {
    pub(crate) fn new(n: usize, k: usize) -> Self {
        Carrier {
            exp: SkewExp::new(k),
            turn: Mat::zeros(k, k),
            planes: vec![[0.0; 2]; k],
            components: Mat::zeros(2 * k, k),
            moved: Mat::zeros(n, k),
        }
    }

    /// Sets the curve for [`Carrier::carry`].
    ///
    /// # Errors
    /// `Overflow`, `Decomposition`.
    pub(crate) fn set(&mut self, curve: &QuasiGeodesic) -> Result<()> {
        for (plane, angle) in self.planes.iter_mut().zip(curve.angles()) {
            *plane = turn_of(*angle);
        }
        self.exp.exp_into(self.turn.as_mut(), curve.omega(), 1.0)
    }

    /// For a curve with `Omega = 0`: carried vectors refer to the basis `e^{X} S R` of the last subspace.
    pub(crate) fn turn_basis(&mut self, turn: &Mat<f64>) {
        self.turn.copy_from(turn);
    }

    /// Carries `v`, shape `(n, k)`, along the curve set by `set`.
    pub(crate) fn carry(&mut self, curve: &QuasiGeodesic, v: MatMut<'_, f64>, way: Direction) {
        let mut v = v;
        self.turn_planes(curve, v.rb(), way);
        mul_add(v.rb_mut(), 1.0, curve.frame(), &self.components);
        self.moved.copy_from(v.rb());
        match way {
            Direction::Forward => mul_into(v, 1.0, &self.moved, &self.turn),
            Direction::Backward => mul_into(v, 1.0, &self.moved, self.turn.transpose()),
        }
    }

    /// The change of `v` by `e^{X} - I`, from its components in the frame.
    fn turn_planes(&mut self, curve: &QuasiGeodesic, v: MatRef<'_, f64>, way: Direction) {
        let k = v.ncols();
        mul_into(&mut self.components, 1.0, curve.frame().transpose(), v);
        for (i, &[cos, sin]) in self.planes.iter().enumerate() {
            let sin = match way {
                Direction::Forward => sin,
                Direction::Backward => -sin,
            };
            for j in 0..k {
                let (along, across) = (self.components[(i, j)], self.components[(k + i, j)]);
                self.components[(i, j)] = cos * along - sin * across;
                self.components[(k + i, j)] = cos * across + sin * along;
            }
        }
    }
}

/// `cos - 1` and `sin` of an angle, without cancellation.
fn turn_of(angle: f64) -> [f64; 2] {
    let half = (0.5 * angle).sin();
    [-2.0 * half * half, angle.sin()]
}

/// `e^{tX} V e^{t Omega}` for the factors of a quasi-geodesic: moves a vector at its start on by `t`.
///
/// # Errors
/// `Overflow`, `Decomposition`.
pub(crate) fn carried(curve: &QuasiGeodesic, v: MatRef<'_, f64>, t: f64) -> Result<Mat<f64>> {
    let k = v.ncols();
    let mut turn = Mat::zeros(k, k);
    SkewExp::new(k).exp_into(turn.as_mut(), curve.omega(), t)?;
    Ok(product(turned(curve, v, t), turn))
}

/// `e^{tX} A` for the factor of a quasi-geodesic.
pub(crate) fn turned(curve: &QuasiGeodesic, a: MatRef<'_, f64>, t: f64) -> Mat<f64> {
    let k = curve.k();
    let mut components = product(curve.frame().transpose(), a);
    for (i, angle) in curve.angles().iter().enumerate() {
        let [cos, sin] = turn_of(t * angle);
        for j in 0..a.ncols() {
            let (along, across) = (components[(i, j)], components[(k + i, j)]);
            components[(i, j)] = cos * along - sin * across;
            components[(k + i, j)] = cos * across + sin * along;
        }
    }
    let mut out = a.to_owned();
    mul_add(&mut out, 1.0, curve.frame(), &components);
    out
}
