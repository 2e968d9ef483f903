//! The flow of Riemannian cubics linearised along one of them: forward in the initial data, and transposed.
//!
//! A variation is described by four tangent vectors: the displacement `p` of the point, and the variations `w, a, b` of
//! `x, x', x''` relative to the rotation of the whole space that displaces the point. The form
//!
//! ```math
//! \omega(1, 2) = \langle a_1, w_2\rangle - \langle w_1, a_2\rangle - \langle b_1, p_2\rangle + \langle p_1, b_2\rangle
//!     + \langle x'', [p_1, p_2]_m\rangle - \langle [x, x']_h, [p_1, p_2]_h\rangle
//! ```
//!
//! of two variations of a cubic is constant in time: the cubics are the critical curves of half the cost, whose
//! boundary terms are `<x', w> - <x'', p>`. Hence the variation `eta` that jumps by the cotangent `D` in `b` alone at
//! some time yields the product of `D` with the displacement at that time, from the data at any other time,
//!
//! ```math
//! \langle D, p(t)\rangle = -\omega(\eta, \cdot)
//! ```
//!
//! and the same holds for sums: one integration back to the start collects any number of cotangents. In tension `b -
//! tau w` and `x'' - tau x` take the place of `b` and `x''` in `omega`.
//!
//! A variation that leaves the span of the curve adds a row below the matrices for every direction orthogonal to the
//! span; all these rows satisfy the same linear equations in `4k` unknowns.
//!
//! # Source
//! Conservation of the symplectic form by Hamiltonian flows: Arnold (1989), "Mathematical Methods of Classical Mechanics", 2nd
//! ed., sec. 38; its boundary form by the second variation: Marsden, West (2001), "Discrete mechanics and variational
//! integrators", Acta Numerica 10, 357-514, sec. 1.2.

use faer::{Mat, MatRef, Scale};

use super::variation::{Reached, start, vary};
use crate::cubic::taylor::blocks::{BlockSizes, Sizes};
use crate::cubic::taylor::initial::{Horizontal, InitialData};
use crate::cubic::taylor::march::{Accuracy, TaylorMarch};
use crate::cubic::taylor::state::State;
use crate::cubic::turning::{bracket, turned};
use crate::curve::sampling::check_parameter;
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use crate::linalg::dual::Dual;
use crate::linalg::structure::{check_finite, check_range, check_shape};
use crate::space::Quotient;

/// Quantity named in `Overflow` errors.
pub(crate) const VARIATION: &str = "variation of a Riemannian cubic";

/// The linearised flow from the start of a curve.
#[derive(Debug, Clone)]
pub(crate) struct LinearFlow {
    pub(crate) data: InitialData,
    /// The frame at the start, shape `(n, r)`; its columns span the curve.
    pub(crate) frame: Mat<f64>,
}

/// A time relative to the start and a cotangent there, in the coordinates of the frame at the start, shape `(r, k)`.
type FlowLoad = (f64, Mat<f64>);

impl LinearFlow {
    /// Built from point, velocity, covariant acceleration and covariant jerk at the start, shape `(n, k)`, and the
    /// tension.
    ///
    /// # Errors
    /// `Shape`, `NonFinite`, `NotOrthonormal`, `NotTangent`.
    pub(crate) fn new(
        [s, v, a, j]: [MatRef<'_, f64>; 4],
        tension: f64,
        quotient: Quotient,
    ) -> Result<Self> {
        Ok(Self::of_data(
            InitialData::new(s, v, a, j, quotient)?.in_tension(tension),
        ))
    }

    fn of_data(data: InitialData) -> Self {
        let frame = match &data.frame {
            Some(basis) => basis * &data.g,
            None => data.g.clone(),
        };
        LinearFlow { data, frame }
    }

    /// Built from the start of a curve in the coordinates of a basis.
    pub(crate) fn of_taylor(start: &State, basis: Option<Mat<f64>>) -> Self {
        let (quotient, vectors) = (start.blocks.quotient, start.vectors());
        let jerk = Horizontal::jerk(quotient, vectors.each_ref());
        let [velocity, acceleration, _] = vectors;
        Self::of_data(InitialData {
            frame: basis,
            g: start.frame().to_owned(),
            velocity,
            acceleration,
            jerk,
            tension: start.tension,
            quotient,
        })
    }

    /// Rows and columns of the blocks in the span.
    pub(crate) fn blocks(&self) -> Sizes {
        let k = self.data.velocity.omega.nrows();
        let m = self.frame.ncols() - k;
        Sizes::new(m, k, self.data.quotient)
    }

    /// Whether there are directions orthogonal to the span.
    pub(crate) fn has_rows(&self) -> bool {
        self.frame.ncols() < self.frame.nrows()
    }

    /// The point at the start.
    fn point(&self) -> MatRef<'_, f64> {
        self.frame.subcols(0, self.blocks().k)
    }

    /// The tangent vector at the start with the given coordinates.
    fn up(&self, x: &Horizontal) -> Mat<f64> {
        &self.frame * x.tangent()
    }

    /// The part of the columns outside the span.
    pub(crate) fn off(&self, mut columns: Mat<f64>) -> Mat<f64> {
        for _ in 0..2 {
            let along = self.frame.transpose() * &columns;
            columns -= &self.frame * along;
        }
        columns
    }

    /// The variations of the points at some times, shape `(n, k)` each, for `(p, w, a, b)` at the start.
    ///
    /// # Errors
    /// `TooManySteps`, `Overflow`, `Interrupted`.
    pub(crate) fn points(
        &self,
        start: &[Mat<f64>; 4],
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        let k = self.blocks().k;
        let [p, vectors @ ..] = start.each_ref().map(|x| x.as_ref());
        let inside = vectors.map(|v| Horizontal::of_tangent(self.frame.as_ref(), v));
        let found = vary::<1>(&self.data, 0, &[inside], times, interrupt)?;
        let moved = |reached: &Reached| {
            let frame = &self.frame * &reached.frame;
            let displaced = turned(self.point(), p, frame.subcols(0, k));
            let displaced = displaced + &frame * reached.variations[0][0].tangent();
            match self.data.quotient {
                Quotient::Frames => displaced,
                // What remains is the rotation of the basis.
                Quotient::Subspaces => {
                    let point = frame.subcols(0, k);
                    &displaced - point * (point.transpose() * &displaced)
                }
            }
        };
        let mut out: Vec<Mat<f64>> = found.iter().map(moved).collect();
        if self.has_rows() {
            let rows = self.off(side_by_side(&vectors));
            let flows = self.row_flows(times, interrupt)?;
            for (out, flow) in out.iter_mut().zip(flows) {
                *out += &rows * flow.submatrix(0, k, k, 3 * k).transpose();
            }
        }
        for point in &out {
            check_range(VARIATION, point.as_ref())?;
        }
        Ok(out)
    }

    /// `(p, w, a, b)` at the start of the variation `eta` that collects cotangents at given times.
    ///
    /// # Errors
    /// `TooManySteps`, `Overflow`, `Interrupted`.
    pub(crate) fn collected(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 4]> {
        let low = cotangents.iter().map(|w| self.frame.transpose() * w);
        let mut loads: Vec<FlowLoad> = times.iter().copied().zip(low).collect();
        // From the latest time down to the start, and from the earliest up to it.
        loads.sort_by(|one, other| other.0.total_cmp(&one.0));
        let later = loads.partition_point(|load| load.0 >= 0.0);
        let (later, earlier) = loads.split_at_mut(later);
        earlier.reverse();
        let (n, k) = (self.frame.nrows(), self.blocks().k);
        let mut eta: [Mat<f64>; 4] = std::array::from_fn(|_| Mat::zeros(n, k));
        for side in [&*later, &*earlier] {
            if side.is_empty() {
                continue;
            }
            let found = self.carried_back(side, interrupt)?;
            for (eta, found) in eta.iter_mut().zip(&found) {
                *eta += self.up(found);
            }
        }
        if self.has_rows() {
            let mut bars = Mat::zeros(n, 4 * k);
            let flows = self.row_flows(times, interrupt)?;
            for (flow, cotangent) in flows.iter().zip(cotangents) {
                bars += self.off(cotangent.to_owned()) * flow.subrows(0, k);
            }
            let [by_p, by_w, by_a, by_b] = [0, 1, 2, 3].map(|i| bars.subcols(i * k, k));
            // The inverse of `gradient`.
            let (p, tension) = (by_b * Scale(-1.0), Scale(self.data.tension));
            eta[1] += by_a;
            eta[2] += &p * tension - by_w;
            eta[3] += by_p + by_a * tension + self.twisted(&p);
            eta[0] += p;
        }
        Ok(eta)
    }

    /// The gradient `-omega(eta, .)` with respect to `(p, w, a, b)` at the start, as tangent vectors.
    pub(crate) fn gradient(&self, [p, w, a, b]: &[Mat<f64>; 4]) -> [Mat<f64>; 4] {
        let tension = Scale(self.data.tension);
        let by_p = b - w * tension - self.twisted(p);
        [by_p, p * tension - a, w.clone(), -p]
    }

    /// `[x'' - tau x, p]_m - [[x, x']_h, p]`, which arises because the displacements of two variations do not commute.
    fn twisted(&self, p: &Mat<f64>) -> Mat<f64> {
        let s = self.point();
        let normal = |v: &Mat<f64>| v - s * (s.transpose() * v);
        let data = &self.data;
        let (v, a) = (self.up(&data.velocity), self.up(&data.acceleration));
        let pull = self.up(&data.second()) - &v * Scale(data.tension);
        let [x, y, z] = [&v, &a, p].map(normal);
        let turned = &y * (x.transpose() * &z) - &x * (y.transpose() * &z);
        match self.data.quotient {
            Quotient::Frames => bracket(s, pull.as_ref(), p.as_ref()) - turned,
            Quotient::Subspaces => &z * (y.transpose() * &x - x.transpose() * &y) - turned,
        }
    }

    /// Collects the loads on one side of the start, the farthest first.
    fn carried_back(
        &self,
        loads: &[FlowLoad],
        interrupt: Interrupt<'_>,
    ) -> Result<[Horizontal; 4]> {
        let blocks = self.blocks();
        let mut march = TaylorMarch::<Dual<1>, Sizes>::new(blocks, Accuracy::FULL);
        start(&mut march, &self.data, &[]);
        for (time, cotangent) in loads {
            march.run(*time, interrupt, &mut |_, _, _| Ok(()))?;
            jump(&mut march, cotangent.as_ref());
        }
        march.run(0.0, interrupt, &mut |_, _, _| Ok(()))?;
        let mut reached = Reached::none(blocks);
        reached.read(&march, 1);
        Ok(reached.variations.swap_remove(0))
    }

    /// The matrices, shape `(4 k, 4 k)`, that map `(p, w, a, b)` of a row outside the span from the start to given
    /// times.
    ///
    /// # Errors
    /// `TooManySteps`, `Overflow`, `Interrupted`.
    pub(crate) fn row_flows(
        &self,
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        let blocks = Sizes {
            m: self.blocks().m + 1,
            ..self.blocks()
        };
        let k = blocks.k;
        let unit = |j: usize| {
            let mut unit = Horizontal::zeros(blocks);
            unit.normal[(blocks.m - 1, j)] = 1.0;
            unit
        };
        let directions: Vec<[Horizontal; 3]> = (0..3 * k)
            .map(|i| {
                let mut direction = std::array::from_fn(|_| Horizontal::zeros(blocks));
                direction[i / k] = unit(i % k);
                direction
            })
            .collect();
        let found = vary::<8>(&self.data, 1, &directions, times, interrupt)?;
        let flow = |reached: Reached| {
            let displaced = (0..k).map(|j| reached.displaced(&unit(j)));
            let columns = displaced.chain(reached.variations.iter().cloned());
            let columns: Vec<[Horizontal; 4]> = columns.collect();
            Mat::from_fn(4 * k, 4 * k, |i, j| {
                columns[j][i / k].normal[(blocks.m - 1, i % k)]
            })
        };
        Ok(found.into_iter().map(flow).collect())
    }
}

/// Concatenates matrices of one shape horizontally.
pub(crate) fn side_by_side(matrices: &[MatRef<'_, f64>]) -> Mat<f64> {
    let (n, k) = matrices[0].shape();
    Mat::from_fn(n, matrices.len() * k, |i, j| matrices[j / k][(i, j % k)])
}

/// Adds a cotangent to the derivative part of `x''`.
fn jump(march: &mut TaylorMarch<Dual<1>, Sizes>, cotangent: MatRef<'_, f64>) {
    let Sizes { m, k, .. } = march.blocks;
    let mut here = Reached::none(march.blocks);
    here.read(march, 0);
    let bar = Horizontal::of_tangent(here.frame.as_ref(), cotangent);
    let parts = march.series.parts();
    let turned = if march.blocks.are_subspaces() { 0 } else { k };
    for j in 0..k {
        for i in 0..turned {
            parts.omega[2][i + k * j].slope[0] += 2.0 * bar.omega[(i, j)];
        }
        for i in 0..m {
            parts.b[2][i + m * j].slope[0] += bar.normal[(i, j)];
        }
    }
}

/// # Errors
/// `Shape`, `NonFinite`.
pub(crate) fn check_cotangents(
    s: MatRef<'_, f64>,
    times: &[f64],
    cotangents: &[MatRef<'_, f64>],
) -> Result<()> {
    const NAME: &str = "W";
    for &t in times {
        check_parameter(t)?;
    }
    if times.len() != cotangents.len() {
        return Err(Error::Shape {
            name: NAME,
            expected: format!("one for each of {} times", times.len()),
            found: cotangents.len().to_string(),
        });
    }
    for cotangent in cotangents {
        check_shape(NAME, *cotangent, s.nrows(), s.ncols())?;
        check_finite(NAME, *cotangent)?;
    }
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{Stiefel, linalg::structure::norm};

    /// A point that cannot move, spheres, `k = n`, `k = n - 1`, and curves that do not span the whole space.
    pub(crate) const SHAPES: [[usize; 2]; 13] = [
        [1, 1],
        [2, 1],
        [2, 2],
        [3, 1],
        [3, 2],
        [3, 3],
        [4, 4],
        [5, 2],
        [6, 1],
        [7, 3],
        [9, 2],
        [10, 2],
        [12, 3],
    ];

    /// Pseudorandom numbers between -1 and 1.
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 11) as f64) / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// The tangent part of a matrix at a point.
    pub(crate) fn tangent(quotient: Quotient, s: MatRef<'_, f64>, x: &Mat<f64>) -> Mat<f64> {
        let inner = s.transpose() * x;
        match quotient {
            Quotient::Frames => x - s * (&inner + inner.transpose()) * Scale(0.5),
            Quotient::Subspaces => x - s * inner,
        }
    }

    /// The flow of a curve from a random point, whose velocity has the given size.
    pub(crate) fn flow(
        [n, k]: [usize; 2],
        tension: f64,
        speed: f64,
        quotient: Quotient,
    ) -> LinearFlow {
        let mut next = numbers(7 + n as u64);
        let manifold = Stiefel::new(n, k).unwrap();
        let raw = Mat::from_fn(n, k, |_, _| next());
        let s = manifold.project(raw.as_ref()).unwrap();
        let vectors = [1.0, 2.0, 3.0].map(|size: f64| {
            let raw = Mat::from_fn(n, k, |_, _| next());
            let v = tangent(quotient, s.as_ref(), &raw);
            let unit = norm(v.as_ref());
            // A curve without degrees of freedom has none.
            let factor = if unit == 0.0 {
                0.0
            } else {
                size * speed.powf(size) / unit
            };
            v * Scale(factor)
        });
        let [v, a, j] = vectors.each_ref().map(|x| x.as_ref());
        LinearFlow::new([s.as_ref(), v, a, j], tension, quotient).unwrap()
    }
}
