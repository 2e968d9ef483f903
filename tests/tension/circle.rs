//! Cubics in tension on a circle: angles `c0 + c1 t + c2 cosh(theta t) + c3 sinh(theta t)`.

use faer::{Mat, mat};

/// The angle of a curve on a circle.
#[derive(Debug, Clone, Copy)]
pub struct Angle {
    pub theta: f64,
    pub c: [f64; 4],
}

impl Angle {
    /// A derivative at a time.
    pub fn at(&self, t: f64, order: i32) -> f64 {
        let [c0, c1, c2, c3] = self.c;
        let (sinh, cosh) = ((self.theta * t).sinh(), (self.theta * t).cosh());
        let polynomial = match order {
            0 => c0 + c1 * t,
            1 => c1,
            _ => 0.0,
        };
        let [even, odd] = match order % 2 {
            0 => [cosh, sinh],
            _ => [sinh, cosh],
        };
        polynomial + self.theta.powi(order) * (c2 * even + c3 * odd)
    }

    /// `int a''^2 + tau a'^2` over `[0, 1]`, by Simpson's rule.
    pub fn cost(&self) -> f64 {
        let count = 4000;
        let integrand = |i: i32| {
            let t = f64::from(i) / f64::from(count);
            self.at(t, 2).powi(2) + self.theta.powi(2) * self.at(t, 1).powi(2)
        };
        let weight = |i: i32| match i {
            0 => 1.0,
            i if i == count => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let sum: f64 = (0..=count).map(|i| weight(i) * integrand(i)).sum();
        sum / (3.0 * f64::from(count))
    }
}

/// The point at an angle, and the unit tangent vector there, both of shape `(2, 1)`.
pub fn point(angle: f64) -> [Mat<f64>; 2] {
    let (sin, cos) = angle.sin_cos();
    [mat![[cos], [sin]], mat![[-sin], [cos]]]
}
