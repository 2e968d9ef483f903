//! A fixed quasi-geodesic at eight parameters at once.

use crate::error::Result;
use crate::linalg::SkewSchur;
use crate::linalg::lane_jet::LaneJet;
use crate::linalg::lane_matrix::LaneMatrix;
use crate::linalg::lanes::Lanes;
use crate::manifold::QuasiGeodesic;

/// `beta(t) = F [cos(t Sigma) G; sin(t Sigma) G]` with `G = W^T V e^{t D} V^T`, `Omega = V D V^T` in real Schur form.
/// Everything that does not depend on `t` is computed once.
#[derive(Debug, Clone)]
pub(crate) struct LaneLeg {
    k: usize,
    /// `[S W, Q]` in column-major order, `r x 2k`.
    frame: Vec<f64>,
    angles: Vec<f64>,
    /// `W^T V` and `V`, in column-major order.
    right: Vec<f64>,
    basis: Vec<f64>,
    /// Angles of `Omega`.
    turns: Vec<f64>,
}

/// Buffers for legs of one `k`.
pub(crate) struct LaneLegWork {
    turned: LaneMatrix,
    coordinates: LaneJet,
    /// Taylor coefficients of `W^T V e^{tD}` and of `W^T V e^{tD} V^T`.
    moved: LaneJet,
    turning: LaneJet,
}

impl LaneLegWork {
    pub(crate) fn new(k: usize) -> Self {
        LaneLegWork {
            turned: LaneMatrix::zeros(k, k),
            coordinates: LaneJet::zeros(2 * k, k),
            moved: LaneJet::zeros(k, k),
            turning: LaneJet::zeros(k, k),
        }
    }
}

impl LaneLeg {
    pub(crate) fn new(curve: &QuasiGeodesic) -> Result<Self> {
        let k = curve.k();
        let mut schur = SkewSchur::new(k);
        schur.compute(curve.omega())?;
        let right = curve.right() * schur.basis();
        let by_columns = |a: faer::MatRef<'_, f64>| -> Vec<f64> {
            (0..a.ncols())
                .flat_map(|j| (0..a.nrows()).map(move |i| a[(i, j)]))
                .collect()
        };
        Ok(LaneLeg {
            k,
            frame: by_columns(curve.frame()),
            angles: curve.angles().to_vec(),
            right: by_columns(right.as_ref()),
            basis: by_columns(schur.basis()),
            turns: schur.angles().to_vec(),
        })
    }

    /// A bound on the spectral norm of the velocity: the largest angle of the normal part plus the largest angle of
    /// `Omega`.
    pub(crate) fn speed_bound(&self) -> f64 {
        let largest = |angles: &[f64]| angles.iter().fold(0.0_f64, |m, &x| m.max(x));
        largest(&self.angles) + largest(&self.turns)
    }

    /// Computes positions, shape `(r, k)`.
    #[inline(always)]
    pub(crate) fn points_into(&self, t: Lanes, work: &mut LaneLegWork, out: &mut LaneMatrix) {
        let k = self.k;
        self.turn(t, work);
        for i in 0..k {
            let (sin, cos) = (t * self.angles[i]).sin_cos();
            for j in 0..k {
                let g = if k == 1 {
                    Lanes::splat(self.right[0])
                } else {
                    self.turned_entry(&work.turned, i, j)
                };
                work.coordinates.c[0].set(i, j, g * cos);
                work.coordinates.c[0].set(k + i, j, g * sin);
            }
        }
        out.set_constant_product(&self.frame, &work.coordinates.c[0]);
    }

    /// Computes Taylor coefficients, shape `(r, k)`.
    #[inline(always)]
    pub(crate) fn jets_into(
        &self,
        t: Lanes,
        order: usize,
        work: &mut LaneLegWork,
        out: &mut LaneJet,
    ) {
        let k = self.k;
        self.turn_jets(t, order, work);
        for i in 0..k {
            let theta = self.angles[i];
            let (sin, cos) = (t * theta).sin_cos();
            for j in 0..=order {
                for l in 0..k {
                    let (mut upper, mut lower, mut factor) = (Lanes::ZERO, Lanes::ZERO, 1.0);
                    for a in 0..=j {
                        // The a-th Taylor coefficients of cos(t theta) and sin(t theta).
                        let (c, s) = match a {
                            0 => (cos, sin),
                            1 => (-sin, cos),
                            2 => (-cos, -sin),
                            _ => (sin, -cos),
                        };
                        let g = work.turning.c[j - a].at(i, l) * factor;
                        upper += g * c;
                        lower += g * s;
                        factor *= theta / (a + 1) as f64;
                    }
                    work.coordinates.c[j].set(i, l, upper);
                    work.coordinates.c[j].set(k + i, l, lower);
                }
            }
        }
        for j in 0..=order {
            out.c[j].set_constant_product(&self.frame, &work.coordinates.c[j]);
        }
    }

    /// Taylor coefficients of `W^T V e^{tD} V^T`.
    #[inline(always)]
    fn turn_jets(&self, t: Lanes, order: usize, work: &mut LaneLegWork) {
        let k = self.k;
        self.turn(t, work);
        for j in 0..=order {
            for (l, &angle) in self.turns.iter().enumerate() {
                let factor = angle.powi(j as i32) / [1.0, 1.0, 2.0, 6.0][j];
                for i in 0..k {
                    let (f, g) = (work.turned.at(i, 2 * l), work.turned.at(i, 2 * l + 1));
                    // Each derivative maps (f, g) to angle (g, -f).
                    let (f, g) = match j {
                        0 => (f, g),
                        1 => (g, -f),
                        2 => (-f, -g),
                        _ => (-g, f),
                    };
                    work.moved.c[j].set(i, 2 * l, f * factor);
                    work.moved.c[j].set(i, 2 * l + 1, g * factor);
                }
            }
            if k % 2 == 1 {
                for i in 0..k {
                    let fixed = if j == 0 {
                        self.right[(k - 1) * k + i]
                    } else {
                        0.0
                    };
                    work.moved.c[j].set(i, k - 1, Lanes::splat(fixed));
                }
            }
            for i in 0..k {
                for l in 0..k {
                    let entry = self.turned_entry(&work.moved.c[j], i, l);
                    work.turning.c[j].set(i, l, entry);
                }
            }
        }
    }

    /// `W^T V e^{tD}`.
    #[inline(always)]
    fn turn(&self, t: Lanes, work: &mut LaneLegWork) {
        let k = self.k;
        for (l, &angle) in self.turns.iter().enumerate() {
            let (sin, cos) = (t * angle).sin_cos();
            for i in 0..k {
                let (x, y) = (self.right[2 * l * k + i], self.right[(2 * l + 1) * k + i]);
                work.turned.set(i, 2 * l, cos * x + sin * y);
                work.turned.set(i, 2 * l + 1, cos * y - sin * x);
            }
        }
        if k % 2 == 1 {
            for i in 0..k {
                work.turned
                    .set(i, k - 1, Lanes::splat(self.right[(k - 1) * k + i]));
            }
        }
    }

    /// Entry of `W^T V e^{tD} V^T`.
    #[inline(always)]
    fn turned_entry(&self, turned: &LaneMatrix, i: usize, j: usize) -> Lanes {
        let mut sum = Lanes::ZERO;
        for l in 0..self.k {
            sum += turned.at(i, l) * self.basis[l * self.k + j];
        }
        sum
    }
}
