//! Splines and boundary values by collocation, beside the solvers that shoot.

use faer::{Mat, MatRef};

use super::dense::Dense;
use super::knots::{End, Ends, Knots};
use super::newton::{Options, Outcome, Start, solve};
use crate::cubic::BoundaryOptions;
use crate::curve::Curve;
use crate::interrupt::Interrupt;
use crate::linalg::field::Field;
use crate::linalg::lanes::Lanes;
use crate::report::StopReason;
use crate::skew_exp;
use crate::space::{FixedFrames, Frames, Homogeneous};
use crate::spline::{EndCondition, EndConditions, SplineOptions, cubic_spline};
use crate::{RiemannianCubic, Stiefel};

/// Numbers between -1 and 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        ((self.0 >> 11) as f64) / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self, size: usize, length: f64) -> Vec<f64> {
        let v: Vec<f64> = (0..size).map(|_| self.next()).collect();
        let norm = v.iter().map(|v| v * v).sum::<f64>().sqrt();
        v.iter().map(|v| length * v / norm).collect()
    }
}

/// Frames that follow one another at distances up to `far`, at unequal times.
struct Walk {
    lengths: Vec<f64>,
    targets: Vec<Vec<f64>>,
    frames: Vec<Mat<f64>>,
}

impl Walk {
    fn new(space: impl Homogeneous, legs: usize, far: f64, numbers: &mut Numbers) -> Self {
        let r = space.size();
        let mut walk = Walk {
            lengths: Vec::new(),
            targets: Vec::new(),
            frames: vec![Mat::identity(r, r)],
        };
        for _ in 0..legs {
            let length = far * (0.6 + 0.4 * numbers.next());
            let target = exponential(space, &numbers.vector(space.dim(), length));
            let before = &walk.frames[walk.frames.len() - 1];
            let next = before * &target;
            walk.targets.push(columns(&target));
            walk.frames.push(next);
            walk.lengths.push(1.0 + 0.5 * numbers.next());
        }
        walk
    }

    fn knots<'a>(&'a self, ends: &'a Ends) -> Knots<'a> {
        Knots {
            lengths: &self.lengths,
            targets: self.targets.iter().map(Vec::as_slice).collect(),
            ends,
        }
    }

    fn times(&self) -> Vec<f64> {
        let mut times = vec![0.0];
        for h in &self.lengths {
            times.push(times[times.len() - 1] + h);
        }
        times
    }

    fn points(&self, k: usize) -> Vec<MatRef<'_, f64>> {
        self.frames
            .iter()
            .map(|g| g.as_ref().subcols(0, k))
            .collect()
    }
}

fn matrix(space: impl Homogeneous, x: &[f64]) -> Mat<f64> {
    let r = space.size();
    let mut entries = vec![0.0; r * r];
    space.matrix_into(x, &mut entries);
    Mat::from_fn(r, r, |i, j| entries[i * r + j])
}

fn exponential(space: impl Homogeneous, x: &[f64]) -> Mat<f64> {
    skew_exp(matrix(space, x).as_ref()).unwrap()
}

fn columns(a: &Mat<f64>) -> Vec<f64> {
    a.col_iter().flat_map(|c| c.iter().copied()).collect()
}

fn options<'a>(start: Start<'a>) -> Options<'a> {
    Options {
        start,
        tolerance: 1e-12,
        max_iterations: 60,
        may_go_on: &|| true,
        interrupt: Interrupt::NEVER,
    }
}

/// From rest but for given velocities at the ends: the first step leads to the solution of flat space.
fn solved<T: Field, S: Homogeneous>(space: S, knots: &Knots<'_>) -> (Outcome, Option<Dense>) {
    let (outcome, dense, ..) = motion::<T, S>(space, knots);
    (outcome, dense)
}

/// The same with velocities at the knots, and `x'` and `x''` at the start of each leg.
fn motion<T: Field, S: Homogeneous>(
    space: S,
    knots: &Knots<'_>,
) -> (Outcome, Option<Dense>, Vec<f64>, Vec<f64>) {
    let (d, legs) = (space.dim(), knots.lengths.len());
    let mut velocities = vec![0.0; d * (legs + 1)];
    if let Ends::Open(ends) = knots.ends {
        for (end, knot) in ends.iter().zip([0, legs]) {
            if let End::Velocity(v) = end {
                velocities[knot * d..][..d].copy_from_slice(v);
            }
        }
    }
    let mut bends = vec![0.0; 2 * d * legs];
    let found = solve::<T, S>(
        space,
        knots,
        &mut velocities,
        &mut bends,
        &options(Start::Flat),
    );
    let (outcome, dense) = found.unwrap();
    (outcome, dense, velocities, bends)
}

/// The point of a leg at `s` between 0 and 1.
fn point(dense: &Dense, frame: &Mat<f64>, leg: usize, s: f64, k: usize) -> Mat<f64> {
    let r = frame.nrows();
    let stride = (dense.order + 1) * r * r;
    let mut sum = vec![0.0; r * r];
    for coefficient in dense.frames[leg * stride..][..stride]
        .chunks_exact(r * r)
        .rev()
    {
        for (sum, c) in sum.iter_mut().zip(coefficient) {
            *sum = *sum * (s - 0.5) + c;
        }
    }
    frame * Mat::from_fn(r, k, |i, j| sum[i * r + j])
}

fn distance(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (a - b).norm_l2()
}

fn compare_spline<T: Field, S: Homogeneous>(space: S, far: f64, ends: &Ends, seed: u64) {
    let [r, d] = [space.size(), space.dim()];
    let k = (1..r).find(|k| Frames { r, k: *k }.dim() == d).unwrap();
    let mut walk = Walk::new(space, 9, far, &mut Numbers(seed));
    let legs = walk.lengths.len();
    if let Ends::Periodic = ends {
        // Back to the first frame.
        let target = walk.frames[legs].transpose() * &walk.frames[0];
        walk.targets.push(columns(&target));
        walk.frames.push(walk.frames[0].clone());
        walk.lengths.push(1.0);
    }
    let (outcome, dense) = solved::<T, S>(space, &walk.knots(ends));
    assert_eq!(
        outcome.reason,
        StopReason::Converged,
        "({r}, {k}) {far}: {outcome:?}"
    );
    assert!(outcome.iterations <= 14, "({r}, {k}) {far}: {outcome:?}");
    assert!(
        outcome.residual <= outcome.tolerance,
        "({r}, {k}) {far}: {outcome:?}"
    );
    let dense = dense.unwrap();
    let (times, points) = (walk.times(), walk.points(k));
    let vector =
        |knot: usize, x: &[f64]| &walk.frames[knot] * matrix(space, x).as_ref().subcols(0, k);
    let last = walk.lengths.len();
    let conditions = match ends {
        Ends::Periodic => EndConditions::Periodic,
        Ends::Open(ends) => EndConditions::Each(Box::new([(0, &ends[0]), (last, &ends[1])].map(
            |(knot, end)| match end {
                End::Velocity(v) => EndCondition::Velocity(vector(knot, v)),
                End::Acceleration(a) => EndCondition::Acceleration(vector(knot, a)),
            },
        ))),
    };
    let (curve, _) = cubic_spline(&times, &points, &conditions, &SplineOptions::default()).unwrap();
    for leg in 0..last {
        for s in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let found = point(&dense, &walk.frames[leg], leg, s, k);
            let t = times[leg] + s * walk.lengths[leg];
            let error = distance(&found, &curve.point(t.min(times[last])).unwrap());
            assert!(
                error < 2e-11,
                "({r}, {k}) {far}, leg {leg} at {s}: {error:e}"
            );
        }
    }
}

fn each_space(compare: impl Fn(usize)) {
    (0..7).for_each(compare);
}

fn compare_splines(far: f64, ends: impl Fn(usize, &mut Numbers) -> Ends) {
    each_space(|which| {
        let mut numbers = Numbers(which as u64 + 17);
        let mut ends = |d: usize| ends(d, &mut numbers);
        match which {
            0 => compare_spline::<Lanes, _>(FixedFrames::<2, 1>, far, &ends(1), 1),
            1 => compare_spline::<Lanes, _>(FixedFrames::<3, 1>, far, &ends(2), 2),
            2 => compare_spline::<Lanes, _>(FixedFrames::<3, 2>, far, &ends(3), 3),
            3 => compare_spline::<f64, _>(Frames { r: 4, k: 2 }, far, &ends(5), 4),
            4 => compare_spline::<Lanes, _>(Frames { r: 5, k: 2 }, far, &ends(7), 5),
            5 => compare_spline::<Lanes, _>(Frames { r: 4, k: 3 }, far, &ends(6), 6),
            _ => compare_spline::<f64, _>(Frames { r: 6, k: 3 }, far, &ends(12), 7),
        }
    });
}

#[test]
fn natural_splines_are_those_of_shooting() {
    for far in [0.3, 1.0] {
        compare_splines(far, |d, _| {
            Ends::Open([(); 2].map(|()| End::Acceleration(vec![0.0; d])))
        });
    }
}

#[test]
fn ends_with_velocities_and_accelerations_are_met() {
    compare_splines(0.7, |d, numbers| {
        Ends::Open([
            End::Velocity(numbers.vector(d, 0.8)),
            End::Acceleration(numbers.vector(d, 0.6)),
        ])
    });
}

#[test]
fn closed_splines_are_those_of_shooting() {
    // Few steps of a walk do not lead far from where it began.
    compare_splines(0.3, |_, _| Ends::Periodic);
}

#[test]
fn boundary_values_are_those_of_shooting() {
    for (r, k) in [(3, 1), (3, 2), (4, 2), (6, 3)] {
        let space = Frames { r, k };
        let mut numbers = Numbers(41);
        for problem in 0..10 {
            let mut walk = Walk::new(space, 1, 1.0, &mut numbers);
            walk.lengths = vec![1.0];
            let [first, last] = [(); 2].map(|()| numbers.vector(space.dim(), 1.0));
            let ends = Ends::Open([End::Velocity(first.clone()), End::Velocity(last.clone())]);
            let (outcome, dense) = solved::<f64, _>(space, &walk.knots(&ends));
            assert_eq!(
                outcome.reason,
                StopReason::Converged,
                "({r}, {k}) {problem}: {outcome:?}"
            );
            let vector = |knot: usize, x: &[f64]| {
                &walk.frames[knot] * matrix(space, x).as_ref().subcols(0, k)
            };
            let (points, v) = (walk.points(k), [vector(0, &first), vector(1, &last)]);
            let curve = RiemannianCubic::from_boundary(
                points[0],
                v[0].as_ref(),
                points[1],
                v[1].as_ref(),
                &BoundaryOptions::default(),
            )
            .unwrap();
            for s in [0.1, 0.5, 0.8] {
                let found = point(dense.as_ref().unwrap(), &walk.frames[0], 0, s, k);
                let error = distance(&found, &curve.point(s).unwrap());
                assert!(error < 2e-11, "({r}, {k}) {problem} at {s}: {error:e}");
            }
        }
    }
}

#[test]
fn polynomials_stay_on_the_manifold() {
    let space = FixedFrames::<3, 2>;
    let walk = Walk::new(space, 20, 1.2, &mut Numbers(5));
    let ends = Ends::Open([(); 2].map(|()| End::Acceleration(vec![0.0; 3])));
    let (outcome, dense) = solved::<Lanes, _>(space, &walk.knots(&ends));
    assert_eq!(outcome.reason, StopReason::Converged);
    let dense = dense.unwrap();
    let manifold = Stiefel::new(3, 2).unwrap();
    for leg in 0..20 {
        for i in 0..=20 {
            let s = point(&dense, &walk.frames[leg], leg, i as f64 / 20.0, 2);
            manifold.check_point("s", s.as_ref(), 1e-13).unwrap();
        }
    }
}

#[test]
fn a_start_at_a_solution_is_kept() {
    let space = FixedFrames::<3, 2>;
    let walk = Walk::new(space, 9, 1.2, &mut Numbers(8));
    let ends = Ends::Open([(); 2].map(|()| End::Acceleration(vec![0.0; 3])));
    let knots = walk.knots(&ends);
    let (first, dense, velocities, bends) = motion::<Lanes, _>(space, &knots);
    let dense = dense.unwrap();
    let third_derivative = |leg: usize, times: &[f64]| {
        let stride = (dense.order + 1) * 3;
        let series = &dense.x[leg * stride..][..stride];
        let at = |s: &f64| {
            let mut sum = [0.0; 3];
            for (power, c) in series.chunks_exact(3).enumerate().skip(3).rev() {
                let factor = (power * (power - 1) * (power - 2)) as f64;
                for (sum, c) in sum.iter_mut().zip(c) {
                    *sum = *sum * (s - 0.5) + factor * c;
                }
            }
            sum
        };
        Ok(times.iter().flat_map(at).collect())
    };
    let (mut v, mut b) = (velocities.clone(), bends.clone());
    let options = options(Start::Near(&third_derivative));
    let (outcome, _) = solve::<Lanes, _>(space, &knots, &mut v, &mut b, &options).unwrap();
    assert!(
        outcome.iterations < first.iterations,
        "{outcome:?}, {first:?} from rest"
    );
    let moved = v
        .iter()
        .zip(&velocities)
        .fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(moved < 1e-12, "{moved:e}");
}
