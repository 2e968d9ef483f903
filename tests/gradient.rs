//! Riemannian gradient and Hessian from the Euclidean ones, for a function of degree four.

mod common;

use common::*;
use faer::{Mat, Scale};
use stiefel_rs::{Error, Metric, ParallelTransport, Stiefel};

fn metrics() -> [Metric; 4] {
    [
        Metric::CANONICAL,
        Metric::EUCLIDEAN,
        Metric::new(1.5).unwrap(),
        Metric::new(-0.8).unwrap(),
    ]
}

/// `f(X) = tr(X^T A X B) / 2 + tr(C^T X) + sum X^4`.
struct Function {
    a: Mat<f64>,
    b: Mat<f64>,
    c: Mat<f64>,
}

impl Function {
    fn random(n: usize, k: usize, rng: &mut Rng) -> Self {
        let (a, b) = (gaussian(n, n, rng), gaussian(k, k, rng));
        Function {
            a: &a + a.transpose(),
            b: &b + b.transpose(),
            c: gaussian(n, k, rng),
        }
    }

    fn gradient(&self, x: &Mat<f64>) -> Mat<f64> {
        let cubic = Mat::from_fn(x.nrows(), x.ncols(), |i, j| 4.0 * x[(i, j)].powi(3));
        &self.a * x * &self.b + &self.c + cubic
    }

    fn hessian(&self, x: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
        let square = Mat::from_fn(x.nrows(), x.ncols(), |i, j| {
            12.0 * x[(i, j)].powi(2) * v[(i, j)]
        });
        &self.a * v * &self.b + square
    }

    fn riemannian_gradient(&self, m: Stiefel, x: &Mat<f64>) -> Mat<f64> {
        m.euclidean_to_riemannian_gradient(x.as_ref(), self.gradient(x).as_ref())
            .unwrap()
    }

    fn riemannian_hessian(&self, m: Stiefel, x: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
        let (g, h) = (self.gradient(x), self.hessian(x, v));
        m.euclidean_to_riemannian_hessian(x.as_ref(), g.as_ref(), h.as_ref(), v.as_ref())
            .unwrap()
    }
}

fn each_case(mut check: impl FnMut(Stiefel, &Function, &Mat<f64>, &Mat<f64>, &Mat<f64>, &str)) {
    let mut rng = Rng::new(131);
    for (n, k) in SIZES {
        for metric in metrics() {
            let m = Stiefel::new(n, k).unwrap().with_metric(metric);
            let f = Function::random(n, k, &mut rng);
            let s = random_point(n, k, &mut rng);
            let (v, w) = (
                random_tangent(&s, 1.0, &mut rng),
                random_tangent(&s, 1.0, &mut rng),
            );
            check(m, &f, &s, &v, &w, &format!("({n}, {k}), {metric:?}"));
        }
    }
}

fn dot(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.ncols())
        .map(|j| a.col(j).transpose() * b.col(j))
        .sum()
}

fn inner(m: Stiefel, s: &Mat<f64>, v: &Mat<f64>, w: &Mat<f64>) -> f64 {
    m.inner(s.as_ref(), v.as_ref(), w.as_ref()).unwrap()
}

#[test]
fn gradient_represents_the_differential() {
    each_case(|m, f, s, v, _, place| {
        let gradient = f.riemannian_gradient(m, s);
        m.check_tangent("gradient", s.as_ref(), gradient.as_ref(), 1e-14)
            .unwrap();
        let size = frobenius(f.gradient(s).as_ref());
        let error = inner(m, s, &gradient, v) - dot(&f.gradient(s), v);
        assert_within(error.abs(), 1e-14 * size, place);
    });
}

#[test]
fn gradients_of_the_two_usual_metrics() {
    each_case(|m, f, s, _, _, place| {
        let g = f.gradient(s);
        let exact = match m.metric() {
            Metric::CANONICAL => &g - s * g.transpose() * s,
            Metric::EUCLIDEAN => m.project_tangent(s.as_ref(), g.as_ref()).unwrap(),
            _ => return,
        };
        let bound = 1e-14 * frobenius(g.as_ref());
        assert_close(&f.riemannian_gradient(m, s), &exact, bound, place);
    });
}

#[test]
fn hessian_is_symmetric() {
    each_case(|m, f, s, v, w, place| {
        let (hv, hw) = (f.riemannian_hessian(m, s, v), f.riemannian_hessian(m, s, w));
        m.check_tangent("Hessian", s.as_ref(), hv.as_ref(), 1e-14)
            .unwrap();
        let size = frobenius(hv.as_ref()) + frobenius(hw.as_ref());
        let error = inner(m, s, &hv, w) - inner(m, s, v, &hw);
        assert_within(error.abs(), 1e-14 * size * s.ncols() as f64, place);
    });
}

#[test]
fn hessian_is_the_covariant_derivative_of_the_gradient() {
    each_case(|m, f, s, v, _, place| {
        // Differences of fourth order between the gradients at both ends of a short geodesic, after parallel transport.
        let h = 2e-3;
        let at = |t: f64| {
            let there = ParallelTransport::new(m, s.as_ref(), (v * Scale(t)).as_ref()).unwrap();
            let end = there.end();
            let velocity = there.transport((v * Scale(-t)).as_ref()).unwrap();
            let back = ParallelTransport::new(m, end.as_ref(), velocity.as_ref()).unwrap();
            back.transport(f.riemannian_gradient(m, &end).as_ref())
                .unwrap()
        };
        let differences = ((at(h) - at(-h)) * Scale(8.0) - (at(2.0 * h) - at(-2.0 * h)))
            * Scale(1.0 / (12.0 * h));
        let exact = f.riemannian_hessian(m, s, v);
        let size = frobenius(f.riemannian_gradient(m, s).as_ref()) + frobenius(exact.as_ref());
        // h^4 = 1.6e-11, eps / h = 1e-13.
        assert_close(&exact, &differences, 1e-9 * size, place);
    });
}

#[test]
fn bad_and_extreme_arguments() {
    let mut rng = Rng::new(132);
    let m = Stiefel::new(4, 2).unwrap();
    let s = random_point(4, 2, &mut rng);
    let v = random_tangent(&s, 1.0, &mut rng);
    let nan = Mat::from_fn(4, 2, |i, j| if (i, j) == (2, 1) { f64::NAN } else { 0.0 });
    for bad in [nan, Mat::zeros(3, 2)] {
        for (i, name) in ["S", "G", "H", "V"].into_iter().enumerate() {
            let mut x = [&s, &v, &v, &v].map(|a| a.as_ref());
            x[i] = bad.as_ref();
            let error = m
                .euclidean_to_riemannian_hessian(x[0], x[1], x[2], x[3])
                .unwrap_err();
            assert!(error.to_string().starts_with(name), "{name}: {error}");
            if i < 2 {
                let error = m.euclidean_to_riemannian_gradient(x[0], x[1]).unwrap_err();
                assert!(error.to_string().starts_with(name), "{name}: {error}");
            }
        }
    }
    let tilted = &v + &s;
    let error =
        m.euclidean_to_riemannian_hessian(s.as_ref(), v.as_ref(), v.as_ref(), tilted.as_ref());
    assert!(
        matches!(error, Err(Error::NotTangent { name: "V", .. })),
        "{error:?}"
    );
    for scale in [1e-320, 1e-160, 1e100, 1e160, 1e300, 1.7e308] {
        let g = Mat::from_fn(4, 2, |_, _| scale);
        for result in [
            m.euclidean_to_riemannian_gradient(s.as_ref(), g.as_ref()),
            m.euclidean_to_riemannian_hessian(s.as_ref(), g.as_ref(), g.as_ref(), v.as_ref()),
        ] {
            match result {
                Ok(x) => assert!(frobenius(x.as_ref()).is_finite()),
                Err(error) => assert!(
                    scale > 1e300 && matches!(error, Error::Overflow { .. }),
                    "{scale:e}: {error}"
                ),
            }
        }
    }
}
