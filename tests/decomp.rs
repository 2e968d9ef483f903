//! The skew Schur form and the factorisations.

mod common;

use common::*;
use faer::{Mat, Scale, mat};
use stiefel_rs::Error;
use stiefel_rs::linalg::SkewSchur;
use stiefel_rs::linalg::decomp::{
    Svd, SymmetricEigen, polar_factor, singular_range, smallest_real_part, solve_lower,
    solve_matrix, solve_square, solve_upper, spectral_norm, thin_q, thin_qr,
};

// ------------------------------------------------------------- skew Schur form

fn check_schur(
    a: &Mat<f64>,
    place: &str,
    residual: &mut Worst,
    orthogonality: &mut Worst,
) -> Vec<f64> {
    let m = a.nrows();
    let mut schur = SkewSchur::new(m);
    schur.compute(a.as_ref()).unwrap();
    let (v, angles) = (schur.basis().to_owned(), schur.angles().to_vec());
    let size = frobenius(a.as_ref());
    let rebuilt = conjugated(&v, &plane_generators(&angles, m));
    if size > 0.0 {
        residual.see(distance(&rebuilt, a) / size / (m as f64 * EPS), || {
            place.to_owned()
        });
    } else {
        assert_eq!(&rebuilt, a, "{place}");
    }
    orthogonality.see(orthonormality(&v) / (m as f64 * EPS), || place.to_owned());
    assert!(
        angles.windows(2).all(|w| w[0] >= w[1]) && angles.iter().all(|x| *x >= 0.0),
        "{place}: {angles:?}"
    );
    angles
}

#[test]
fn skew_schur_rebuilds_the_matrix_from_orthogonal_planes() {
    let mut rng = Rng::new(21);
    let mut residual = Worst::new("|A - V T V^T| / (m eps |A|)");
    let mut orthogonality = Worst::new("|V^T V - I|_2 / (m eps)");
    for m in 1..=40 {
        let planes = m / 2;
        let kinds: [(&str, Vec<f64>); 6] = [
            ("zero", vec![0.0; planes]),
            ("equal", vec![0.7; planes]),
            (
                "clustered",
                (0..planes).map(|l| 1.0 + 1e-10 * l as f64).collect(),
            ),
            (
                "half at rest",
                (0..planes)
                    .map(|l| if l % 2 == 0 { 0.0 } else { 1.3 })
                    .collect(),
            ),
            (
                "graded",
                (0..planes).map(|l| 10.0_f64.powi(-(l as i32))).collect(),
            ),
            (
                "random",
                (0..planes).map(|_| rng.between(0.0, 5.0)).collect(),
            ),
        ];
        for (name, mut angles) in kinds {
            let a = conjugated(
                &random_orthogonal(m, &mut rng),
                &plane_generators(&angles, m),
            );
            let a = (&a - a.transpose()) * Scale(0.5);
            let found = check_schur(
                &a,
                &format!("m = {m}, {name}"),
                &mut residual,
                &mut orthogonality,
            );
            angles.sort_by(|x, y| y.total_cmp(x));
            for (x, y) in found.iter().zip(&angles) {
                let bound = 8.0 * m as f64 * EPS * angles[0];
                assert_within((x - y).abs(), bound, &format!("angle {y}, m = {m}, {name}"));
            }
        }
        let a = random_skew(m, 1.0, &mut rng);
        check_schur(
            &a,
            &format!("m = {m}, dense"),
            &mut residual,
            &mut orthogonality,
        );
    }
    residual.assert_at_most(4.0);
    orthogonality.assert_at_most(4.0);
}

#[test]
fn skew_schur_does_not_depend_on_the_scale() {
    let mut rng = Rng::new(22);
    let mut residual = Worst::new("scaled |A - V T V^T| / (m eps |A|)");
    let mut orthogonality = Worst::new("scaled |V^T V - I|_2 / (m eps)");
    for m in [2, 3, 4, 5, 8, 13] {
        for norm in [1e-300, 1e-200, 1e200, 1e300] {
            let a = random_skew(m, norm, &mut rng);
            check_schur(
                &a,
                &format!("m = {m}, norm = {norm:e}"),
                &mut residual,
                &mut orthogonality,
            );
        }
    }
    residual.assert_at_most(4.0);
    orthogonality.assert_at_most(4.0);
}

#[test]
fn skew_schur_of_sparse_matrices() {
    let mut residual = Worst::new("sparse |A - V T V^T| / (m eps |A|)");
    let mut orthogonality = Worst::new("sparse |V^T V - I|_2 / (m eps)");
    for m in 2..=12 {
        for i in 1..m {
            let mut a = Mat::zeros(m, m);
            a[(i, 0)] = -2.0;
            a[(0, i)] = 2.0;
            let angles = check_schur(
                &a,
                &format!("m = {m}, entry {i}"),
                &mut residual,
                &mut orthogonality,
            );
            assert_eq!(angles[0], 2.0, "m = {m}, entry {i}");
        }
        let anti = Mat::from_fn(m, m, |i, j| {
            if i + j + 1 == m {
                (i as f64 - j as f64).signum() * f64::from(u8::from(i != j))
            } else {
                0.0
            }
        });
        check_schur(
            &anti,
            &format!("m = {m}, antidiagonal"),
            &mut residual,
            &mut orthogonality,
        );
    }
    residual.assert_at_most(4.0);
    orthogonality.assert_at_most(4.0);
}

// --------------------------------------------------------------- factorisations

const SHAPES: [(usize, usize); 8] = [
    (1, 1),
    (3, 1),
    (2, 2),
    (5, 3),
    (6, 6),
    (3, 5),
    (20, 4),
    (40, 40),
];

#[test]
fn svd_rebuilds_the_matrix() {
    let mut rng = Rng::new(31);
    for (n, k) in SHAPES {
        let a = gaussian(n, k, &mut rng);
        let mut svd = Svd::new(n, k);
        svd.compute(a.as_ref()).unwrap();
        let rank = n.min(k);
        let s = Mat::from_fn(rank, k, |i, j| if i == j { svd.s(i) } else { 0.0 });
        let bound = 8.0 * (n + k) as f64 * EPS * frobenius(a.as_ref());
        assert_close(
            &(svd.u() * s * svd.v().transpose()),
            &a,
            bound,
            &format!("U S V^T, ({n}, {k})"),
        );
        let bound = 8.0 * (n + k) as f64 * EPS;
        assert_within(
            orthonormality(&svd.u().to_owned()),
            bound,
            &format!("U, ({n}, {k})"),
        );
        assert_within(
            orthonormality(&svd.v().to_owned()),
            bound,
            &format!("V, ({n}, {k})"),
        );
        assert!(
            (1..rank).all(|i| svd.s(i - 1) >= svd.s(i)) && svd.s(rank - 1) >= 0.0,
            "order, ({n}, {k})"
        );
    }
}

/// Regression: faer leaves a part of V unset for wide matrices, so that used buffers gave a wrong basis.
#[test]
fn svd_does_not_depend_on_what_its_buffers_held() {
    let mut rng = Rng::new(36);
    for (n, k) in SHAPES {
        let mut used = Svd::new(n + 1, k + 1);
        used.compute(gaussian(n + 1, k + 1, &mut rng).as_ref())
            .unwrap();
        let a = gaussian(n, k, &mut rng);
        let mut fresh = Svd::new(n, k);
        fresh.compute(a.as_ref()).unwrap();
        used.compute(a.as_ref()).unwrap();
        assert_eq!(used.u().to_owned(), fresh.u().to_owned(), "U, ({n}, {k})");
        assert_eq!(used.v().to_owned(), fresh.v().to_owned(), "V, ({n}, {k})");
        assert!(
            (0..n.min(k)).all(|i| used.s(i) == fresh.s(i)),
            "s, ({n}, {k})"
        );
    }
}

#[test]
fn svd_of_extreme_scales() {
    let mut rng = Rng::new(37);
    for (n, k) in SHAPES {
        for scale in [1e-307, 1e-200, 1e200, 1e306] {
            let a = gaussian(n, k, &mut rng);
            let (mut plain, mut extreme) = (Svd::new(n, k), Svd::new(n, k));
            plain.compute(a.as_ref()).unwrap();
            extreme.compute((&a * Scale(scale)).as_ref()).unwrap();
            for i in 0..n.min(k) {
                let bound = 16.0 * (n + k) as f64 * EPS * plain.s(0);
                let error = (extreme.s(i) / scale - plain.s(i)).abs();
                assert_within(error, bound, &format!("s_{i}, ({n}, {k}), scale {scale:e}"));
            }
        }
    }
}

#[test]
fn symmetric_eigen_rebuilds_the_matrix() {
    let mut rng = Rng::new(32);
    for m in [1, 2, 3, 5, 12, 40] {
        let g = gaussian(m, m, &mut rng);
        let a = &g + g.transpose();
        let mut eigen = SymmetricEigen::new(m);
        eigen.compute(a.as_ref()).unwrap();
        let w = eigen.vectors().to_owned();
        let lambda = Mat::from_fn(m, m, |i, j| if i == j { eigen.value(i) } else { 0.0 });
        let bound = 8.0 * m as f64 * EPS * frobenius(a.as_ref());
        assert_close(
            &conjugated(&w, &lambda),
            &a,
            bound,
            &format!("W L W^T, m = {m}"),
        );
        assert_within(
            orthonormality(&w),
            8.0 * m as f64 * EPS,
            &format!("W, m = {m}"),
        );
        assert!(
            (1..m).all(|i| eigen.value(i - 1) <= eigen.value(i)),
            "order, m = {m}"
        );
    }
}

#[test]
fn polar_factor_is_the_nearest_orthonormal_matrix() {
    let mut rng = Rng::new(33);
    for (n, k) in SHAPES.into_iter().filter(|(n, k)| n >= k) {
        let far = gaussian(n, k, &mut rng);
        // Both sides of the distance from which on it comes from a singular value decomposition.
        let near = |size: f64| {
            let noise = &far * Scale(size / frobenius(far.as_ref()));
            random_point(n, k, &mut Rng::new(35)) + noise
        };
        for a in [
            near(1e-9),
            near(0.2),
            near(0.3),
            near(0.8) * Scale(1e6),
            far.clone(),
        ] {
            check_polar_factor(&a, n, k);
        }
    }
}

fn check_polar_factor(a: &Mat<f64>, n: usize, k: usize) {
    let q = polar_factor("A", a.as_ref()).unwrap();
    assert_within(
        orthonormality(&q),
        8.0 * n as f64 * EPS,
        &format!("orthonormal, ({n}, {k})"),
    );
    // A = Q H with H = Q^T A symmetric and positive definite, which makes Q the nearest point.
    let h = q.transpose() * a;
    let bound = 8.0 * n as f64 * EPS * frobenius(a.as_ref());
    assert_close(
        &h,
        &h.transpose().to_owned(),
        bound,
        &format!("H symmetric, ({n}, {k})"),
    );
    assert_close(&(&q * &h), a, bound, &format!("Q H = A, ({n}, {k})"));
    let smallest = h.self_adjoint_eigenvalues(faer::Side::Lower).unwrap()[0];
    assert!(smallest > 0.0, "H positive, ({n}, {k}): {smallest:e}");
}

#[test]
fn polar_factor_refuses_a_rank_deficient_matrix() {
    let a = mat![[1.0, 2.0], [2.0, 4.0], [3.0, 6.0]];
    match polar_factor("A", a.as_ref()) {
        Err(Error::RankDeficient {
            name: "A",
            smallest,
            largest,
        }) => {
            assert_within(smallest, 4.0 * EPS * largest, "smallest singular value");
            assert_within(
                (largest - 70.0_f64.sqrt()).abs(),
                1e-14,
                "largest singular value",
            );
        }
        other => panic!("expected RankDeficient, found {other:?}"),
    }
    let zero = polar_factor("A", Mat::zeros(4, 2).as_ref());
    assert!(matches!(zero, Err(Error::RankDeficient { .. })), "{zero:?}");
}

#[test]
fn thin_q_factors_with_a_nonnegative_diagonal() {
    let mut rng = Rng::new(34);
    for (n, k) in SHAPES {
        let a = gaussian(n, k, &mut rng);
        let q = thin_q(a.as_ref());
        assert_eq!(q.shape(), (n, n.min(k)));
        let r = q.transpose() * &a;
        let bound = 8.0 * n as f64 * EPS * frobenius(a.as_ref());
        assert_close(&(&q * &r), &a, bound, &format!("Q R = A, ({n}, {k})"));
        assert_within(
            orthonormality(&q),
            8.0 * n as f64 * EPS,
            &format!("Q, ({n}, {k})"),
        );
        for j in 0..q.ncols() {
            assert!(r[(j, j)] >= 0.0, "R_{j}{j} = {:e}, ({n}, {k})", r[(j, j)]);
            for i in j + 1..q.ncols() {
                assert_within(
                    r[(i, j)].abs(),
                    bound,
                    &format!("R upper triangular, ({n}, {k})"),
                );
            }
        }
    }
}

#[test]
fn thin_q_is_orthonormal_for_every_rank() {
    let mut rng = Rng::new(35);
    for rank in 0..=4 {
        let a = gaussian(12, rank, &mut rng) * gaussian(rank, 5, &mut rng);
        assert_within(
            orthonormality(&thin_q(a.as_ref())),
            12.0 * 8.0 * EPS,
            &format!("rank {rank}"),
        );
    }
}

#[test]
fn thin_qr_multiplies_back() {
    let mut rng = Rng::new(36);
    for (n, k) in SHAPES {
        if n < k {
            continue;
        }
        let a = gaussian(n, k, &mut rng);
        let (q, r) = thin_qr(a.as_ref());
        let bound = 8.0 * n as f64 * EPS * frobenius(a.as_ref());
        assert_close(&(&q * &r), &a, bound, &format!("Q R = A, ({n}, {k})"));
        assert_close(&q, &thin_q(a.as_ref()), 0.0, "the same Q");
        for j in 0..k {
            assert!(r[(j, j)] >= 0.0, "R_{j}{j} = {:e}", r[(j, j)]);
            for i in j + 1..k {
                assert_eq!(r[(i, j)], 0.0, "below the diagonal");
            }
        }
    }
}

#[test]
fn spectral_norm_is_the_largest_singular_value() {
    let mut rng = Rng::new(37);
    for (n, k) in SHAPES {
        let a = gaussian(n, k, &mut rng);
        for scale in [1e-300, 1.0, 1e300] {
            let measured = spectral_norm((&a * Scale(scale)).as_ref()).unwrap();
            let exact = spectral(a.as_ref()) * scale;
            assert_within(
                (measured - exact).abs(),
                1e-14 * exact,
                &format!("({n}, {k}), {scale:e}"),
            );
        }
    }
    for (n, k) in [(0, 0), (0, 3), (4, 0), (3, 2)] {
        assert_eq!(spectral_norm(Mat::zeros(n, k).as_ref()).unwrap(), 0.0);
    }
    let infinite = mat![[f64::INFINITY]];
    let error = spectral_norm(infinite.as_ref());
    assert!(matches!(error, Err(Error::Overflow { .. })), "{error:?}");
}

#[test]
fn smallest_real_part_of_a_spectrum() {
    let mut rng = Rng::new(38);
    for m in [1, 2, 3, 7] {
        // A shifted rotation, with eigenvalues 2 + e^{i theta}, and 3.
        let angles = spread_angles(m, &mut rng);
        let angles = scaled(&angles, 2.5);
        let a = rotation_with_angles(&angles, m, &mut rng) + identity(m) * Scale(2.0);
        let exact = angles.iter().fold(3.0_f64, |x, t| x.min(2.0 + t.cos()));
        let measured = smallest_real_part(a.as_ref()).unwrap();
        assert_within((measured - exact).abs(), 1e-14, &format!("m = {m}"));
    }
    let nan = mat![[f64::NAN]];
    let error = smallest_real_part(nan.as_ref());
    assert!(matches!(error, Err(Error::Overflow { .. })), "{error:?}");
}

#[test]
fn solves_with_square_and_triangular_matrices() {
    let mut rng = Rng::new(39);
    for m in [1, 2, 5, 20] {
        let a = gaussian(m, m, &mut rng) + identity(m) * Scale(2.0 * m as f64);
        let b = gaussian(m, 3, &mut rng);
        let x = solve_matrix(a.as_ref(), b.as_ref()).unwrap();
        assert_close(&(&a * &x), &b, 1e-14 * m as f64, "A X = B");
        let mut x = b.clone();
        solve_lower(a.as_ref(), x.as_mut());
        let lower = Mat::from_fn(m, m, |i, j| if i >= j { a[(i, j)] } else { 0.0 });
        assert_close(&(&lower * &x), &b, 1e-14 * m as f64, "L X = B");
        let mut x = b.clone();
        solve_upper(a.as_ref(), x.as_mut());
        let upper = Mat::from_fn(m, m, |i, j| if i <= j { a[(i, j)] } else { 0.0 });
        assert_close(&(&upper * &x), &b, 1e-14 * m as f64, "U X = B");
    }
    assert!(solve_matrix(Mat::zeros(3, 3).as_ref(), identity(3).as_ref()).is_none());
    assert!(solve_square(Mat::zeros(3, 3).as_ref(), &[1.0; 3]).is_none());
    let a = mat![[2.0, 1.0], [0.0, 4.0]];
    assert_eq!(solve_square(a.as_ref(), &[4.0, 8.0]), Some(vec![1.0, 2.0]));
}

#[test]
fn singular_range_is_that_of_the_factors() {
    let mut rng = Rng::new(40);
    for (m, scale) in [(1, 1.0), (3, 1e-200), (7, 1.0), (12, 1e200)] {
        let (u, v) = (
            random_orthogonal(m, &mut rng),
            random_orthogonal(m, &mut rng),
        );
        let values = Mat::from_fn(m, m, |i, j| {
            if i == j {
                scale * 0.5_f64.powi(i as i32)
            } else {
                0.0
            }
        });
        let found = singular_range((u * values * v).as_ref()).unwrap();
        let expected = [0.5_f64.powi(m as i32 - 1), 1.0];
        for (found, expected) in found.into_iter().zip(expected) {
            let defect = (found / scale - expected).abs();
            assert_within(defect, 10.0 * m as f64 * f64::EPSILON, "singular value");
        }
    }
    assert_eq!(singular_range(Mat::zeros(2, 2).as_ref()), Ok([0.0; 2]));
    let nan = mat![[f64::NAN]];
    assert!(matches!(
        singular_range(nan.as_ref()),
        Err(Error::Overflow { .. })
    ));
}
