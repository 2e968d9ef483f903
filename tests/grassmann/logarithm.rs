//! Logarithm, distance, principal angles and aligned bases, for all angles and bases.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

use faer::Mat;
use stiefel_rs::Error;

use crate::common::{
    EPS, Rng, assert_close, assert_within, cyclic_permutation, frobenius, identity,
    random_orthogonal,
};
use crate::{SIZES, angles, exp, log, manifold};

/// Two points at the given angles, the velocity between them, and all angles in decreasing order.
struct Pair {
    y0: Mat<f64>,
    y1: Mat<f64>,
    v: Mat<f64>,
    angles: Vec<f64>,
}

/// In dense bases; angles are repeated to fill all directions.
fn pair((n, k): (usize, usize), given: &[f64], rng: &mut Rng) -> Pair {
    let basis = random_orthogonal(n, rng);
    let (w, z) = (random_orthogonal(k, rng), random_orthogonal(k, rng));
    let angle = |j: usize| {
        if j < k.min(n - k) {
            given[j % given.len()]
        } else {
            0.0
        }
    };
    let part = |f: &dyn Fn(f64) -> f64, first: usize| {
        Mat::from_fn(n, k, |i, j| {
            let column = first + j;
            if column < n {
                basis[(i, column)] * f(angle(j))
            } else {
                0.0
            }
        })
    };
    let y0 = part(&|_| 1.0, 0) * &w;
    let y1 = (part(&f64::cos, 0) + part(&f64::sin, k)) * &z;
    let v = part(&|x| x, k) * &w;
    let mut angles: Vec<f64> = (0..k).map(angle).collect();
    angles.sort_by(|a, b| b.total_cmp(a));
    Pair { y0, y1, v, angles }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |s: f64, x| s.hypot(*x))
}

/// Includes both sides of a cosine of `sqrt(0.1)` and of a sine of 1/2, where the method changes.
const GIVEN: [&[f64]; 13] = [
    &[0.0],
    &[0.4],
    &[1.0, 1.0, 0.2],
    &[1e-8],
    &[1e-12, 0.7],
    &[1.3, 1e-5, 0.0],
    &[1.5],
    &[0.785, 0.785_000_001],
    &[1.57, 0.1],
    &[1.249_045],
    &[1.249_046, 1e-3],
    &[FRAC_PI_6 - 1e-6],
    &[FRAC_PI_6 + 1e-6],
];

#[test]
fn given_angles_come_back() {
    let mut rng = Rng::new(77);
    for (shape, given) in SIZES.iter().flat_map(|s| GIVEN.map(|g| (*s, g))) {
        let Pair {
            y0,
            y1,
            v,
            angles: exact,
        } = pair(shape, given, &mut rng);
        let what = format!("{shape:?}, {given:?}");
        let size = 1e-15 * 8.0 * shape.0 as f64;
        // With several angles near pi/2, principal vectors are accurate to eps / cos.
        let loss = 1.0 / exact[0].cos();
        assert_close(&log(&y0, &y1), &v, size * loss, &what);
        for (found, exact) in angles(&y0, &y1).iter().zip(&exact) {
            assert_within((found - exact).abs(), size, &what);
        }
        let m = manifold(&y0);
        let dist = m.dist(y0.as_ref(), y1.as_ref()).unwrap();
        assert_within((dist - norm(&exact)).abs(), size, &what);
        let aligned = m.align(y0.as_ref(), y1.as_ref()).unwrap();
        assert_close(&exp(&y0, &log(&y0, &y1)), &aligned, size * loss, &what);
        let product = y0.transpose() * &aligned;
        assert_close(&product, &product.transpose().to_owned(), size, &what);
    }
}

#[test]
fn logarithms_do_not_depend_on_the_bases() {
    let mut rng = Rng::new(78);
    for (shape, given) in SIZES.iter().flat_map(|s| GIVEN.map(|g| (*s, g))) {
        let Pair { y0, y1, .. } = pair(shape, given, &mut rng);
        let [q0, q1] = [(); 2].map(|()| random_orthogonal(shape.1, &mut rng));
        let turned = log(&(&y0 * &q0), &(&y1 * &q1));
        assert_close(
            &turned,
            &(log(&y0, &y1) * &q0),
            1e-12,
            &format!("{shape:?}, {given:?}"),
        );
    }
}

#[test]
fn tiny_angles_are_relative() {
    for angle in [1e-300_f64, 1e-160, 1e-20, 1e-8, 1e-3] {
        for (n, k) in [(4, 2), (10, 5), (3, 2), (8, 1)] {
            let y0 = Mat::from_fn(n, k, |i, j| f64::from(u8::from(i == j)));
            let outside = k.min(n - k);
            let mut y1 = y0.clone();
            for j in 0..outside {
                (y1[(j, j)], y1[(k + j, j)]) = (angle.cos(), angle.sin());
            }
            // Bases that differ by a permutation have the same entries.
            let y1 = y1 * cyclic_permutation(k);
            let what = format!("{angle:e}, ({n}, {k})");
            let v = log(&y0, &y1);
            for j in 0..outside {
                assert_within((v[(k + j, j)] / angle - 1.0).abs(), 4.0 * EPS, &what);
            }
            let exact = angle * (outside as f64).sqrt();
            let dist = manifold(&y0).dist(y0.as_ref(), y1.as_ref()).unwrap();
            assert_within((dist / exact - 1.0).abs(), 4.0 * EPS, &what);
            for (j, found) in angles(&y0, &y1).iter().enumerate() {
                let exact = if j < outside { angle } else { 0.0 };
                assert_within((found - exact).abs(), 4.0 * EPS * angle, &what);
            }
        }
    }
}

#[test]
fn angles_of_all_sizes_keep_their_digits() {
    let mut exact = [FRAC_PI_2 - 1e-8, 1.0, 1e-8, 1e-160, 1e-300];
    for _ in 0..exact.len() {
        exact.rotate_left(1);
        let y0 = Mat::from_fn(10, 5, |i, j| f64::from(u8::from(i == j)));
        let y1 = Mat::from_fn(10, 5, |i, j| match i {
            _ if i == j => exact[j].cos(),
            _ if i == j + 5 => exact[j].sin(),
            _ => 0.0,
        });
        let mut sorted = exact;
        sorted.sort_by(|a, b| b.total_cmp(a));
        for (found, exact) in angles(&y0, &y1).iter().zip(sorted) {
            assert_within(
                (found / exact - 1.0).abs(),
                4.0 * EPS,
                &format!("{exact:e}"),
            );
        }
        let v = log(&y0, &y1);
        for j in 0..5 {
            assert_within(
                (v[(j + 5, j)] / exact[j] - 1.0).abs(),
                4.0 * EPS,
                "column of the logarithm",
            );
        }
    }
}

#[test]
fn a_right_angle_is_outside_of_the_domain() {
    let mut rng = Rng::new(79);
    for shape in SIZES.into_iter().filter(|(n, k)| n > k) {
        for given in [&[FRAC_PI_2][..], &[FRAC_PI_2, 0.3]] {
            let Pair {
                y0,
                y1,
                angles: exact,
                ..
            } = pair(shape, given, &mut rng);
            let m = manifold(&y0);
            for result in [
                m.log(y0.as_ref(), y1.as_ref()),
                m.align(y0.as_ref(), y1.as_ref()),
            ] {
                let error = result.unwrap_err();
                assert!(matches!(error, Error::RightAngle { .. }), "{error}");
                assert_within((error.angle().unwrap() - FRAC_PI_2).abs(), 1e-14, "angle");
            }
            let dist = m.dist(y0.as_ref(), y1.as_ref()).unwrap();
            assert_within(
                (dist - norm(&exact)).abs(),
                1e-14 * shape.0 as f64,
                "distance",
            );
        }
    }
}

#[test]
fn all_of_space_is_one_point() {
    let mut rng = Rng::new(80);
    for n in [1, 2, 3, 7] {
        let [y0, y1] = [(); 2].map(|()| random_orthogonal(n, &mut rng));
        assert_eq!(log(&y0, &y1), Mat::<f64>::zeros(n, n));
        assert_eq!(angles(&y0, &y1), vec![0.0; n]);
        assert_eq!(manifold(&y0).dist(y0.as_ref(), y1.as_ref()), Ok(0.0));
    }
}

#[test]
fn equal_subspaces_are_round_off_apart() {
    let mut rng = Rng::new(81);
    for (n, k) in SIZES {
        let basis = random_orthogonal(n, &mut rng);
        let y = basis.subcols(0, k).to_owned();
        let other = &y * random_orthogonal(k, &mut rng);
        let v = log(&y, &other);
        assert_within(
            frobenius(v.as_ref()),
            4.0 * EPS * (n * k) as f64,
            "logarithm",
        );
        let along = y.transpose() * &v;
        assert_within(
            frobenius(along.as_ref()),
            EPS * EPS * (n * k) as f64 * 8.0,
            "horizontal all the same",
        );
        let same = manifold(&y).align(y.as_ref(), other.as_ref()).unwrap();
        assert_close(&same, &y, 4.0 * EPS * (n * k) as f64, "aligned");
        assert_close(&(basis.transpose() * &basis), &identity(n), 1e-13, "basis");
    }
}

#[test]
fn bases_to_nine_digits_are_projected_off_twice() {
    let mut rng = Rng::new(82);
    for (n, k) in [(8, 1), (9, 3), (12, 5), (30, 12)] {
        for angle in [0.1, 0.5, 0.6, 1.2, 1.4] {
            let Pair { y0, y1, .. } = pair((n, k), &[angle, 0.5 * angle], &mut rng);
            // Not orthonormal, by up to 4e-10.
            let stretch = Mat::from_fn(k, k, |i, j| {
                f64::from(u8::from(i == j)) + 1e-10 * (1.0 + (3 * i + j) as f64).sin() / k as f64
            });
            let y0 = y0 * stretch;
            let v = log(&y0, &y1);
            // A single projection leaves 1e-10.
            let along = y0.transpose() * &v;
            assert_within(
                frobenius(along.as_ref()),
                EPS * (n * k) as f64,
                &format!("({n}, {k}), {angle}"),
            );
        }
    }
}
