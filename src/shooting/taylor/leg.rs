//! A leg of a chain: its middle, and the residuals of its equations.

use super::room::Room;
use super::series::LegSeries;
use crate::linalg::field::{Field, larger, largest, transposed_multiply};
use crate::space::{Homogeneous, orthonormalise};

/// One leg, or eight of them, in the time in which it takes one unit.
///
/// Frames are relative to the frame of the knot where the leg starts, matrices in row-major order; vectors are
/// coordinates in the frame of the knot at the respective end, unless stated otherwise.
pub(crate) struct SeriesLeg<'a, T> {
    /// The next knot's frame.
    pub(crate) target: &'a mut [T],
    /// `x, x', x''` at the middle.
    pub(crate) middle: [&'a mut [T]; 3],
    /// Required values of `x` at both ends.
    pub(crate) velocity: &'a mut [T],
    pub(crate) last_velocity: &'a mut [T],
    /// Tension of the curve; `None` for a cubic.
    pub(crate) tension: Option<T>,
    pub(crate) residual: LegResidual<'a, T>,
    /// Order of its series, and the number of terms that it needs beyond those predicted by its speed.
    pub(crate) order: usize,
    pub(crate) more: usize,
    /// `x'` and `x''` at both ends, and `x, x', x''` at the last end in the frame reached there.
    pub(crate) accelerations: [&'a mut [T]; 2],
    pub(crate) thirds: [&'a mut [T]; 2],
    pub(crate) reached: [&'a mut [T]; 3],
    /// The isometry between the frame reached and the frame of the next knot.
    pub(crate) holonomy: &'a mut [T],
}

/// The residuals of a leg's equations.
pub(crate) struct LegResidual<'a, T> {
    /// Excess of `x` over its required value at both ends.
    pub(crate) velocities: [&'a mut [T]; 2],
    /// Displacement of the end from the next knot.
    pub(crate) point: &'a mut [T],
    /// The largest entry.
    pub(crate) size: f64,
    /// Contribution of the last terms of the series, for each lane.
    pub(crate) tail: T,
}

impl<T: Field> LegResidual<'_, T> {
    /// Square root of the sum of squares of all entries of a lane.
    #[inline(always)]
    pub(crate) fn norm(&self, lane: usize) -> f64 {
        let [first, last] = &self.velocities;
        let vectors = [first, last, &self.point];
        let entries = vectors.into_iter().flat_map(|vector| vector.iter());
        entries.map(|x| x.lane(lane).powi(2)).sum::<f64>().sqrt()
    }
}

/// Buffers shared by all legs.
#[derive(Clone)]
pub(crate) struct LegScratch<T> {
    pub(crate) series: LegSeries<T>,
    reached: Vec<T>,
    u: Vec<T>,
    work: Vec<T>,
    wanted: Vec<T>,
}

impl<T: Field> LegScratch<T> {
    pub(crate) fn new(space: impl Homogeneous, order: usize) -> Self {
        let square = space.size() * space.size();
        let zeros = |count: usize| vec![T::ZERO; count];
        LegScratch {
            series: LegSeries::new(space, order),
            reached: zeros(square),
            u: zeros(square),
            work: zeros(2 * square),
            wanted: zeros(space.dim()),
        }
    }
}

impl<'a, T: Field> SeriesLeg<'a, T> {
    /// Number of floating-point numbers of a leg.
    pub(crate) fn len(space: impl Homogeneous) -> usize {
        15 * space.dim() + 2 * space.size() * space.size()
    }

    pub(crate) fn new(space: impl Homogeneous, room: &mut Room<'a, T>) -> Self {
        let (d, square) = (space.dim(), space.size() * space.size());
        SeriesLeg {
            target: room.take(square),
            middle: std::array::from_fn(|_| room.take(d)),
            velocity: room.take(d),
            last_velocity: room.take(d),
            tension: None,
            order: 0,
            more: 0,
            residual: LegResidual {
                velocities: std::array::from_fn(|_| room.take(d)),
                point: room.take(d),
                size: f64::INFINITY,
                tail: T::constant(f64::INFINITY),
            },
            accelerations: std::array::from_fn(|_| room.take(d)),
            thirds: std::array::from_fn(|_| room.take(d)),
            reached: std::array::from_fn(|_| room.take(d)),
            holonomy: room.take(square),
        }
    }

    /// `x, x', x''` at the middle.
    pub(crate) fn middle(&self) -> [&[T]; 3] {
        self.middle.each_ref().map(|x| &**x)
    }

    /// Computes the residuals from series of its order; those of `x` stay in the buffers.
    #[inline(always)]
    pub(crate) fn set_residual(&mut self, space: impl Homogeneous, scratch: &mut LegScratch<T>) {
        let order = self.order;
        let (d, r) = (space.dim(), space.size());
        let square = r * r;
        let LegScratch {
            series,
            u,
            reached,
            work,
            wanted,
        } = scratch;
        series.set_curve(space, self.middle(), self.tension, order);
        let tail = series.reached_into(space, order, reached);
        // With u = target^T g at the end, and its part q in H, the displacement of the end is the logarithm of q^T u.
        transposed_multiply(r, self.target, reached, u);
        space.isotropy_part_into(u, self.holonomy);
        if space.isotropy_dim() > 0 {
            orthonormalise(r, self.holonomy, work);
        }
        let relative = &mut work[..square];
        transposed_multiply(r, self.holonomy, u, relative);
        space.each_entry(
            #[inline(always)]
            |p, i, j| self.residual.point[p] = space.skew_coordinate(relative, [i, j]),
        );
        let [first, last] = &mut self.residual.velocities;
        series.at_ends(d, order + 3, 0, [first, last]);
        self.reached[0].copy_from_slice(last);
        space.turn_back_into(self.holonomy, self.last_velocity, wanted);
        for p in 0..d {
            first[p] -= self.velocity[p];
            last[p] -= wanted[p];
        }
        let vectors = [&mut self.accelerations, &mut self.thirds];
        for (derivative, [first, last]) in (1..3).zip(vectors) {
            let reached = &mut *self.reached[derivative];
            series.at_ends(d, order + 3, derivative, [first, reached]);
            space.turn_into(self.holonomy, reached, last);
        }
        self.residual.tail = series.curve_tail(space, order).larger(tail);
        let LegResidual {
            velocities: [first, last],
            point,
            size,
            ..
        } = &mut self.residual;
        *size = larger(larger(largest(first), largest(last)), largest(point));
    }

    /// The largest contribution of the last terms of the series, over all lanes.
    #[inline(always)]
    pub(crate) fn largest_tail(&self) -> f64 {
        largest(&[self.residual.tail])
    }

    /// The largest entry of `x'` at the ends and of `x''` at the middle.
    #[inline(always)]
    pub(crate) fn largest_derivative(&self) -> f64 {
        let [first, last] = self.accelerations.each_ref().map(|x| largest(x));
        larger(larger(first, last), largest(self.middle[2]))
    }

    /// A bound on the velocity up to second order, `|x| + |x'| / 2 + |x''| / 8` at the middle, or the rate at which
    /// tension lets velocities grow, if that is larger.
    #[inline(always)]
    pub(crate) fn speed(&self) -> f64 {
        let mut squares = [T::ZERO; 3];
        for (sum, vector) in squares.iter_mut().zip(&self.middle) {
            for x in vector.iter() {
                *sum += *x * *x;
            }
        }
        let bound = |lane: usize| {
            let [v, a, b] = squares.map(|sum| sum.lane(lane).sqrt());
            let tension = self.tension.map_or(0.0, |tension| tension.lane(lane));
            larger(v + 0.5 * a + 0.125 * b, tension.sqrt())
        };
        (0..T::COUNT).map(bound).fold(0.0, larger)
    }
}
