//! Families of data of splines with one parameter, and their derivatives.

use faer::{Mat, MatRef, Scale};
use stiefel_rs::spline::{
    EndCondition, EndConditions, Piecewise, SplineGradient, SplineOptions, SplineVariation,
    cubic_spline,
};
use stiefel_rs::{Curve, Interrupt, RiemannianCubic, Stiefel};

use crate::common::{Rng, gaussian, random_tangent};
use crate::knots::{views, walk};

/// The end conditions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    Natural,
    Velocities,
    Accelerations,
    Mixed,
    Periodic,
}

pub const ALL_ENDS: [Ends; 5] = [
    Ends::Natural,
    Ends::Velocities,
    Ends::Accelerations,
    Ends::Mixed,
    Ends::Periodic,
];

/// Data, and the directions in which they move.
pub struct Family {
    pub ends: Ends,
    pub t: Vec<f64>,
    pub points: Vec<Mat<f64>>,
    pub vectors: [Mat<f64>; 2],
    pub dt: Vec<f64>,
    pub ds: Vec<Mat<f64>>,
    /// Ambient directions of the vectors at the ends, before they are made tangent.
    pub shifts: [Mat<f64>; 2],
}

/// The data at one parameter.
pub struct Data {
    pub t: Vec<f64>,
    pub points: Vec<Mat<f64>>,
    pub conditions: EndConditions,
}

pub fn symmetric(a: &Mat<f64>) -> Mat<f64> {
    (a + a.transpose()) * Scale(0.5)
}

impl Family {
    pub fn new(shape: (usize, usize), count: usize, ends: Ends, seed: u64) -> Self {
        let mut rng = Rng::new(seed);
        let (t, mut points) = walk(shape, count, 0.6, seed + 1);
        if ends == Ends::Periodic {
            points[count - 1] = points[0].clone();
        }
        let last = points.len() - 1;
        let mut ds: Vec<Mat<f64>> = points
            .iter()
            .map(|point| random_tangent(point, 1.0, &mut rng))
            .collect();
        if ends == Ends::Periodic {
            ds[last] = ds[0].clone();
        }
        Family {
            ends,
            vectors: [0, last].map(|knot| random_tangent(&points[knot], 0.7, &mut rng)),
            dt: (0..t.len()).map(|_| rng.between(-0.5, 0.5)).collect(),
            shifts: [(); 2].map(|()| gaussian(shape.0, shape.1, &mut rng)),
            ds,
            t,
            points,
        }
    }

    /// The same data in other coordinates of space.
    pub fn mapped(&self, f: impl Fn(&Mat<f64>) -> Mat<f64>) -> Self {
        Family {
            ends: self.ends,
            t: self.t.clone(),
            dt: self.dt.clone(),
            points: self.points.iter().map(&f).collect(),
            ds: self.ds.iter().map(&f).collect(),
            vectors: self.vectors.each_ref().map(&f),
            shifts: self.shifts.each_ref().map(&f),
        }
    }

    fn orders(&self) -> [Option<usize>; 2] {
        match self.ends {
            Ends::Natural | Ends::Periodic => [None; 2],
            Ends::Velocities => [Some(1); 2],
            Ends::Accelerations => [Some(2); 2],
            Ends::Mixed => [Some(2), Some(1)],
        }
    }

    pub fn at(&self, h: f64) -> Data {
        let (n, k) = self.points[0].shape();
        let manifold = Stiefel::new(n, k).unwrap();
        let moved = |(point, ds): (&Mat<f64>, &Mat<f64>)| {
            let step = ds * Scale(h);
            let end = manifold.exp(point.as_ref(), step.as_ref()).unwrap();
            manifold.project(end.as_ref()).unwrap()
        };
        let points: Vec<Mat<f64>> = self.points.iter().zip(&self.ds).map(moved).collect();
        let last = points.len() - 1;
        let conditions = match self.ends {
            Ends::Natural => EndConditions::Natural,
            Ends::Periodic => EndConditions::Periodic,
            _ => {
                let orders = self.orders();
                EndConditions::Each(Box::new([0, 1].map(|end| {
                    let s = &points[[0, last][end]];
                    let y = &self.vectors[end] + &self.shifts[end] * Scale(h);
                    let vector = &y - s * symmetric(&(s.transpose() * &y));
                    match orders[end] {
                        Some(1) => EndCondition::Velocity(vector),
                        _ => EndCondition::Acceleration(vector),
                    }
                })))
            }
        };
        Data {
            t: self
                .t
                .iter()
                .zip(&self.dt)
                .map(|(t, dt)| t + h * dt)
                .collect(),
            points,
            conditions,
        }
    }

    /// Derivatives of the vectors at the ends.
    pub fn end_changes(&self) -> [Option<Mat<f64>>; 2] {
        let (orders, last) = (self.orders(), self.points.len() - 1);
        [0, 1].map(|end| {
            orders[end]?;
            let knot = [0, last][end];
            let (s, ds) = (&self.points[knot], &self.ds[knot]);
            let inner = ds.transpose() * &self.vectors[end] + s.transpose() * &self.shifts[end];
            Some(&self.shifts[end] - s * symmetric(&inner))
        })
    }

    /// Calls a function with the variation of the data.
    pub fn with_variation<T>(&self, call: impl FnOnce(&SplineVariation<'_>) -> T) -> T {
        let points = views(&self.ds);
        let ends = self.end_changes();
        call(&SplineVariation {
            points: &points,
            times: &self.dt,
            ends: ends
                .each_ref()
                .map(|end| end.as_ref().map(|end| end.as_ref())),
        })
    }

    /// The product of a gradient with the variation of the data.
    pub fn product(&self, gradient: &SplineGradient) -> f64 {
        let points = gradient.points.iter().zip(&self.ds);
        let times = gradient.times.iter().zip(&self.dt);
        let ends = self.end_changes();
        let ends = gradient.ends.iter().zip(&ends).map(|pair| match pair {
            (Some(gradient), Some(end)) => dot(gradient.as_ref(), end.as_ref()),
            (None, None) => 0.0,
            _ => panic!("a gradient for every vector that is given"),
        });
        points
            .map(|(g, d)| dot(g.as_ref(), d.as_ref()))
            .sum::<f64>()
            + times.map(|(g, d)| g * d).sum::<f64>()
            + ends.sum::<f64>()
    }
}

impl Data {
    pub fn spline(&self) -> Piecewise<RiemannianCubic> {
        let options = SplineOptions {
            tolerance: 1e-14,
            ..SplineOptions::default()
        };
        let ends = &self.conditions;
        match cubic_spline(
            &self.t,
            &views(&self.points),
            ends,
            &options,
            Interrupt::NEVER,
        ) {
            Ok((curve, _)) => curve,
            // The vector may exceed the tolerance by round-off.
            Err(_) => {
                let options = SplineOptions {
                    tolerance: 1e-12,
                    ..options
                };
                cubic_spline(
                    &self.t,
                    &views(&self.points),
                    ends,
                    &options,
                    Interrupt::NEVER,
                )
                .unwrap()
                .0
            }
        }
    }
}

pub fn dot(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    let columns = a.col_iter().zip(b.col_iter());
    columns.map(|(a, b)| a.transpose() * b).sum()
}

/// The derivative at 0 by central differences of fourth order, for entries.
pub fn difference(f: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let h = 2e-3;
    let [a, b, c, d] = [h, -h, 2.0 * h, -2.0 * h].map(f);
    (0..a.len())
        .map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h))
        .collect()
}

/// Entries of points at some times.
pub fn sampled(curve: &Piecewise<RiemannianCubic>, times: &[f64]) -> Vec<f64> {
    let points = times.iter().map(|t| curve.point(*t).unwrap());
    points.flat_map(|point| entries(&point)).collect()
}

/// The entries in column-major order.
pub fn entries(a: &Mat<f64>) -> Vec<f64> {
    a.col_iter().flat_map(|c| c.iter().copied()).collect()
}
