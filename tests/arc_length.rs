//! Arc length: closed forms, additivity, curves that rest, the inverse, constant speed, bad input.

mod common;

use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Boundary, Rng, assert_within, distance, random_point, random_tangent};
use faer::{Mat, MatRef, mat};
use stiefel_rs::curve::ArcLength;
use stiefel_rs::linalg::jet::MatrixJet;
use stiefel_rs::spline::{EndConditions, SplineOptions, geometric_hermite, geometric_spline};
use stiefel_rs::{Curve, Error, GeometricCubic, Interrupt, QuasiGeodesic, Retraction, Stiefel};

/// The stated accuracy: 1e-12, relative.
const RELATIVE: f64 = 1e-12;

fn views(points: &[Mat<f64>]) -> Vec<MatRef<'_, f64>> {
    points.iter().map(Mat::as_ref).collect()
}

fn on_circle(angle: f64) -> Mat<f64> {
    mat![[angle.cos()], [angle.sin()]]
}

/// On the circle, with given angles and angular velocities at unit times.
fn circle(angles: &[f64], rates: &[f64]) -> stiefel_rs::spline::Piecewise<GeometricCubic> {
    let t: Vec<f64> = (0..angles.len()).map(|i| i as f64).collect();
    let points: Vec<Mat<f64>> = angles.iter().map(|a| on_circle(*a)).collect();
    let tangents: Vec<Mat<f64>> = angles
        .iter()
        .zip(rates)
        .map(|(a, v)| mat![[-v * a.sin()], [v * a.cos()]])
        .collect();
    geometric_hermite(&t, &views(&points), &views(&tangents)).unwrap()
}

#[test]
fn quasi_geodesics_have_length_speed_times_time() {
    for shape in [(1, 1), (2, 1), (3, 2), (3, 3), (6, 3), (20, 2)] {
        let mut rng = Rng::new(1);
        let s = random_point(shape.0, shape.1, &mut rng);
        let v = random_tangent(&s, 1.3, &mut rng);
        let speed = Stiefel::new(shape.0, shape.1)
            .unwrap()
            .norm(s.as_ref(), v.as_ref())
            .unwrap();
        let curve = QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
        for (t0, t1) in [(0.0, 1.0), (-2.0, 3.0), (0.4, 0.4)] {
            let found = curve.arc_length(t0, t1, Interrupt::NEVER).unwrap();
            let bound = RELATIVE * speed * (t1 - t0) + 1e-14;
            assert_within(
                (found - speed * (t1 - t0)).abs(),
                bound,
                &format!("{shape:?}"),
            );
        }
    }
}

#[test]
fn a_curve_that_turns_back_is_as_long_as_both_ways() {
    // On [0, 1], the speed of the angle 3 t - 6 t^2 + 4 t^3 - 1/2 has a double zero; the angle -t + 2 t^2 reverses its
    // direction.
    let rest = circle(&[0.0, 1.0], &[3.0, 3.0]);
    // Angle u -> 3u - 6u^2 + 4u^3, derivative 3 (1 - 2u)^2 >= 0.
    assert_within(
        (rest.arc_length(0.0, 1.0, Interrupt::NEVER).unwrap() - 1.0).abs(),
        RELATIVE,
        "rest",
    );
    // Angle -u + u^2: down to -1/4 and back.
    let back = circle(&[0.0, 0.0], &[-1.0, 1.0]);
    assert_within(
        (back.arc_length(0.0, 1.0, Interrupt::NEVER).unwrap() - 0.5).abs(),
        RELATIVE,
        "back",
    );
    let half = ArcLength::of(&back, Interrupt::NEVER).unwrap();
    let t = half.parameter(0.25 + 0.0625).unwrap();
    // -u + u^2 = -1/4 + 1/16.
    assert_within((t - 0.75).abs(), 1e-10, "after the turn");
}

#[test]
fn lengths_add_up_and_do_not_change_with_time() {
    for shape in [(3, 1), (3, 2), (4, 4), (7, 3)] {
        let curve = Boundary::random(shape, 1.0, 1.5, &mut Rng::new(2)).curve();
        let total = curve.arc_length(0.0, 1.0, Interrupt::NEVER).unwrap();
        let parts: f64 = [0.0, 0.3, 0.55, 1.0]
            .windows(2)
            .map(|t| curve.arc_length(t[0], t[1], Interrupt::NEVER).unwrap())
            .sum();
        assert_within(
            (parts - total).abs(),
            2.0 * RELATIVE * total,
            &format!("{shape:?}"),
        );
        // A polygon of many chords is shorter, relative to the curve, by the order of a squared step.
        let chords: f64 = (0..500)
            .map(|i| {
                let [a, b] = [i, i + 1].map(|i| curve.point(f64::from(i) / 500.0).unwrap());
                let v = Retraction::QuasiGeodesic
                    .inverse_retract(a.as_ref(), b.as_ref())
                    .unwrap();
                Stiefel::of("S", a.as_ref())
                    .unwrap()
                    .norm(a.as_ref(), v.as_ref())
                    .unwrap()
            })
            .sum();
        assert_within(
            (chords - total).abs(),
            1e-5 * total,
            &format!("{shape:?} chords"),
        );
    }
}

#[test]
fn parameters_of_equal_lengths() {
    for shape in [(2, 1), (3, 2), (4, 4), (20, 2)] {
        let curve = Boundary::random(shape, 1.0, 2.0, &mut Rng::new(3)).curve();
        let length = ArcLength::of(&curve, Interrupt::NEVER).unwrap();
        let count = 60;
        let t = length.equal(count).unwrap();
        assert_eq!((t.len(), t[0], t[count - 1]), (count, 0.0, 1.0));
        let step = length.total() / (count - 1) as f64;
        for pair in t.windows(2) {
            assert!(pair[0] < pair[1], "{shape:?}: {pair:?}");
            let found = curve
                .arc_length(pair[0], pair[1], Interrupt::NEVER)
                .unwrap();
            let bound = 2.0 * RELATIVE * length.total();
            assert_within((found - step).abs(), bound, &format!("{shape:?}"));
        }
        let samples = length.sample(count).unwrap();
        assert_eq!(samples.len(), count);
        assert_eq!(samples.get(7), curve.point(t[7]).unwrap().as_ref());
        // Given lengths in any order, with the same results as one by one.
        let wanted = [0.9, 0.1, 0.0, 1.0].map(|share| share * length.total());
        let found = length.parameters(&wanted).unwrap();
        for (wanted, t) in wanted.iter().zip(&found) {
            assert_eq!(length.parameter(*wanted).unwrap(), *t);
            let back = curve.arc_length(0.0, *t, Interrupt::NEVER).unwrap();
            assert_within(
                (back - wanted).abs(),
                2.0 * RELATIVE * length.total(),
                "given",
            );
        }
    }
}

#[test]
fn pieces_are_measured_one_by_one() {
    let mut rng = Rng::new(4);
    let mut points = vec![random_point(4, 2, &mut rng)];
    for i in 0..6 {
        let v = random_tangent(&points[i], 0.6, &mut rng);
        points.push(common::retract(&points[i], &v));
    }
    let t = [0.0, 0.1, 1.0, 1.5, 3.0, 3.2, 5.0];
    let (curve, _) = geometric_spline(
        &t,
        &views(&points),
        &EndConditions::Natural,
        &SplineOptions::default(),
        Interrupt::NEVER,
    )
    .unwrap();
    let sum: f64 = curve
        .pieces()
        .iter()
        .map(|piece| piece.arc_length(0.0, 1.0, Interrupt::NEVER).unwrap())
        .sum();
    let total = curve.arc_length(0.0, 5.0, Interrupt::NEVER).unwrap();
    assert_within((sum - total).abs(), 2.0 * RELATIVE * total, "pieces");
    let length = ArcLength::of(&curve, Interrupt::NEVER).unwrap();
    for (i, t) in length.equal(50).unwrap().into_iter().enumerate() {
        let found = curve.arc_length(0.0, t, Interrupt::NEVER).unwrap();
        let expected = total * i as f64 / 49.0;
        assert_within((found - expected).abs(), 2.0 * RELATIVE * total, "equal");
    }
}

#[test]
fn a_curve_that_does_not_move_has_no_length() {
    let s = random_point(4, 2, &mut Rng::new(5));
    let curve = QuasiGeodesic::from_velocity(s.as_ref(), Mat::zeros(4, 2).as_ref()).unwrap();
    let length = ArcLength::of(&curve, Interrupt::NEVER).unwrap();
    assert_eq!(length.total(), 0.0);
    assert_eq!(length.equal(5).unwrap(), [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(length.parameter(0.0).unwrap(), 0.0);
    // A curve that rests up to round-off.
    let v = Mat::zeros(4, 2);
    let still = GeometricCubic::from_boundary(s.as_ref(), v.as_ref(), s.as_ref(), v.as_ref());
    let still = still.unwrap();
    assert_within(
        still.arc_length(0.0, 1.0, Interrupt::NEVER).unwrap(),
        1e-14,
        "still",
    );
    assert_within(distance(&still.point(0.5).unwrap(), &s), 1e-14, "still");
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let curve = Boundary::random((4, 2), 1.0, 2.0, &mut Rng::new(6)).curve();
    let solve = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let length = ArcLength::of(&curve, Interrupt::NEVER).unwrap();
            length.equal(300).unwrap()
        })
    };
    assert_eq!(solve(1), solve(3));
}

#[test]
fn bad_input_is_refused() {
    let curve = Boundary::random((4, 2), 1.0, 1.0, &mut Rng::new(7)).curve();
    assert!(matches!(
        curve.arc_length(0.0, f64::NAN, Interrupt::NEVER),
        Err(Error::NonFinite { .. })
    ));
    assert!(matches!(
        curve.arc_length(1.0, 0.5, Interrupt::NEVER),
        Err(Error::InvalidArgument {
            name: "t1",
            found: 0.5,
            ..
        })
    ));
    let length = ArcLength::of(&curve, Interrupt::NEVER).unwrap();
    for wrong in [-0.1, 1.1 * length.total()] {
        assert!(matches!(
            length.parameter(wrong),
            Err(Error::InvalidArgument { name: "length", .. })
        ));
    }
    let index = length.parameters(&[0.1, f64::INFINITY]);
    assert!(matches!(index, Err(Error::NonFinite { index: 1, .. })));
    for count in [0, 1] {
        let refused = length.equal(count);
        assert!(matches!(
            refused,
            Err(Error::InvalidArgument { name: "count", .. })
        ));
    }
    let stop = || true;
    let stopped = ArcLength::of(&curve, Interrupt::new(&stop));
    assert!(matches!(stopped, Err(Error::Interrupted { .. })));
}

/// Counts the evaluations of a curve.
struct Counted<C> {
    curve: C,
    evaluations: AtomicUsize,
}

impl<C: Curve> Curve for Counted<C> {
    type Workspace = C::Workspace;

    fn n(&self) -> usize {
        self.curve.n()
    }

    fn k(&self) -> usize {
        self.curve.k()
    }

    fn t_span(&self) -> (f64, f64) {
        self.curve.t_span()
    }

    fn breakpoints(&self) -> Vec<f64> {
        self.curve.breakpoints()
    }

    fn frame(&self) -> Option<MatRef<'_, f64>> {
        self.curve.frame()
    }

    fn workspace(&self) -> C::Workspace {
        self.curve.workspace()
    }

    fn coordinates_into(
        &self,
        t: f64,
        order: usize,
        work: &mut C::Workspace,
        out: &mut MatrixJet,
    ) -> Result<(), Error> {
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        self.curve.coordinates_into(t, order, work, out)
    }
}

fn evaluations_of_resampling(curve: impl Curve) -> usize {
    let curve = Counted {
        curve,
        evaluations: AtomicUsize::new(0),
    };
    let length = ArcLength::of(&curve, Interrupt::NEVER).unwrap();
    let t = length.equal(100).unwrap();
    assert!(t.windows(2).all(|pair| pair[0] <= pair[1]));
    curve.evaluations.load(Ordering::Relaxed)
}

/// Speeds are then known to a few digits only, and halving panels does not make them smoother.
#[test]
fn round_off_of_speeds_does_not_cause_more_evaluations() {
    // A single panel that is halved to the limit of 1024 parts takes 28 evaluations for each of 1023 halvings.
    const MOST: usize = 20_000;
    let short = Boundary::random((3, 2), 1e-10, 2e-10, &mut Rng::new(5)).curve();
    let found = evaluations_of_resampling(short);
    assert!(found < MOST, "short: {found}");
    let t: Vec<f64> = (0..8)
        .map(|i| 2.0_f64.powi(30) + 0.1 * f64::from(i))
        .collect();
    let angles = [0.0, 0.4, 0.5, 1.1, 1.0, 1.6, 1.7, 2.5];
    let points: Vec<Mat<f64>> = angles.iter().map(|angle| on_circle(*angle)).collect();
    let options = SplineOptions::default();
    let far = geometric_spline(
        &t,
        &views(&points),
        &EndConditions::Natural,
        &options,
        Interrupt::NEVER,
    );
    let found = evaluations_of_resampling(far.unwrap().0);
    assert!(found < MOST, "far: {found}");
}
