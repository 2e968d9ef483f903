//! The charts: Hamiltonians, momenta, discretization maps, their lifts and integrators, shooting.

#[path = "common/paper.rs"]
mod paper;

use faer::Mat;
use nalgebra::{SMatrix, SVector};
use stiefel_rs::chart::discretization::{Blocks, cotangent_lift};
use stiefel_rs::chart::{
    Chart, DiscretizationMap, Frame, LinearMap, ShootingOptions, Sphere, integrate,
    integrate_with_tangent, reference, shoot,
};
use stiefel_rs::manifold::{Stiefel, covariant};
use stiefel_rs::newton::NewtonOptions;
use stiefel_rs::{Error, Interrupt, StopReason};

use std::f64::consts::{FRAC_PI_2, PI};

const SPHERE_STATE: [f64; 8] = [1.1, 0.4, 0.3, -0.2, 0.7, -0.5, 0.9, 0.35];
const FRAME_STATE: [f64; 12] = [
    1.2, 0.4, -0.8, 0.3, -0.2, 0.5, 0.7, -0.5, 0.2, 0.9, 0.35, -0.6,
];

/// A third discretization map, on no other footing than the crate's own: nonlinear in position and velocity.
///
/// `R_d(x, v) = (x - v/3, x + 2v/3 + c (x_i + x_{i+1}) v_i^2)`, componentwise with the next component.
struct Curved(f64);

impl<const X: usize> DiscretizationMap<X> for Curved {
    fn map(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> [SVector<f64, X>; 2] {
        let bend = SVector::from_fn(|i, _| self.0 * (x[i] + x[(i + 1) % X]) * v[i] * v[i]);
        [x - v / 3.0, x + v * (2.0 / 3.0) + bend]
    }

    fn jacobian(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> Blocks<X> {
        let identity = SMatrix::<f64, X, X>::identity();
        let (mut dx, mut dv) = (identity, identity * (2.0 / 3.0));
        for i in 0..X {
            dx[(i, i)] += self.0 * v[i] * v[i];
            dx[(i, (i + 1) % X)] += self.0 * v[i] * v[i];
            dv[(i, i)] += 2.0 * self.0 * (x[i] + x[(i + 1) % X]) * v[i];
        }
        [[identity, identity / -3.0], [dx, dv]]
    }

    fn second_derivative(
        &self,
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        l: &[SVector<f64, X>; 2],
    ) -> Blocks<X> {
        let (mut xv, mut vv) = (SMatrix::<f64, X, X>::zeros(), SMatrix::<f64, X, X>::zeros());
        for i in 0..X {
            let next = (i + 1) % X;
            xv[(i, i)] += 2.0 * self.0 * v[i] * l[1][i];
            xv[(next, i)] += 2.0 * self.0 * v[i] * l[1][i];
            vv[(i, i)] += 2.0 * self.0 * (x[i] + x[next]) * l[1][i];
        }
        [[SMatrix::zeros(), xv], [xv.transpose(), vv]]
    }
}

/// `J^T Omega J - Omega`, largest entry.
fn symplectic_defect<const Z: usize>(jacobian: &SMatrix<f64, Z, Z>) -> f64 {
    let half = Z / 2;
    let omega = SMatrix::<f64, Z, Z>::from_fn(|i, j| {
        if j == i + half {
            1.0
        } else if i == j + half {
            -1.0
        } else {
            0.0
        }
    });
    (jacobian.transpose() * omega * jacobian - omega).amax()
}

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
        // Sixth order: error h^6 and round-off eps / h, both below 1e-12.
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
fn sphere_hamiltonian_is_the_papers() {
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

/// `H = p_q . qdot + p_qdot . a - |a + Gamma|_g^2 / 2` with the acceleration of largest value, metric and Christoffel
/// symbols taken from the embedding by differences: independent of the closed form.
#[test]
fn frame_hamiltonian_follows_from_the_metric() {
    let [q, qdot]: [[f64; 3]; 2] = [[1.2, 0.4, -0.8], [0.3, -0.2, 0.5]];
    let metric = |q: &[f64; 3]| {
        let point = Frame.embed(q);
        let manifold = Stiefel::of("S", point.as_ref()).unwrap();
        let unit = |i: usize| {
            let mut e = [0.0; 3];
            e[i] = 1.0;
            Frame.embed_velocity(q, &e)
        };
        SMatrix::<f64, 3, 3>::from_fn(|i, j| {
            manifold.inner(point.as_ref(), unit(i).as_ref(), unit(j).as_ref())
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
        Frame.embed(&[
            q[0] + s * h * qdot[0],
            q[1] + s * h * qdot[1],
            q[2] + s * h * qdot[2],
        ])
    };
    let difference = (at(1.0) - at(-1.0)) * faer::Scale(8.0) - (at(2.0) - at(-2.0));
    let defect =
        (difference * faer::Scale(1.0 / (12.0 * h)) - Frame.embed_velocity(&q, &qdot)).norm_l2();
    assert!(defect < 1e-12, "{defect:e}");
    let manifold = Stiefel::new(3, 2).unwrap();
    let (s, v) = (Frame.embed(&q), Frame.embed_velocity(&q, &qdot));
    manifold.check_point("S", s.as_ref(), 1e-15).unwrap();
    manifold
        .check_tangent("V", s.as_ref(), v.as_ref(), 1e-15)
        .unwrap();
}

/// Covariant acceleration and jerk of a chart curve, from its momenta's own flow.
fn covariant_derivatives<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z: &SVector<f64, Z>,
) -> [Mat<f64>; 4] {
    let d = X / 2;
    let h = 2e-3;
    let t: Vec<f64> = (-4..=4).map(|i| f64::from(i) * h).collect();
    let states = reference(chart, z, &t, Interrupt::NEVER).unwrap();
    let points: Vec<Mat<f64>> = states
        .iter()
        .map(|z| chart.embed(&z.as_slice()[..d]))
        .collect();
    let combine = |weights: [f64; 4], sign: f64, centre: f64, scale: f64| {
        let mut sum = &points[4] * faer::Scale(centre);
        for (j, w) in weights.iter().enumerate() {
            sum += (&points[5 + j] + &points[3 - j] * faer::Scale(sign)) * faer::Scale(*w);
        }
        sum * faer::Scale(scale)
    };
    // Central differences of orders 8, 8 and 6.
    let d1 = combine(
        [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0],
        -1.0,
        0.0,
        1.0 / h,
    );
    let d2 = combine(
        [8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0],
        1.0,
        -205.0 / 72.0,
        1.0 / (h * h),
    );
    let d3 = combine(
        [-61.0 / 30.0, 169.0 / 120.0, -3.0 / 10.0, 7.0 / 240.0],
        -1.0,
        0.0,
        1.0 / (h * h * h),
    );
    let s = points[4].clone();
    let a = covariant::acceleration(s.as_ref(), d1.as_ref(), d2.as_ref());
    let j = covariant::jerk(s.as_ref(), d1.as_ref(), d2.as_ref(), d3.as_ref());
    [s, d1, a, j]
}

fn json_matrix(value: &serde_json::Value) -> Mat<f64> {
    let rows = value.as_array().unwrap();
    Mat::from_fn(rows.len(), rows[0].as_array().unwrap().len(), |i, j| {
        rows[i][j].as_f64().unwrap()
    })
}

fn cubics() -> Vec<serde_json::Value> {
    serde_json::from_str(include_str!("data/cubics.json")).unwrap()
}

fn check_reference<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    z0: &SVector<f64, Z>,
    name: &str,
) {
    let d = X / 2;
    let data = cubics()
        .into_iter()
        .find(|case| case["name"] == name)
        .unwrap();
    let exact = reference(chart, z0, &[0.5, 1.0, 0.0], Interrupt::NEVER).unwrap();
    for (z, time) in exact.iter().zip([Some("0.5"), Some("1.0"), None]) {
        let values = time.map_or(&data["initial"], |t| &data["at"][t]);
        let expected = |key: &str| json_matrix(&values[key]);
        let (q, qdot) = (&z.as_slice()[..d], &z.as_slice()[d..X]);
        let position = (chart.embed(q) - expected("point")).norm_l2();
        let velocity = (chart.embed_velocity(q, qdot) - expected("velocity")).norm_l2();
        assert!(
            position < 1e-14 && velocity < 1e-14,
            "{name} at {time:?}: {position:e}, {velocity:e}"
        );
        // The differences cost digits; they still tell covariant from coordinate derivatives.
        let [_, _, a, j] = covariant_derivatives(chart, z);
        let acceleration = (a - expected("acceleration")).norm_l2();
        let jerk = (j - expected("jerk")).norm_l2();
        assert!(
            acceleration < 1e-8 && jerk < 1e-5,
            "{name} at {time:?}: {acceleration:e}, {jerk:e}"
        );
    }
}

#[test]
fn reference_meets_40_digit_data() {
    check_reference(&Sphere, &paper::sphere(), "paper-sphere");
    check_reference(&Frame, &paper::frame(), "paper-stiefel-3-2");
}

#[test]
fn reference_runs_backwards_and_in_any_order() {
    let z0 = paper::frame();
    let there = reference(&Frame, &z0, &[1.0, 0.25, -0.5, 0.75], Interrupt::NEVER).unwrap();
    let back = reference(&Frame, &there[0], &[-1.0, -0.75], Interrupt::NEVER).unwrap();
    assert!((back[0] - z0).amax() < 1e-13, "{:e}", (back[0] - z0).amax());
    assert!(
        (back[1] - there[1]).amax() < 1e-13,
        "{:e}",
        (back[1] - there[1]).amax()
    );
    let forward = reference(&Frame, &there[2], &[0.5], Interrupt::NEVER).unwrap();
    assert!(
        (forward[0] - z0).amax() < 1e-13,
        "{:e}",
        (forward[0] - z0).amax()
    );
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

/// The lift of a map with numeric derivative: `DR_d^T (-p_0, p_1) = (pdot, p)` and symplectic.
#[test]
fn cotangent_lift_is_symplectic() {
    let lift = |map: &dyn Fn(&SVector<f64, 8>) -> SVector<f64, 8>, at: &SVector<f64, 8>| {
        let h = 1e-4;
        SMatrix::<f64, 8, 8>::from_columns(&std::array::from_fn::<_, 8, _>(|i| {
            let moved = |s: f64| {
                let mut moved = *at;
                moved[i] += s * h;
                map(&moved)
            };
            ((moved(1.0) - moved(-1.0)) * 8.0 - (moved(2.0) - moved(-2.0))) / (12.0 * h)
        }))
    };
    let at: SVector<f64, 8> = [0.3, -0.4, 0.7, 0.2, 0.05, -0.1, 0.3, 0.6].into();
    fn apply(map: &impl DiscretizationMap<2>, u: &SVector<f64, 8>) -> SVector<f64, 8> {
        let part = |i: usize| u.fixed_rows::<2>(i).into_owned();
        let [(x0, p0), (x1, p1)] =
            cotangent_lift(map, &part(0), &part(2), &part(4), &part(6)).unwrap();
        SVector::from_column_slice(
            &[x0.as_slice(), p0.as_slice(), x1.as_slice(), p1.as_slice()].concat(),
        )
    }
    // Tangent bundle form d(pdot) ^ dx + dp ^ d(xdot); product form dp_1 ^ dx_1 - dp_0 ^ dx_0.
    let form = |pairs: [(usize, usize, f64); 2]| {
        let mut omega = SMatrix::<f64, 8, 8>::zeros();
        for (x, p, sign) in pairs {
            for i in 0..2 {
                omega[(x + i, p + i)] = sign;
                omega[(p + i, x + i)] = -sign;
            }
        }
        omega
    };
    let (source, target) = (
        form([(0, 6, 1.0), (4, 2, 1.0)]),
        form([(4, 6, 1.0), (0, 2, -1.0)]),
    );
    type Lift<'a> = &'a dyn Fn(&SVector<f64, 8>) -> SVector<f64, 8>;
    let maps: [Lift<'_>; 3] = [
        &|u| apply(&LinearMap::INITIAL_POINT, u),
        &|u| apply(&LinearMap::MIDPOINT, u),
        &|u| apply(&Curved(0.3), u),
    ];
    for (name, map) in ["initial point", "mid-point", "curved"]
        .into_iter()
        .zip(maps)
    {
        let jacobian = lift(map, &at);
        let defect = (jacobian.transpose() * target * jacobian - source).amax();
        assert!(
            defect < 1e-10,
            "{name}: {defect:e} (difference formula of order 4)"
        );
    }
}

#[test]
fn cotangent_lift_of_the_papers_maps() {
    // Mid-point: p = (p_0 + p_1)/2, pdot = p_1 - p_0. Initial point: p = p_1, pdot = p_1 - p_0.
    let [x, p, v, rate] =
        [[0.3, -0.4], [0.7, 0.2], [0.05, -0.1], [0.3, 0.6]].map(SVector::<f64, 2>::from);
    let [(x0, p0), (x1, p1)] = cotangent_lift(&LinearMap::MIDPOINT, &x, &p, &v, &rate).unwrap();
    let defect = (x0 - (x - v / 2.0)).amax() + (x1 - (x + v / 2.0)).amax();
    assert!(defect + (p0 - (p - rate / 2.0)).amax() + (p1 - (p + rate / 2.0)).amax() < 1e-15);
    let [(x0, p0), (x1, p1)] =
        cotangent_lift(&LinearMap::INITIAL_POINT, &x, &p, &v, &rate).unwrap();
    assert!(
        (x0 - x).amax() + (x1 - x - v).amax() + (p1 - p).amax() + (p0 - p + rate).amax() < 1e-15
    );
}

fn check_step<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z: &SVector<f64, Z>,
    name: &str,
) {
    let (_, jacobian) = integrate_with_tangent(chart, map, z, 1, 0.05, Interrupt::NEVER).unwrap();
    let defect = symplectic_defect(&jacobian);
    assert!(defect < 1e-12, "{name}: J^T Omega J - Omega = {defect:e}");
    // The tangent is the derivative of the step, by differences of order 4 with round-off eps / h.
    let h = 1e-3;
    for i in 0..Z {
        let moved = |s: f64| {
            let mut moved = *z;
            moved[i] += s * h;
            integrate(chart, map, &moved, 1, 0.05, Interrupt::NEVER).unwrap()[1]
        };
        let column = ((moved(1.0) - moved(-1.0)) * 8.0 - (moved(2.0) - moved(-2.0))) / (12.0 * h);
        let defect = (column - jacobian.column(i)).amax();
        assert!(defect < 1e-10, "{name}, column {i}: {defect:e}");
    }
}

#[test]
fn steps_are_symplectic_with_exact_tangents() {
    let (s, f) = (SPHERE_STATE.into(), FRAME_STATE.into());
    check_step(
        &Sphere,
        &LinearMap::INITIAL_POINT,
        &s,
        "sphere, initial point",
    );
    check_step(&Sphere, &LinearMap::MIDPOINT, &s, "sphere, mid-point");
    check_step(&Sphere, &Curved(0.3), &s, "sphere, a user's map");
    check_step(
        &Frame,
        &LinearMap::INITIAL_POINT,
        &f,
        "frame, initial point",
    );
    check_step(&Frame, &LinearMap::MIDPOINT, &f, "frame, mid-point");
    check_step(&Frame, &Curved(0.3), &f, "frame, a user's map");
}

#[test]
fn initial_point_step_is_the_papers_formula() {
    // q_1 = q_0 + h H_p(q_0, p_1), p_1 = p_0 - h H_q(q_0, p_1).
    let (z0, h): (SVector<f64, 12>, f64) = (FRAME_STATE.into(), 0.05);
    let z1 = integrate(
        &Frame,
        &LinearMap::INITIAL_POINT,
        &z0,
        1,
        h,
        Interrupt::NEVER,
    )
    .unwrap()[1];
    let mixed = SVector::<f64, 12>::from_fn(|i, _| if i < 6 { z0[i] } else { z1[i] });
    let gradient = Frame.gradient(&mixed);
    for i in 0..6 {
        let (position, momentum) = (
            z1[i] - z0[i] - h * gradient[6 + i],
            z1[6 + i] - z0[6 + i] + h * gradient[i],
        );
        assert!(
            position.abs() < 1e-15 && momentum.abs() < 1e-15,
            "{i}: {position:e}, {momentum:e}"
        );
    }
}

#[test]
fn midpoint_step_is_the_implicit_midpoint_rule() {
    let (z0, h): (SVector<f64, 8>, f64) = (SPHERE_STATE.into(), 0.05);
    let z1 = integrate(&Sphere, &LinearMap::MIDPOINT, &z0, 1, h, Interrupt::NEVER).unwrap()[1];
    let gradient = Sphere.gradient(&((z0 + z1) / 2.0));
    for i in 0..4 {
        let (position, momentum) = (
            z1[i] - z0[i] - h * gradient[4 + i],
            z1[4 + i] - z0[4 + i] + h * gradient[i],
        );
        assert!(
            position.abs() < 1e-15 && momentum.abs() < 1e-15,
            "{i}: {position:e}, {momentum:e}"
        );
    }
}

/// Fitted slope of log error against log h over five halvings, least squares.
fn order<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z0: &SVector<f64, Z>,
) -> f64 {
    let exact = reference(chart, z0, &[1.0], Interrupt::NEVER).unwrap()[0];
    let (mut sx, mut sy, mut sxx, mut sxy) = (0.0, 0.0, 0.0, 0.0);
    for level in 0..6 {
        let steps = 20 << level;
        let end = integrate(chart, map, z0, steps, 1.0, Interrupt::NEVER).unwrap()[steps];
        let (x, y) = (-(steps as f64).ln(), (end - exact).norm().ln());
        (sx, sy, sxx, sxy) = (sx + x, sy + y, sxx + x * x, sxy + x * y);
    }
    (6.0 * sxy - sx * sy) / (6.0 * sxx - sx * sx)
}

#[test]
fn measured_orders_are_one_and_two() {
    let (s, f) = (paper::sphere(), paper::frame());
    let orders = [
        (order(&Sphere, &LinearMap::INITIAL_POINT, &s), 1.0),
        (order(&Frame, &LinearMap::INITIAL_POINT, &f), 1.0),
        (order(&Sphere, &LinearMap::MIDPOINT, &s), 2.0),
        (order(&Frame, &LinearMap::MIDPOINT, &f), 2.0),
        (order(&Frame, &Curved(0.3), &f), 1.0),
    ];
    for (measured, expected) in orders {
        assert!(
            (measured - expected).abs() < 0.2,
            "measured order {measured:.3}, expected {expected}"
        );
    }
}

#[test]
fn midpoint_step_is_symmetric_in_time() {
    let z0 = paper::sphere();
    let there = integrate(
        &Sphere,
        &LinearMap::MIDPOINT,
        &z0,
        50,
        1.0,
        Interrupt::NEVER,
    )
    .unwrap()[50];
    let back = integrate(
        &Sphere,
        &LinearMap::MIDPOINT,
        &there,
        50,
        -1.0,
        Interrupt::NEVER,
    )
    .unwrap()[50];
    assert!((back - z0).amax() < 1e-13, "{:e}", (back - z0).amax());
}

#[test]
fn cyclic_momenta_are_conserved_to_round_off() {
    // phi and psi are cyclic: their momenta are linear invariants, which both maps keep exactly.
    let z0 = paper::frame();
    for map in [LinearMap::INITIAL_POINT, LinearMap::MIDPOINT] {
        for z in integrate(&Frame, &map, &z0, 1000, 1.0, Interrupt::NEVER).unwrap() {
            let drift = (z[7] - z0[7]).abs().max((z[8] - z0[8]).abs());
            assert!(drift < 1e-12, "{map:?}: {drift:e}");
        }
    }
}

fn check_shooting<const X: usize, const Z: usize>(
    chart: &impl Chart<X, Z>,
    map: &impl DiscretizationMap<X>,
    z0: &SVector<f64, Z>,
) {
    let exact = reference(chart, z0, &[1.0], Interrupt::NEVER).unwrap()[0];
    let (x0, x1) = (
        z0.fixed_rows::<X>(0).into_owned(),
        exact.fixed_rows::<X>(0).into_owned(),
    );
    let found = shoot(chart, map, &x0, &x1, 40, &ShootingOptions::default()).unwrap();
    assert!(found.report.converged && found.report.reason == StopReason::Converged);
    assert!(
        found.report.iterations <= 5,
        "{} steps",
        found.report.iterations
    );
    let (first, last) = (found.trajectory[0], found.trajectory[40]);
    assert_eq!(first.fixed_rows::<X>(0), x0, "the start is exact");
    let defect = (last.fixed_rows::<X>(0) - x1).norm();
    assert!(defect <= 1e-12, "end defect {defect:e}");
    // Starting from the answer takes no step.
    let again = ShootingOptions {
        guess: Some(found.momenta),
        ..ShootingOptions::default()
    };
    assert_eq!(
        shoot(chart, map, &x0, &x1, 40, &again)
            .unwrap()
            .report
            .iterations,
        0
    );
}

#[test]
fn shooting_meets_both_ends_for_any_map() {
    check_shooting(&Sphere, &LinearMap::INITIAL_POINT, &paper::sphere());
    check_shooting(&Sphere, &LinearMap::MIDPOINT, &paper::sphere());
    check_shooting(&Sphere, &Curved(0.2), &paper::sphere());
    check_shooting(&Frame, &LinearMap::INITIAL_POINT, &paper::frame());
    check_shooting(&Frame, &LinearMap::MIDPOINT, &paper::frame());
    check_shooting(&Frame, &Curved(0.2), &paper::frame());
}

#[test]
fn bad_input_is_a_typed_error() {
    let z0 = paper::sphere();
    let map = LinearMap::MIDPOINT;
    let run =
        |z: &SVector<f64, 8>, steps, t| integrate(&Sphere, &map, z, steps, t, Interrupt::NEVER);
    assert!(matches!(
        run(&z0, 0, 1.0),
        Err(Error::InvalidArgument { name: "steps", .. })
    ));
    assert!(matches!(
        run(&z0, 10, f64::NAN),
        Err(Error::NonFinite { name: "t_end", .. })
    ));
    assert!(matches!(
        run(&z0, usize::MAX, 1.0),
        Err(Error::InvalidArgument { name: "steps", .. })
    ));
    let mut bad = z0;
    bad[5] = f64::INFINITY;
    assert!(matches!(
        run(&bad, 10, 1.0),
        Err(Error::NonFinite { index: 5, .. })
    ));
    for theta in [0.0, -0.3, PI, 4.0] {
        bad = z0;
        bad[0] = theta;
        assert!(
            matches!(run(&bad, 10, 1.0), Err(Error::OutsideChart { value, .. }) if value == theta)
        );
    }
    // One step far too long for its equations, and a curve that runs out of the chart.
    bad = z0;
    bad[2] = 40.0;
    assert!(matches!(
        run(&bad, 4, 1.0),
        Err(Error::OutsideChart { .. } | Error::NoConvergence { .. })
    ));
    // Along a meridian the curve runs through the pole itself.
    let meridian = SVector::from([FRAC_PI_2, PI, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let out = reference(&Sphere, &meridian, &[1.0], Interrupt::NEVER);
    assert!(
        matches!(out, Err(Error::OutsideChart { value, .. }) if value >= PI),
        "{out:?}"
    );
    assert!(matches!(
        reference(&Sphere, &z0, &[0.1, f64::NAN], Interrupt::NEVER),
        Err(Error::NonFinite { index: 1, .. })
    ));
    assert_eq!(
        reference(&Sphere, &z0, &[], Interrupt::NEVER)
            .unwrap()
            .len(),
        0
    );
}

#[test]
fn shooting_reports_why_it_stopped() {
    let z0 = paper::sphere();
    let x0 = z0.fixed_rows::<4>(0).into_owned();
    let x1 = SVector::from([1.2, 3.5, 0.4, 0.1]);
    let run = |newton: NewtonOptions<'_>| {
        let options = ShootingOptions {
            newton,
            ..ShootingOptions::default()
        };
        shoot(&Sphere, &LinearMap::MIDPOINT, &x0, &x1, 20, &options)
    };
    let never = run(NewtonOptions {
        max_iterations: 0,
        ..NewtonOptions::default()
    });
    match never {
        Err(Error::NoConvergence { report, .. }) => {
            assert!(!report.converged && report.iterations == 0 && report.residual > 0.0);
            assert_eq!(report.reason, StopReason::MaxIterations);
        }
        other => panic!("expected NoConvergence, found {other:?}"),
    }
    let exact = run(NewtonOptions {
        tolerance: 0.0,
        ..NewtonOptions::default()
    });
    match exact {
        // Round-off sets a floor: either it is hit exactly, or the report says that nothing lowers it any more.
        Ok(found) => assert_eq!(found.report.residual, 0.0),
        Err(Error::NoConvergence { report, .. }) => assert!(report.residual < 1e-13, "{report}"),
        other => panic!("{other:?}"),
    }
    let stop = || true;
    let interrupted = run(NewtonOptions {
        interrupt: Interrupt::new(&stop),
        ..NewtonOptions::default()
    });
    assert!(matches!(interrupted, Err(Error::Interrupted { .. })));
    let negative = run(NewtonOptions {
        tolerance: -1.0,
        ..NewtonOptions::default()
    });
    assert!(matches!(
        negative,
        Err(Error::InvalidArgument {
            name: "tolerance",
            ..
        })
    ));
}
