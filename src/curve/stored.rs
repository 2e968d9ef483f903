//! Stored form of de Casteljau curves.

use std::f64::consts::FRAC_PI_2;

use faer::{Mat, MatRef};

use super::curve::Curve;
use super::de_casteljau::GeometricPolynomial;
#[cfg(feature = "python")]
use super::geodesic_polynomial::GeodesicPolynomial;
use super::geometric_cubic::GeometricCubic;
use super::subspace_polynomial::SubspacePolynomial;
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::structure::{distance, norm};
use crate::manifold::QuasiGeodesic;
use crate::manifold::stored::{Legs, MEMBERSHIP, check_orthonormal, check_shape, store_legs};
use crate::stored::{Fields, READER, Stored, StoredPiece, extend, only, refusal};

impl Stored for GeometricPolynomial {
    const KIND: &'static str = "GeometricPolynomial";

    fn store(&self, fields: &mut Fields) {
        store_polynomials(&[self], fields);
    }

    fn restore(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Self> {
        only(restore_polynomials(fields, interrupt)?)
    }
}

impl Stored for GeometricCubic {
    const KIND: &'static str = "GeometricCubic";

    fn store(&self, fields: &mut Fields) {
        Self::store_all(std::slice::from_ref(self), fields);
    }

    fn restore(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Self> {
        only(Self::restore_all(fields, interrupt)?)
    }
}

impl StoredPiece for GeometricCubic {
    const SPLINE: &'static str = "spline of GeometricCubic";

    fn store_all(pieces: &[Self], fields: &mut Fields) {
        let polynomials: Vec<_> = pieces.iter().map(GeometricCubic::as_polynomial).collect();
        store_polynomials(&polynomials, fields);
    }

    fn restore_all(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Vec<Self>> {
        let polynomials = restore_polynomials(fields, interrupt)?;
        polynomials
            .into_iter()
            .map(|curve| match curve.degree() {
                3 => Ok(GeometricCubic::of_polynomial(curve)),
                degree => Err(refusal(format!("expected degree 3, found {degree}"))),
            })
            .collect()
    }
}

impl Stored for SubspacePolynomial {
    const KIND: &'static str = "SubspacePolynomial";

    fn store(&self, fields: &mut Fields) {
        Self::store_all(std::slice::from_ref(self), fields);
    }

    fn restore(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Self> {
        only(Self::restore_all(fields, interrupt)?)
    }
}

/// The bases are recomputed from the geodesics.
impl StoredPiece for SubspacePolynomial {
    const SPLINE: &'static str = "spline of SubspacePolynomial";

    fn store_all(pieces: &[Self], fields: &mut Fields) {
        let points: Vec<_> = pieces.iter().map(Self::reduced).collect();
        let shape = pieces.first().map(|curve| [curve.n(), curve.k()]);
        store_control_points(shape.unwrap_or_default(), &points, fields);
        store_legs(pieces.iter().flat_map(Self::legs), fields);
    }

    fn restore_all(fields: &mut Fields, interrupt: Interrupt<'_>) -> Result<Vec<Self>> {
        restore_with_legs(fields, interrupt, check_spans)?
            .into_iter()
            .map(|((frame, points), legs)| Self::of_legs(points, frame, legs, interrupt))
            .collect()
    }
}

fn store_polynomials(curves: &[&GeometricPolynomial], fields: &mut Fields) {
    let points: Vec<_> = curves
        .iter()
        .map(|curve| (curve.frame(), curve.reduced_points()))
        .collect();
    let shape = curves
        .first()
        .map_or([0, 0], |curve| [curve.n(), curve.k()]);
    store_control_points(shape, &points, fields);
    store_legs(curves.iter().flat_map(|curve| curve.legs()), fields);
}

fn restore_polynomials(
    fields: &mut Fields,
    interrupt: Interrupt<'_>,
) -> Result<Vec<GeometricPolynomial>> {
    let curves = restore_with_legs(fields, interrupt, check_ends)?;
    curves
        .into_iter()
        .map(|((frame, points), legs)| {
            interrupt.check(READER)?;
            let curve = GeometricPolynomial::unchecked(points, frame, legs)?;
            curve.check_branch()?;
            Ok(curve)
        })
        .collect()
}

/// Control points with the legs between them, each of which is checked by `check` with its two ends.
fn restore_with_legs(
    fields: &mut Fields,
    interrupt: Interrupt<'_>,
    check: fn(&QuasiGeodesic, &[Mat<f64>]) -> Result<()>,
) -> Result<Vec<(ControlPoints, Vec<QuasiGeodesic>)>> {
    let points = restore_control_points(fields)?;
    let mut legs = Legs::of(fields)?;
    let mut curves = Vec::with_capacity(points.len());
    for (frame, points) in points {
        interrupt.check(READER)?;
        let (r, k) = points[0].shape();
        let own = points
            .windows(2)
            .map(|ends| {
                let leg = legs.next(r, k)?;
                check(&leg, ends)?;
                Ok(leg)
            })
            .collect::<Result<_>>()?;
        curves.push(((frame, points), own));
    }
    legs.end()?;
    Ok(curves)
}

/// Return an error unless a leg runs from one control point to the next.
fn check_ends(leg: &QuasiGeodesic, ends: &[Mat<f64>]) -> Result<()> {
    check_gap(leg, 0.0, &ends[0])?;
    check_gap(leg, 1.0, &ends[1])
}

/// Return an error unless a leg is the shortest geodesic from one basis to the span of the next.
fn check_spans(leg: &QuasiGeodesic, ends: &[Mat<f64>]) -> Result<()> {
    let angle = leg.angles().iter().fold(0.0_f64, |m, a| m.max(a.abs()));
    if angle >= FRAC_PI_2 || norm(leg.omega()) > 0.0 {
        return Err(refusal(
            "legs: one is not a shortest geodesic of subspaces".to_owned(),
        ));
    }
    check_gap(leg, 0.0, &ends[0])?;
    let in_terms = ends[1].transpose() * leg.point(1.0)?;
    check_gap(leg, 1.0, &(&ends[1] * in_terms))
}

/// Return an error unless a leg passes through a point.
fn check_gap(leg: &QuasiGeodesic, t: f64, point: &Mat<f64>) -> Result<()> {
    let speed = norm(leg.initial_velocity().as_ref());
    let gap = distance(leg.point(t)?.as_ref(), point.as_ref());
    // If numbers overflow, the gap is NaN.
    if gap.is_nan() || gap > MEMBERSHIP * (1.0 + speed) {
        let problem = format!("legs: one is {gap:.3e} away from its control point");
        return Err(refusal(problem));
    }
    Ok(())
}

/// A frame and control points in its coordinates.
type StoredCoordinates<'a> = (Option<MatRef<'a, f64>>, &'a [Mat<f64>]);

/// Stores frames and control points in their coordinates.
fn store_control_points(shape: [usize; 2], curves: &[StoredCoordinates<'_>], fields: &mut Fields) {
    let (mut frames, mut points) = (Vec::new(), Vec::new());
    for (frame, own) in curves {
        if let Some(frame) = frame {
            extend(&mut frames, *frame);
        }
        for point in *own {
            extend(&mut points, point.as_ref());
        }
    }
    let framed = curves.iter().map(|(frame, _)| usize::from(frame.is_some()));
    fields.put_whole("shape", shape);
    fields.put_whole("degrees", curves.iter().map(|(_, points)| points.len() - 1));
    fields.put_whole("ranks", curves.iter().map(|(_, points)| points[0].nrows()));
    fields.put_whole("framed", framed);
    fields.put_flat("frames", frames);
    fields.put_flat("control_points", points);
}

type ControlPoints = (Option<Mat<f64>>, Vec<Mat<f64>>);

fn restore_control_points(fields: &mut Fields) -> Result<Vec<ControlPoints>> {
    let [n, k] = fields.some_whole("shape")?;
    let degrees = fields.whole("degrees")?;
    let ranks = fields.whole_each("ranks", degrees.len())?;
    let framed = fields.whole_each("framed", degrees.len())?;
    let mut frames = fields.parts("frames")?;
    let mut points = fields.parts("control_points")?;
    let mut curves = Vec::with_capacity(degrees.len());
    for ((degree, rank), framed) in degrees.into_iter().zip(ranks).zip(framed) {
        check_shape(rank, k)?;
        let frame = match framed {
            1 if rank <= n => {
                let frame = frames.matrix(n, rank)?;
                check_orthonormal("frames", frame.as_ref())?;
                Some(frame)
            }
            0 if rank == n => None,
            _ => {
                return Err(refusal(format!(
                    "{rank} dimensions of {n} (framed: {framed})"
                )));
            }
        };
        if degree == 0 {
            return Err(refusal("degrees: must be at least 1, found 0".to_owned()));
        }
        let own = (0..=degree)
            .map(|_| {
                let point = points.matrix(rank, k)?;
                check_orthonormal("control_points", point.as_ref())?;
                Ok(point)
            })
            .collect::<Result<_>>()?;
        curves.push((frame, own));
    }
    frames.end()?;
    points.end()?;
    Ok(curves)
}

#[cfg(feature = "python")]
impl Stored for GeodesicPolynomial {
    const KIND: &'static str = "GeodesicPolynomial";

    fn store(&self, fields: &mut Fields) {
        let curve = (self.frame(), self.reduced_points());
        store_control_points([self.n(), self.k()], &[curve], fields);
    }

    /// The geodesics between the control points are recomputed.
    fn restore(fields: &mut Fields, _: Interrupt<'_>) -> Result<Self> {
        let (frame, points) = only(restore_control_points(fields)?)?;
        Self::of_reduced(points, frame)
    }
}
