//! Jets in several variables: identities whose derivatives of all orders are known.

use stiefel_rs::chart::jet::{Analytic, Jet, atan2, cos_sinc, sin_cos, sqrt};
use stiefel_rs::chart::rotation::{angles, from_angles, product};
use stiefel_rs::chart::series::Series;

/// The largest difference of values and of derivatives up to the third.
fn distance<const N: usize>(f: &Jet<N>, g: &Jet<N>) -> f64 {
    let mut worst = (f.value() - g.value()).abs();
    for a in 0..N {
        worst = worst.max((f.first(a) - g.first(a)).abs());
        for b in 0..N {
            worst = worst.max((f.second(a, b) - g.second(a, b)).abs());
            for c in 0..N {
                worst = worst.max((f.third(a, b, c) - g.third(a, b, c)).abs());
            }
        }
    }
    worst
}

fn variables() -> [Jet<3>; 3] {
    [0.7, -0.4, 1.3].map({
        let mut index = 0;
        move |value| {
            index += 1;
            Jet::variable(value, index - 1, 1.0)
        }
    })
}

#[test]
fn a_polynomial_has_its_derivatives() {
    let [x, y, z] = variables();
    let f = x * x * y + y * z * z - z;
    let (x, y, z) = (0.7_f64, -0.4, 1.3);
    assert!((f.value() - (x * x * y + y * z * z - z)).abs() < 1e-15);
    let first = [2.0 * x * y, x * x + z * z, 2.0 * y * z - 1.0];
    for a in 0..3 {
        assert!((f.first(a) - first[a]).abs() < 1e-15);
    }
    assert_eq!(f.third(0, 0, 1), 2.0);
    assert_eq!(f.third(1, 0, 0), 2.0);
    assert_eq!(f.third(2, 1, 2), 2.0);
    assert_eq!(f.third(0, 1, 2), 0.0);
    assert_eq!(f.second(2, 1), 2.0 * z);
}

#[test]
fn functions_satisfy_their_identities_with_all_derivatives() {
    let [x, y, z] = variables();
    let one = Jet::from(1.0);
    let angle = x * y + z;
    let (s, c) = sin_cos(angle);
    // A few operations on derivatives of size up to 10.
    let bound = 1e-13;
    assert!(distance(&(s * s + c * c), &one) < bound);
    let positive = x * x + z * z * z + one;
    let root = sqrt(positive);
    assert!(distance(&(root * root), &positive) < bound);
    assert!(distance(&(positive / root), &root) < bound);
    assert!(distance(&atan2(positive * s, positive * c), &angle) < bound);
    let turned = x - z - one;
    let (s, c) = sin_cos(turned);
    assert!(distance(&atan2(root * s, root * c), &turned) < bound);
}

#[test]
fn cosine_and_sinc_of_a_root_join_and_are_smooth_at_zero() {
    // Near 0, within the series, on both sides of the switch to the recursion, and far beyond.
    for s0 in [0.0, 1e-9, 0.3, 1.999_999, 2.000_001, 7.0, 60.0] {
        let s = Jet::<1>::variable(s0, 0, 1.0);
        let (cos, sinc) = cos_sinc(s);
        let defect = distance(&(cos * cos + s * sinc * sinc), &Jet::from(1.0));
        assert!(defect < 1e-14 * (1.0 + s0), "{s0}: {defect:e}");
        // 2 s sinc' = cos - sinc, to the second derivative.
        let slope = |f: &Jet<1>| [f.first(0), f.second(0, 0), f.third(0, 0, 0)];
        let (f, g) = (slope(&sinc), slope(&cos));
        assert!((2.0 * s0 * f[0] - (cos.value() - sinc.value())).abs() < 1e-15);
        assert!((2.0 * s0 * f[1] + 3.0 * f[0] - g[0]).abs() < 1e-15);
        assert!((2.0 * s0 * f[2] + 5.0 * f[1] - g[1]).abs() < 1e-15);
        assert!((g[0] + 0.5 * sinc.value()).abs() < 1e-15);
    }
    let (_, sinc) = cos_sinc(Jet::<1>::variable(0.0, 0, 1.0));
    let taylor = [1.0, -1.0 / 6.0, 2.0 / 120.0, -6.0 / 5040.0];
    let found = [
        sinc.value(),
        sinc.first(0),
        sinc.second(0, 0),
        sinc.third(0, 0, 0),
    ];
    for (f, t) in found.iter().zip(taylor) {
        assert!((f - t).abs() < 1e-17, "{f} against {t}");
    }
}

#[test]
fn numbers_and_pairs_agree_with_jets() {
    let x = Jet::<1>::variable(0.8, 0, 1.5);
    let pair = Series::<2>::new([0.8, 1.5]);
    let of = |f: Jet<1>, g: Series<2>, value: f64| {
        assert!((f.value() - value).abs() < 1e-15 && (g.number() - value).abs() < 1e-15);
        assert!((f.first(0) - g.coefficients()[1]).abs() < 1e-15);
    };
    of(sqrt(x), sqrt(pair), 0.8_f64.sqrt());
    of(sin_cos(x).0, sin_cos(pair).0, 0.8_f64.sin());
    of(cos_sinc(x).1, cos_sinc(pair).1, cos_sinc(0.8).1);
    of(
        atan2(x, x * x),
        atan2(pair, pair * pair),
        0.8_f64.atan2(0.64),
    );
}

#[test]
fn angles_undo_quaternions_with_all_derivatives() {
    let [theta, phi, psi] = variables();
    let back = angles(from_angles([theta, phi, psi]));
    for (found, expected) in back.iter().zip([theta, phi, psi]) {
        assert!(distance(found, &expected) < 1e-13);
    }
    // A rotation about the third axis adds to phi from the left and to psi from the right.
    let turn = from_angles([Jet::from(0.0), Jet::from(0.3), Jet::from(0.0)]);
    let left = angles(product(turn, from_angles([theta, phi, psi])));
    let right = angles(product(from_angles([theta, phi, psi]), turn));
    assert!(distance(&left[1], &(phi + Jet::from(0.3))) < 1e-13);
    assert!(distance(&right[2], &(psi + Jet::from(0.3))) < 1e-13);
    assert!(distance(&left[0], &theta) < 1e-13 && distance(&right[1], &phi) < 1e-13);
}
