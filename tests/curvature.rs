//! Curvature: against brackets of full size, Gauss's equation, spheres, rotations, holonomy, and its symmetries.

mod common;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::manifold::covariant::christoffel;
use stiefel_rs::{Error, Metric, ParallelTransport, Stiefel};

fn metrics() -> [Metric; 4] {
    [
        Metric::CANONICAL,
        Metric::EUCLIDEAN,
        Metric::new(1.5).unwrap(),
        Metric::new(-0.8).unwrap(),
    ]
}

fn manifold(s: &Mat<f64>, metric: Metric) -> Stiefel {
    Stiefel::of("S", s.as_ref()).unwrap().with_metric(metric)
}

fn r(m: Stiefel, s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> Mat<f64> {
    m.curvature(s.as_ref(), u.as_ref(), v.as_ref(), w.as_ref())
        .unwrap()
}

fn inner(m: Stiefel, s: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> f64 {
    m.inner(s.as_ref(), v.as_ref(), w.as_ref()).unwrap()
}

fn sectional(m: Stiefel, s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>) -> f64 {
    m.sectional_curvature(s.as_ref(), u.as_ref(), v.as_ref())
        .unwrap_or_else(|e| panic!("{:?}: {e}", s.shape()))
}

/// A point and four tangent vectors of norm 1 in each shape of dimension at least 2.
fn each_shape(seed: u64, mut check: impl FnMut(&Mat<f64>, [&Mat<f64>; 4], &str)) {
    let mut rng = Rng::new(seed);
    for (n, k) in SIZES {
        if Stiefel::new(n, k).unwrap().dim() < 2 {
            continue;
        }
        for _ in 0..3 {
            let s = random_point(n, k, &mut rng);
            let vectors: [Mat<f64>; 4] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
            check(&s, vectors.each_ref(), &format!("({n}, {k})"));
        }
    }
}

/// The quotient `SO(n) / SO(n-k)` with full matrices: the first k columns of `g` are `S`.
struct Quotient {
    g: Mat<f64>,
    k: usize,
}

impl Quotient {
    fn at(s: &Mat<f64>, rng: &mut Rng) -> Self {
        let (n, k) = s.shape();
        let mut both = Mat::zeros(n, n);
        both.as_mut().subcols_mut(0, k).copy_from(s);
        both.as_mut()
            .subcols_mut(k, n - k)
            .copy_from(gaussian(n, n - k, rng));
        let mut g = both.qr().compute_Q();
        g.as_mut().subcols_mut(0, k).copy_from(s);
        Quotient { g, k }
    }

    /// The `x` in `m` with `g x` = `v` in the first k columns.
    fn lift(&self, v: &Mat<f64>) -> Mat<f64> {
        let (n, k) = (self.g.nrows(), self.k);
        let body = self.g.transpose() * v;
        Mat::from_fn(n, n, |i, j| match (i < k, j < k) {
            (_, true) => body[(i, j)],
            (true, false) => -body[(j, i)],
            _ => 0.0,
        })
    }

    fn push(&self, x: &Mat<f64>) -> Mat<f64> {
        (&self.g * x).subcols(0, self.k).to_owned()
    }

    /// The two parts of `[x, y]`.
    fn bracket(&self, x: &Mat<f64>, y: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
        let full = x * y - y * x;
        let (n, k) = (x.nrows(), self.k);
        let h = Mat::from_fn(
            n,
            n,
            |i, j| if i >= k && j >= k { full[(i, j)] } else { 0.0 },
        );
        (&full - &h, h)
    }
}

#[test]
fn canonical_curvature_is_that_of_the_naturally_reductive_quotient() {
    let mut worst = Worst::new("tensor");
    let mut worst_sectional = Worst::new("sectional");
    let mut rng = Rng::new(111);
    each_shape(112, |s, [u, v, w, _], place| {
        let quotient = Quotient::at(s, &mut rng);
        let [x, y, z] = [u, v, w].map(|a| quotient.lift(a));
        let m = |a: &Mat<f64>, b: &Mat<f64>| quotient.bracket(a, b).0;
        let h = |a: &Mat<f64>, b: &Mat<f64>| quotient.bracket(a, b).1;
        // Kobayashi and Nomizu, volume II, theorem X.3.3.
        let turned = h(&x, &y);
        let exact = m(&x, &m(&y, &z)) * Scale(0.25)
            - m(&y, &m(&x, &z)) * Scale(0.25)
            - m(&m(&x, &y), &z) * Scale(0.5)
            - (&turned * &z - &z * &turned);
        let canonical = manifold(s, Metric::CANONICAL);
        let k = s.ncols() as f64;
        worst.see(
            distance(&r(canonical, s, u, v, w), &quotient.push(&exact)) / k,
            || place.to_owned(),
        );
        // O'Neill: a quarter of the part in m, and the part in h, each in the norm tr(A^T A) / 2.
        let size = |a: &Mat<f64>| 0.5 * frobenius(a.as_ref()).powi(2);
        let area = inner(canonical, s, u, u) * inner(canonical, s, v, v)
            - inner(canonical, s, u, v).powi(2);
        let exact = (0.25 * size(&m(&x, &y)) + size(&h(&x, &y))) / area;
        let measured = sectional(canonical, s, u, v);
        worst_sectional.see((measured - exact).abs() * area.sqrt() / k, || {
            place.to_owned()
        });
    });
    worst.assert_at_most(5e-15);
    worst_sectional.assert_at_most(5e-15);
}

#[test]
fn euclidean_curvature_is_gauss_equation() {
    let mut worst = Worst::new("Gauss");
    each_shape(113, |s, [u, v, w, z], place| {
        let second = |a: &Mat<f64>, b: &Mat<f64>| {
            let product = a.transpose() * b;
            s * (&product + product.transpose()) * Scale(-0.5)
        };
        let dot = |a: Mat<f64>, b: Mat<f64>| {
            (0..a.ncols())
                .map(|j| a.col(j).transpose() * b.col(j))
                .sum::<f64>()
        };
        let exact = dot(second(u, z), second(v, w)) - dot(second(u, w), second(v, z));
        let euclidean = manifold(s, Metric::EUCLIDEAN);
        let measured = inner(euclidean, s, &r(euclidean, s, u, v, w), z);
        worst.see((measured - exact).abs() / s.ncols() as f64, || {
            place.to_owned()
        });
    });
    worst.assert_at_most(5e-15);
}

#[test]
fn curvature_has_its_symmetries_and_the_bianchi_identity() {
    let mut worst = Worst::new("symmetry");
    each_shape(114, |s, [u, v, w, z], place| {
        for metric in metrics() {
            let m = manifold(s, metric);
            let t = |a: &Mat<f64>, b: &Mat<f64>, c: &Mat<f64>, d: &Mat<f64>| {
                inner(m, s, &r(m, s, a, b, c), d)
            };
            let place = |what: &str| format!("{what}, {place}, {metric:?}");
            worst.see((t(u, v, w, z) + t(v, u, w, z)).abs(), || {
                place("first pair")
            });
            worst.see((t(u, v, w, z) + t(u, v, z, w)).abs(), || {
                place("second pair")
            });
            worst.see((t(u, v, w, z) - t(w, z, u, v)).abs(), || {
                place("pairs exchanged")
            });
            let cycle = r(m, s, u, v, w) + r(m, s, v, w, u) + r(m, s, w, u, v);
            worst.see(frobenius(cycle.as_ref()), || place("Bianchi"));
        }
    });
    worst.assert_at_most(1e-14);
}

#[test]
fn curvature_is_tangent_and_equivariant() {
    let mut rng = Rng::new(115);
    each_shape(116, |s, [u, v, w, _], place| {
        for metric in metrics() {
            let m = manifold(s, metric);
            let value = r(m, s, u, v, w);
            m.check_tangent("R", s.as_ref(), value.as_ref(), 1e-14)
                .unwrap();
            let q = random_orthogonal(s.nrows(), &mut rng);
            let turned = r(m, &(&q * s), &(&q * u), &(&q * v), &(&q * w));
            assert_close(
                &turned,
                &(&q * value),
                3e-14,
                &format!("{place}, {metric:?}"),
            );
        }
    });
}

#[test]
fn sphere_has_curvature_one_in_every_metric() {
    let mut rng = Rng::new(117);
    for n in [3, 4, 10, 100] {
        let s = random_point(n, 1, &mut rng);
        let [u, v, w] = std::array::from_fn(|_| random_tangent(&s, 2.0, &mut rng));
        for metric in metrics() {
            let m = manifold(&s, metric);
            let exact = &u * Scale(inner(m, &s, &v, &w)) - &v * Scale(inner(m, &s, &u, &w));
            assert_close(
                &r(m, &s, &u, &v, &w),
                &exact,
                1e-14,
                &format!("R(U,V)W = <V,W>U - <U,W>V, S^{}", n - 1),
            );
            assert_within((sectional(m, &s, &u, &v) - 1.0).abs(), 1e-14, "curvature 1");
        }
    }
}

#[test]
fn rotations_have_a_quarter_of_the_bracket() {
    let mut rng = Rng::new(118);
    // St(n, n-1) is SO(n) as well, in the canonical metric alone.
    for (n, k) in [(3, 3), (5, 5), (3, 2), (6, 5)] {
        let s = random_point(n, k, &mut rng);
        let quotient = Quotient::at(&s, &mut rng);
        let [u, v] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
        let (x, y) = (quotient.lift(&u), quotient.lift(&v));
        let bracket = &x * &y - &y * &x;
        for metric in metrics() {
            if k < n && metric != Metric::CANONICAL {
                continue;
            }
            let m = manifold(&s, metric);
            let double = &x * &bracket - &bracket * &x;
            // R(x, y) x = -[[x, y], x] / 4.
            assert_close(
                &r(m, &s, &u, &v, &u),
                &(quotient.push(&double) * Scale(0.25)),
                1e-14,
                "a quarter of [[x,y],x]",
            );
            let area = inner(m, &s, &u, &u) * inner(m, &s, &v, &v) - inner(m, &s, &u, &v).powi(2);
            let exact = 0.25 * metric.weight() * frobenius(bracket.as_ref()).powi(2) / area;
            assert_within(
                (sectional(m, &s, &u, &v) - exact).abs(),
                1e-14,
                &format!("({n}, {k}), {metric:?}"),
            );
        }
    }
}

#[test]
fn curvature_is_the_holonomy_of_small_loops() {
    // Round a square of side h and back: W changes by -h^2 R(U, V) W + O(h^3), here made O(h^4) by the loop through the
    // opposite square.
    let mut rng = Rng::new(119);
    for (n, k) in [(3, 1), (4, 2), (5, 3), (4, 4), (8, 2)] {
        for metric in metrics() {
            let s = random_point(n, k, &mut rng);
            let [u, v, w] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
            let m = manifold(&s, metric);
            let exact = r(m, &s, &u, &v, &w);
            let error = |h: f64| {
                let sum = holonomy(m, &s, &(&u * Scale(h)), &(&v * Scale(h)), &w)
                    + holonomy(m, &s, &(&u * Scale(-h)), &(&v * Scale(-h)), &w);
                distance(&(sum * Scale(-0.5 / (h * h))), &exact)
            };
            let errors = [error(0.04), error(0.02), error(0.01)];
            for pair in errors.windows(2) {
                let slope = (pair[0] / pair[1]).log2();
                assert!(
                    (slope - 2.0).abs() < 0.2 || pair[1] < 1e-8,
                    "({n}, {k}), {metric:?}: errors {errors:?}, slope {slope}"
                );
            }
            assert_within(errors[2], 5e-3, &format!("({n}, {k}), {metric:?}"));
        }
    }
}

/// `P W - W` for the transport round the quadrangle with the sides `U`, `V`, `-U` (each made parallel along the one before),
/// closed by the geodesic back to `S`.
fn holonomy(m: Stiefel, s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> Mat<f64> {
    let mut point = s.clone();
    let mut frame = [u.clone(), v.clone(), w.clone()];
    for side in [0, 1, 2] {
        let velocity = if side == 2 {
            &frame[0] * Scale(-1.0)
        } else {
            frame[side].clone()
        };
        let step = ParallelTransport::new(m, point.as_ref(), velocity.as_ref()).unwrap();
        frame = frame
            .each_ref()
            .map(|x| step.transport(x.as_ref()).unwrap());
        point = step.end();
    }
    // The way home: the velocity is corrected until the geodesic arrives.
    let mut home = m
        .project_tangent(point.as_ref(), (s - &point).as_ref())
        .unwrap();
    for _ in 0..60 {
        let end = ParallelTransport::new(m, point.as_ref(), home.as_ref())
            .unwrap()
            .end();
        home += m
            .project_tangent(point.as_ref(), (s - end).as_ref())
            .unwrap();
    }
    let last = ParallelTransport::new(m, point.as_ref(), home.as_ref()).unwrap();
    assert_within(distance(&last.end(), s), 1e-14, "the loop is closed");
    last.transport(frame[2].as_ref()).unwrap() - w
}

#[test]
fn curvature_is_the_commutator_of_covariant_derivatives() {
    // Fields P_X Z for fixed Z, canonical metric, by differences of fourth order in the embedding.
    let mut rng = Rng::new(120);
    for (n, k) in [(3, 1), (4, 2), (5, 3), (3, 3)] {
        let s = random_point(n, k, &mut rng);
        let [u, v, w] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
        let m = manifold(&s, Metric::CANONICAL);
        let field = |z: &Mat<f64>| {
            let z = z.clone();
            move |x: &Mat<f64>| {
                let sym = x.transpose() * &z;
                &z - x * (&sym + sym.transpose()) * Scale(0.5)
            }
        };
        let (fu, fv, fw) = (field(&u), field(&v), field(&w));
        let derivative = |f: &dyn Fn(&Mat<f64>) -> Mat<f64>, x: &Mat<f64>, z: &Mat<f64>| {
            let h = 2e-3;
            let at = |t: f64| f(&retract(x, &(z * Scale(t))));
            ((at(h) - at(-h)) * Scale(8.0) - (at(2.0 * h) - at(-2.0 * h))) * Scale(1.0 / (12.0 * h))
        };
        let covariant =
            |f: &dyn Fn(&Mat<f64>) -> Mat<f64>, g: &dyn Fn(&Mat<f64>) -> Mat<f64>, x: &Mat<f64>| {
                let (z, y) = (f(x), g(x));
                derivative(g, x, &z) + christoffel(x.as_ref(), z.as_ref(), y.as_ref())
            };
        let vw = |x: &Mat<f64>| covariant(&fv, &fw, x);
        let uw = |x: &Mat<f64>| covariant(&fu, &fw, x);
        let bracket = |x: &Mat<f64>| derivative(&fv, x, &fu(x)) - derivative(&fu, x, &fv(x));
        let exact =
            covariant(&fu, &vw, &s) - covariant(&fv, &uw, &s) - covariant(&bracket, &fw, &s);
        // h^4 = 1.6e-11 times fifth derivatives.
        assert_close(&r(m, &s, &u, &v, &w), &exact, 2e-9, &format!("({n}, {k})"));
    }
}

#[test]
fn sign_is_that_of_the_equation_of_riemannian_cubics() {
    // x''' = [x'', x]_m - [[x, x']_h, x] is D_t^3 S' + R(D_t S', S') S' = 0, so R(a, x) x is
    // [[x, a]_h, x] - [x, [x, a]_m]_m / 4.
    let mut rng = Rng::new(121);
    each_shape(122, |s, [a, x, ..], place| {
        let quotient = Quotient::at(s, &mut rng);
        let (la, lx) = (quotient.lift(a), quotient.lift(x));
        let (along, turned) = quotient.bracket(&lx, &la);
        let exact = &turned * &lx - &lx * &turned - quotient.bracket(&lx, &along).0 * Scale(0.25);
        let measured = r(manifold(s, Metric::CANONICAL), s, a, x, x);
        assert_close(
            &measured,
            &quotient.push(&exact),
            1e-14 * s.ncols() as f64,
            place,
        );
    });
}

#[test]
fn canonical_sectional_curvature_is_between_zero_and_five_quarters() {
    let mut rng = Rng::new(123);
    for (n, k) in [(3, 2), (4, 2), (5, 3), (6, 6), (6, 2), (8, 4)] {
        let m = Stiefel::new(n, k).unwrap();
        for i in 0..300 {
            let s = random_point(n, k, &mut rng);
            let [u, v] = std::array::from_fn(|_| {
                let a = random_tangent(&s, 1.0, &mut rng);
                // Every third pair has low rank, where the curvature is large.
                let thin = Mat::from_fn(n, k, |p, q| {
                    if q < 2 && i % 3 == 0 {
                        30.0 * a[(p, q)]
                    } else {
                        a[(p, q)]
                    }
                });
                m.project_tangent(s.as_ref(), thin.as_ref()).unwrap()
            });
            let value = sectional(m, &s, &u, &v);
            assert!(
                (-1e-14..=1.25 + 1e-14).contains(&value),
                "({n}, {k}): {value}"
            );
        }
    }
}

#[test]
fn five_quarters_are_attained() {
    for (n, k) in [(4, 2), (6, 3), (20, 4)] {
        let s = Mat::from_fn(n, k, |i, j| f64::from(u8::from(i == j)));
        let block = |entries: [[f64; 2]; 2]| {
            Mat::from_fn(n, k, |i, j| {
                if (k..k + 2).contains(&i) && j < 2 {
                    entries[i - k][j]
                } else {
                    0.0
                }
            })
        };
        let (u, v) = (
            block([[1.0, 0.0], [0.0, 1.0]]),
            block([[0.0, -1.0], [1.0, 0.0]]),
        );
        let value = sectional(Stiefel::new(n, k).unwrap(), &s, &u, &v);
        assert_within((value - 1.25).abs(), 1e-15, &format!("({n}, {k})"));
    }
}

#[test]
fn sectional_curvature_depends_on_the_plane_alone() {
    let mut worst = Worst::new("another basis");
    each_shape(124, |s, [u, v, ..], place| {
        for metric in metrics() {
            let m = manifold(s, metric);
            let value = sectional(m, s, u, v);
            for (a, b) in [
                (u * Scale(3.0) - v, u + v * Scale(0.2)),
                (u * Scale(1e-200), v * Scale(1e150)),
                (v.clone(), u.clone()),
            ] {
                worst.see((sectional(m, s, &a, &b) - value).abs(), || {
                    format!("{place}, {metric:?}")
                });
            }
            // A thin plane: eps / 1e-4.
            let thin = sectional(m, s, u, &(u + v * Scale(1e-4)));
            assert_within(
                (thin - value).abs(),
                1e-10,
                &format!("thin, {place}, {metric:?}"),
            );
        }
    });
    worst.assert_at_most(1e-14);
}

#[test]
fn vectors_that_span_no_plane_are_refused_with_their_area() {
    let mut rng = Rng::new(125);
    let s = random_point(5, 2, &mut rng);
    let m = manifold(&s, Metric::CANONICAL);
    let [u, v] = std::array::from_fn(|_| random_tangent(&s, 1.0, &mut rng));
    let zero = Mat::zeros(5, 2);
    for (a, b) in [
        (&u, &u * Scale(-2.0)),
        (&zero, u.clone()),
        (&u, zero.clone()),
    ] {
        match m.sectional_curvature(s.as_ref(), a.as_ref(), b.as_ref()) {
            Err(Error::LinearlyDependent { area, .. }) => assert_within(area, 1e-15, "area"),
            other => panic!("{other:?}"),
        }
    }
    match m.sectional_curvature(s.as_ref(), u.as_ref(), (&u + &v * Scale(1e-9)).as_ref()) {
        Err(Error::LinearlyDependent { area, .. }) => {
            let exact = 1e-9 * (1.0 - inner(m, &s, &u, &v).powi(2)).sqrt();
            assert_within((area - exact).abs(), 1e-15, "area");
        }
        other => panic!("{other:?}"),
    }
    // The circle has no planes.
    let s = random_point(2, 1, &mut rng);
    let (u, v) = (
        random_tangent(&s, 1.0, &mut rng),
        random_tangent(&s, 3.0, &mut rng),
    );
    let error =
        manifold(&s, Metric::CANONICAL).sectional_curvature(s.as_ref(), u.as_ref(), v.as_ref());
    assert!(
        matches!(error, Err(Error::LinearlyDependent { .. })),
        "{error:?}"
    );
}

#[test]
fn vectors_that_are_nothing_but_round_off() {
    // Short enough for the check of tangent vectors, and nothing of them is tangent.
    let mut rng = Rng::new(127);
    for s in [
        identity(4).subcols(0, 2).to_owned(),
        random_point(4, 2, &mut rng),
    ] {
        for metric in metrics() {
            let m = manifold(&s, metric);
            let v = random_tangent(&s, 1.0, &mut rng);
            let noise = &s * Scale(1e-12);
            for (a, b, c) in [(&noise, &v, &v), (&v, &noise, &v), (&v, &v, &noise)] {
                // Round-off of the noise.
                assert_within(frobenius(r(m, &s, a, b, c).as_ref()), 1e-26, "nothing");
            }
            for (a, b) in [(&noise, &v), (&v, &noise)] {
                match m.sectional_curvature(s.as_ref(), a.as_ref(), b.as_ref()) {
                    Err(Error::LinearlyDependent { area, .. }) => {
                        assert_within(area, 1e-14, "area")
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
    }
}

#[test]
fn bad_and_extreme_arguments() {
    let mut rng = Rng::new(126);
    let s = random_point(4, 2, &mut rng);
    let m = manifold(&s, Metric::CANONICAL);
    let u = random_tangent(&s, 1.0, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let nan = Mat::from_fn(4, 2, |i, j| if (i, j) == (0, 1) { f64::NAN } else { 0.0 });
    let tensor = |s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>| {
        m.curvature(s.as_ref(), u.as_ref(), v.as_ref(), w.as_ref())
    };
    let plane = |s: &Mat<f64>, u: &Mat<f64>, v: &Mat<f64>| {
        m.sectional_curvature(s.as_ref(), u.as_ref(), v.as_ref())
    };
    for bad in [nan, Mat::zeros(3, 2), &u + &s] {
        for (i, name) in ["S", "U", "V", "W"].into_iter().enumerate() {
            let mut arguments = [&s, &u, &v, &u];
            arguments[i] = &bad;
            let [a, b, c, d] = arguments;
            let error = tensor(a, b, c, d).unwrap_err();
            assert!(error.to_string().starts_with(name), "{name}: {error}");
            if i < 3 {
                let error = plane(a, b, c).unwrap_err();
                assert!(error.to_string().starts_with(name), "{name}: {error}");
            }
        }
    }
    // Multilinear: extreme lengths may cancel.
    let exact = tensor(&s, &u, &v, &u).unwrap();
    for (a, b, c) in [
        (1e140, 1e-140, 1.0),
        (1e-300, 1e150, 1e150),
        (1e-200, 1e-100, 1.0),
        (1e-300, 1.0, 1.0),
    ] {
        let value = tensor(&s, &(&u * Scale(a)), &(&v * Scale(b)), &(&u * Scale(c))).unwrap();
        let scaled = &exact * Scale(a) * Scale(c) * Scale(b);
        let size = frobenius(scaled.as_ref());
        assert_within(
            distance(&value, &scaled),
            1e-14 * size.max(1e-290),
            &format!("{a:e} {b:e} {c:e}"),
        );
    }
    let huge = &u * Scale(1e140);
    let error = tensor(&s, &huge, &(&v * Scale(1e140)), &huge);
    assert!(matches!(error, Err(Error::Overflow { .. })), "{error:?}");
    let error = tensor(&s, &(&u * Scale(1e300)), &v, &u);
    assert!(
        error.is_ok()
            || matches!(
                error,
                Err(Error::NotTangent { .. } | Error::Overflow { .. })
            ),
        "{error:?}"
    );
}
