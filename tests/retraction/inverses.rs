//! Inverses of the retractions, and their domains.

use std::f64::consts::FRAC_PI_2;

use faer::{Mat, Scale};
use stiefel_rs::{Error, Retraction, Stiefel};

use crate::common::{
    Rng, SIZES, Worst, assert_close, assert_within, distance, identity, plane_rotations,
    random_point, random_tangent, retract,
};
use crate::vectors::{LINEAR, apply, each_shape, inverse};

#[test]
fn inverse_brings_the_vector_back() {
    let mut worst = Worst::new("|inverse(retract(V)) - V|");
    each_shape(&[0.0, 1e-300, 1e-9, 1e-3, 0.5, 1.0, 3.0], |s, v, place| {
        for retraction in LINEAR {
            let back = inverse(retraction, s, &apply(retraction, s, v));
            worst.see(distance(&back, v), || format!("{retraction:?} {place}"));
        }
    });
    // At most 0.75 n k eps |V|^2.
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
                let found = retraction.inverse_retract(s0.as_ref(), s1.as_ref());
                match found.as_ref().map_err(Error::cause) {
                    Ok(v) => {
                        joined[i] += 1;
                        let miss = distance(&apply(retraction, &s0, v), &s1);
                        assert_within(miss, 1e-8, &format!("{retraction:?} ({n}, {k})"));
                    }
                    Err(Error::OutsideRetractionDomain {
                        retraction: name,
                        value,
                        ..
                    }) => {
                        refused[i] += 1;
                        assert_eq!(*name, retraction.name());
                        assert!(value.is_finite());
                    }
                    Err(other) => panic!("{retraction:?} ({n}, {k}): {other}"),
                }
            }
        }
    }
    // Both cases occur often, so that both branches are tested.
    assert!(
        joined.iter().all(|c| *c > 20) && refused[..2].iter().all(|c| *c > 20),
        "{joined:?} {refused:?}"
    );
}

/// A rotation of the plane, and the identity in `m - 2` more dimensions.
fn rotation(angle: f64, m: usize) -> Mat<f64> {
    plane_rotations(&[angle], m)
}

#[test]
fn sums_reach_rotations_below_a_right_angle() {
    // M is a rotation of the plane: its eigenvalues have the real part cos, its first pivot is cos, and det M = 1.
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
    // S + V never reaches a rotation by a right angle; the Cayley transform does.
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
