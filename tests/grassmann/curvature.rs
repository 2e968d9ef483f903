//! Curvature, compared with the reflections `2 Y Y^T - I` in O(n) and closed forms; gradients and Hessians.

use faer::{Mat, Scale};
use stiefel_rs::{Error, Stiefel};

use crate::common::{assert_close, assert_within, frobenius, gaussian, identity};
use crate::{each_point, exp, horizontal, transport};

/// The differential of `Y -> 2 Y Y^T - I`.
fn lifted(y: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
    (v * y.transpose() + y * v.transpose()) * Scale(2.0)
}

#[test]
fn curvature_is_that_of_the_reflections() {
    each_point(|m, y, rng| {
        let n = m.n();
        let [u, v, w] = [(); 3].map(|()| horizontal(&y, 1.0, rng));
        let r = m.curvature(y.as_ref(), u.as_ref(), v.as_ref(), w.as_ref());
        let s = &y * y.transpose() * Scale(2.0) - identity(n);
        let rotations = Stiefel::new(n, n).unwrap();
        let [a, b, c] = [&u, &v, &w].map(|x| lifted(&y, x));
        let exact = rotations.curvature(s.as_ref(), a.as_ref(), b.as_ref(), c.as_ref());
        let bound = 5e-15 * 16.0 * n as f64;
        assert_close(
            &lifted(&y, &r.unwrap()),
            &exact.unwrap(),
            bound,
            "R(U, V) W",
        );
    });
}

#[test]
fn curvature_of_extreme_lengths() {
    each_point(|m, y, rng| {
        let [u, v, w] = [(); 3].map(|()| horizontal(&y, 1.0, rng));
        let r = |a: f64, b: f64, c: f64| {
            let [u, v, w] = [(&u, a), (&v, b), (&w, c)].map(|(x, scale)| x * Scale(scale));
            m.curvature(y.as_ref(), u.as_ref(), v.as_ref(), w.as_ref())
        };
        let unit = r(1.0, 1.0, 1.0).unwrap();
        let extreme = r(1e200, 1e-300, 1e150).unwrap() * Scale(1e-50);
        assert_close(&extreme, &unit, 5e-15 * m.k() as f64, "lengths");
        if m.n() > m.k() && frobenius(unit.as_ref()) > 1e-3 {
            assert_eq!(
                r(1e200, 1e200, 1.0).unwrap_err(),
                Error::Overflow {
                    quantity: "curvature"
                }
            );
        }
    });
}

#[test]
fn sectional_curvature_is_between_zero_and_two() {
    each_point(|m, y, rng| {
        let [u, v] = [(); 2].map(|()| horizontal(&y, 3.0, rng));
        let value = m.sectional_curvature(y.as_ref(), u.as_ref(), v.as_ref());
        if m.dim() < 2 {
            assert!(
                matches!(value, Err(Error::LinearlyDependent { .. })),
                "{value:?}"
            );
            return;
        }
        let value = value.unwrap();
        assert!((-1e-14..=2.0 + 1e-14).contains(&value), "{value}");
        if m.k() == 1 || m.n() - m.k() == 1 {
            assert_within((value - 1.0).abs(), 1e-13, "projective space");
        }
    });
}

#[test]
fn two_is_attained() {
    let block = |entries: [[f64; 2]; 2]| {
        Mat::from_fn(4, 2, |i, j| if i < 2 { 0.0 } else { entries[i - 2][j] })
    };
    let y = Mat::from_fn(4, 2, |i, j| f64::from(u8::from(i == j)));
    let (u, v) = (
        block([[1.0, 0.0], [0.0, 1.0]]),
        block([[0.0, -1.0], [1.0, 0.0]]),
    );
    let m = crate::manifold(&y);
    let value = m
        .sectional_curvature(y.as_ref(), u.as_ref(), v.as_ref())
        .unwrap();
    assert_within((value - 2.0).abs(), 1e-15, "two");
    let flat = block([[0.0, 0.0], [0.0, 1.0]]);
    let first = block([[1.0, 0.0], [0.0, 0.0]]);
    let value = m
        .sectional_curvature(y.as_ref(), first.as_ref(), flat.as_ref())
        .unwrap();
    assert_within(value.abs(), 1e-15, "flat");
}

/// `f = tr(A P B P)` of the projector `P = Y Y^T`, which depends on the subspace alone.
struct Cost {
    a: Mat<f64>,
    b: Mat<f64>,
}

impl Cost {
    fn product(&self, x: &Mat<f64>) -> Mat<f64> {
        &self.a * x * &self.b + &self.b * x * &self.a
    }

    fn gradient(&self, y: &Mat<f64>) -> Mat<f64> {
        self.product(&(y * y.transpose())) * y * Scale(2.0)
    }

    fn hessian(&self, y: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
        let change = v * y.transpose() + y * v.transpose();
        (self.product(&(y * y.transpose())) * v + self.product(&change) * y) * Scale(2.0)
    }
}

#[test]
fn the_hessian_is_the_covariant_derivative_of_the_gradient() {
    each_point(|m, y, rng| {
        let n = m.n();
        let [a, b] = [(); 2].map(|()| {
            let x = gaussian(n, n, rng);
            &x + x.transpose()
        });
        let cost = Cost { a, b };
        let v = horizontal(&y, 1.0, rng);
        let hessian = m
            .euclidean_to_riemannian_hessian(
                y.as_ref(),
                cost.gradient(&y).as_ref(),
                cost.hessian(&y, &v).as_ref(),
                v.as_ref(),
            )
            .unwrap();
        let carried = |h: f64| {
            let step = &v * Scale(h);
            let end = exp(&y, &step);
            let gradient = m
                .euclidean_to_riemannian_gradient(end.as_ref(), cost.gradient(&end).as_ref())
                .unwrap();
            transport(&end, &(-transport(&y, &step, &step)), &gradient)
        };
        let h = 1e-3;
        let difference = (carried(-2.0 * h) - carried(2.0 * h)
            + (carried(h) - carried(-h)) * Scale(8.0))
            * Scale(1.0 / (12.0 * h));
        let size = frobenius(cost.a.as_ref()) * frobenius(cost.b.as_ref());
        // h^4 times a fifth derivative of about 100, and eps / h.
        assert_close(&hessian, &difference, 1e-9 * size, "Hessian");
    });
}
