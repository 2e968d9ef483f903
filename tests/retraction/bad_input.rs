//! Bad arguments, extreme lengths, and names.

use faer::{Mat, Scale};
use stiefel_rs::{Error, Retraction, Stiefel};

use crate::common::{
    Rng, SIZES, assert_close, assert_within, frobenius, identity, orthonormality, random_point,
    random_tangent,
};
use crate::vectors::apply;

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
        // A single direction: S + V numerically loses the others.
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
    // V of length 1e12: a right angle up to 1e-12.
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
