//! Derivatives of boundary problems of Riemannian cubics, compared with differences along smooth families of data.

mod common;
#[path = "common/boundary.rs"]
mod data;

use common::{Rng, distance, frobenius, identity, random_tangent};
use data::*;
use faer::{Mat, MatRef, Scale};
use stiefel_rs::cubic::BoundaryVariation;
use stiefel_rs::{Curve, Error, Interrupt};

/// Data along a smooth family: rotated frames with their velocities, exactly on the constraints.
struct Family {
    data: Data,
    turns: [Mat<f64>; 2],
    rates: [Mat<f64>; 2],
}

impl Family {
    fn random(shape: (usize, usize), rng: &mut Rng) -> Self {
        let data = Data::random(shape, 1.5, 1.5, rng);
        let skew = |rng: &mut Rng| {
            let a = common::gaussian(shape.0, shape.0, rng);
            (&a - a.transpose()) * Scale(0.3)
        };
        let turns = [skew(rng), skew(rng)];
        let rates = [
            random_tangent(&data.s0, 1.0, rng),
            random_tangent(&data.s1, 1.0, rng),
        ];
        Family { data, turns, rates }
    }

    /// `S(h) = e^{hA} S`, `V(h) = e^{hA} (V + h W)`.
    fn at(&self, h: f64) -> Data {
        let [a, b] = self
            .turns
            .each_ref()
            .map(|a| stiefel_rs::skew_exp((a * Scale(h)).as_ref()).unwrap());
        Data {
            s0: &a * &self.data.s0,
            v0: &a * (&self.data.v0 + &self.rates[0] * Scale(h)),
            s1: &b * &self.data.s1,
            v1: &b * (&self.data.v1 + &self.rates[1] * Scale(h)),
        }
    }

    /// `dS0, dV0, dS1, dV1` at `h = 0`.
    fn rate(&self) -> [Mat<f64>; 4] {
        let [a, b] = &self.turns;
        [
            a * &self.data.s0,
            a * &self.data.v0 + &self.rates[0],
            b * &self.data.s1,
            b * &self.data.v1 + &self.rates[1],
        ]
    }
}

/// Central difference with one step of Richardson extrapolation, error `O(h^4)`.
fn richardson(f: impl Fn(f64) -> Mat<f64>) -> Mat<f64> {
    let h = 2e-3;
    let central = |h: f64| (f(h) - f(-h)) * Scale(0.5 / h);
    (central(0.5 * h) * Scale(4.0) - central(h)) * Scale(1.0 / 3.0)
}

fn variation(rates: &[Mat<f64>; 4]) -> BoundaryVariation<'_> {
    let [s0, v0, s1, v1] = rates.each_ref().map(|x| -> MatRef<'_, f64> { x.as_ref() });
    BoundaryVariation { s0, v0, s1, v1 }
}

#[test]
fn derivatives_agree_with_differences() {
    // (12, 2) and (7, 1) have rows outside the span of the data.
    for shape in [(3, 1), (7, 1), (3, 2), (4, 2), (5, 3), (3, 3), (12, 2)] {
        let mut rng = Rng::new(23);
        let family = Family::random(shape, &mut rng);
        let curve = family.data.solve().unwrap();
        let derivative = curve.boundary_derivative(Interrupt::NEVER).unwrap();
        let rates = family.rate();
        let found = derivative
            .initial(&variation(&rates), Interrupt::NEVER)
            .unwrap();
        let solve = |h: f64| family.at(h).solve().unwrap();
        let checks = [
            (
                "A",
                found.acceleration,
                richardson(|h| solve(h).acceleration(0.0).unwrap()),
            ),
            ("J", found.jerk, richardson(|h| solve(h).jerk(0.0).unwrap())),
        ];
        for (name, found, expected) in checks {
            let error = distance(&found, &expected) / (1.0 + frobenius(expected.as_ref()));
            println!("{shape:?} {name}: {error:.1e}");
            // h^4 and 1e-12 / h.
            common::assert_within(error, 1e-7, &format!("{shape:?} {name}"));
        }
        let times = [0.0, 0.7, 0.3, 1.0];
        let points = derivative
            .points(&curve, &variation(&rates), &times, Interrupt::NEVER)
            .unwrap();
        for (t, found) in times.into_iter().zip(points) {
            let expected = richardson(|h| solve(h).point(t).unwrap());
            common::assert_close(&found, &expected, 1e-7, &format!("{shape:?} point at {t}"));
        }
        let expected =
            richardson(|h| Mat::full(1, 1, solve(h).cost(Interrupt::NEVER).unwrap()))[(0, 0)];
        let error = (derivative.cost(&variation(&rates)).unwrap() - expected).abs();
        common::assert_within(
            error / (1.0 + expected.abs()),
            1e-7,
            &format!("{shape:?} cost"),
        );
    }
}

#[test]
fn variations_that_break_a_constraint_are_errors() {
    let mut rng = Rng::new(24);
    let family = Family::random((4, 2), &mut rng);
    let derivative = family
        .data
        .solve()
        .unwrap()
        .boundary_derivative(Interrupt::NEVER)
        .unwrap();
    let mut rates = family.rate();
    rates[3] += &family.data.s1;
    let error = derivative
        .initial(&variation(&rates), Interrupt::NEVER)
        .unwrap_err();
    assert!(
        matches!(error, Error::NotTangent { name: "dV1", .. }),
        "{error}"
    );
    rates[3] = identity(3);
    assert!(matches!(
        derivative.cost(&variation(&rates)),
        Err(Error::Shape { .. })
    ));
}
