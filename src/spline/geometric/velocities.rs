//! Velocities at knots, estimated from the points alone.

use faer::{Mat, MatRef, Scale};

use super::links::Links;
use crate::error::Result;
use crate::legs::Knots;
use crate::linalg::product::{columns, entries};
use crate::linalg::structure::{check_range, norm};
use crate::manifold::only_bases::advised_knots;
use crate::solve::direction::Direction;
use crate::solve::tridiagonal::Isometries;
use crate::space::{Kind, Quotient};
use crate::spline::ends::{EndConditions, Ends, check_ends};
use crate::spline::knots;
use crate::spline::reduced_knots::ReducedKnots;

/// The method for estimating velocities.
///
/// The formulas are those of flat space, applied in tangent spaces: displacements are the velocities of the
/// quasi-geodesics between neighbouring points, whose rotations carry vectors from knot to knot. On the circle `St(2,
/// 1)` this is exactly the formula for the angle. For subspaces displacements are logarithms, and vectors are carried
/// by parallel transport. With slopes `m = displacement / h`:
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::Quotient;
/// use stiefel_rs::spline::{VelocityEstimate, estimate_velocities};
/// // On the circle, a jump between two rests.
/// let points = [0.0_f64, 0.0, 0.0, 1.0, 1.0, 1.0].map(|a| mat![[a.cos()], [a.sin()]]);
/// let (t, views) = ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], points.each_ref().map(|point| point.as_ref()));
/// // The parabola takes half of the slope of the jump, which undershoots before it; Akima's mean stays at rest.
/// let parabolas = estimate_velocities(&t, &views, VelocityEstimate::CatmullRom, Quotient::Frames)?;
/// assert!((parabolas[2].norm_l2() - 0.5).abs() < 1e-14);
/// let akima = estimate_velocities(&t, &views, VelocityEstimate::Akima, Quotient::Frames)?;
/// assert!(akima[2].norm_l2() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum VelocityEstimate {
    /// The velocity of the parabola through a knot and its two neighbours; at an end, through the last three points.
    ///
    /// ```math
    /// v_i = \frac{h_+ m_- + h_- m_+}{h_- + h_+}
    /// ```
    ///
    /// For equally spaced times this is the Catmull-Rom formula, half of the displacement between the neighbours. It is
    /// local: moving a point changes only the velocities at its neighbours. For smooth data its error is of second
    /// order.
    CatmullRom,
    /// A weighted mean of the slopes on both sides; a side has more weight the less its slopes change. There is no
    /// overshoot near jumps and near constant parts.
    ///
    /// ```math
    /// v_i = \frac{w_{i+1} m_- + w_{i-1} m_+}{w_{i-1} + w_{i+1}},\qquad
    /// w_j = |m_+ - m_-| + \tfrac12 |m_+ + m_-| \text{ at knot } j
    /// ```
    ///
    /// with norms of the manifold's metric, and slopes extrapolated linearly beyond the ends.
    ///
    /// Source: Akima (1970), J. ACM 17, 589-602, with the weights of MATLAB's and SciPy's "makima".
    Akima,
    /// The velocities of the natural cubic spline (of the periodic one for closed data), in tangent spaces. In the
    /// interior the error is of third order on spheres and for subspaces, and of second order elsewhere, where
    /// quasi-geodesics are not geodesics.
    Natural,
}

impl VelocityEstimate {
    /// The estimate with a given name, the same in Rust and Python: `"catmull-rom"`, `"akima"` or `"natural"`.
    pub fn from_word(word: &str) -> Option<Self> {
        match word {
            "catmull-rom" => Some(VelocityEstimate::CatmullRom),
            "akima" => Some(VelocityEstimate::Akima),
            "natural" => Some(VelocityEstimate::Natural),
            _ => None,
        }
    }
}

/// Estimate velocities at all knots: tangent vectors per unit of time, each of shape `(n, k)`.
///
/// Pass them to [`cubic_hermite`](crate::spline::cubic_hermite) or
/// [`geometric_hermite`](crate::spline::geometric_hermite) to obtain a curve through the points. For subspaces they are
/// horizontal at the given bases; changing the basis at one knot changes only the representation of the velocity there.
///
/// # Arguments
/// * `t` - increasing times, two or more; `points` - one per time, shape `(n, k)`; `quotient` - the meaning of the
///   points
/// # Errors
/// `Shape`, `NonFinite`, `InvalidArgument` (times), `Overflow`; wrapped in `AtKnot`: `NotOrthonormal`,
/// `NoJoiningCurve`, `OutsideLogDomain`, `DifferentComponents` (no quasi-geodesic leads to the next point), in `OnlyBases`
/// if the two look like mere bases; `RightAngle` (a principal angle to the next subspace is pi/2).
///
/// # Examples
/// ```
/// use faer::{Mat, MatRef};
/// use stiefel_rs::Quotient;
/// use stiefel_rs::spline::{VelocityEstimate, estimate_velocities};
/// // A circle at constant speed 1/2.
/// let t = [0.0, 1.0, 3.0, 4.0];
/// let points = t.map(|t: f64| Mat::from_fn(2, 1, |i, _| [(0.5 * t).cos(), (0.5 * t).sin()][i]));
/// let views: Vec<MatRef<'_, f64>> = points.iter().map(Mat::as_ref).collect();
/// let v = estimate_velocities(&t, &views, VelocityEstimate::CatmullRom, Quotient::Frames)?;
/// assert!((v[0][(1, 0)] - 0.5).abs() < 1e-15);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
pub fn estimate_velocities(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    estimate: VelocityEstimate,
    quotient: Quotient,
) -> Result<Vec<Mat<f64>>> {
    estimated(t, points, estimate, quotient, &EndConditions::Natural)
}

/// As [`estimate_velocities`], for a closed curve: the last point equals the first one, and so does its velocity. For
/// subspaces the last basis may be any basis of the first subspace.
///
/// # Errors
/// As [`estimate_velocities`], and `InvalidArgument` wrapped in `AtKnot` if the last point differs from the first one.
pub fn estimate_closed_velocities(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    estimate: VelocityEstimate,
    quotient: Quotient,
) -> Result<Vec<Mat<f64>>> {
    estimated(t, points, estimate, quotient, &EndConditions::Periodic)
}

fn estimated(
    t: &[f64],
    points: &[MatRef<'_, f64>],
    estimate: VelocityEstimate,
    quotient: Quotient,
    ends: &EndConditions,
) -> Result<Vec<Mat<f64>>> {
    knots::check(t, points)?;
    check_ends(quotient, points, ends)?;
    let kind = Kind::real(quotient);
    let knots = ReducedKnots::of_spline(kind, t, points, ends)?;
    let links = Links::new(&knots.points, quotient);
    let links = links.map_err(|error| advised_knots(error, quotient, points))?;
    let low_ends = knots.ends(ends, |_, v| entries(v));
    let slopes = Slopes {
        grid: Knots::of_points(&knots.lengths, &low_ends),
        points: &knots.points,
        links,
    };
    let mut velocities = match estimate {
        VelocityEstimate::Natural => slopes.natural()?,
        VelocityEstimate::CatmullRom => slopes.parabolas(),
        VelocityEstimate::Akima => slopes.akima(),
    };
    if matches!(ends, EndConditions::Periodic) {
        velocities.push(velocities[0].clone());
    }
    let rate = Scale(1.0 / knots.unit);
    let lifted = points.iter().zip(&velocities);
    lifted
        .enumerate()
        .map(|(knot, (point, v))| {
            let v = knots.lift_vector(knot, *point, v.as_ref()) * rate;
            check_range("velocities", v.as_ref())?;
            Ok(v)
        })
        .collect()
}

/// The slopes on both sides of every knot.
struct Slopes<'a> {
    grid: Knots<'a>,
    points: &'a [Mat<f64>],
    links: Links,
}

impl Slopes<'_> {
    fn is_closed(&self) -> bool {
        matches!(self.grid.ends, Ends::Periodic)
    }

    fn legs(&self) -> usize {
        self.grid.lengths.len()
    }

    fn natural(mut self) -> Result<Vec<Mat<f64>>> {
        let mut all = self.links.right_sides(&self.grid);
        self.grid.flat_system()?.solve(&mut self.links, &mut all)?;
        let velocities = all.chunks(self.links.size());
        Ok(velocities
            .map(|entries| columns(entries, self.points[0].nrows()).to_owned())
            .collect())
    }

    /// The slope of a leg at its end.
    fn last(&self, leg: usize) -> Mat<f64> {
        self.links.last(leg) * Scale(1.0 / self.grid.lengths[leg])
    }

    /// The slope of a leg at its start.
    fn first(&self, leg: usize) -> Mat<f64> {
        self.links.first(leg) * Scale(1.0 / self.grid.lengths[leg])
    }

    /// Velocities of parabolas through three points.
    fn parabolas(mut self) -> Vec<Mat<f64>> {
        let inner = |slopes: &Self, knot| match slopes.grid.legs_at(knot) {
            [Some(before), Some(after)] => {
                let (h0, h1) = (slopes.grid.lengths[before], slopes.grid.lengths[after]);
                let [m0, m1] = [slopes.last(before), slopes.first(after)];
                Some(m0 * Scale(h1 / (h0 + h1)) + m1 * Scale(h0 / (h0 + h1)))
            }
            _ => None,
        };
        let mut velocities: Vec<Mat<f64>> = (0..self.grid.count())
            .map(|knot| inner(&self, knot).unwrap_or_else(|| Mat::zeros(0, 0)))
            .collect();
        if self.is_closed() {
            return velocities;
        }
        // On a parabola, the slope between two points is the mean of the velocities there.
        let last = self.legs();
        let (first_slope, last_slope) = (self.first(0), self.last(last - 1));
        if last == 1 {
            return vec![first_slope, last_slope];
        }
        let before = self.carried(0, &velocities[1], Direction::Backward);
        velocities[0] = first_slope * Scale(2.0) - before;
        let after = self.carried(last - 1, &velocities[last - 1], Direction::Forward);
        velocities[last] = last_slope * Scale(2.0) - after;
        velocities
    }

    fn carried(&mut self, link: usize, v: &Mat<f64>, way: Direction) -> Mat<f64> {
        let mut carried = Mat::zeros(v.nrows(), v.ncols());
        self.links.carry(link, v.as_ref(), carried.as_mut(), way);
        carried
    }

    fn akima(mut self) -> Vec<Mat<f64>> {
        let (legs, closed) = (self.legs(), self.is_closed());
        if legs == 1 {
            let both = vec![self.first(0), self.last(0)];
            return both.into_iter().take(self.grid.count()).collect();
        }
        let weights = self.weights();
        let weight = |knot: usize, step: usize| {
            // For an open curve the weights start one knot before the first.
            let place = knot + step;
            if closed {
                weights[(place + legs - 1) % legs]
            } else {
                weights[place]
            }
        };
        (0..self.grid.count())
            .map(|knot| {
                let [before, after] = self.slopes_at(knot);
                let [w0, w1] = [weight(knot, 0), weight(knot, 2)];
                let sum = w0 + w1;
                // All weights vanish: four slopes are zero.
                let share = if sum > 0.0 { w0 / sum } else { 0.5 };
                &before + (&after - &before) * Scale(share)
            })
            .collect()
    }

    /// The slopes before and after a knot, extrapolated linearly beyond the ends if there are at least two legs.
    fn slopes_at(&mut self, knot: usize) -> [Mat<f64>; 2] {
        match self.grid.legs_at(knot) {
            [Some(before), Some(after)] => [self.last(before), self.first(after)],
            [None, _] => {
                let (near, next) = (self.first(0), self.first(1));
                let far = self.carried(0, &next, Direction::Backward);
                [&near * Scale(2.0) - far, near]
            }
            [Some(leg), None] => {
                let (near, next) = (self.last(leg), self.last(leg - 1));
                let far = self.carried(leg, &next, Direction::Forward);
                let beyond = &near * Scale(2.0) - far;
                [near, beyond]
            }
        }
    }

    /// `w_j` at the knots; for an open curve from one knot before the first to one past the last.
    fn weights(&self) -> Vec<f64> {
        let inner = |knot: usize| match self.grid.legs_at(knot) {
            [Some(before), Some(after)] => {
                self.weight(knot, &self.last(before), &self.first(after))
            }
            _ => 0.0,
        };
        if self.is_closed() {
            return (0..self.legs()).map(inner).collect();
        }
        let legs = self.legs();
        let mut weights = vec![0.0; legs + 3];
        for knot in 1..legs {
            weights[knot + 1] = inner(knot);
        }
        // Slopes `a, b` at the knot next to an end are extrapolated to `2 a - b` and `3 a - 2 b`.
        for (knot, a, b, places) in [
            (1, self.last(0), self.first(1), [1, 0]),
            (
                legs - 1,
                self.first(legs - 1),
                self.last(legs - 2),
                [legs + 1, legs + 2],
            ),
        ] {
            let once = &a * Scale(2.0) - &b;
            let twice = &a * Scale(3.0) - &b * Scale(2.0);
            weights[places[0]] = self.weight(knot, &once, &a);
            weights[places[1]] = self.weight(knot, &twice, &once);
        }
        weights
    }

    /// `|b - a| + |b + a| / 2` at a knot.
    fn weight(&self, knot: usize, a: &Mat<f64>, b: &Mat<f64>) -> f64 {
        let point = self.points[knot].as_ref();
        canonical_norm(point, &(b - a)) + 0.5 * canonical_norm(point, &(b + a))
    }
}

/// `sqrt(|V|^2 - |S^T V|^2 / 2)`, which is `|V|` for horizontal vectors.
fn canonical_norm(s: MatRef<'_, f64>, v: &Mat<f64>) -> f64 {
    let (full, along) = (norm(v.as_ref()), norm((s.transpose() * v).as_ref()));
    (full * full - 0.5 * along * along).max(0.0).sqrt()
}
