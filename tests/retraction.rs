//! Retractions: their equations, their orders against the geodesic, their inverses and the borders of these.

mod common;

use common::*;
use std::f64::consts::FRAC_PI_2;

use faer::{Mat, Scale};
use stiefel_rs::{Curve, Error, Metric, QuasiGeodesic, Retraction, Stiefel, skew_exp};

const LINEAR: [Retraction; 3] = [Retraction::Qr, Retraction::Polar, Retraction::Cayley];

fn apply(retraction: Retraction, s: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
    retraction
        .retract(s.as_ref(), v.as_ref())
        .unwrap_or_else(|e| panic!("{retraction:?} {:?}: {e}", s.shape()))
}

fn inverse(retraction: Retraction, s0: &Mat<f64>, s1: &Mat<f64>) -> Mat<f64> {
    retraction
        .inverse_retract(s0.as_ref(), s1.as_ref())
        .unwrap_or_else(|e| panic!("{retraction:?} {:?}: {e}", s0.shape()))
}

/// A point and a tangent vector of each norm, in each shape.
fn each_shape(norms: &[f64], mut check: impl FnMut(&Mat<f64>, &Mat<f64>, &str)) {
    let mut rng = Rng::new(71);
    for (n, k) in SIZES {
        for norm in norms {
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, *norm, &mut rng);
            check(&s, &v, &format!("({n}, {k}), |V| = {norm}"));
        }
    }
}

/// The skew `n x n` matrix `K S^T - S K^T + f S Omega S^T` of a tangent vector.
fn generator(s: &Mat<f64>, v: &Mat<f64>, f: f64) -> Mat<f64> {
    let omega = s.transpose() * v;
    let normal = project_off(s, v);
    &normal * s.transpose() - s * normal.transpose() + s * omega * s.transpose() * Scale(f)
}

/// The geodesic of the metric of weight `w` at 1, by exponentials of full size.
fn exponential(s: &Mat<f64>, v: &Mat<f64>, w: f64) -> Mat<f64> {
    let skew = |a: Mat<f64>| (&a - a.transpose()) * Scale(0.5);
    let turn = skew_exp(skew(s.transpose() * v * Scale(1.0 - 2.0 * w)).as_ref()).unwrap();
    skew_exp(skew(generator(s, v, 2.0 * w)).as_ref()).unwrap() * s * turn
}

// ------------------------------------------------------------------ the equations

#[test]
fn retractions_map_to_points() {
    let mut worst = Worst::new("orthonormality");
    each_shape(&[0.0, 1e-300, 1e-9, 1.0, 10.0], |s, v, place| {
        for retraction in Retraction::ALL {
            let y = apply(retraction, s, v);
            worst.see(orthonormality(&y), || format!("{retraction:?} {place}"));
        }
    });
    worst.assert_at_most(1e-14);
}

#[test]
fn zero_is_mapped_to_the_point_itself() {
    each_shape(&[0.0, 1e-300], |s, v, place| {
        for retraction in Retraction::ALL {
            let y = apply(retraction, s, v);
            assert_close(&y, s, 1e-15 * s.nrows() as f64, place);
        }
    });
}

#[test]
fn quasi_geodesic_is_the_curve_at_one() {
    each_shape(&[1.0, 5.0], |s, v, place| {
        let curve = QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
        let y = apply(Retraction::QuasiGeodesic, s, v);
        assert_close(&y, &curve.point(1.0).unwrap(), 1e-14, place);
    });
}

#[test]
fn qr_factor_is_triangular_with_positive_diagonal() {
    each_shape(&[0.5, 1.0, 5.0], |s, v, place| {
        let (y, sum) = (apply(Retraction::Qr, s, v), s + v);
        let r = y.transpose() * &sum;
        let bound = 1e-15 * frobenius(sum.as_ref()) * s.nrows() as f64;
        assert_close(&(&y * &r), &sum, bound, &format!("Q R = S + V, {place}"));
        for j in 0..r.ncols() {
            assert!(
                r[(j, j)] >= 1.0 - bound,
                "{place}: R[{j},{j}] = {}",
                r[(j, j)]
            );
            for i in j + 1..r.nrows() {
                assert_within(
                    r[(i, j)].abs(),
                    bound,
                    &format!("below the diagonal, {place}"),
                );
            }
        }
    });
}

#[test]
fn polar_factor_leaves_the_root_of_the_gram_matrix() {
    each_shape(&[0.5, 1.0, 5.0], |s, v, place| {
        let (y, sum) = (apply(Retraction::Polar, s, v), s + v);
        let p = y.transpose() * &sum;
        let bound = 2e-15 * frobenius(sum.as_ref()) * s.nrows() as f64;
        assert_close(&(&y * &p), &sum, bound, &format!("Y P = S + V, {place}"));
        assert_close(
            &p,
            &p.transpose().to_owned(),
            bound,
            &format!("P symmetric, {place}"),
        );
        let gram = v.transpose() * v + identity(v.ncols());
        let size = frobenius(gram.as_ref());
        assert_close(
            &(&p * &p),
            &gram,
            1e-14 * size,
            &format!("P^2 = I + V^T V, {place}"),
        );
        let eigenvalues = p.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        assert!(
            eigenvalues[0] >= 1.0 - bound,
            "{place}: P is not positive: {eigenvalues:?}"
        );
    });
}

#[test]
fn cayley_transform_of_full_size() {
    each_shape(&[0.5, 1.0, 5.0], |s, v, place| {
        let w = generator(s, v, 1.0);
        assert_close(&(&w * s), v, 1e-14, &format!("W S = V, {place}"));
        // Wen and Yin's form of the same matrix.
        let p = identity(s.nrows()) - s * s.transpose() * Scale(0.5);
        let theirs = &p * v * s.transpose() - s * v.transpose() * &p;
        assert_close(&w, &theirs, 1e-14, &format!("W, {place}"));
        let y = apply(Retraction::Cayley, s, v);
        let residual = &y - &w * &y * Scale(0.5) - s - v * Scale(0.5);
        assert_within(
            frobenius(residual.as_ref()),
            2e-15 * s.nrows() as f64,
            &format!("(I - W/2) Y = (I + W/2) S, {place}"),
        );
    });
}

#[test]
fn retractions_are_equivariant() {
    let mut rng = Rng::new(72);
    each_shape(&[1.0], |s, v, place| {
        let q = random_orthogonal(s.nrows(), &mut rng);
        for retraction in Retraction::ALL {
            let moved = apply(retraction, &(&q * s), &(&q * v));
            let expected = &q * apply(retraction, s, v);
            assert_close(&moved, &expected, 3e-14, &format!("{retraction:?} {place}"));
        }
    });
}

// ------------------------------------------------------------------ the table of orders

/// Slopes of `log |R(tV) - exp(tV)|` against `log t` over four halvings.
fn slopes(retraction: Retraction, (n, k): (usize, usize), weight: f64) -> Vec<f64> {
    let mut rng = Rng::new(73);
    let s = random_point(n, k, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let errors: Vec<f64> = (0..5)
        .map(|i| {
            let step = &v * Scale(0.1 * 0.5_f64.powi(i));
            distance(
                &apply(retraction, &s, &step),
                &exponential(&s, &step, weight),
            )
        })
        .collect();
    errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect()
}

#[test]
fn table_of_orders_in_the_module_documentation() {
    use Retraction::{Cayley, Polar, Qr, QuasiGeodesic};
    let (canonical, euclidean) = (Metric::CANONICAL.weight(), Metric::EUCLIDEAN.weight());
    let shapes = [(5, 2), (6, 3), (5, 4)];
    let mut table = Vec::new();
    for shape in shapes {
        for (retraction, first, second) in [
            (QuasiGeodesic, 2.0, 2.0),
            (Qr, 2.0, 2.0),
            (Polar, 2.0, 3.0),
            (Cayley, 3.0, 2.0),
        ] {
            table.push((retraction, shape, canonical, first));
            table.push((retraction, shape, euclidean, second));
        }
    }
    for weight in [canonical, euclidean] {
        for (retraction, sphere, rotations) in
            [(Qr, 3.0, 2.0), (Polar, 3.0, 3.0), (Cayley, 3.0, 3.0)]
        {
            table.push((retraction, (4, 1), weight, sphere));
            table.push((retraction, (4, 4), weight, rotations));
        }
    }
    for (retraction, shape, weight, order) in table {
        let measured = slopes(retraction, shape, weight);
        println!("{retraction:?} {shape:?} w = {weight}: {measured:.3?}");
        for slope in measured {
            assert_within(
                (slope - order).abs(),
                0.2,
                &format!("{retraction:?} {shape:?} w = {weight}: slope {slope} for {order}"),
            );
        }
    }
}

#[test]
fn quasi_geodesics_are_geodesics_on_spheres_and_rotations() {
    let mut rng = Rng::new(74);
    for (n, k) in [(4, 1), (4, 4), (2, 1), (3, 3)] {
        let s = random_point(n, k, &mut rng);
        let v = random_tangent(&s, 2.0, &mut rng);
        for weight in [0.5, 1.0] {
            let y = apply(Retraction::QuasiGeodesic, &s, &v);
            assert_close(
                &y,
                &exponential(&s, &v, weight),
                1e-14,
                &format!("({n}, {k})"),
            );
        }
    }
}

// ------------------------------------------------------------------ the inverses

#[test]
fn inverse_brings_the_vector_back() {
    let mut worst = Worst::new("|inverse(retract(V)) - V|");
    each_shape(&[0.0, 1e-300, 1e-9, 1e-3, 0.5, 1.0, 3.0], |s, v, place| {
        for retraction in LINEAR {
            let back = inverse(retraction, s, &apply(retraction, s, v));
            worst.see(distance(&back, v), || format!("{retraction:?} {place}"));
        }
    });
    // 0.75 n k eps |V|^2 at the largest.
    worst.assert_at_most(5e-14);
}

#[test]
fn inverse_leads_to_the_point_and_is_tangent() {
    let mut rng = Rng::new(75);
    let mut worst = Worst::new("|retract(inverse(S1)) - S1|");
    for (n, k) in SIZES {
        let manifold = Stiefel::new(n, k).unwrap();
        for length in [1e-6, 0.3, 1.0] {
            let s0 = random_point(n, k, &mut rng);
            let s1 = retract(&s0, &random_tangent(&s0, length, &mut rng));
            for retraction in Retraction::ALL {
                let v = inverse(retraction, &s0, &s1);
                manifold
                    .check_tangent("V", s0.as_ref(), v.as_ref(), 1e-14)
                    .unwrap();
                let miss = distance(&apply(retraction, &s0, &v), &s1);
                worst.see(miss, || format!("{retraction:?} ({n}, {k}), {length}"));
            }
        }
    }
    worst.assert_at_most(1e-13);
}

#[test]
fn any_pair_of_points_is_joined_or_refused() {
    let mut rng = Rng::new(76);
    let (mut joined, mut refused) = ([0; 3], [0; 3]);
    for (n, k) in SIZES {
        for _ in 0..40 {
            let (s0, s1) = (random_point(n, k, &mut rng), random_point(n, k, &mut rng));
            for (i, retraction) in LINEAR.into_iter().enumerate() {
                match retraction.inverse_retract(s0.as_ref(), s1.as_ref()) {
                    Ok(v) => {
                        joined[i] += 1;
                        let miss = distance(&apply(retraction, &s0, &v), &s1);
                        assert_within(miss, 1e-8, &format!("{retraction:?} ({n}, {k})"));
                    }
                    Err(Error::OutsideRetractionDomain {
                        retraction: name,
                        value,
                        ..
                    }) => {
                        refused[i] += 1;
                        assert_eq!(name, retraction.name());
                        assert!(value.is_finite());
                    }
                    Err(other) => panic!("{retraction:?} ({n}, {k}): {other}"),
                }
            }
        }
    }
    // Both happen often, so that neither arm is idle.
    assert!(
        joined.iter().all(|c| *c > 20) && refused[..2].iter().all(|c| *c > 20),
        "{joined:?} {refused:?}"
    );
}

/// Rotation of the plane, with the identity in `m - 2` more dimensions.
fn rotation(angle: f64, m: usize) -> Mat<f64> {
    plane_rotations(&[angle], m)
}

#[test]
fn sums_reach_rotations_below_a_right_angle() {
    // Of M, a rotation of the plane: the eigenvalues have the real part cos, and the first pivot is cos; det M = 1.
    for (retraction, m) in [Retraction::Qr, Retraction::Polar]
        .into_iter()
        .flat_map(|r| [2, 3, 5].map(|m| (r, m)))
    {
        let s = identity(m);
        for angle in [0.1, 1.0, 1.5, 1.57, FRAC_PI_2 - 1e-6] {
            let v = inverse(retraction, &s, &rotation(angle, m));
            let bound = 1e-13 * angle.tan().powi(2);
            assert_within((v[(1, 0)] - angle.tan()).abs(), bound, "tan");
        }
        for angle in [FRAC_PI_2 + 1e-6, 1.58, 2.0, 3.0, 3.2] {
            match retraction.inverse_retract(s.as_ref(), rotation(angle, m).as_ref()) {
                Err(Error::OutsideRetractionDomain { value, .. }) => {
                    assert_within((value - angle.cos()).abs(), 1e-14, "the measured number");
                }
                other => panic!("{retraction:?}, angle {angle}: {other:?}"),
            }
        }
    }
}

#[test]
fn cayley_reaches_rotations_below_half_a_turn() {
    for m in [2, 3, 5] {
        let s = identity(m);
        for angle in [0.1, 1.0, 2.0, 3.0, 3.13, 3.2] {
            let v = inverse(Retraction::Cayley, &s, &rotation(angle, m));
            let exact = 2.0 * (0.5 * angle).tan();
            assert_within(
                (v[(1, 0)] - exact).abs(),
                1e-15 * exact.powi(2).max(1.0),
                "2 tan(angle / 2)",
            );
        }
        let half = Mat::from_fn(m, m, |i, j| match (i == j, i < 2) {
            (true, true) => -1.0,
            (true, false) => 1.0,
            _ => 0.0,
        });
        match Retraction::Cayley.inverse_retract(s.as_ref(), half.as_ref()) {
            Err(Error::OutsideRetractionDomain { value, .. }) => assert_eq!(value, 0.0),
            other => panic!("half a turn: {other:?}"),
        }
    }
}

#[test]
fn antipodal_points_and_other_components_are_refused() {
    for retraction in LINEAR {
        for (s0, s1) in [
            (identity(1), identity(1) * Scale(-1.0)),
            (
                identity(3).subcols(0, 1).to_owned(),
                identity(3).subcols(0, 1) * Scale(-1.0),
            ),
            (
                identity(4),
                Mat::from_fn(4, 4, |i, j| {
                    if i != j {
                        0.0
                    } else if i == 2 {
                        -1.0
                    } else {
                        1.0
                    }
                }),
            ),
        ] {
            let error = retraction.inverse_retract(s0.as_ref(), s1.as_ref());
            assert!(
                matches!(error, Err(Error::OutsideRetractionDomain { .. })),
                "{retraction:?} {:?}: {error:?}",
                s0.shape()
            );
        }
    }
}

#[test]
fn orthogonal_points_on_the_sphere_are_out_of_reach_of_the_sum() {
    // S + V never turns by a right angle; the Cayley transform does.
    let (s0, s1) = (
        identity(3).subcols(0, 1).to_owned(),
        identity(3).subcols(1, 1).to_owned(),
    );
    for retraction in [Retraction::Qr, Retraction::Polar] {
        let error = retraction.inverse_retract(s0.as_ref(), s1.as_ref());
        assert!(
            matches!(error, Err(Error::OutsideRetractionDomain { .. })),
            "{error:?}"
        );
    }
    let v = inverse(Retraction::Cayley, &s0, &s1);
    assert_close(&v, &(&s1 * Scale(2.0)), 1e-15, "2 tan(pi / 4)");
}

#[test]
fn points_at_the_tolerance_are_served() {
    let mut rng = Rng::new(77);
    for (n, k) in SIZES {
        let (s0, v) = {
            let s = random_point(n, k, &mut rng);
            let v = random_tangent(&s, 1.0, &mut rng);
            (s, v)
        };
        for retraction in LINEAR {
            // |S^T S - I| = 8e-10, on both ends.
            let stretch = Scale(1.0 + 4e-10 / (k as f64).sqrt());
            let s1 = apply(retraction, &s0, &v) * stretch;
            let back = inverse(retraction, &(&s0 * stretch), &s1);
            assert_close(&back, &v, 1e-8, &format!("{retraction:?} ({n}, {k})"));
        }
    }
}

// ------------------------------------------------------------------ bad input

#[test]
fn bad_arguments_are_typed_errors() {
    let mut rng = Rng::new(78);
    let s = random_point(4, 2, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let tall = Mat::zeros(5, 2);
    let nan = Mat::from_fn(4, 2, |i, j| if (i, j) == (1, 1) { f64::NAN } else { 0.0 });
    let off = &s * Scale(1.1);
    for retraction in Retraction::ALL {
        let map = |a: &Mat<f64>, b: &Mat<f64>| retraction.retract(a.as_ref(), b.as_ref());
        let back = |a: &Mat<f64>, b: &Mat<f64>| retraction.inverse_retract(a.as_ref(), b.as_ref());
        assert!(matches!(
            map(&s, &tall),
            Err(Error::Shape { name: "V", .. })
        ));
        assert!(matches!(
            map(&s, &nan),
            Err(Error::NonFinite { name: "V", .. })
        ));
        assert!(matches!(
            map(&nan, &v),
            Err(Error::NonFinite { name: "S", .. })
        ));
        assert!(matches!(
            map(&off, &v),
            Err(Error::NotOrthonormal { name: "S", .. })
        ));
        match map(&s, &(&v + &s * Scale(1e-3))) {
            Err(Error::NotTangent { defect, .. }) => {
                assert_within(
                    (defect - 1e-3 * 2.0_f64.sqrt()).abs(),
                    1e-14,
                    "measured defect",
                );
            }
            other => panic!("{other:?}"),
        }
        assert!(matches!(
            back(&s, &tall),
            Err(Error::Shape { name: "S1", .. })
        ));
        assert!(matches!(
            back(&nan, &s),
            Err(Error::NonFinite { name: "S0", .. })
        ));
        assert!(matches!(
            back(&s, &nan),
            Err(Error::NonFinite { name: "S1", .. })
        ));
        assert!(matches!(
            back(&off, &s),
            Err(Error::NotOrthonormal { name: "S0", .. })
        ));
        assert!(matches!(
            back(&s, &off),
            Err(Error::NotOrthonormal { name: "S1", .. })
        ));
    }
}

#[test]
fn extreme_lengths_give_a_point_or_a_typed_error() {
    let mut rng = Rng::new(79);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let unit = random_tangent(&s, 1.0, &mut rng);
        // One direction only: S + V loses the others.
        let column = Mat::from_fn(n, k, |i, j| if j == 0 { unit[(i, j)] } else { 0.0 });
        let thin = Stiefel::new(n, k)
            .unwrap()
            .project_tangent(s.as_ref(), column.as_ref())
            .unwrap();
        for v in [&unit, &thin] {
            for scale in [
                1e-320, 1e-160, 1e-20, 1e4, 1e8, 1e12, 1e16, 1e20, 1e155, 1e300, 1.7e308,
            ] {
                let v = v * Scale(scale);
                for retraction in Retraction::ALL {
                    match retraction.retract(s.as_ref(), v.as_ref()) {
                        Ok(y) => assert_within(
                            orthonormality(&y),
                            2e-14,
                            &format!("{retraction:?} ({n}, {k}) at {scale:e}"),
                        ),
                        Err(error) => assert!(
                            scale >= 1e8
                                && matches!(
                                    error,
                                    Error::RankDeficient { .. }
                                        | Error::InvalidArgument { .. }
                                        | Error::Overflow { .. }
                                        // The products of the check itself overflow.
                                        | Error::NotTangent { .. }
                                ),
                            "{retraction:?} ({n}, {k}) at {scale:e}: {error}"
                        ),
                    }
                }
            }
        }
    }
}

#[test]
fn long_vectors_on_the_sphere_are_still_right() {
    // V of length 1e12: a right angle but for 1e-12.
    let s = identity(3).subcols(0, 1).to_owned();
    let v = identity(3).subcols(1, 1) * Scale(1e12);
    for retraction in [Retraction::Qr, Retraction::Polar] {
        let y = apply(retraction, &s, &v);
        let exact = Mat::from_fn(3, 1, |i, _| [1e-12, 1.0, 0.0][i]);
        assert_close(&y, &exact, 1e-15, &format!("{retraction:?}"));
    }
    let error = Retraction::Cayley.retract(s.as_ref(), v.as_ref());
    assert!(
        matches!(error, Err(Error::InvalidArgument { found: 1e12, .. })),
        "{error:?}"
    );
    let v = identity(3).subcols(1, 1) * Scale(1e7);
    let y = apply(Retraction::Cayley, &s, &v);
    let angle = 2.0 * (5e6_f64).atan();
    let exact = Mat::from_fn(3, 1, |i, _| [angle.cos(), angle.sin(), 0.0][i]);
    assert_close(&y, &exact, 1e-15, "Cayley");
}

#[test]
fn cayley_is_orthonormal_up_to_its_limit() {
    let mut rng = Rng::new(80);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let unit = random_tangent(&s, 1.0, &mut rng);
        let unit = &unit * Scale(1.0 / frobenius(unit.as_ref()).max(1e-9));
        for length in [1e2, 1e4, 1e6, 9.9e7] {
            let y = apply(Retraction::Cayley, &s, &(&unit * Scale(length)));
            assert_within(
                orthonormality(&y),
                1e-14,
                &format!("({n}, {k}), {length:e}"),
            );
        }
    }
}

#[test]
fn names_go_both_ways() {
    for retraction in Retraction::ALL {
        assert_eq!(Retraction::from_name(retraction.name()), Some(retraction));
    }
    assert_eq!(Retraction::from_name("QR"), None);
    assert_eq!(Retraction::default(), Retraction::QuasiGeodesic);
}
