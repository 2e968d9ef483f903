//! Derivatives of splines in tension: forward ones compared with differences, transposed ones with the forward ones.

use faer::{Mat, MatRef, Scale};
use stiefel_rs::spline::{EndConditions, SplineOptions, SplineVariation, cubic_spline};
use stiefel_rs::{Curve, Geodesic, Interrupt};

use crate::common::{Rng, distance, frobenius, gaussian, random_point, random_tangent, retract};

const SHAPES: [(usize, usize); 5] = [(3, 1), (3, 2), (4, 2), (4, 4), (14, 2)];

fn dot(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    let columns = a.col_iter().zip(b.col_iter());
    columns.map(|(a, b)| a.transpose() * b).sum()
}

fn views(points: &[Mat<f64>]) -> Vec<MatRef<'_, f64>> {
    points.iter().map(|x| x.as_ref()).collect()
}

#[test]
fn derivatives_of_splines_are_those_of_the_solutions() {
    for shape in SHAPES {
        let mut rng = Rng::new(3 + shape.0 as u64);
        let mut points = vec![random_point(shape.0, shape.1, &mut rng)];
        for i in 1..5 {
            let v = random_tangent(&points[i - 1], 0.7, &mut rng);
            points.push(retract(&points[i - 1], &v));
        }
        let t = [0.0, 0.8, 1.5, 2.6, 3.2];
        let options = SplineOptions {
            tension: 4.0,
            ..SplineOptions::default()
        };
        let moves: Vec<Mat<f64>> = points
            .iter()
            .map(|s| random_tangent(s, 1.0, &mut rng))
            .collect();
        let rates = [0.3, -0.2, 0.5, 0.1, -0.4];
        let solved = |h: f64| {
            let moved: Vec<Mat<f64>> = points
                .iter()
                .zip(&moves)
                .map(|(s, v)| {
                    let way = Geodesic::from_velocity(s.as_ref(), (v * Scale(h)).as_ref()).unwrap();
                    way.point(1.0).unwrap()
                })
                .collect();
            let t: Vec<f64> = t.iter().zip(rates).map(|(t, rate)| t + h * rate).collect();
            cubic_spline(
                &t,
                &views(&moved),
                &EndConditions::Natural,
                &options,
                Interrupt::NEVER,
            )
            .unwrap()
            .0
        };
        let curve = solved(0.0);
        let h = 1e-4;
        let (up, down) = (solved(h), solved(-h));
        let derivative = curve
            .data_derivative(&EndConditions::Natural, Interrupt::NEVER)
            .unwrap();
        let moves = views(&moves);
        let variation = SplineVariation {
            points: &moves,
            times: &rates,
            ends: [None, None],
        };
        let times = [0.4, 1.2, 3.0];
        let found = derivative
            .points(&variation, &times, Interrupt::NEVER)
            .unwrap();
        for (found, t) in found.iter().zip(times) {
            let wanted = (up.point(t).unwrap() - down.point(t).unwrap()) * Scale(0.5 / h);
            let error = distance(found, &wanted) / (1.0 + frobenius(wanted.as_ref()));
            assert!(error < 1e-6, "{shape:?} at {t}: {error:e}");
        }
        let w: Vec<Mat<f64>> = times
            .iter()
            .map(|_| gaussian(shape.0, shape.1, &mut rng))
            .collect();
        let forward: f64 = found.iter().zip(&w).map(|(x, w)| dot(x, w)).sum();
        let back = derivative
            .pull_back(&times, &views(&w), Interrupt::NEVER)
            .unwrap();
        let pairs = back.points.iter().zip(&moves);
        let mut total: f64 = pairs.map(|(g, x)| dot(g, &x.to_owned())).sum();
        total += back
            .times
            .iter()
            .zip(rates)
            .map(|(g, rate)| g * rate)
            .sum::<f64>();
        assert!(
            (forward - total).abs() < 1e-9 * (1.0 + forward.abs()),
            "{shape:?}: {forward} {total}"
        );
        let gradient = curve
            .cost_gradient(&EndConditions::Natural, Interrupt::NEVER)
            .unwrap();
        let pairs = gradient.points.iter().zip(&moves);
        let mut slope: f64 = pairs.map(|(g, x)| dot(g, &x.to_owned())).sum();
        slope += gradient
            .times
            .iter()
            .zip(rates)
            .map(|(g, rate)| g * rate)
            .sum::<f64>();
        let wanted =
            (up.cost(Interrupt::NEVER).unwrap() - down.cost(Interrupt::NEVER).unwrap()) / (2.0 * h);
        assert!(
            (slope - wanted).abs() < 1e-5 * (1.0 + wanted.abs()),
            "{shape:?}: {slope} {wanted}"
        );
    }
}
