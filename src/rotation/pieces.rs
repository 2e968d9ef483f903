//! The pieces of a rotation spline: polynomials of its quaternion and of its body rate.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use super::series::{
    QuaternionEntries, VectorEntries, conjugate, derivative, dot, normalised, product,
    quaternion_series, value,
};
use crate::cubic::RiemannianCubic;
use crate::curve::Curve;
use crate::legs::RotationSeries;
use crate::linalg::simd::vectorised;

/// The polynomials of all legs, in order.
#[derive(Debug)]
pub(super) struct Pieces {
    segments: Vec<Segment>,
    /// Index of the first segment of each leg, and one past the last segment.
    legs: Vec<usize>,
    rates: Vec<VectorEntries>,
    quaternions: Vec<QuaternionEntries>,
}

/// One polynomial, in powers of `u = rate (s - center)`, where `s` is the time within the leg.
#[derive(Debug)]
struct Segment {
    /// End of its interval.
    upper: f64,
    center: f64,
    rate: f64,
    /// Index of its first coefficient; coefficients are those of the body rate, in units of `u`, and of the quaternion.
    first: usize,
    terms: usize,
}

impl Pieces {
    /// From the curves of the legs and the quaternions at the knots, whose signs are arbitrary except for the first
    /// one.
    pub(super) fn new(cubics: &[RiemannianCubic], knots: &[QuaternionEntries]) -> Self {
        Self::of_legs(0, cubics, knots, |pieces, cubic, start| {
            pieces.push_cubic(cubic, start)
        })
    }

    /// The same from the series of the legs.
    pub(super) fn of_series(series: &[RotationSeries], knots: &[QuaternionEntries]) -> Self {
        let terms = series.iter().map(|leg| leg.rates.len()).sum();
        Self::of_legs(
            terms,
            series,
            knots,
            #[inline(always)]
            |pieces, series, start| pieces.push_series(series, start),
        )
    }

    fn of_legs<L>(
        terms: usize,
        legs: &[L],
        knots: &[QuaternionEntries],
        push: impl Fn(&mut Self, &L, QuaternionEntries) -> QuaternionEntries,
    ) -> Self {
        let mut pieces = Pieces {
            segments: Vec::with_capacity(legs.len()),
            legs: vec![0],
            rates: Vec::with_capacity(terms),
            quaternions: Vec::with_capacity(terms),
        };
        let mut here = knots[0];
        vectorised(
            #[inline(always)]
            || {
                for (leg, next) in legs.iter().zip(&knots[1..]) {
                    let end = push(&mut pieces, leg, here);
                    pieces.legs.push(pieces.segments.len());
                    // Continue from the given quaternion, so that errors do not accumulate.
                    here = next.map(|x| x * 1.0_f64.copysign(dot(*next, end)));
                }
            },
        );
        pieces
    }

    /// The curve of one piece, starting near a given quaternion.
    pub(super) fn of_cubic(cubic: &RiemannianCubic, start: QuaternionEntries) -> Self {
        let mut pieces = Pieces {
            segments: Vec::new(),
            legs: vec![0],
            rates: Vec::new(),
            quaternions: Vec::new(),
        };
        pieces.push_cubic(cubic, start);
        pieces.legs.push(pieces.segments.len());
        pieces
    }

    /// Appends a leg from its series about its middle; returns the quaternion at its end.
    #[inline(always)]
    fn push_series(
        &mut self,
        series: &RotationSeries,
        start: QuaternionEntries,
    ) -> QuaternionEntries {
        let RotationSeries { rates, quaternions } = series;
        let center = product(start, conjugate(normalised(value(quaternions, -0.5))));
        let end = product(center, value(quaternions, 0.5));
        let quaternions = quaternions.iter().map(|q| product(center, *q));
        self.push(1.0, [0.5, 1.0], rates, quaternions);
        end
    }

    /// Appends a leg from the polynomials of its curve on `St(3, 3)`; returns the quaternion at its end.
    fn push_cubic(
        &mut self,
        cubic: &RiemannianCubic,
        start: QuaternionEntries,
    ) -> QuaternionEntries {
        let mut here = start;
        let frame = cubic.frame();
        for polynomial in cubic.polynomials() {
            // `omega`, column by column.
            let rates: Vec<VectorEntries> = polynomial
                .vectors
                .chunks_exact(9)
                .map(|omega| [omega[5], omega[6], omega[1]])
                .collect();
            let entry = |i: usize, j: usize| polynomial.points[j * polynomial.rows + i];
            let center = match frame {
                None => of_matrix(entry),
                Some(frame) => of_matrix(|i, j| (0..3).map(|l| frame[(i, l)] * entry(l, j)).sum()),
            };
            let mut quaternions = quaternion_series(&rates, center);
            let at = |s: f64| polynomial.rate * (s - polynomial.center);
            if dot(value(&quaternions, at(polynomial.lower)), here) < 0.0 {
                quaternions = quaternions.iter().map(|q| q.map(|x| -x)).collect();
            }
            here = value(&quaternions, at(polynomial.upper));
            let place = [polynomial.center, polynomial.upper];
            self.push(polynomial.rate, place, &rates, quaternions.into_iter());
        }
        here
    }

    #[inline(always)]
    fn push(
        &mut self,
        rate: f64,
        [center, upper]: [f64; 2],
        rates: &[VectorEntries],
        quaternions: impl Iterator<Item = QuaternionEntries>,
    ) {
        self.segments.push(Segment {
            upper,
            center,
            rate,
            first: self.rates.len(),
            terms: rates.len(),
        });
        self.rates.extend_from_slice(rates);
        self.quaternions.extend(quaternions);
    }

    /// Negates all quaternions, which leaves the rotations unchanged.
    pub(super) fn change_sign(&mut self) {
        for q in &mut self.quaternions {
            *q = q.map(|x| -x);
        }
    }

    #[inline(always)]
    fn at(&self, leg: usize, s: f64) -> (&Segment, f64) {
        let segments = &self.segments[self.legs[leg]..self.legs[leg + 1]];
        let segment = match segments {
            [only] => only,
            _ => {
                let which = segments.partition_point(|segment| segment.upper < s);
                &segments[which.min(segments.len() - 1)]
            }
        };
        (segment, segment.rate * (s - segment.center))
    }

    /// The unit quaternion at time `s` of a leg.
    #[inline(always)]
    pub(super) fn quaternion(&self, leg: usize, s: f64) -> QuaternionEntries {
        let (segment, u) = self.at(leg, s);
        let coefficients = &self.quaternions[segment.first..][..segment.terms];
        normalised(value(coefficients, u))
    }

    /// The body rate or a derivative of order up to 2, at time `s` of a leg of the given length.
    #[inline(always)]
    pub(super) fn rate(&self, leg: usize, s: f64, length: f64, order: usize) -> VectorEntries {
        let (segment, u) = self.at(leg, s);
        let coefficients = &self.rates[segment.first..][..segment.terms];
        let vector = match order {
            0 => value(coefficients, u),
            order => derivative(coefficients, u, order),
        };
        // Multiply one factor at a time: the product of the factors may overflow.
        (0..=order).fold(vector, |vector, _| {
            vector.map(|x| x * segment.rate / length)
        })
    }
}

/// The unit quaternion of a rotation matrix.
pub(super) fn of_matrix(entry: impl Fn(usize, usize) -> f64) -> QuaternionEntries {
    let matrix = Rotation3::from_matrix_unchecked(Matrix3::from_fn(entry));
    normalised(UnitQuaternion::from_rotation_matrix(&matrix).coords.into())
}
