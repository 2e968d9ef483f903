//! Variations of Riemannian cubics: exact directional derivatives of points and velocities with respect to initial data.

use faer::Mat;

use super::initial::{Horizontal, InitialData};
use super::reduced::Sized;
use super::taylor::{Accuracy, March};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::dual::{Dual, Number};

/// Variations at one time, in coordinates in which the frame at the start is the identity; shape `(r, k)`, one for each
/// direction.
pub(super) struct Slopes {
    pub(super) points: Vec<Mat<f64>>,
    pub(super) velocities: Vec<Mat<f64>>,
    /// Of the tangent vectors `g x'` and `g x''`.
    pub(super) accelerations: Vec<Mat<f64>>,
    pub(super) seconds: Vec<Mat<f64>>,
    /// The frame there, shape `(r, r)`.
    pub(super) frame: Mat<f64>,
    /// `x, x', x''` there.
    pub(super) state: [Horizontal; 3],
}

/// Variations of the curve with the given initial data at each of several times after the start, the start held fixed.
/// A pass carries `N` directions.
///
/// # Arguments
/// * `extra` - rows beside the span, in which the curve stays zero
/// * `directions` - variations of `(x, x', x'')`; the normal parts have `extra` rows more than those of the data
/// # Errors
/// `TooManySteps`, `Overflow`, `Interrupted`.
pub(super) fn vary<const N: usize>(
    data: &InitialData,
    extra: usize,
    directions: &[[Horizontal; 3]],
    times: &[f64],
    interrupt: Interrupt<'_>,
) -> Result<Vec<Slopes>> {
    let k = data.velocity.omega.nrows();
    let blocks = Sized {
        m: data.velocity.normal.nrows() + extra,
        k,
    };
    let mut out: Vec<Slopes> = Vec::new();
    out.resize_with(times.len(), || Slopes::none(blocks));
    let mut march = March::<Dual<N>, Sized>::new(blocks, Accuracy::FULL);
    // A curve without freedom still has a frame.
    let passes = directions
        .chunks(N)
        .chain(directions.is_empty().then_some(&[][..]));
    for pass in passes {
        start(&mut march, data, pass);
        for (slopes, &t) in out.iter_mut().zip(times) {
            let behind = t.abs() < march.time.abs() || t * march.time < 0.0;
            if behind {
                start(&mut march, data, pass);
            }
            march.run(t, interrupt, |_, _, _| Ok(()))?;
            slopes.read(&march, pass.len());
        }
    }
    Ok(out)
}

impl Slopes {
    /// No direction.
    pub(super) fn none(blocks: Sized) -> Self {
        let r = blocks.m + blocks.k;
        Slopes {
            points: Vec::new(),
            velocities: Vec::new(),
            accelerations: Vec::new(),
            seconds: Vec::new(),
            frame: Mat::zeros(r, r),
            state: std::array::from_fn(|_| Horizontal::zeros(blocks)),
        }
    }

    /// Of the state that a march has reached.
    pub(super) fn read<const N: usize>(&mut self, march: &March<Dual<N>, Sized>, count: usize) {
        let Sized { m, k } = march.blocks;
        let (r, series) = (m + k, &march.series);
        let vector = |level: usize, i: usize, j: usize| {
            let mut sum = Dual::<N>::ZERO;
            for l in 0..k {
                sum += series.s()[i + r * l] * series.omega(level)[l + k * j];
            }
            for l in 0..m {
                sum += series.e()[i + r * l] * series.b(level)[l + m * j];
            }
            sum
        };
        for direction in 0..count {
            let point = |i: usize, j: usize| series.s()[i + r * j].slope[direction];
            self.points.push(Mat::from_fn(r, k, point));
        }
        let vectors = [
            &mut self.velocities,
            &mut self.accelerations,
            &mut self.seconds,
        ];
        for (level, out) in vectors.into_iter().enumerate() {
            let entries: Vec<Dual<N>> =
                (0..r * k).map(|at| vector(level, at % r, at / r)).collect();
            let slope =
                |direction: usize| Mat::from_fn(r, k, |i, j| entries[i + r * j].slope[direction]);
            out.extend((0..count).map(slope));
        }
        self.frame = Mat::from_fn(r, r, |i, j| match j.checked_sub(k) {
            None => series.s()[i + r * j].value,
            Some(j) => series.e()[i + r * j].value,
        });
        self.state = std::array::from_fn(|level| Horizontal {
            omega: Mat::from_fn(k, k, |i, j| series.omega(level)[i + k * j].value),
            normal: Mat::from_fn(m, k, |i, j| series.b(level)[i + m * j].value),
        });
    }
}

/// Puts a march at the start of a curve: frame the identity, derivatives with their variations.
pub(super) fn start<const N: usize>(
    march: &mut March<Dual<N>, Sized>,
    data: &InitialData,
    directions: &[[Horizontal; 3]],
) {
    let Sized { m, k } = march.blocks;
    let r = m + k;
    (march.time, march.steps) = (0.0, 0);
    let second = data.second();
    march.series.set_tension(data.tension);
    let series = march.series.parts();
    for j in 0..r {
        for i in 0..r {
            let entry = Dual::<N>::constant(f64::from(u8::from(i == j)));
            match j.checked_sub(k) {
                None => series.s[i + r * j] = entry,
                Some(j) => series.e[i + r * j] = entry,
            }
        }
    }
    let inside = data.velocity.normal.nrows();
    for (level, x) in [&data.velocity, &data.acceleration, &second]
        .into_iter()
        .enumerate()
    {
        let varied = |value: f64, pick: &dyn Fn(&Horizontal) -> f64| {
            let mut entry = Dual::<N>::constant(value);
            for (slope, direction) in entry.slope.iter_mut().zip(directions) {
                *slope = pick(&direction[level]);
            }
            entry
        };
        for j in 0..k {
            for i in 0..k {
                series.omega[level][i + k * j] = varied(x.omega[(i, j)], &|d| d.omega[(i, j)]);
            }
            for i in 0..m {
                let value = if i < inside { x.normal[(i, j)] } else { 0.0 };
                series.b[level][i + m * j] = varied(value, &|d| d.normal[(i, j)]);
            }
        }
    }
}
