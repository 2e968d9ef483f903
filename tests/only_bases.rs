//! Frames that are far apart only because their columns are rotated: errors name the subspaces.

use faer::{Mat, MatRef, mat};
use stiefel_rs::cubic::{BoundaryOptions, RiemannianCubic, SearchOptions};
use stiefel_rs::spline::{
    EndConditions, SmoothingOptions, SplineOptions, VelocityEstimate, cubic_spline,
    estimate_velocities, geometric_spline, smoothing_spline,
};
use stiefel_rs::{
    Error, GeometricCubic, Grassmann, Interrupt, QuasiGeodesic, Quotient, Retraction, Stiefel,
    skew_exp,
};

/// The first columns of the identity, and the same with opposite signs: one subspace.
fn opposite() -> [Mat<f64>; 2] {
    let identity = Mat::<f64>::identity(6, 2);
    [identity.clone(), -identity]
}

/// Bases along a geodesic of subspaces, 0.3 apart, whose columns are rotated from each to the next.
fn turned(n: usize, k: usize, count: usize) -> Vec<Mat<f64>> {
    let manifold = Grassmann::new(n, k).unwrap();
    let y = Mat::<f64>::identity(n, k);
    let v = Mat::from_fn(n, k, |i, j| {
        if i < k {
            0.0
        } else {
            ((3 * i + 5 * j) as f64).sin()
        }
    });
    let v = &v * faer::Scale(0.3 / v.norm_l2());
    let turn = |i: usize| {
        let a = Mat::from_fn(k, k, |p, q| (i as f64 * 2.1 * (p as f64 - q as f64)).sin());
        skew_exp(a.as_ref()).unwrap()
    };
    let point = |i: usize| {
        let v = &v * faer::Scale(i as f64);
        manifold.exp(y.as_ref(), v.as_ref()).unwrap() * turn(i)
    };
    (0..count).map(point).collect()
}

/// The distances in the error, which is at the given knot.
fn distances(error: Error, at: Option<usize>) -> [f64; 2] {
    let error = match (error, at) {
        (Error::AtKnot { knot, source }, Some(at)) if knot == at => *source,
        (error, None) => error,
        (error, _) => panic!("{error}"),
    };
    match error {
        Error::OnlyBases {
            frames,
            subspaces,
            source,
        } => {
            assert!(!matches!(*source, Error::OnlyBases { .. }), "said twice");
            [frames, subspaces]
        }
        error => panic!("{error}"),
    }
}

fn failed<T>(result: Result<T, Error>) -> Error {
    result.err().expect("there is no curve between them")
}

#[test]
fn two_points() {
    let [s0, s1] = opposite();
    let [s0, s1] = [s0.as_ref(), s1.as_ref()];
    let manifold = Stiefel::new(6, 2).unwrap();
    let errors = [
        failed(manifold.log(s0, s1)),
        failed(QuasiGeodesic::between(s0, s1)),
        failed(Retraction::Polar.inverse_retract(s0, s1)),
        failed(Retraction::Qr.inverse_retract(s0, s1)),
        failed(Retraction::Cayley.inverse_retract(s0, s1)),
        failed(Retraction::QuasiGeodesic.inverse_retract(s0, s1)),
    ];
    for error in errors {
        let [frames, subspaces] = distances(error, None);
        assert!((frames - 8.0_f64.sqrt()).abs() < 1e-15, "{frames}");
        assert!(subspaces < 1e-15, "{subspaces}");
    }
}

#[test]
fn splines() {
    let points = turned(20, 3, 6);
    let views: Vec<MatRef<'_, f64>> = points.iter().map(Mat::as_ref).collect();
    let t: Vec<f64> = (0..6).map(f64::from).collect();
    let ends = EndConditions::Natural;
    // One step is too few for frames at any distance.
    let options = SplineOptions {
        max_iterations: 1,
        ..SplineOptions::default()
    };
    let found = cubic_spline(&t, &views, &ends, &options, Interrupt::NEVER);
    let [frames, subspaces] = distances(failed(found), Some(0));
    let aligned = Grassmann::new(20, 3)
        .unwrap()
        .align(views[0], views[1])
        .unwrap();
    assert!(
        (frames - (&points[1] - &points[0]).norm_l2()).abs() < 1e-12,
        "{frames}"
    );
    assert!(
        (subspaces - (aligned - &points[0]).norm_l2()).abs() < 1e-12,
        "{subspaces}"
    );

    let [s0, s1] = opposite();
    let views = [s0.as_ref(), s1.as_ref(), s0.as_ref()];
    let found = geometric_spline(
        &t[..3],
        &views,
        &ends,
        &SplineOptions::default(),
        Interrupt::NEVER,
    );
    distances(failed(found), Some(0));
    let smoothing = SmoothingOptions {
        lambda: Some(1.0),
        ..SmoothingOptions::default()
    };
    let found = smoothing_spline(&t[..2], &views[..2], None, &smoothing, Interrupt::NEVER);
    distances(failed(found), Some(0));
    let found = estimate_velocities(&t[..3], &views, VelocityEstimate::Natural, Quotient::Frames);
    distances(failed(found), Some(0));
}

#[test]
fn boundary_problem() {
    let points = turned(20, 3, 2);
    let [s0, s1] = [points[0].as_ref(), points[1].as_ref()];
    let rest = Mat::zeros(20, 3);
    let options = BoundaryOptions {
        max_iterations: 1,
        ..BoundaryOptions::default()
    };
    let found = RiemannianCubic::from_boundary(
        s0,
        rest.as_ref(),
        s1,
        rest.as_ref(),
        &options,
        Interrupt::NEVER,
    );
    let options = SearchOptions {
        boundary: options,
        ..SearchOptions::default()
    };
    let all = RiemannianCubic::all_from_boundary(
        s0,
        rest.as_ref(),
        s1,
        rest.as_ref(),
        &options,
        Interrupt::NEVER,
    );
    for error in [failed(found), failed(all)] {
        assert!(error.report().is_some_and(|report| !report.converged));
        distances(error, None);
    }
}

/// Unit vectors that span nearly the same line: as lines they are near, and no frames are meant.
#[test]
fn lines_get_no_hint() {
    let y0 = mat![[1.0], [0.0], [0.0]];
    let y1 = mat![[-0.96], [0.28], [0.0]];
    let (across, rest) = (mat![[0.0], [0.0], [2.0]], Mat::zeros(3, 1));
    let options = BoundaryOptions {
        max_iterations: 1,
        tolerance: 1e-15,
        quotient: Quotient::Subspaces,
        ..BoundaryOptions::default()
    };
    let data = [&y0, &across, &y1, &rest].map(|x| x.as_ref());
    let [y0, v0, y1, v1] = data;
    let found = RiemannianCubic::from_boundary(y0, v0, y1, v1, &options, Interrupt::NEVER);
    assert!(!matches!(failed(found), Error::OnlyBases { .. }));
}

/// The ends are equal, but the velocity is too large.
#[test]
fn hints_are_about_the_given_points() {
    let s = Mat::<f64>::identity(6, 2);
    let v = Mat::from_fn(6, 2, |i, j| match (i, j) {
        (1, 0) => 3.0 * std::f64::consts::PI,
        (0, 1) => -3.0 * std::f64::consts::PI,
        _ => 0.0,
    });
    let rest = Mat::zeros(6, 2);
    let [s, v, rest] = [&s, &v, &rest].map(|x| x.as_ref());
    let error = failed(GeometricCubic::from_boundary(s, v, s, rest));
    assert!(!matches!(error, Error::OnlyBases { .. }), "{error}");
}

/// One angle is pi/2, so that bases cannot be aligned; the answer does not depend on the coordinates of the space.
#[test]
fn no_hint_where_bases_cannot_be_aligned() {
    let s0 = Mat::<f64>::identity(6, 2);
    let mut s1 = Mat::zeros(6, 2);
    (s1[(0, 0)], s1[(2, 1)]) = (-1.0, 1.0);
    let a = Mat::from_fn(6, 6, |i, j| (1.3 * (i as f64 - j as f64)).sin());
    let turn = skew_exp(a.as_ref()).unwrap();
    for turn in [Mat::identity(6, 6), turn] {
        let [s0, s1] = [&s0, &s1].map(|s| &turn * s);
        let found = Retraction::Polar.inverse_retract(s0.as_ref(), s1.as_ref());
        let error = failed(found);
        assert!(!matches!(error, Error::OnlyBases { .. }), "{error}");
    }
}

#[test]
fn subspaces_and_rotations_are_no_bases() {
    // A rotation by pi about an axis: every rotation spans the whole space.
    let half_turn = Mat::from_fn(3, 3, |i, j| match (i == j, i) {
        (true, 0) => 1.0,
        (true, _) => -1.0,
        _ => 0.0,
    });
    let identity = Mat::<f64>::identity(3, 3);
    let error = failed(
        Stiefel::new(3, 3)
            .unwrap()
            .log(identity.as_ref(), half_turn.as_ref()),
    );
    assert!(matches!(error, Error::NoJoiningCurve { .. }), "{error}");
    // Orthogonal planes are as far apart as subspaces as they are as frames.
    let [s0, s1] =
        [0, 2].map(|first| Mat::from_fn(6, 2, |i, j| f64::from(u8::from(i == j + first))));
    let found = Retraction::Polar.inverse_retract(s0.as_ref(), s1.as_ref());
    let error = failed(found);
    assert!(
        matches!(error, Error::OutsideRetractionDomain { .. }),
        "{error}"
    );
}
