//! Curves through serde: they are restored bit for bit, and modified data are refused.

mod common;

use common::{Rng, random_point, random_tangent};
use faer::{Mat, MatRef, Scale};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use stiefel_rs::cubic::{BoundaryOptions, IntegrationOptions};
use stiefel_rs::spline::{
    EndConditions, Outside, Piecewise, SplineOptions, cubic_hermite, cubic_spline,
    geometric_hermite, geometric_subspace_hermite,
};
use stiefel_rs::{
    Curve, Geodesic, GeometricCubic, GeometricPolynomial, Interrupt, Metric, QuasiGeodesic,
    RiemannianCubic, Stiefel, SubspacePolynomial,
};

/// A change of the numbers of an array.
type Edit<'a> = &'a dyn Fn(&mut [f64]);

const SHAPES: [(usize, usize); 6] = [(3, 1), (3, 2), (3, 3), (9, 2), (20, 2), (50, 3)];

fn through_json<C: Serialize + DeserializeOwned>(curve: &C) -> C {
    serde_json::from_str(&serde_json::to_string(curve).unwrap()).unwrap()
}

/// Bit-identical inside the interval, and where the curve is extrapolated.
fn assert_same<C: Curve>(again: &C, original: &C, outside: f64) {
    assert_eq!(again.t_span(), original.t_span());
    let (start, end) = original.t_span();
    for i in 0..=12 {
        let share = -outside + (1.0 + 2.0 * outside) * f64::from(i) / 12.0;
        let t = start + (end - start) * share.clamp(-outside, 1.0 + outside);
        for nu in 0..=3 {
            assert_eq!(
                again.derivative(t, nu).unwrap(),
                original.derivative(t, nu).unwrap(),
                "{t} {nu}"
            );
        }
    }
    assert_eq!(
        again.cost(Interrupt::NEVER).unwrap(),
        original.cost(Interrupt::NEVER).unwrap()
    );
}

fn ends((n, k): (usize, usize)) -> [Mat<f64>; 4] {
    let mut rng = Rng::new(n as u64 + 100 * k as u64);
    let s = random_point(n, k, &mut rng);
    let [v, a, j] = [0.5, 0.7, 0.9].map(|size| random_tangent(&s, size, &mut rng));
    let curve = cubic([&s, &v, &a, &j], 1.0, 1e-17);
    let end = |nu| curve.derivative(1.0, nu).unwrap();
    [s, v, end(0), end(1)]
}

fn cubic(data: [&Mat<f64>; 4], t_end: f64, tolerance: f64) -> RiemannianCubic {
    let options = IntegrationOptions {
        t_end,
        tolerance,
        ..IntegrationOptions::default()
    };
    let [s, v, a, j] = data.map(|x| x.as_ref());
    RiemannianCubic::from_initial(s, v, a, j, &options, Interrupt::NEVER).unwrap()
}

fn walk((n, k): (usize, usize), count: usize) -> (Vec<f64>, Vec<Mat<f64>>) {
    let mut rng = Rng::new(7);
    let manifold = Stiefel::new(n, k).unwrap();
    let mut points = vec![random_point(n, k, &mut rng)];
    for i in 1..count {
        let v = random_tangent(&points[i - 1], 0.5, &mut rng);
        points.push(manifold.exp(points[i - 1].as_ref(), v.as_ref()).unwrap());
    }
    let t = (0..count).map(|i| f64::from(i as u32).powf(1.2)).collect();
    (t, points)
}

fn natural(t: &[f64], points: &[Mat<f64>]) -> Piecewise<RiemannianCubic> {
    let (ends, options) = (EndConditions::Natural, SplineOptions::default());
    let found = cubic_spline(t, &views(points), &ends, &options, Interrupt::NEVER);
    found.unwrap().0
}

fn views(points: &[Mat<f64>]) -> Vec<MatRef<'_, f64>> {
    points.iter().map(Mat::as_ref).collect()
}

#[test]
fn single_curves_come_back_to_the_last_bit() {
    for shape in SHAPES {
        let [s0, v0, s1, v1] = &ends(shape);
        let (s0, v0, s1, v1) = (s0.as_ref(), v0.as_ref(), s1.as_ref(), v1.as_ref());
        let quick = GeometricCubic::from_boundary(s0, v0, s1, v1).unwrap();
        assert_same(&through_json(&quick), &quick, 0.2);
        let points = quick.control_points();
        let degree_two = GeometricPolynomial::new(&views(&points)[..3]).unwrap();
        assert_same(&through_json(&degree_two), &degree_two, 0.2);
        let straight = QuasiGeodesic::between(s0, s1).unwrap();
        assert_same(&through_json(&straight), &straight, 2.0);
        for metric in [
            Metric::CANONICAL,
            Metric::EUCLIDEAN,
            Metric::new(0.3).unwrap(),
        ] {
            let manifold = Stiefel::new(shape.0, shape.1).unwrap().with_metric(metric);
            let geodesic = manifold.geodesic(s0, v0).unwrap();
            let again = through_json(&geodesic);
            assert_same(&again, &geodesic, 2.0);
            assert_eq!(again.length(), geodesic.length());
        }
        let options = BoundaryOptions::default();
        let exact =
            RiemannianCubic::from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER).unwrap();
        let again = through_json(&exact);
        assert_same(&again, &exact, 0.5);
        assert_eq!(again.report(), exact.report());
        assert_eq!(again.steps(), exact.steps());
        for other in [
            exact.reversed(),
            exact.reparametrised(-5.0, -4.0).unwrap().reversed(),
            cubic(
                [
                    &s0.to_owned(),
                    &v0.to_owned(),
                    &v0.to_owned(),
                    &v0.to_owned(),
                ],
                -2.0,
                1e-5,
            ),
        ] {
            assert_same(&through_json(&other), &other, 0.5);
        }
    }
}

#[test]
fn de_casteljau_curves_of_subspaces_come_back_to_the_last_bit() {
    for shape in SHAPES {
        let (t, points) = walk(shape, 4);
        let curve = SubspacePolynomial::try_from(&points[..]).unwrap();
        assert_same(&through_json(&curve), &curve, 0.1);
        let mut rng = Rng::new(9);
        let velocities: Vec<Mat<f64>> = points
            .iter()
            .map(|y| {
                let v = random_tangent(y, 0.4, &mut rng);
                &v - y * (y.transpose() * &v)
            })
            .collect();
        let (points, velocities) = (views(&points), views(&velocities));
        let spline =
            geometric_subspace_hermite(&t, &points, &velocities, Interrupt::NEVER).unwrap();
        assert_same(&through_json(&spline), &spline, 0.0);
    }
    // A leg with a wrong end.
    let (_, points) = walk((5, 2), 3);
    let curve = SubspacePolynomial::try_from(&points[..]).unwrap();
    let mut form = serde_json::to_value(&curve).unwrap();
    form["arrays"]["leg_angles"]["entries"][0] = json!(0.1);
    let error = serde_json::from_value::<SubspacePolynomial>(form).unwrap_err();
    assert!(error.to_string().contains("legs"), "{error}");
}

#[test]
fn splines_come_back_to_the_last_bit() {
    for shape in SHAPES {
        let (t, points) = walk(shape, 5);
        let spline = natural(&t, &points);
        assert_same(&through_json(&spline), &spline, 0.0);
        let longer = spline.with_outside(Outside::Continued);
        assert_same(&through_json(&longer), &longer, 0.1);
        let mut rng = Rng::new(8);
        let velocities: Vec<Mat<f64>> = points
            .iter()
            .map(|s| random_tangent(s, 0.4, &mut rng))
            .collect();
        let options = BoundaryOptions::default();
        let (points, velocities) = (views(&points), views(&velocities));
        let exact = cubic_hermite(&t, &points, &velocities, &options, Interrupt::NEVER).unwrap();
        let again = through_json(&exact);
        assert_same(&again, &exact, 0.0);
        for (again, original) in again.pieces().iter().zip(exact.pieces()) {
            assert_eq!(again.report(), original.report());
        }
        let quick = geometric_hermite(&t, &points, &velocities).unwrap();
        assert_same(&through_json(&quick), &quick, 0.0);
    }
}

#[test]
fn a_basis_that_pieces_share_is_stored_once() {
    let (n, k, count) = (60, 1, 6);
    let (t, points) = walk((n, k), count);
    let spline = natural(&t, &points);
    let stored = serde_json::to_value(&spline).unwrap();
    let frames = stored["arrays"]["frames"]["entries"].as_array().unwrap();
    // Pieces in the span of all points share a basis with that many columns; other bases have at most four columns
    // each.
    assert!(
        frames.len() <= n * (count * k).max(4 * (count - 1)),
        "{}",
        frames.len()
    );
}

/// The error message for a modified form.
fn refused<C: Serialize + DeserializeOwned>(curve: &C, change: impl FnOnce(&mut Value)) -> String {
    let mut form = serde_json::to_value(curve).unwrap();
    change(&mut form);
    match serde_json::from_value::<C>(form) {
        Ok(_) => panic!("was taken"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn another_format_version_or_kind_is_refused() {
    let [s0, v0, s1, v1] = &ends((4, 2));
    let options = BoundaryOptions::default();
    let (s0, v0, s1, v1) = (s0.as_ref(), v0.as_ref(), s1.as_ref(), v1.as_ref());
    let curve = RiemannianCubic::from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER).unwrap();
    let said = refused(&curve, |form| form["format"] = json!("another"));
    assert!(
        said.contains("expected format 'stiefel_rs curve', found 'another'"),
        "{said}"
    );
    let said = refused(&curve, |form| form["version"] = json!(2));
    assert!(
        said.contains("newer version of the package, form 2; this version reads form 1"),
        "{said}"
    );
    let said = refused(&curve, |form| form["version"] = json!(0));
    assert!(said.contains("expected form 1, found 0"), "{said}");
    let said = refused(&curve, |form| form["kind"] = json!("GeometricCubic"));
    assert!(
        said.contains("expected a 'RiemannianCubic', found a 'GeometricCubic'"),
        "{said}"
    );
    let said = refused(&curve, |form| {
        form["arrays"]["more"] = form["arrays"]["spans"].clone()
    });
    assert!(said.contains("unexpected entry 'more'"), "{said}");
    for key in ["format", "version", "kind", "arrays"] {
        refused(&curve, |form| {
            drop(form.as_object_mut().unwrap().remove(key))
        });
    }
}

/// If accepted, the result is a curve whose points are on the manifold.
fn on_the_manifold<C: Curve>(curve: &C, name: &str) {
    let manifold = Stiefel::new(curve.n(), curve.k()).unwrap();
    let (start, end) = curve.t_span();
    for i in 0..=16 {
        let t = start + (end - start) * f64::from(i) / 16.0;
        // Refused if the curve would have to be integrated too far, or jumps.
        if let Ok(point) = curve.point(t) {
            manifold
                .check_point("S", point.as_ref(), 1e-9)
                .unwrap_or_else(|error| panic!("{name} at {t}: {error}"));
        }
    }
}

/// Every array is removed, emptied, made longer or shorter, or reshaped; numbers are replaced by impossible ones.
fn tamper<C: Serialize + DeserializeOwned + Curve>(curve: &C) {
    let form = serde_json::to_value(curve).unwrap();
    let names: Vec<String> = form["arrays"]
        .as_object()
        .unwrap()
        .keys()
        .cloned()
        .collect();
    let taken = |change: &dyn Fn(&mut Value)| {
        let mut form = form.clone();
        change(&mut form);
        serde_json::from_value::<C>(form)
    };
    let refused = |what: &str, change: &dyn Fn(&mut Value)| {
        let said = taken(change)
            .err()
            .unwrap_or_else(|| panic!("{what} was taken"));
        assert!(
            said.to_string().contains("stored curve: "),
            "{what}: {said}"
        );
    };
    for name in &names {
        let entries = form["arrays"][name]["entries"].as_array().unwrap();
        let without = |form: &mut Value| {
            drop(form["arrays"].as_object_mut().unwrap().remove(name));
        };
        match name.as_str() {
            // The first files have none.
            "strategies" => assert!(taken(&without).is_ok()),
            _ => refused(name, &without),
        }
        refused(name, &|form| {
            form["arrays"][name]["shape"] = json!([entries.len() + 1])
        });
        refused(name, &|form| {
            form["arrays"][name]["shape"] = json!([usize::MAX, usize::MAX])
        });
        let resized = |entries: Vec<Value>| {
            move |form: &mut Value| {
                form["arrays"][name] = json!({"shape": [entries.len()], "entries": entries});
            }
        };
        if !entries.is_empty() {
            refused(name, &resized(Vec::new()));
            refused(name, &resized(entries[1..].to_vec()));
        }
        refused(name, &resized([&entries[..], &[json!(1.0)]].concat()));
        // A wrong number may still give a curve, but must never panic.
        for index in [0, entries.len() / 2, entries.len().saturating_sub(1)] {
            for wrong in [-1.0, 0.0, 0.5, 2.0, 1e15, 1e300, -1e300] {
                let changed = taken(&|form| {
                    if let Some(entry) = form["arrays"][name]["entries"].get_mut(index) {
                        *entry = json!(wrong);
                    }
                });
                if let Ok(curve) = changed {
                    on_the_manifold(&curve, &format!("{name} {index} {wrong}"));
                }
            }
        }
        // All numbers of an array are wrong.
        let edits: [Edit<'_>; 5] = [
            &|x| x.iter_mut().for_each(|x| *x *= 1.01),
            &|x| x.iter_mut().for_each(|x| *x *= -1.0),
            &|x| x.iter_mut().for_each(|x| *x += 0.01),
            &|x| x.reverse(),
            &|x| x.rotate_left(1.min(x.len())),
        ];
        for (i, edit) in edits.iter().enumerate() {
            let changed = taken(&|form| {
                let mut numbers: Vec<f64> = entries.iter().map(|x| x.as_f64().unwrap()).collect();
                edit(&mut numbers);
                form["arrays"][name]["entries"] = json!(numbers);
            });
            if let Ok(curve) = changed {
                on_the_manifold(&curve, &format!("{name}, edit {i}"));
            }
        }
    }
}

#[test]
fn tampered_curves_are_refused() {
    let [s0, v0, s1, v1] = &ends((9, 2));
    let (s0, v0, s1, v1) = (s0.as_ref(), v0.as_ref(), s1.as_ref(), v1.as_ref());
    tamper(&QuasiGeodesic::between(s0, s1).unwrap());
    tamper(&Geodesic::between(s0, s1).unwrap());
    tamper(&GeometricCubic::from_boundary(s0, v0, s1, v1).unwrap());
    let options = BoundaryOptions::default();
    tamper(&RiemannianCubic::from_boundary(s0, v0, s1, v1, &options, Interrupt::NEVER).unwrap());
    let (t, points) = walk((3, 2), 4);
    let spline = natural(&t, &points);
    tamper(&spline);
    let still: Vec<Mat<f64>> = points.iter().map(|point| point * Scale(0.0)).collect();
    let quick: Piecewise<GeometricCubic> =
        geometric_hermite(&t, &views(&points), &views(&still)).unwrap();
    tamper(&quick);
    for metric in [Metric::EUCLIDEAN, Metric::new(0.3).unwrap()] {
        let manifold = Stiefel::new(9, 2).unwrap().with_metric(metric);
        tamper(&manifold.geodesic(s0, v0).unwrap());
    }
    // Stored in a frame.
    let [s0, v0, s1, v1] = &ends((20, 2));
    let (s0, v0, s1, v1) = (s0.as_ref(), v0.as_ref(), s1.as_ref(), v1.as_ref());
    tamper(&GeometricCubic::from_boundary(s0, v0, s1, v1).unwrap());
    tamper(
        &RiemannianCubic::from_boundary(
            s0,
            v0,
            s1,
            v1,
            &BoundaryOptions::default(),
            Interrupt::NEVER,
        )
        .unwrap(),
    );
}

#[test]
fn rough_and_fast_curves_come_back() {
    let mut rng = Rng::new(21);
    for shape in SHAPES {
        let s = random_point(shape.0, shape.1, &mut rng);
        for (sizes, t_end) in [
            ([1.0, 2.0, 3.0], 1.0),
            ([300.0, 1.0, 0.0], 1.0),
            ([0.01, 5.0, 40.0], -2.0),
        ] {
            let [v, a, j] = sizes.map(|size| random_tangent(&s, size, &mut rng));
            for tolerance in [1e-17, 1e-8, 1e-3, 0.1] {
                let curve = cubic([&s, &v, &a, &j], t_end, tolerance);
                assert_same(&through_json(&curve), &curve, 0.0);
            }
        }
    }
}
