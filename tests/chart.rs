//! The charts: Hamiltonians with their derivatives, the embedding, momenta.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{SMatrix, SVector};
use stiefel_rs::Error;
use stiefel_rs::chart::{Chart, Frame, Sphere};
use stiefel_rs::manifold::Stiefel;

const SPHERE_STATE: [f64; 8] = [1.1, 0.4, 0.3, -0.2, 0.7, -0.5, 0.9, 0.35];
const FRAME_STATE: [f64; 12] = [
    1.2, 0.4, -0.8, 0.3, -0.2, 0.5, 0.7, -0.5, 0.2, 0.9, 0.35, -0.6,
];

fn gradient_by_differences<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z: &SVector<f64, Z>,
) -> SVector<f64, Z> {
    let h = 1e-3;
    SVector::from_fn(|i, _| {
        let value = |s: f64| {
            let mut moved = *z;
            moved[i] += s * h;
            chart.hamiltonian(&moved)
        };
        // Order six: truncation h^6 and round-off eps / h are both below 1e-12.
        (45.0 * (value(1.0) - value(-1.0)) - 9.0 * (value(2.0) - value(-2.0)) + value(3.0)
            - value(-3.0))
            / (60.0 * h)
    })
}

fn check_derivatives<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z: &SVector<f64, Z>,
) {
    let gradient = chart.gradient(z);
    let defect = (gradient - gradient_by_differences(chart, z)).amax();
    assert!(defect < 1e-11, "gradient against differences: {defect:e}");
    let (hessian, h) = (chart.hessian(z), 1e-3);
    for i in 0..Z {
        let moved = |s: f64| {
            let mut moved = *z;
            moved[i] += s * h;
            chart.gradient(&moved)
        };
        let column = (moved(1.0) - moved(-1.0)) * 45.0 - (moved(2.0) - moved(-2.0)) * 9.0
            + moved(3.0)
            - moved(-3.0);
        let defect = (hessian.column(i) - column / (60.0 * h)).amax();
        assert!(
            defect < 1e-11,
            "Hessian column {i} against differences: {defect:e}"
        );
    }
    assert_eq!(
        hessian,
        hessian.transpose(),
        "the Hessian is symmetric to the last bit"
    );
}

#[test]
fn gradients_and_hessians_are_exact() {
    check_derivatives(&Sphere, &SPHERE_STATE.into());
    check_derivatives(&Frame, &FRAME_STATE.into());
    // At theta = pi/2, where the paper's form of the frame Hamiltonian divides by zero.
    let mut z: SVector<f64, 12> = FRAME_STATE.into();
    z[0] = FRAC_PI_2;
    check_derivatives(&Frame, &z);
}

#[test]
fn sphere_hamiltonian_is_its_closed_form() {
    let z: SVector<f64, 8> = SPHERE_STATE.into();
    let [t, _, td, pd, pt, pp, ptd, ppd] = SPHERE_STATE;
    let (s, c) = t.sin_cos();
    let geometric = pt * td + pp * pd + 0.5 * (ptd * ptd + ppd * ppd / (s * s));
    let expected = geometric + s * c * pd * pd * ptd - 2.0 * c / s * td * pd * ppd;
    assert!(
        (Sphere.hamiltonian(&z) - expected).abs() < 4.0 * f64::EPSILON,
        "{expected}"
    );
}

/// `H = p_q . qdot + p_qdot . a - |a + Gamma|_g^2 / 2` at the maximising acceleration, with metric and Christoffel
/// symbols from differences of the embedding: independent of the closed form.
#[test]
fn frame_hamiltonian_follows_from_the_metric() {
    let [q, qdot]: [[f64; 3]; 2] = [[1.2, 0.4, -0.8], [0.3, -0.2, 0.5]];
    let metric = |q: &[f64; 3]| {
        let point = Frame.embed(q).unwrap();
        let manifold = Stiefel::of("S", point.as_ref()).unwrap();
        let unit = |i: usize| {
            let mut e = [0.0; 3];
            e[i] = 1.0;
            Frame.embed_velocity(q, &e).unwrap()
        };
        SMatrix::<f64, 3, 3>::from_fn(|i, j| {
            manifold
                .inner(point.as_ref(), unit(i).as_ref(), unit(j).as_ref())
                .unwrap()
        })
    };
    let (g, h) = (metric(&q), 1e-4);
    let slope = |l: usize| {
        let moved = |s: f64| {
            let mut moved = q;
            moved[l] += s * h;
            metric(&moved)
        };
        ((moved(1.0) - moved(-1.0)) * 8.0 - (moved(2.0) - moved(-2.0))) / (12.0 * h)
    };
    let dg: Vec<_> = (0..3).map(slope).collect();
    let lowered = SVector::<f64, 3>::from_fn(|l, _| {
        let mut sum = 0.0;
        for i in 0..3 {
            for j in 0..3 {
                sum += 0.5 * (dg[i][(l, j)] + dg[j][(l, i)] - dg[l][(i, j)]) * qdot[i] * qdot[j];
            }
        }
        sum
    });
    let inverse = g.try_inverse().unwrap();
    let z: SVector<f64, 12> = FRAME_STATE.into();
    let p_dot = z.fixed_rows::<3>(9).into_owned();
    let first: f64 = (0..3).map(|i| z[6 + i] * qdot[i]).sum();
    let expected = first + 0.5 * p_dot.dot(&(inverse * p_dot)) - p_dot.dot(&(inverse * lowered));
    let defect = (Frame.hamiltonian(&z) - expected).abs();
    assert!(defect < 1e-11, "difference formula of order 4: {defect:e}");
}

#[test]
fn velocities_are_derivatives_of_points() {
    let (q, qdot, h) = ([1.2, 0.4, -0.8], [0.3, -0.2, 0.5], 1e-3);
    let at = |s: f64| {
        Frame
            .embed(&[
                q[0] + s * h * qdot[0],
                q[1] + s * h * qdot[1],
                q[2] + s * h * qdot[2],
            ])
            .unwrap()
    };
    let difference = (at(1.0) - at(-1.0)) * faer::Scale(8.0) - (at(2.0) - at(-2.0));
    let defect = (difference * faer::Scale(1.0 / (12.0 * h))
        - Frame.embed_velocity(&q, &qdot).unwrap())
    .norm_l2();
    assert!(defect < 1e-12, "{defect:e}");
    let manifold = Stiefel::new(3, 2).unwrap();
    let (s, v) = (
        Frame.embed(&q).unwrap(),
        Frame.embed_velocity(&q, &qdot).unwrap(),
    );
    manifold.check_point("S", s.as_ref(), 1e-15).unwrap();
    manifold
        .check_tangent("V", s.as_ref(), v.as_ref(), 1e-15)
        .unwrap();
}

#[test]
fn momenta_and_derivatives_are_inverse_to_each_other() {
    let z: SVector<f64, 12> = FRAME_STATE.into();
    let curve = Frame.derivatives(&z);
    let d = |i: usize| &curve.as_slice()[3 * i..3 * i + 3];
    let momenta = Frame.momenta(d(0), d(1), d(2), d(3)).unwrap();
    let defect = (momenta - z.fixed_rows::<6>(6)).amax();
    assert!(defect < 1e-14, "{defect:e}");
}

#[test]
fn momenta_follow_the_christoffel_formula() {
    // p_qdot = g (qddot + Gamma), p_q,i = 2 Gamma^k_ij qdot^j p_qdot,k - d/dt p_qdot,i, on the sphere by hand.
    let [q, v, a, b]: [[f64; 2]; 4] = [[1.1, 0.4], [0.3, -0.2], [0.5, 0.7], [-0.4, 0.9]];
    let (s, c) = q[0].sin_cos();
    let cot = c / s;
    let p = [
        a[0] - s * c * v[1] * v[1],
        s * s * (a[1] + 2.0 * cot * v[0] * v[1]),
    ];
    let rate = [
        b[0] - (c * c - s * s) * v[0] * v[1] * v[1] - 2.0 * s * c * v[1] * a[1],
        2.0 * s * c * v[0] * (a[1] + 2.0 * cot * v[0] * v[1])
            + s * s
                * (b[1] - 2.0 / (s * s) * v[0] * v[0] * v[1]
                    + 2.0 * cot * (a[0] * v[1] + v[0] * a[1])),
    ];
    let expected = [
        2.0 * cot * v[1] * p[1] - rate[0],
        2.0 * (-s * c * v[1] * p[0] + cot * v[0] * p[1]) - rate[1],
        p[0],
        p[1],
    ];
    let momenta = Sphere.momenta(&q, &v, &a, &b).unwrap();
    let defect = (momenta - SVector::from(expected)).amax();
    assert!(defect < 1e-14, "{defect:e}");
}

#[test]
fn wrong_lengths_are_typed_errors() {
    let refused = |result: stiefel_rs::Result<()>| matches!(result, Err(Error::Shape { .. }));
    assert!(refused(Sphere.embed(&[1.0]).map(|_| ())));
    assert!(refused(Frame.embed(&[]).map(|_| ())));
    assert!(refused(
        Sphere.embed_velocity(&[1.0, 2.0], &[1.0]).map(|_| ())
    ));
    assert!(refused(
        Sphere
            .momenta(&[1.0, 2.0], &[0.0; 2], &[0.0], &[0.0; 2])
            .map(|_| ())
    ));
    assert!(Sphere.check("q", &[]).is_err());
    assert!(matches!(
        Sphere.embed(&[-1.0, 0.0]),
        Err(Error::OutsideChart { .. })
    ));
}
