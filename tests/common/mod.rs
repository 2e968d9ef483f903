//! Generators of points, vectors and rotations, and assertions, shared by the test binaries.
#![allow(dead_code)] // each binary uses a part

use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

use faer::{Mat, MatRef, Scale};
use stiefel_rs::cubic::IntegrationOptions;
use stiefel_rs::{
    Curve, GeometricCubic, Interrupt, QuasiGeodesic, RiemannianCubic, orthogonal_log, skew_exp,
};

/// Machine epsilon, twice the unit round-off of `f64`.
pub const EPS: f64 = f64::EPSILON;

/// `(n, k)`: the sphere, the proper Stiefel manifold, `n < 2k`, the orthogonal group, a tall shape that is computed in
/// fewer dimensions, and shapes at the boundaries of the special cases (`n = 4k`, `n = 2k`, `n = k + 1`).
pub const SIZES: [(usize, usize); 14] = [
    (3, 1),
    (4, 2),
    (5, 3),
    (6, 6),
    (20, 4),
    (2, 1),
    (1, 1),
    (3, 2),
    (3, 3),
    (6, 3),
    (8, 2),
    (20, 2),
    (7, 6),
    (30, 12),
];

/// A seeded generator: splitmix64 (Steele, Lea, Flood 2014) and the Box-Muller transform.
pub struct Rng {
    state: u64,
}

impl Rng {
    pub fn new(seed: u64) -> Self {
        Rng {
            state: seed.wrapping_mul(0x2545_f491_4f6c_dd1d),
        }
    }

    pub fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `(0, 1)`.
    pub fn uniform(&mut self) -> f64 {
        ((self.next_u64() >> 11) as f64 + 0.5) * 2.0_f64.powi(-53)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (2.0 * PI * self.uniform()).cos()
    }
}

pub fn gaussian(rows: usize, cols: usize, rng: &mut Rng) -> Mat<f64> {
    Mat::from_fn(rows, cols, |_, _| rng.normal())
}

/// Skew-symmetric of the given Frobenius norm (zero for `m = 1`).
pub fn random_skew(m: usize, norm: f64, rng: &mut Rng) -> Mat<f64> {
    let g = gaussian(m, m, rng);
    let skew = &g - g.transpose();
    let size = frobenius(skew.as_ref());
    if size == 0.0 {
        skew
    } else {
        skew * Scale(1.0 / size) * Scale(norm)
    }
}

pub fn random_orthogonal(m: usize, rng: &mut Rng) -> Mat<f64> {
    gaussian(m, m, rng).qr().compute_thin_Q()
}

pub fn random_rotation(m: usize, rng: &mut Rng) -> Mat<f64> {
    let mut q = random_orthogonal(m, rng);
    if q.determinant() < 0.0 {
        negate_column(&mut q, m - 1);
    }
    q
}

pub fn negate_column(a: &mut Mat<f64>, j: usize) {
    for i in 0..a.nrows() {
        a[(i, j)] = -a[(i, j)];
    }
}

/// `blockdiag(theta_i J)`, padded with zeros to size `m`.
pub fn plane_generators(angles: &[f64], m: usize) -> Mat<f64> {
    assert!(
        2 * angles.len() <= m,
        "{} planes do not fit in {m} dimensions",
        angles.len()
    );
    let mut out = Mat::zeros(m, m);
    for (l, theta) in angles.iter().enumerate() {
        out[(2 * l + 1, 2 * l)] = *theta;
        out[(2 * l, 2 * l + 1)] = -theta;
    }
    out
}

/// `blockdiag(rotation by theta_i)`, padded with ones on the diagonal to size `m`.
pub fn plane_rotations(angles: &[f64], m: usize) -> Mat<f64> {
    let mut out = Mat::identity(m, m);
    for (l, theta) in angles.iter().enumerate() {
        let (sin, cos) = theta.sin_cos();
        out[(2 * l, 2 * l)] = cos;
        out[(2 * l + 1, 2 * l + 1)] = cos;
        out[(2 * l + 1, 2 * l)] = sin;
        out[(2 * l, 2 * l + 1)] = -sin;
    }
    out
}

/// `V B V^T`.
pub fn conjugated(v: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    v * b * v.transpose()
}

/// A rotation with the given angles in the planes of a random orthogonal basis, and the identity elsewhere.
pub fn rotation_with_angles(angles: &[f64], m: usize, rng: &mut Rng) -> Mat<f64> {
    conjugated(&random_orthogonal(m, rng), &plane_rotations(angles, m))
}

/// `i -> i + 1 mod m`, of determinant `(-1)^(m-1)`.
pub fn cyclic_permutation(m: usize) -> Mat<f64> {
    Mat::from_fn(m, m, |i, j| f64::from(u8::from(i == (j + 1) % m)))
}

pub fn random_point(n: usize, k: usize, rng: &mut Rng) -> Mat<f64> {
    gaussian(n, k, rng).qr().compute_thin_Q()
}

/// A point that can be joined to `s`: for `k = n` in the same component.
pub fn random_partner(s: &Mat<f64>, rng: &mut Rng) -> Mat<f64> {
    let (n, k) = s.shape();
    if n == k {
        s * random_rotation(k, rng)
    } else {
        random_point(n, k, rng)
    }
}

/// A tangent vector at `s` of the given canonical norm (zero if the dimension is 0).
pub fn random_tangent(s: &Mat<f64>, norm: f64, rng: &mut Rng) -> Mat<f64> {
    let (n, k) = s.shape();
    let omega = random_skew(k, k as f64, rng);
    let g = gaussian(n, k, rng);
    let normal = if n == k {
        Mat::zeros(n, k)
    } else {
        project_off(s, &project_off(s, &g))
    };
    let size = frobenius(normal.as_ref()).hypot(frobenius(omega.as_ref()) * 0.5_f64.sqrt());
    let v = normal + s * omega;
    if size == 0.0 {
        v
    } else {
        v * Scale(norm / size)
    }
}

/// `(S0 U cos + Q sin) U^T R` with random `U`, `Q`, and a rotation `R` away from the boundary of the logarithm's
/// domain.
pub fn partner_at_angles(s0: &Mat<f64>, angles: &[f64], rng: &mut Rng) -> Mat<f64> {
    let (n, k) = s0.shape();
    let g = gaussian(n, k, rng);
    let q = project_off(s0, &project_off(s0, &g)).qr().compute_thin_Q();
    let u = random_rotation(k, rng);
    let diagonal =
        |f: fn(f64) -> f64| Mat::from_fn(k, k, |i, j| if i == j { f(angles[i]) } else { 0.0 });
    let turned = s0 * &u * diagonal(f64::cos) + q * diagonal(f64::sin);
    turned * u.transpose() * skew_exp(random_skew(k, 1.0, rng).as_ref()).unwrap()
}

/// End points at a given distance and end velocities of a given norm.
pub struct Boundary {
    pub s0: Mat<f64>,
    pub v0: Mat<f64>,
    pub s1: Mat<f64>,
    pub v1: Mat<f64>,
}

impl Boundary {
    pub fn random((n, k): (usize, usize), distance: f64, speed: f64, rng: &mut Rng) -> Self {
        let s0 = random_point(n, k, rng);
        let s1 = retract(&s0, &random_tangent(&s0, distance, rng));
        let (v0, v1) = (
            random_tangent(&s0, speed, rng),
            random_tangent(&s1, speed, rng),
        );
        Boundary { s0, v0, s1, v1 }
    }

    pub fn curve(&self) -> GeometricCubic {
        GeometricCubic::from_boundary(
            self.s0.as_ref(),
            self.v0.as_ref(),
            self.s1.as_ref(),
            self.v1.as_ref(),
        )
        .unwrap_or_else(|e| panic!("{:?}: {e}", self.s0.shape()))
    }

    pub fn all(&self) -> Vec<&Mat<f64>> {
        vec![&self.s0, &self.v0, &self.s1, &self.v1]
    }

    /// From all four matrices, in the order of [`Boundary::all`].
    pub fn of(all: &[Mat<f64>]) -> Self {
        let [s0, v0, s1, v1] = [0, 1, 2, 3].map(|i| all[i].clone());
        Boundary { s0, v0, s1, v1 }
    }

    pub fn mapped(&self, f: impl Fn(&Mat<f64>) -> Mat<f64>) -> Self {
        Boundary::of(&self.all().into_iter().map(f).collect::<Vec<_>>())
    }
}

/// The retraction of the manifold.
pub fn retract(s: &Mat<f64>, v: &Mat<f64>) -> Mat<f64> {
    QuasiGeodesic::from_velocity(s.as_ref(), v.as_ref())
        .unwrap()
        .point(1.0)
        .unwrap()
}

pub fn through(points: &[Mat<f64>; 4]) -> GeometricCubic {
    GeometricCubic::from_control_points(points.each_ref().map(|p| p.as_ref())).unwrap()
}

/// `(I - S S^T) G`.
pub fn project_off(s: &Mat<f64>, g: &Mat<f64>) -> Mat<f64> {
    g - s * (s.transpose() * g)
}

pub fn identity(m: usize) -> Mat<f64> {
    Mat::identity(m, m)
}

/// Frobenius norm without overflow or underflow.
pub fn frobenius(a: MatRef<'_, f64>) -> f64 {
    let largest = largest_entry(a);
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    let sum: f64 = a
        .col_iter()
        .flat_map(|c| c.iter())
        .map(|x| (x / largest).powi(2))
        .sum();
    largest * sum.sqrt()
}

pub fn largest_entry(a: MatRef<'_, f64>) -> f64 {
    // Not `f64::max`, which drops NaN: NaN must fail every bound.
    a.col_iter()
        .flat_map(|c| c.iter())
        .fold(0.0, |s, x| if x.abs() <= s { s } else { x.abs() })
}

/// Largest singular value.
pub fn spectral(a: MatRef<'_, f64>) -> f64 {
    if a.nrows() == 0 {
        0.0
    } else {
        a.singular_values()
            .expect("singular values of finite input")[0]
    }
}

pub fn distance(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    frobenius((a - b).as_ref())
}

/// `|S^T S - I|_2`.
pub fn orthonormality(s: &Mat<f64>) -> f64 {
    spectral((s.transpose() * s - identity(s.ncols())).as_ref())
}

/// Fails with both numbers unless `defect <= bound`; NaN fails.
#[track_caller]
pub fn assert_within(defect: f64, bound: f64, what: &str) {
    assert!(
        defect <= bound,
        "{what}: defect {defect:.3e} exceeds the bound {bound:.3e}"
    );
}

#[track_caller]
pub fn assert_close(a: &Mat<f64>, b: &Mat<f64>, bound: f64, what: &str) {
    assert_eq!(a.shape(), b.shape(), "{what}: shapes differ");
    assert_within(distance(a, b), bound, what);
}

/// The orthogonal matrices that act on `n x k` matrices: `A -> L A`, or `A -> L A R`.
#[derive(Clone, Copy)]
pub enum Actions {
    Left,
    Both,
}

/// Fails unless a function of matrices of one shape commutes with random orthogonal transformations, to a bound in the
/// Frobenius norm of each result.
#[track_caller]
pub fn assert_equivariant(
    actions: Actions,
    data: &[&Mat<f64>],
    function: impl Fn(&[Mat<f64>]) -> Vec<Mat<f64>>,
    bound: f64,
    what: &str,
    rng: &mut Rng,
) {
    let (n, k) = data[0].shape();
    let left = random_orthogonal(n, rng);
    let right = match actions {
        Actions::Left => identity(k),
        Actions::Both => random_orthogonal(k, rng),
    };
    let data: Vec<Mat<f64>> = data.iter().map(|a| (*a).clone()).collect();
    let moved: Vec<Mat<f64>> = data.iter().map(|a| &left * a * &right).collect();
    let (here, there) = (function(&data), function(&moved));
    assert!(!here.is_empty() && here.len() == there.len(), "{what}");
    for (here, there) in here.iter().zip(&there) {
        assert_close(
            &(&left * here * &right),
            there,
            bound,
            &format!("equivariance, {what}"),
        );
    }
}

/// The largest of many defects, and the case in which it occurred; printed with `--nocapture`.
pub struct Worst {
    title: String,
    defect: f64,
    place: String,
}

impl Worst {
    pub fn new(title: &str) -> Self {
        Worst {
            title: title.to_owned(),
            defect: 0.0,
            place: "nowhere".to_owned(),
        }
    }

    pub fn see(&mut self, defect: f64, place: impl FnOnce() -> String) {
        // NaN counts as the worst.
        if defect > self.defect || defect.is_nan() {
            (self.defect, self.place) = (defect, place());
        }
    }

    #[track_caller]
    pub fn assert_at_most(&self, bound: f64) {
        println!(
            "{}: worst {:.3e} (bound {:.3e}) at {}",
            self.title, self.defect, bound, self.place
        );
        assert_within(
            self.defect,
            bound,
            &format!("{} at {}", self.title, self.place),
        );
    }
}

/// `|exp(log Q) - Q|_F`.
pub fn backward_error(q: &Mat<f64>) -> f64 {
    let log = orthogonal_log(q.as_ref()).unwrap_or_else(|e| panic!("m = {}: {e}", q.nrows()));
    distance(&skew_exp(log.as_ref()).unwrap(), q)
}

/// Angles spread over `(0, 1]`, to be scaled to a largest angle.
pub fn spread_angles(m: usize, rng: &mut Rng) -> Vec<f64> {
    (0..m / 2)
        .map(|l| if l == 0 { 1.0 } else { rng.uniform() })
        .collect()
}

/// Every angle times a factor.
pub fn scaled(angles: &[f64], factor: f64) -> Vec<f64> {
    angles.iter().map(|x| x * factor).collect()
}

/// Counts how often a solve polls the interrupt, before each step of an integration and of Newton's method; returns
/// also its result.
pub fn counted<T>(solve: impl FnOnce(Interrupt<'_>) -> T) -> (usize, T) {
    let checks = AtomicUsize::new(0);
    let count = || {
        checks.fetch_add(1, Ordering::Relaxed);
        false
    };
    let result = solve(Interrupt::new(&count));
    (checks.into_inner(), result)
}

/// The cubic integrated from the state of another one at time 0.
pub fn integrated_from_start(curve: &RiemannianCubic) -> RiemannianCubic {
    let state = [
        curve.point(0.0),
        curve.derivative(0.0, 1),
        curve.acceleration(0.0),
        curve.jerk(0.0),
    ];
    let state = state.map(|x| x.unwrap());
    let options = IntegrationOptions {
        tension: curve.tension(),
        ..Default::default()
    };
    cubic_from(state.each_ref(), &options)
}

/// The cubic with the given point, velocity, covariant acceleration and covariant jerk at time 0.
pub fn cubic_from(state: [&Mat<f64>; 4], options: &IntegrationOptions) -> RiemannianCubic {
    let [s, v, a, j] = state.map(|x| x.as_ref());
    RiemannianCubic::from_initial(s, v, a, j, options, Interrupt::NEVER).unwrap()
}
