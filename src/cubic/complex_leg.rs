//! A leg of a spline over the complex numbers: the real one of the embedded matrices, in the coordinates of the complex space.

use faer::Mat;

use super::leg::Leg;
use super::packing::{of_real_coordinates, to_real_coordinates};
use super::reduced::Sized;
use super::taylor::Accuracy;
use crate::error::Result;
use crate::linalg::lanes::LANES;

pub(super) struct ComplexLeg<'a> {
    real: Box<dyn Leg + 'a>,
    blocks: Sized,
}

impl<'a> ComplexLeg<'a> {
    /// Over the real leg in blocks of complex matrices.
    pub(super) fn new(real: Box<dyn Leg + 'a>, blocks: Sized) -> Self {
        ComplexLeg { real, blocks }
    }

    /// How many real coordinates stand for so many.
    fn real_count(&self, count: usize) -> usize {
        count / self.blocks.dim().max(1) * self.blocks.embedded().dim()
    }
}

impl Leg for ComplexLeg<'_> {
    fn arrive_into(
        &mut self,
        start: &[f64],
        next: &[f64],
        tension: f64,
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<f64> {
        let start = to_real_coordinates(start, self.blocks);
        let mut real = vec![0.0; self.real_count(values.len())];
        let distance = self
            .real
            .arrive_into(&start, next, tension, accuracy, &mut real)?;
        values.copy_from_slice(&of_real_coordinates(&real, self.blocks));
        Ok(distance)
    }

    fn arrive_abreast_into(
        &mut self,
        start: &[Vec<f64>; LANES],
        next: [&[f64]; LANES],
        tension: [f64; LANES],
        accuracy: Accuracy,
        values: &mut [f64],
    ) -> Result<[f64; LANES]> {
        let start = start
            .each_ref()
            .map(|start| to_real_coordinates(start, self.blocks));
        let mut real = vec![0.0; self.real_count(values.len())];
        let distances = self
            .real
            .arrive_abreast_into(&start, next, tension, accuracy, &mut real)?;
        values.copy_from_slice(&of_real_coordinates(&real, self.blocks));
        Ok(distances)
    }

    fn derivative(
        &mut self,
        start: &[f64],
        next: &[f64],
        tension: f64,
        accuracy: Accuracy,
    ) -> Result<Mat<f64>> {
        let real = to_real_coordinates(start, self.blocks);
        let derivative = self.real.derivative(&real, next, tension, accuracy)?;
        let mut out = Mat::zeros(start.len(), start.len());
        let mut unit = vec![0.0; start.len()];
        for column in 0..start.len() {
            unit[column] = 1.0;
            let direction = to_real_coordinates(&unit, self.blocks);
            unit[column] = 0.0;
            let mut changes = vec![0.0; real.len()];
            // An entry and its copy.
            for (p, x) in direction.into_iter().enumerate().filter(|(_, x)| *x != 0.0) {
                for (change, a) in changes.iter_mut().zip(derivative.col(p).iter()) {
                    *change += a * x;
                }
            }
            let changes = of_real_coordinates(&changes, self.blocks);
            for (row, change) in changes.into_iter().enumerate() {
                out[(row, column)] = change;
            }
        }
        Ok(out)
    }

    fn allow(&mut self, speed: f64) {
        self.real.allow(speed);
    }

    fn work(&self) -> f64 {
        self.real.work()
    }
}
