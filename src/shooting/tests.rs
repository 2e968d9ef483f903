//! Splines by series, compared with the Taylor method for initial values; boundary values, compared
//! with single shooting.

use faer::{Mat, MatRef, Scale};

use crate::cubic::BoundaryOptions;
use crate::cubic::taylor::blocks::Sizes;
use crate::cubic::taylor::march::Accuracy;
use crate::cubic::taylor::piecewise_taylor::PiecewiseTaylor;
use crate::cubic::taylor::state::State;
use crate::curve::Curve;
use crate::interrupt::Interrupt;
use crate::legs::{Curves, Dense, End, Ends, Knots, Options};
use crate::linalg::field::Field;
use crate::linalg::lanes::Lanes;
use crate::report::{SolverReport, StopReason};
use crate::skew_exp;
use crate::space::{FixedFrames, Homogeneous, RealSpace};
use crate::{RiemannianCubic, Stiefel};

/// Pseudorandom numbers between -1 and 1.
struct TestNumbers(u64);

impl TestNumbers {
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

/// A walk of frames at successive distances up to `far`, at unequal times.
struct Walk {
    lengths: Vec<f64>,
    targets: Vec<Vec<f64>>,
    frames: Vec<Mat<f64>>,
    /// Tension of the curves.
    tension: f64,
}

impl Walk {
    fn new(space: impl Homogeneous, legs: usize, far: f64, numbers: &mut TestNumbers) -> Self {
        let r = space.size();
        let mut walk = Walk {
            lengths: Vec::new(),
            targets: Vec::new(),
            frames: vec![Mat::identity(r, r)],
            tension: 0.0,
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
            tension: self.tension,
        }
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

fn options<'a>() -> Options<'a> {
    Options {
        tolerance: 1e-12,
        max_iterations: 60,
        may_go_on: &|_| true,
        interrupt: Interrupt::NEVER,
    }
}

type FoundValues = (SolverReport, Option<Box<dyn Curves>>);

/// Starts at rest except for given velocities at the ends, so that the first step leads to the solution of flat space.
fn solved<T, S>(space: S, knots: &Knots<'_>) -> FoundValues
where
    T: Field + Send + Sync + 'static,
    S: Homogeneous + 'static,
{
    let (d, legs) = (space.dim(), knots.lengths.len());
    let mut velocities = vec![0.0; d * (legs + 1)];
    if let Ends::Open(ends) = knots.ends {
        for (end, knot) in ends.iter().zip([0, legs]) {
            if let End::Velocity(v) = end {
                velocities[knot * d..][..d].copy_from_slice(v);
            }
        }
    }
    let mut derivatives = vec![0.0; 2 * d * legs];
    super::solve::<T, S>(space, knots, &mut velocities, &mut derivatives, &options()).unwrap()
}

/// The point of a leg at `s` between 0 and 1.
fn point(dense: &Dense, frame: &Mat<f64>, leg: usize, s: f64, k: usize) -> Mat<f64> {
    let r = frame.nrows();
    let mut sum = vec![0.0; r * r];
    for coefficient in dense.frames(leg, r).chunks_exact(r * r).rev() {
        for (sum, c) in sum.iter_mut().zip(coefficient) {
            *sum = *sum * (s - 0.5) + c;
        }
    }
    frame * Mat::from_fn(r, k, |i, j| sum[i * r + j])
}

fn distance(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (a - b).norm_l2()
}

fn check_spline<T, S>(space: S, far: f64, ends: &Ends, seed: u64)
where
    T: Field + Send + Sync + 'static,
    S: Homogeneous + 'static,
{
    // Without tension, and with a tension that lets velocities grow as e^1.7 along a leg.
    for tension in [0.0, 3.0] {
        check_spline_in_tension::<T, S>(space, (far, tension), ends, seed);
    }
}

fn check_spline_in_tension<T, S>(space: S, (far, tension): (f64, f64), ends: &Ends, seed: u64)
where
    T: Field + Send + Sync + 'static,
    S: Homogeneous + 'static,
{
    let [r, d] = [space.size(), space.dim()];
    let k = (1..r)
        .find(|k| RealSpace::frames(r, *k).dim() == d)
        .unwrap();
    let mut walk = Walk::new(space, 9, far, &mut TestNumbers(seed));
    walk.tension = tension;
    let legs = walk.lengths.len();
    if let Ends::Periodic = ends {
        // Back to the first frame.
        let target = walk.frames[legs].transpose() * &walk.frames[0];
        walk.targets.push(columns(&target));
        walk.frames.push(walk.frames[0].clone());
        walk.lengths.push(1.0);
    }
    let (outcome, curves) = solved::<T, S>(space, &walk.knots(ends));
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
    let curves = curves.unwrap();
    // Every leg must be the cubic that the Taylor method integrates from its start, and must lead to the next frame up
    // to an isometry.
    let mut before: Option<[Mat<f64>; 2]> = None;
    for leg in 0..walk.lengths.len() {
        let (frame, h) = (&walk.frames[leg], walk.lengths[leg]);
        let (dense, which) = curves.of_leg(leg);
        let taylor = integrated(dense, which, frame, k, tension * h * h);
        for s in [0.2, 0.5, 0.9, 1.0] {
            let found = point(dense, frame, which, s, k);
            let error = distance(&found, &point_of(&taylor, s, [r, k]));
            assert!(
                error < 1e-12,
                "({r}, {k}) {far}, leg {leg} at {s}: {error:e}"
            );
        }
        let next = walk.frames[leg + 1].as_ref().subcols(0, k).to_owned();
        let error = distance(&point(dense, frame, which, 1.0, k), &next);
        assert!(error < 1e-12, "({r}, {k}) {far}, knot {leg}: {error:e}");
        let last = dense.last_frame(which, r * r);
        let last = frame * Mat::from_fn(r, r, |i, j| last[i * r + j]);
        let at = |g: &Mat<f64>, end: usize| -> [Mat<f64>; 2] {
            let vectors: Vec<&[f64]> = dense.end(which, end, d).collect();
            [1, 2].map(|order| {
                let vector = g * matrix(space, vectors[order - 1]).as_ref().subcols(0, k);
                vector * Scale(h.powi(-(order as i32)))
            })
        };
        if let Some(before) = before {
            for (order, (a, b)) in before.iter().zip(&at(frame, 0)).enumerate() {
                let jump = distance(a, b);
                assert!(
                    jump < 1e-11,
                    "({r}, {k}) {far}, knot {leg}, order {order}: {jump:e}"
                );
            }
        }
        before = Some(at(&last, 1));
    }
}

/// A leg as integrated by the Taylor method.
fn integrated(
    dense: &Dense,
    leg: usize,
    frame: &Mat<f64>,
    k: usize,
    tension: f64,
) -> PiecewiseTaylor {
    let r = frame.nrows();
    let space = RealSpace::frames(r, k);
    let mut entries = columns(frame);
    for x in dense.end(leg, 0, space.dim()) {
        let x = matrix(space, x);
        entries.extend(columns(&x.as_ref().submatrix(0, 0, k, k).to_owned()));
        entries.extend(columns(&x.as_ref().submatrix(k, 0, r - k, k).to_owned()));
    }
    let state = State::of_entries(Sizes::frames(r - k, k), 0.0, entries);
    let mut taylor = PiecewiseTaylor::at(state.in_tension(tension), Accuracy::FULL);
    taylor.extend_to(1.0, Interrupt::NEVER).unwrap();
    taylor
}

fn point_of(taylor: &PiecewiseTaylor, t: f64, [r, k]: [usize; 2]) -> Mat<f64> {
    let mut entries = vec![0.0; taylor.rows() * k];
    taylor.point_into(t, &mut entries);
    Mat::from_fn(r, k, |i, j| entries[i + taylor.rows() * j])
}

fn each_space(compare: impl Fn(usize)) {
    (0..7).for_each(compare);
}

fn check_splines(far: f64, ends: impl Fn(usize, &mut TestNumbers) -> Ends) {
    each_space(|which| {
        let mut numbers = TestNumbers(which as u64 + 17);
        let mut ends = |d: usize| ends(d, &mut numbers);
        match which {
            0 => check_spline::<Lanes, _>(FixedFrames::<2, 1>, far, &ends(1), 1),
            1 => check_spline::<Lanes, _>(FixedFrames::<3, 1>, far, &ends(2), 2),
            2 => check_spline::<Lanes, _>(FixedFrames::<3, 2>, far, &ends(3), 3),
            3 => check_spline::<f64, _>(RealSpace::frames(4, 2), far, &ends(5), 4),
            4 => check_spline::<Lanes, _>(RealSpace::frames(5, 2), far, &ends(7), 5),
            5 => check_spline::<Lanes, _>(RealSpace::frames(4, 3), far, &ends(6), 6),
            _ => check_spline::<f64, _>(RealSpace::frames(6, 3), far, &ends(12), 7),
        }
    });
}

#[test]
fn natural_splines_are_cubics_that_join() {
    for far in [0.3, 1.0] {
        check_splines(far, |d, _| {
            Ends::Open([(); 2].map(|()| End::Acceleration(vec![0.0; d])))
        });
    }
}

#[test]
fn ends_with_velocities_and_accelerations_are_met() {
    check_splines(0.7, |d, numbers| {
        Ends::Open([
            End::Velocity(numbers.vector(d, 0.8)),
            End::Acceleration(numbers.vector(d, 0.6)),
        ])
    });
}

#[test]
fn closed_splines_are_cubics_that_join() {
    // A few steps of a walk do not lead far from its beginning.
    check_splines(0.3, |_, _| Ends::Periodic);
}

#[test]
fn boundary_values_are_those_of_shooting() {
    for (r, k) in [(3, 1), (3, 2), (4, 2), (6, 3)] {
        let space = RealSpace::frames(r, k);
        let mut numbers = TestNumbers(41);
        for problem in 0..10 {
            let mut walk = Walk::new(space, 1, 1.0, &mut numbers);
            walk.lengths = vec![1.0];
            let [first, last] = [(); 2].map(|()| numbers.vector(space.dim(), 1.0));
            let ends = Ends::Open([End::Velocity(first.clone()), End::Velocity(last.clone())]);
            let (outcome, curves) = solved::<f64, _>(space, &walk.knots(&ends));
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
                Interrupt::NEVER,
            )
            .unwrap();
            for s in [0.1, 0.5, 0.8] {
                let (dense, which) = curves.as_ref().unwrap().of_leg(0);
                let found = point(dense, &walk.frames[0], which, s, k);
                let error = distance(&found, &curve.point(s).unwrap());
                assert!(error < 2e-11, "({r}, {k}) {problem} at {s}: {error:e}");
            }
        }
    }
}

#[test]
fn polynomials_stay_on_the_manifold() {
    let space = FixedFrames::<3, 2>;
    let walk = Walk::new(space, 20, 1.2, &mut TestNumbers(5));
    let ends = Ends::Open([(); 2].map(|()| End::Acceleration(vec![0.0; 3])));
    let manifold = Stiefel::new(3, 2).unwrap();
    let (outcome, curves) = solved::<Lanes, _>(space, &walk.knots(&ends));
    assert_eq!(outcome.reason, StopReason::Converged);
    let curves = curves.unwrap();
    for leg in 0..20 {
        let (dense, which) = curves.of_leg(leg);
        for i in 0..=20 {
            let s = point(dense, &walk.frames[leg], which, i as f64 / 20.0, 2);
            manifold.check_point("s", s.as_ref(), 1e-13).unwrap();
        }
    }
}
