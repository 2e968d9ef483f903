//! The exact flows for `n = 3` in closed form: skew matrices are vectors of `R^3` and brackets are cross products.
//!
//! Only the parts of `x` and `p` in `m` matter: all of `R^3` for `k = 2` and 3; for `k = 1` the plane without the first
//! component, which belongs to `h`, the rotation of the last two basis vectors.

use super::split_state::{SplitState, add, check_turn};
use super::trajectory::Observed;
use crate::cubic::taylor::initial::{Horizontal, InitialData};
use crate::error::Result;

type SpaceVector = [f64; 3];

/// A vector with the accumulated rounding errors of its sums.
#[derive(Clone, Copy, Default)]
struct Sum {
    value: SpaceVector,
    low: SpaceVector,
}

impl Sum {
    fn of(value: SpaceVector) -> Self {
        Sum {
            value,
            low: [0.0; 3],
        }
    }

    #[inline(always)]
    fn add(&mut self, increment: SpaceVector) {
        for i in 0..3 {
            add(&mut self.value[i], &mut self.low[i], increment[i]);
        }
    }
}

/// State of a cubic in three dimensions.
pub(crate) struct SpaceState {
    k: usize,
    /// The rows of `g`.
    rows: [Sum; 3],
    x: Sum,
    p: Sum,
    mu: Sum,
    /// 1 if the first component belongs to `m`, else 0.
    first: f64,
    tension: f64,
    start: SpaceVector,
}

impl SpaceState {
    /// The state with the given initial data, whose `g` has shape `(3, 3)`.
    pub(crate) fn new(data: &InitialData) -> Self {
        let k = data.velocity.omega.nrows();
        let [x, p, j] = [&data.velocity, &data.acceleration, &data.jerk].map(axial);
        let first = f64::from(u8::from(k > 1));
        let bracket = cross(x, p);
        // mu_m = tau x - (j - [x, p]_m / 2) and mu_h = [x, p]_h.
        let tension = data.tension;
        let mut mu: SpaceVector = std::array::from_fn(|i| tension * x[i] + 0.5 * bracket[i] - j[i]);
        if first == 0.0 {
            mu[0] = bracket[0];
        }
        let mut state = SpaceState {
            k,
            rows: std::array::from_fn(|i| Sum::of(std::array::from_fn(|l| data.g[(i, l)]))),
            x: Sum::of(x),
            p: Sum::of(p),
            mu: Sum::of(mu),
            first,
            tension,
            start: [0.0; 3],
        };
        state.start = state.momentum();
        state
    }

    /// `g mu`, the axial vector of `g mu g^T` up to the sign of `det g`.
    fn momentum(&self) -> SpaceVector {
        self.rows.map(|row| dot(row.value, self.mu.value))
    }

    /// The covariant jerk as a vector of `m`.
    fn jerk(&self) -> SpaceVector {
        let bracket = cross(self.x.value, self.p.value);
        let (x, mu) = (self.x.value, self.mu.value);
        let mut jerk: SpaceVector =
            std::array::from_fn(|i| self.tension * x[i] + 0.5 * bracket[i] - mu[i]);
        jerk[0] *= self.first;
        jerk
    }

    /// Writes the first `k` columns of `g v` for the skew matrix of an axial vector `v`.
    fn lift(&self, v: SpaceVector, out: &mut [f64]) {
        let columns = [[0.0, v[2], -v[1]], [-v[2], 0.0, v[0]], [v[1], -v[0], 0.0]];
        for j in 0..self.k {
            for i in 0..3 {
                out[3 * j + i] = dot(self.rows[i].value, columns[j]);
            }
        }
    }
}

impl SplitState for SpaceState {
    #[inline]
    fn rotate(&mut self, h: f64) -> Result<()> {
        let x = self.x.value.map(|x| h * x);
        let square = dot(x, x);
        check_turn(square.sqrt())?;
        let [sine, versine, rest] = rotation_functions(square);
        // e^{-X} - I = -sine X + versine X^2; likewise for the mean of e^{-sX} over [0, 1].
        let turned = |v: SpaceVector, odd: f64, even: f64| -> SpaceVector {
            let once = cross(x, v);
            let twice = cross(x, once);
            std::array::from_fn(|i| even * twice[i] - odd * once[i])
        };
        let mu = self.mu.value;
        let mean = turned(mu, versine, rest);
        let kick = self.x.value.map(|x| self.tension * x);
        let mut impulse: SpaceVector = std::array::from_fn(|i| h * (kick[i] - (mu[i] + mean[i])));
        impulse[0] *= self.first;
        self.p.add(impulse);
        self.mu.add(turned(mu, sine, versine));
        for row in &mut self.rows {
            row.add(turned(row.value, sine, versine));
        }
        Ok(())
    }

    #[inline]
    fn drift(&mut self, h: f64) {
        self.x.add(self.p.value.map(|p| h * p));
    }
}

impl Observed for SpaceState {
    fn observe(&mut self, [point, velocity, acceleration, jerk]: [&mut [f64]; 4]) {
        for j in 0..self.k {
            for i in 0..3 {
                point[3 * j + i] = self.rows[i].value[j];
            }
        }
        self.lift(self.x.value, velocity);
        self.lift(self.p.value, acceleration);
        self.lift(self.jerk(), jerk);
    }

    /// `H = <mu, x> + |p|^2 / 2 - tau |x|^2 / 2`, in the inner product `tr(A^T B) / 2` of `so(r)`.
    fn energy(&mut self) -> f64 {
        let (x, p) = (self.x.value, self.p.value);
        dot(self.mu.value, x) + 0.5 * (dot(p, p) - self.tension * dot(x, x))
    }

    /// Defect of `g mu g^T`.
    fn momentum_defect(&mut self) -> f64 {
        let now = self.momentum();
        let change: SpaceVector = std::array::from_fn(|i| now[i] - self.start[i]);
        dot(change, change).sqrt()
    }

    /// `|mu_h - [x, p]_h|`, in the same norm.
    fn constraint_defect(&mut self) -> f64 {
        let bracket = cross(self.x.value, self.p.value);
        (1.0 - self.first) * (self.mu.value[0] - bracket[0]).abs()
    }
}

/// The axial vector of a vector of `m`.
fn axial(v: &Horizontal) -> SpaceVector {
    let k = v.omega.nrows();
    let entry = |i: usize, j: usize| match (i < k, j < k) {
        (true, true) => v.omega[(i, j)],
        (false, true) => v.normal[(i - k, j)],
        (true, false) => -v.normal[(j - k, i)],
        (false, false) => 0.0,
    };
    [entry(2, 1), entry(0, 2), entry(1, 0)]
}

#[inline(always)]
fn cross(a: SpaceVector, b: SpaceVector) -> SpaceVector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn dot(a: SpaceVector, b: SpaceVector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Square of the angle up to which the three functions are Taylor polynomials.
const SERIES: f64 = 1.0;

/// With nine terms, the first omitted one is below `1e-16` of the sum at the largest angle.
const SINE: [f64; 9] = coefficients(1);
const VERSINE: [f64; 9] = coefficients(2);
const REST: [f64; 9] = coefficients(3);

/// `(-1)^j / (2 j + first)!`.
const fn coefficients(first: usize) -> [f64; 9] {
    let mut out = [0.0; 9];
    let (mut factorial, mut i) = (1.0, 1);
    while i <= first {
        factorial *= i as f64;
        i += 1;
    }
    let (mut sign, mut j) = (1.0, 0);
    while j < 9 {
        out[j] = sign / factorial;
        factorial *= ((2 * j + first + 1) * (2 * j + first + 2)) as f64;
        sign = -sign;
        j += 1;
    }
    out
}

/// `sin(t)/t`, `(1 - cos t)/t^2` and `(t - sin t)/t^3` as functions of `t^2`, each accurate to a few units in the last
/// place.
#[inline(always)]
fn rotation_functions(square: f64) -> [f64; 3] {
    if square <= SERIES {
        let horner = |c: &[f64; 9]| c.iter().rev().fold(0.0, |sum, c| sum * square + c);
        return [horner(&SINE), horner(&VERSINE), horner(&REST)];
    }
    let t = square.sqrt();
    let sine = t.sin() / t;
    let half = (0.5 * t).sin() / t;
    [sine, 2.0 * half * half, (1.0 - sine) / square]
}
