//! The Stiefel manifold: membership, projections, metric, and the paper's parametrisation.

mod common;

use common::*;
use faer::{Mat, MatRef, Scale};
use stiefel_rs::manifold::covariant::{acceleration, christoffel};
use stiefel_rs::{Curve, Error, QuasiGeodesic, Stiefel};

fn manifold(s: &Mat<f64>) -> Stiefel {
    Stiefel::of("S", s.as_ref()).unwrap()
}

/// A point and two tangent vectors of norms 2 and 1 in each shape.
fn each_shape(seed: u64, mut check: impl FnMut(Stiefel, &Mat<f64>, &Mat<f64>, &Mat<f64>, &str)) {
    let mut rng = Rng::new(seed);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let (v, w) = (
            random_tangent(&s, 2.0, &mut rng),
            random_tangent(&s, 1.0, &mut rng),
        );
        check(manifold(&s), &s, &v, &w, &format!("({n}, {k})"));
    }
}

// ------------------------------------------------------------------ membership

#[test]
fn sizes_outside_of_one_to_n_are_refused() {
    for (n, k) in [(3, 0), (0, 0), (2, 3)] {
        let error = Stiefel::new(n, k);
        assert!(
            matches!(error, Err(Error::Shape { .. })),
            "St({n}, {k}): {error:?}"
        );
        let error = Stiefel::of("S", Mat::zeros(n, k).as_ref());
        assert!(
            matches!(error, Err(Error::Shape { name: "S", .. })),
            "({n}, {k}): {error:?}"
        );
    }
}

/// Products of both signs overflow to infinities that have no sum: the defect is infinite, and not NaN.
#[test]
fn defects_of_huge_matrices_are_infinite() {
    let signs = [[1.0, 1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]];
    for scale in [1e160, 1e200, 1e308] {
        let y = Mat::from_fn(4, 2, |i, j| scale * signs[i][j]);
        match Stiefel::new(4, 2)
            .unwrap()
            .check_point("y", y.as_ref(), 1e-9)
        {
            Err(Error::NotOrthonormal { defect, .. }) => assert_eq!(defect, f64::INFINITY),
            other => panic!("{scale:e}: {other:?}"),
        }
    }
}

#[test]
fn dimension_counts_a_basis_of_the_tangent_space() {
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut Rng::new(1));
        let columns: Vec<Mat<f64>> = (0..n * k)
            .map(|e| {
                let unit = Mat::from_fn(n, k, |i, j| f64::from(u8::from(i + j * n == e)));
                manifold(&s)
                    .project_tangent(s.as_ref(), unit.as_ref())
                    .unwrap()
            })
            .collect();
        let projector = Mat::from_fn(n * k, n * k, |i, j| columns[j][(i % n, i / n)]);
        let trace: f64 = (0..n * k).map(|i| projector[(i, i)]).sum();
        let dim = manifold(&s).dim();
        assert_within(
            (trace - dim as f64).abs(),
            1e-12 * (n * k) as f64,
            &format!("trace - dim, ({n}, {k})"),
        );
    }
}

#[test]
fn check_point_reports_the_measured_defect() {
    each_shape(2, |manifold, s, _, _, place| {
        manifold.check_point("S", s.as_ref(), 1e-13).unwrap();
        let stretched = s * Scale(1.0 + 1e-3);
        match manifold.check_point("S", stretched.as_ref(), 1e-9) {
            Err(Error::NotOrthonormal {
                name: "S",
                defect,
                tolerance,
            }) => {
                let expected = (2e-3 + 1e-6) * (s.ncols() as f64).sqrt();
                assert_within(
                    (defect - expected).abs(),
                    1e-14,
                    &format!("reported defect, {place}"),
                );
                assert_eq!(tolerance, 1e-9);
            }
            other => panic!("expected NotOrthonormal, found {other:?}"),
        }
    });
}

#[test]
fn check_tangent_reports_the_measured_defect() {
    each_shape(3, |manifold, s, v, _, place| {
        manifold
            .check_tangent("V", s.as_ref(), v.as_ref(), 1e-13)
            .unwrap();
        let tilted = v + s * Scale(1e-3);
        match manifold.check_tangent("V", s.as_ref(), tilted.as_ref(), 1e-9) {
            Err(Error::NotTangent {
                name: "V",
                defect,
                tolerance,
            }) => {
                let expected = 1e-3 * (s.ncols() as f64).sqrt();
                assert_within(
                    (defect - expected).abs(),
                    1e-14,
                    &format!("reported defect, {place}"),
                );
                let expected = 1e-9 * frobenius(tilted.as_ref()).max(1.0);
                assert_within(
                    (tolerance - expected).abs(),
                    1e-12 * expected,
                    &format!("tolerance, {place}"),
                );
            }
            other => panic!("expected NotTangent, found {other:?}"),
        }
    });
}

#[test]
fn checks_look_at_shape_and_finiteness_first() {
    let s = random_point(4, 2, &mut Rng::new(4));
    let manifold = manifold(&s);
    let tall = Mat::zeros(5, 2);
    let error = manifold.check_point("S", tall.as_ref(), 1e-9);
    assert!(
        matches!(error, Err(Error::Shape { name: "S", .. })),
        "{error:?}"
    );
    let error = manifold.check_tangent("V", s.as_ref(), tall.as_ref(), 1e-9);
    assert!(
        matches!(error, Err(Error::Shape { name: "V", .. })),
        "{error:?}"
    );
    for bad in [f64::NAN, f64::INFINITY] {
        let mut a = s.clone();
        a[(2, 1)] = bad;
        let error = manifold.check_point("S", a.as_ref(), 1e-9);
        assert!(
            matches!(
                error,
                Err(Error::NonFinite {
                    name: "S",
                    index: 6
                })
            ),
            "{error:?}"
        );
        let error = manifold.check_tangent("V", s.as_ref(), a.as_ref(), 1e-9);
        assert!(
            matches!(
                error,
                Err(Error::NonFinite {
                    name: "V",
                    index: 6
                })
            ),
            "{error:?}"
        );
        let error = manifold.project(a.as_ref());
        assert!(
            matches!(
                error,
                Err(Error::NonFinite {
                    name: "Y",
                    index: 6
                })
            ),
            "{error:?}"
        );
    }
    let error = manifold.check_point("S", (&s * Scale(1e200)).as_ref(), 1e-9);
    assert!(
        matches!(error, Err(Error::NotOrthonormal { .. })),
        "overflow in S^T S: {error:?}"
    );
}

// ----------------------------------------------------------------- projections

#[test]
fn project_undoes_a_positive_stretch() {
    let mut rng = Rng::new(5);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let g = gaussian(k, k, &mut rng);
        let stretch = &g * g.transpose() * Scale(1.0 / k as f64) + identity(k) * Scale(0.5);
        let found = manifold(&s).project((&s * stretch).as_ref()).unwrap();
        // Conditioning of the polar factor: 1 / smallest stretch = 2; the stretch itself is of size about 5.
        assert_close(
            &found,
            &s,
            64.0 * n as f64 * EPS,
            &format!("polar factor of S H, ({n}, {k})"),
        );
    }
}

#[test]
fn project_is_idempotent() {
    each_shape(6, |manifold, s, v, _, place| {
        let once = manifold.project((s + v).as_ref()).unwrap();
        let twice = manifold.project(once.as_ref()).unwrap();
        let bound = 8.0 * s.nrows() as f64 * EPS;
        assert_within(
            orthonormality(&once),
            bound,
            &format!("orthonormal, {place}"),
        );
        assert_close(&twice, &once, bound, &format!("idempotent, {place}"));
    });
}

#[test]
fn project_refuses_a_rank_deficient_matrix() {
    let manifold = Stiefel::new(4, 2).unwrap();
    let error = manifold.project(Mat::full(4, 2, 1.0).as_ref());
    assert!(
        matches!(error, Err(Error::RankDeficient { name: "Y", .. })),
        "{error:?}"
    );
}

#[test]
fn project_tangent_is_the_orthogonal_projection() {
    let mut rng = Rng::new(7);
    for (n, k) in SIZES {
        let s = random_point(n, k, &mut rng);
        let (manifold, z) = (manifold(&s), gaussian(n, k, &mut rng));
        let once = manifold.project_tangent(s.as_ref(), z.as_ref()).unwrap();
        let bound = 8.0 * n as f64 * EPS * frobenius(z.as_ref());
        manifold
            .check_tangent("PZ", s.as_ref(), once.as_ref(), 16.0 * n as f64 * EPS)
            .unwrap();
        let twice = manifold.project_tangent(s.as_ref(), once.as_ref()).unwrap();
        assert_close(&twice, &once, bound, &format!("idempotent, ({n}, {k})"));
        let v = random_tangent(&s, 1.0, &mut rng);
        let rest = z.as_ref() - &once;
        let overlap = trace_of_product(v.as_ref(), rest.as_ref()).abs();
        assert_within(
            overlap,
            2.0 * bound,
            &format!("remainder against a tangent vector, ({n}, {k})"),
        );
    }
}

fn trace_of_product(v: MatRef<'_, f64>, w: MatRef<'_, f64>) -> f64 {
    let product = v.transpose() * w;
    (0..product.nrows()).map(|i| product[(i, i)]).sum()
}

// ---------------------------------------------------------------------- metric

#[test]
fn inner_is_the_canonical_metric() {
    each_shape(8, |manifold, s, v, w, place| {
        let n = s.nrows();
        let weight = identity(n) - s * s.transpose() * Scale(0.5);
        let expected = trace_of_product(v.as_ref(), (&weight * w).as_ref());
        let found = manifold.inner(s.as_ref(), v.as_ref(), w.as_ref()).unwrap();
        assert_within(
            (found - expected).abs(),
            32.0 * n as f64 * EPS,
            &format!("<V, W>, {place}"),
        );
    });
}

#[test]
fn norm_squared_is_inner_of_a_vector_with_itself() {
    each_shape(9, |manifold, s, v, _, place| {
        let (norm, inner) = (
            manifold.norm(s.as_ref(), v.as_ref()).unwrap(),
            manifold.inner(s.as_ref(), v.as_ref(), v.as_ref()).unwrap(),
        );
        let bound = 32.0 * s.nrows() as f64 * EPS;
        assert_within(
            (norm * norm - inner).abs(),
            bound,
            &format!("|V|^2 - <V, V>, {place}"),
        );
        if manifold.dim() > 0 {
            assert_within(
                (norm - 2.0).abs(),
                bound,
                &format!("norm that was asked for, {place}"),
            );
        }
    });
}

#[test]
fn norm_is_homogeneous_at_extreme_scales() {
    each_shape(10, |manifold, s, v, _, place| {
        for scale in [1e-300, 1e-160, 1e160, 1e300] {
            let found = manifold
                .norm(s.as_ref(), (v * Scale(scale)).as_ref())
                .unwrap()
                / scale;
            let bound = 32.0 * s.nrows() as f64 * EPS;
            let expected = manifold.norm(s.as_ref(), v.as_ref()).unwrap();
            assert_within(
                (found - expected).abs(),
                bound,
                &format!("{place}, scale {scale:e}"),
            );
        }
    });
}

// ---------------------------------------------------- the paper's parametrisation

#[test]
fn compose_undoes_decompose() {
    each_shape(11, |manifold, s, v, _, place| {
        let (x, omega) = manifold.decompose(s.as_ref(), v.as_ref()).unwrap();
        let found = manifold
            .compose(s.as_ref(), x.as_ref(), omega.as_ref())
            .unwrap();
        assert_close(
            &found,
            v,
            16.0 * s.nrows() as f64 * EPS,
            &format!("X S + S Omega, {place}"),
        );
        assert_eq!(x, -x.transpose(), "X is exactly skew, {place}");
        assert_eq!(omega, -omega.transpose(), "Omega is exactly skew, {place}");
    });
}

#[test]
fn eq_new_param1_is_our_pair() {
    each_shape(12, |manifold, s, v, _, place| {
        let (x, omega) = manifold.decompose(s.as_ref(), v.as_ref()).unwrap();
        let paper = v * s.transpose() - s * v.transpose()
            + s * v.transpose() * s * s.transpose() * Scale(2.0);
        let bound = 16.0 * s.nrows() as f64 * EPS;
        assert_close(&x, &paper, bound, &format!("X, {place}"));
        assert_close(
            &omega,
            &(s.transpose() * v),
            bound,
            &format!("Omega, {place}"),
        );
    });
}

#[test]
fn split_is_normal_and_skew() {
    each_shape(13, |manifold, s, v, _, place| {
        let (normal, omega) = manifold.split(s.as_ref(), v.as_ref()).unwrap();
        let bound = 16.0 * s.nrows() as f64 * EPS;
        assert_within(
            frobenius((s.transpose() * &normal).as_ref()),
            bound,
            &format!("S^T K, {place}"),
        );
        assert_close(
            &(normal + s * omega),
            v,
            bound,
            &format!("K + S Omega, {place}"),
        );
    });
}

#[test]
fn compose_refuses_wrong_shapes() {
    let s = random_point(4, 2, &mut Rng::new(14));
    let (x, omega) = (Mat::zeros(4, 4), Mat::zeros(2, 2));
    let error = manifold(&s).compose(s.as_ref(), omega.as_ref(), omega.as_ref());
    assert!(
        matches!(error, Err(Error::Shape { name: "X", .. })),
        "{error:?}"
    );
    let error = manifold(&s).compose(s.as_ref(), x.as_ref(), x.as_ref());
    assert!(
        matches!(error, Err(Error::Shape { name: "Omega", .. })),
        "{error:?}"
    );
}

// --------------------------------------------------------------------- retraction

#[test]
fn retraction_is_right_to_first_order() {
    each_shape(15, |manifold, s, v, _, place| {
        let curve = QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref()).unwrap();
        let remainder = |h: f64| distance(&curve.point(h).unwrap(), &(s + v * Scale(h)));
        if manifold.dim() == 0 {
            return assert_within(remainder(1.0), EPS, "a manifold of isolated points");
        }
        for halving in 4..9 {
            let h = 0.5_f64.powi(halving);
            let order = (remainder(h) / remainder(0.5 * h)).log2();
            assert_within(
                (order - 2.0).abs(),
                0.2,
                &format!("order {order:.3} of R(hV) - S - hV, {place}, h = {h}"),
            );
        }
    });
}

// ------------------------------------------------------------------------ connection

/// The connection of the canonical metric is metric: `d<V, W>/dt = <D V, W> + <V, D W>` along a curve.
#[test]
fn christoffel_term_is_metric() {
    each_shape(16, |manifold, s, v, w, place| {
        let u = manifold
            .project_tangent(
                s.as_ref(),
                gaussian(s.nrows(), s.ncols(), &mut Rng::new(17)).as_ref(),
            )
            .unwrap();
        let curve = QuasiGeodesic::from_velocity(s.as_ref(), u.as_ref()).unwrap();
        // Fields along the curve: constant matrices projected on the tangent spaces.
        let field = |z: &Mat<f64>, t: f64| {
            manifold
                .project_tangent(curve.point(t).unwrap().as_ref(), z.as_ref())
                .unwrap()
        };
        let product = |t: f64| {
            let x = curve.point(t).unwrap();
            manifold
                .inner(x.as_ref(), field(v, t).as_ref(), field(w, t).as_ref())
                .unwrap()
        };
        let h = 1e-3;
        let derivative = |f: &dyn Fn(f64) -> Mat<f64>| {
            (f(h) - f(-h)) * Scale(2.0 / (3.0 * h))
                - (f(2.0 * h) - f(-2.0 * h)) * Scale(1.0 / (12.0 * h))
        };
        let covariant = |z: &Mat<f64>| {
            let rate = derivative(&|t| field(z, t));
            rate + christoffel(s.as_ref(), u.as_ref(), field(z, 0.0).as_ref())
        };
        let left = derivative(&|t| Mat::full(1, 1, product(t)))[(0, 0)];
        let right = manifold
            .inner(s.as_ref(), covariant(v).as_ref(), field(w, 0.0).as_ref())
            .unwrap()
            + manifold
                .inner(s.as_ref(), field(v, 0.0).as_ref(), covariant(w).as_ref())
                .unwrap();
        // Fourth-order differences: h^4 |u|^4 / 30, and eps / h.
        let size = frobenius(u.as_ref()).max(1.0);
        let bound = h.powi(4) * size.powi(5) + 64.0 * s.nrows() as f64 * EPS / h;
        assert_within(
            (left - right).abs(),
            bound,
            &format!("d<V, W> - <DV, W> - <V, DW>, {place}"),
        );
    });
}

/// `Gamma(V, W) = Gamma(W, V)`: the connection has no torsion.
#[test]
fn christoffel_term_is_symmetric() {
    each_shape(18, |_, s, v, w, place| {
        let (vw, wv) = (
            christoffel(s.as_ref(), v.as_ref(), w.as_ref()),
            christoffel(s.as_ref(), w.as_ref(), v.as_ref()),
        );
        assert_close(
            &vw,
            &wv,
            16.0 * s.nrows() as f64 * EPS,
            &format!("Gamma(V, W) - Gamma(W, V), {place}"),
        );
    });
}

/// Geodesics of the canonical metric start with `S'' = -Gamma(S', S')`; for pure rotation and pure normal
/// velocity the quasi-geodesic is one.
#[test]
fn quasi_geodesics_of_one_part_are_geodesics() {
    each_shape(19, |manifold, s, v, _, place| {
        let (normal, omega) = manifold.split(s.as_ref(), v.as_ref()).unwrap();
        for part in [normal, s * omega] {
            let curve = QuasiGeodesic::from_velocity(s.as_ref(), part.as_ref()).unwrap();
            let [x, d1, d2] = [0, 1, 2].map(|nu| curve.derivative(0.7, nu).unwrap());
            let size = frobenius(acceleration(x.as_ref(), d1.as_ref(), d2.as_ref()).as_ref());
            assert_within(
                size,
                64.0 * s.nrows() as f64 * EPS,
                &format!("covariant acceleration, {place}"),
            );
        }
    });
}

#[test]
fn every_method_refuses_wrong_shapes_and_numbers() {
    let m = Stiefel::new(5, 2).unwrap();
    let s = random_point(5, 2, &mut Rng::new(1));
    let wrong = Mat::<f64>::zeros(4, 2);
    let nan = Mat::from_fn(5, 2, |i, _| if i == 3 { f64::NAN } else { 0.0 });
    for bad in [wrong.as_ref(), nan.as_ref()] {
        for (x, y) in [(s.as_ref(), bad), (bad, s.as_ref())] {
            assert_bad(m.project_tangent(x, y), "project_tangent");
            assert_bad(m.inner(x, y, s.as_ref()), "inner");
            assert_bad(m.inner(s.as_ref(), x, y), "inner");
            assert_bad(m.norm(x, y), "norm");
            assert_bad(m.split(x, y), "split");
            assert_bad(m.decompose(x, y), "decompose");
            assert_bad(m.check_tangent("V", x, y, 1.0), "check_tangent");
        }
    }
}

fn assert_bad<T: std::fmt::Debug>(result: stiefel_rs::Result<T>, what: &str) {
    let refused = matches!(result, Err(Error::Shape { .. } | Error::NonFinite { .. }));
    assert!(refused, "{what}: {result:?}");
}
