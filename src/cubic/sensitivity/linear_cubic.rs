//! A single cubic on `[0, 1]`, linearised: variations in terms of those of points and velocities at its ends, forward
//! and transposed.
//!
//! The equations are solved [at Gauss nodes](super::collocated) without forming a matrix. Curves in three dimensions,
//! curves that are too fast, and ends that may be conjugate, are treated [by series](super::linear_piece).

use std::sync::OnceLock;

use faer::{Mat, MatRef};

use super::collocated::Collocated;
use super::linear_flow::{LinearFlow, VARIATION};
use super::linear_piece::LinearPiece;
use super::linear_start::{LinearStart, spanning};
use crate::cubic::riemannian_cubic::RiemannianCubic;
use crate::curve::Curve;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::field::add;
use crate::linalg::product::{columns, entries};
use crate::linalg::structure::check_range;

/// Size of frames for which series are quicker, since it is known to the compiler. In Rust, derivative and gradient take
/// 42 us on St(3,1), at nodes 61, 73 and 78 us on St(3,1), (3,2) and (3,3); through Python, whose allocator is quicker,
/// series take 24, 24 and 26 us there. On St(4,2), (5,2), (6,3) and (8,2) series took twice as long as nodes. Not
/// measured for lines in three dimensions.
const BY_SERIES: (usize, usize) = (3, 3);

/// The linearised cubic.
#[derive(Debug)]
pub(crate) struct LinearCubic {
    flow: LinearFlow,
    collocated: Option<Collocated>,
    series: OnceLock<LinearPiece>,
}

impl LinearCubic {
    /// Built for a curve on `[0, 1]`. Its polynomials are used if they have the same time and no larger frame than the
    /// data at the start span; otherwise the curve is integrated from there.
    ///
    /// # Errors
    /// `ConjugateEnds`, `Overflow`, `TooManySteps`, `Decomposition`, `Interrupted`.
    pub(crate) fn new(curve: &RiemannianCubic, interrupt: Interrupt<'_>) -> Result<Self> {
        let known = spanning(curve).filter(|start| {
            let end = curve.state_of_taylor(1.0).map(|end| end.time);
            start.time == 0.0 && end == Some(1.0)
        });
        let (flow, taylor) = match known {
            Some(start) => {
                let basis = curve.frame().map(|basis| basis.to_owned());
                (LinearFlow::of_taylor(start, basis), Some(&**curve.taylor))
            }
            None => {
                let state = curve.state(0.0)?;
                let views = state.each_ref().map(|x| x.as_ref());
                let flow = LinearFlow::new(views, curve.tension(), curve.quotient())?;
                (flow, None)
            }
        };
        let cubic = LinearCubic {
            collocated: match flow.frame.shape() == BY_SERIES {
                true => None,
                false => Collocated::new(&flow, taylor, interrupt)?,
            },
            series: OnceLock::new(),
            flow,
        };
        if cubic.collocated.is_none() {
            cubic.series(interrupt)?;
        }
        Ok(cubic)
    }

    /// The equations at nodes, unless they have failed before.
    fn collocated(&self) -> Option<&Collocated> {
        let collocated = self.collocated.as_ref();
        collocated.filter(|_| self.series.get().is_none())
    }

    fn series(&self, interrupt: Interrupt<'_>) -> Result<&LinearPiece> {
        if self.series.get().is_none() {
            let piece = LinearPiece::new(LinearStart::of_flow(&self.flow), interrupt)?;
            let _ = self.series.set(piece);
        }
        Ok(self.series.get().expect("it was just set"))
    }

    /// The changes of `x'` and `x''` at the start for `(u_0, w_0, u_1, w_1)`.
    ///
    /// # Errors
    /// `ConjugateEnds`, `Overflow`, `TooManySteps`, `Decomposition`, `Interrupted`.
    pub(crate) fn at_start(
        &self,
        z: &[Mat<f64>; 4],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 2]> {
        if let Some(collocated) = self.collocated()
            && let Some(varied) = collocated.vary(&self.flow, z, interrupt)?
        {
            return Ok(varied.start);
        }
        Ok(start_of(self.series(interrupt)?, z))
    }

    /// The variations of the points at given times for `(u_0, w_0, u_1, w_1)`.
    ///
    /// # Errors
    /// As [`LinearCubic::at_start`].
    pub(crate) fn points(
        &self,
        z: &[Mat<f64>; 4],
        times: &[f64],
        interrupt: Interrupt<'_>,
    ) -> Result<Vec<Mat<f64>>> {
        let (on, beyond): (Vec<f64>, Vec<f64>) = times.iter().partition(|t| is_on(**t));
        let varied = match self.collocated() {
            Some(collocated) => collocated
                .vary(&self.flow, z, interrupt)?
                .map(|varied| (collocated, varied)),
            None => None,
        };
        let (on, [a, b]) = match varied {
            Some((collocated, varied)) => {
                (collocated.points(&self.flow, &varied, z, &on), varied.start)
            }
            None => {
                let series = self.series(interrupt)?;
                (points_of(series, z, &on), start_of(series, z))
            }
        };
        let start = [z[0].clone(), z[1].clone(), a, b];
        let beyond = self.flow.points(&start, &beyond, interrupt)?;
        let (mut on, mut beyond) = (on.into_iter(), beyond.into_iter());
        let points = times.iter().map(|t| {
            let points = if is_on(*t) { &mut on } else { &mut beyond };
            let point = points.next().expect("a point for every time");
            check_range(VARIATION, point.as_ref())?;
            Ok(point)
        });
        points.collect()
    }

    /// The gradient with respect to `(u_0, w_0, u_1, w_1)`, as tangent vectors, of `sum tr(W^T S(t))` over cotangents
    /// `W` at given times `t`.
    ///
    /// # Errors
    /// As [`LinearCubic::at_start`].
    pub(crate) fn pull_back(
        &self,
        times: &[f64],
        cotangents: &[MatRef<'_, f64>],
        interrupt: Interrupt<'_>,
    ) -> Result<[Mat<f64>; 4]> {
        let loads = times.iter().copied().zip(cotangents.iter().copied());
        let (on, beyond): (Vec<PointLoad<'_>>, Vec<PointLoad<'_>>) =
            loads.partition(|load| is_on(load.0));
        let by_start = match beyond.is_empty() {
            true => None,
            false => {
                let (times, cotangents): (Vec<f64>, Vec<MatRef<'_, f64>>) =
                    beyond.into_iter().unzip();
                let eta = self.flow.collected(&times, &cotangents, interrupt)?;
                Some(self.flow.gradient(&eta))
            }
        };
        let by_derivatives = by_start.as_ref().map(|[.., a, b]| [a, b]);
        let found = match self.collocated() {
            Some(collocated) => {
                let (times, cotangents): (Vec<f64>, Vec<MatRef<'_, f64>>) =
                    on.iter().copied().unzip();
                let loads = (times.as_slice(), cotangents.as_slice());
                collocated.pull_back(&self.flow, loads, by_derivatives, interrupt)?
            }
            None => None,
        };
        let mut out = match found {
            Some(found) => found,
            None => pulled_back(self.series(interrupt)?, &on, by_derivatives),
        };
        if let Some([by_p, by_w, ..]) = by_start {
            out[0] += by_p;
            out[1] += by_w;
        }
        Ok(out)
    }
}

/// A time and a cotangent there.
type PointLoad<'a> = (f64, MatRef<'a, f64>);

/// Whether the curve need not be integrated beyond its ends.
pub(crate) fn is_on(t: f64) -> bool {
    (0.0..=1.0).contains(&t)
}

fn points_of(piece: &LinearPiece, z: &[Mat<f64>; 4], times: &[f64]) -> Vec<Mat<f64>> {
    let (n, z) = (z[0].nrows(), z.each_ref().map(|z| entries(z.as_ref())));
    let points = piece.points(z.each_ref().map(Vec::as_slice), times);
    points.iter().map(|x| columns(x, n).to_owned()).collect()
}

fn start_of(piece: &LinearPiece, z: &[Mat<f64>; 4]) -> [Mat<f64>; 2] {
    let (n, z) = (z[0].nrows(), z.each_ref().map(|z| entries(z.as_ref())));
    let start = piece.at_start(z.each_ref().map(Vec::as_slice));
    start.map(|x| columns(&x, n).to_owned())
}

fn pulled_back(
    piece: &LinearPiece,
    loads: &[PointLoad<'_>],
    by_derivatives: Option<[&Mat<f64>; 2]>,
) -> [Mat<f64>; 4] {
    let mut found = piece.pull_back(loads.iter().copied());
    if let Some(by_derivatives) = by_derivatives {
        let by_derivatives = by_derivatives.map(|x| entries(x.as_ref()));
        let more = piece.pull_back_start(by_derivatives.each_ref().map(Vec::as_slice));
        for (sum, x) in found.iter_mut().zip(&more) {
            add(sum, 1.0, x);
        }
    }
    let n = piece.frame(0).nrows();
    found.map(|x| columns(&x, n).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cubic::BoundaryOptions;
    use crate::cubic::sensitivity::linear_flow::tests::{SHAPES, flow, tangent};
    use crate::linalg::structure::norm;
    use crate::manifold::QuasiGeodesic;
    use crate::space::Quotient;

    /// Within, at the ends of and outside `[0, 1]`.
    const TIMES: [f64; 6] = [0.3, 0.0, 1.0, 0.71, 1.2, -0.1];

    /// Tangent vectors for the ends of a curve, and cotangents.
    fn data(cubic: &LinearCubic, end: MatRef<'_, f64>) -> ([Mat<f64>; 4], Vec<Mat<f64>>) {
        let (n, k) = (cubic.flow.frame.nrows(), cubic.flow.blocks().k);
        let raw = |which: usize| {
            let entry = |i: usize, j: usize| (1.3 * (i + n * j + 7 * which) as f64).sin();
            Mat::from_fn(n, k, entry)
        };
        let ends: [Mat<f64>; 4] = std::array::from_fn(|i| {
            let frame = if i < 2 {
                cubic.flow.frame.as_ref()
            } else {
                end
            };
            tangent(cubic.flow.data.quotient, frame.subcols(0, k), &raw(i))
        });
        (ends, (4..4 + TIMES.len()).map(raw).collect())
    }

    fn assert_close(found: &Mat<f64>, expected: &Mat<f64>, scale: f64, what: &str) {
        let error = norm((found - expected).as_ref());
        assert!(error < 1e-12 * (1.0 + scale), "{what}: {error:.1e}");
    }

    /// Compares the method at Gauss nodes with series.
    fn check(flow: LinearFlow, what: &str) {
        let cubic = LinearCubic {
            collocated: Collocated::new(&flow, None, Interrupt::NEVER).unwrap(),
            series: OnceLock::new(),
            flow,
        };
        check_cubic(&cubic, what);
    }

    fn check_cubic(cubic: &LinearCubic, what: &str) {
        let series = LinearCubic {
            collocated: None,
            series: OnceLock::new(),
            flow: cubic.flow.clone(),
        };
        assert!(cubic.collocated.is_some(), "{what}");
        let end = series.series(Interrupt::NEVER).unwrap().frame(1);
        let (z, cotangents) = data(cubic, end);
        let [expected, found] =
            [&series, cubic].map(|cubic| cubic.at_start(&z, Interrupt::NEVER).unwrap());
        let scale = expected.iter().map(|x| norm(x.as_ref())).sum::<f64>();
        for (found, expected) in found.iter().zip(&expected) {
            assert_close(found, expected, scale, what);
        }
        let [expected, found] =
            [&series, cubic].map(|cubic| cubic.points(&z, &TIMES, Interrupt::NEVER).unwrap());
        for (found, expected) in found.iter().zip(&expected) {
            assert_close(found, expected, 10.0 * norm(expected.as_ref()), what);
        }
        let views: Vec<MatRef<'_, f64>> = cotangents.iter().map(|x| x.as_ref()).collect();
        let [expected, found] = [&series, cubic]
            .map(|cubic| cubic.pull_back(&TIMES, &views, Interrupt::NEVER).unwrap());
        let scale = expected.iter().map(|x| norm(x.as_ref())).sum::<f64>();
        for (found, expected) in found.iter().zip(&expected) {
            assert_close(found, expected, scale, what);
        }
    }

    #[test]
    fn gauss_nodes_and_series_agree() {
        // A point that cannot move needs no equations.
        for shape in SHAPES.into_iter().skip(1) {
            for quotient in [Quotient::Frames, Quotient::Subspaces] {
                if quotient == Quotient::Subspaces && shape[0] == shape[1] {
                    continue;
                }
                for (tension, speed) in [(0.0, 0.5), (4.0, 0.5), (0.0, 1.5), (0.0, 0.0)] {
                    let flow = flow(shape, tension, speed, quotient);
                    check(flow, &format!("{shape:?} {quotient:?} {tension} {speed}"));
                }
            }
        }
    }

    /// Polynomial solutions of boundary value problems, in the coordinates of a basis and without one.
    #[test]
    fn polynomials_of_solutions_are_used() {
        for shape in [[4, 1], [4, 2], [12, 2], [5, 4], [4, 4], [20, 3]] {
            let flow = flow(shape, 0.0, 1.0, Quotient::Frames);
            let s0 = flow.frame.subcols(0, shape[1]).to_owned();
            let raw = |seed: f64| {
                let entry = |i: usize, j: usize| (seed * (1 + i + 3 * j) as f64).sin();
                let v = tangent(
                    Quotient::Frames,
                    s0.as_ref(),
                    &Mat::from_fn(shape[0], shape[1], entry),
                );
                &v * faer::Scale(0.8 / norm(v.as_ref()))
            };
            let [v0, way] = [1.3, 2.1].map(raw);
            let s1 = QuasiGeodesic::from_velocity(s0.as_ref(), way.as_ref()).unwrap();
            let s1 = s1.point(1.0).unwrap();
            let v1 = tangent(Quotient::Frames, s1.as_ref(), &raw(0.7));
            let data = [&s0, &v0, &s1, &v1].map(|x| x.as_ref());
            let options = BoundaryOptions::default();
            let [s0, v0, s1, v1] = data;
            let curve =
                RiemannianCubic::from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER).unwrap();
            let cubic = LinearCubic::new(&curve, Interrupt::NEVER).unwrap();
            assert_eq!(cubic.flow.frame.nrows(), shape[0]);
            let start = curve.taylor.ends()[0];
            assert_eq!(
                cubic.flow.data.g[(0, 0)],
                start.s()[0],
                "its polynomials are not used"
            );
            check_cubic(&cubic, &format!("{shape:?}"));
        }
    }

    /// From rest to rest, the speed varies as much as it can.
    #[test]
    fn speeds_may_vary() {
        for (n, angle) in [(2, 0.8), (3, 0.5), (3, 1.5), (3, 3.9), (6, 1.0)] {
            let unit = |i: usize, x: f64| {
                let entry = |row: usize, _| if row == i { x } else { 0.0 };
                Mat::from_fn(n, 1, entry)
            };
            let state = [
                unit(0, 1.0),
                Mat::zeros(n, 1),
                unit(1, 6.0 * angle),
                unit(1, -12.0 * angle),
            ];
            let views = state.each_ref().map(|x| x.as_ref());
            let flow = LinearFlow::new(views, 0.0, Quotient::Frames).unwrap();
            check(flow, &format!("rest to rest, {angle} in {n} dimensions"));
        }
    }

    #[test]
    fn huge_and_tiny_variations_are_scaled() {
        let flow = flow([5, 2], 0.0, 1.0, Quotient::Frames);
        let cubic = LinearCubic {
            collocated: Collocated::new(&flow, None, Interrupt::NEVER).unwrap(),
            series: OnceLock::new(),
            flow,
        };
        let (z, _) = data(&cubic, cubic.flow.frame.as_ref());
        let expected = cubic.at_start(&z, Interrupt::NEVER).unwrap();
        for size in [1e-200, 1e-160, 1e160, 1e300] {
            let scaled = z.each_ref().map(|z| z * faer::Scale(size));
            let found = cubic.at_start(&scaled, Interrupt::NEVER).unwrap();
            for (found, expected) in found.iter().zip(&expected) {
                let found = found * faer::Scale(size.recip());
                assert_close(&found, expected, norm(expected.as_ref()), "scaled");
            }
        }
    }

    #[test]
    fn fast_curves_are_treated_by_series() {
        let flow = flow([3, 1], 0.0, 12.0, Quotient::Frames);
        let collocated = Collocated::new(&flow, None, Interrupt::NEVER).unwrap();
        assert!(collocated.is_none());
        assert!(LinearPiece::new(LinearStart::of_flow(&flow), Interrupt::NEVER).is_ok());
    }
}
