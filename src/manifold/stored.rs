//! Stored form of quasi-geodesics and geodesics.

use faer::{Mat, MatRef, Scale};

use super::exponential::FrameMotion;
use super::{Geodesic, Metric, QuasiGeodesic};
use crate::error::Result;
use crate::interrupt::Interrupt;
use crate::linalg::structure::{distance, norm, orthonormality_defect, skew_defect};
use crate::manifold::normal_frame::normal_rank;
use crate::manifold::stiefel::{POINT_TOLERANCE, TANGENT_TOLERANCE};
use crate::space::Quotient;
use crate::stored::{Fields, Parts, Stored, extend, refusal};

impl Stored for QuasiGeodesic {
    const KIND: &'static str = "QuasiGeodesic";

    fn store(&self, fields: &mut Fields) {
        fields.put_whole("shape", [self.n(), self.k()]);
        store_legs([self], fields);
    }

    fn restore(fields: &mut Fields, _: Interrupt<'_>) -> Result<Self> {
        let [n, k] = fields.some_whole("shape")?;
        check_shape(n, k)?;
        let mut legs = Legs::of(fields)?;
        let curve = legs.next(n, k)?;
        legs.end()?;
        Ok(curve)
    }
}

/// Return an error unless `(n, k)` is the shape of a point.
pub(crate) fn check_shape(n: usize, k: usize) -> Result<()> {
    if 1 <= k && k <= n {
        return Ok(());
    }
    Err(refusal(format!(
        "shape: ({n}, {k}) is not the shape of a point"
    )))
}

/// Stores the numbers of several quasi-geodesics.
pub(crate) fn store_legs<'a>(
    legs: impl IntoIterator<Item = &'a QuasiGeodesic>,
    fields: &mut Fields,
) {
    let mut numbers: [Vec<f64>; 4] = Default::default();
    for leg in legs {
        let [frames, angles, rights, turns] = &mut numbers;
        extend(frames, leg.frame());
        angles.extend(leg.angles());
        extend(rights, leg.right());
        extend(turns, leg.omega());
    }
    for (name, numbers) in NAMES.into_iter().zip(numbers) {
        fields.put_flat(name, numbers);
    }
}

const NAMES: [&str; 4] = ["leg_frames", "leg_angles", "leg_rights", "leg_omegas"];

/// Allowed defect of stored points, per unit of the motion along the curve: ten times the tolerance of the points from
/// which a curve is built, since the curve carries their defect along.
pub(crate) const MEMBERSHIP: f64 = 10.0 * POINT_TOLERANCE;

/// Return an error unless the columns of a matrix are orthonormal.
pub(crate) fn check_orthonormal(name: &str, a: MatRef<'_, f64>) -> Result<()> {
    let defect = orthonormality_defect(a);
    // False also for NaN, from entries that overflow.
    if defect <= MEMBERSHIP {
        return Ok(());
    }
    Err(refusal(format!(
        "{name}: columns are not orthonormal, by {defect:.3e}, more than {MEMBERSHIP:.3e}"
    )))
}

/// Return an error unless points stay orthonormal when they move along `Q` in the frame `[S, Q]` with the given rates.
/// A direction with zero rate does not count, and one with a small rate may have a larger defect.
fn check_moving(
    name: &str,
    frame: MatRef<'_, f64>,
    k: usize,
    rates: &[f64],
    speed: f64,
) -> Result<()> {
    let weight = |j: usize| {
        if j < k {
            1.0
        } else {
            rates[j - k].abs().min(1.0)
        }
    };
    let gram = frame.transpose() * frame;
    let off = Mat::from_fn(gram.nrows(), gram.ncols(), |i, j| {
        weight(i) * weight(j) * (gram[(i, j)] - f64::from(u8::from(i == j)))
    });
    let (defect, allowed) = (norm(off.as_ref()), MEMBERSHIP * (1.0 + speed));
    if defect <= allowed {
        return Ok(());
    }
    Err(refusal(format!(
        "{name}: columns are not orthonormal, by {defect:.3e}, more than {allowed:.3e}"
    )))
}

/// Quasi-geodesics that are read one after another.
pub(crate) struct Legs {
    frames: Parts,
    angles: Parts,
    rights: Parts,
    omegas: Parts,
}

impl Legs {
    /// # Errors
    /// `Stored` if the numbers are missing.
    pub(crate) fn of(fields: &mut Fields) -> Result<Self> {
        Ok(Legs {
            frames: fields.parts(NAMES[0])?,
            angles: fields.parts(NAMES[1])?,
            rights: fields.parts(NAMES[2])?,
            omegas: fields.parts(NAMES[3])?,
        })
    }

    /// # Errors
    /// `Stored` if there are too few numbers, or if `Omega` is not skew-symmetric.
    pub(crate) fn next(&mut self, n: usize, k: usize) -> Result<QuasiGeodesic> {
        let columns = k.saturating_mul(2);
        let frame = self.frames.matrix(n, columns)?;
        let angles = self.angles.next(Some(k))?.to_vec();
        let right = self.rights.matrix(k, k)?;
        let omega = self.omegas.matrix(k, k)?;
        check_skew(NAMES[3], &omega)?;
        check_orthonormal(NAMES[2], right.as_ref())?;
        let speed = angles
            .iter()
            .fold(norm(omega.as_ref()), |sum, x| sum.hypot(*x));
        check_moving(NAMES[0], frame.as_ref(), k, &angles, speed)?;
        Ok(QuasiGeodesic {
            frame,
            angles,
            right,
            omega,
        })
    }

    /// # Errors
    /// `Stored` if numbers are left.
    pub(crate) fn end(self) -> Result<()> {
        for rest in [self.frames, self.angles, self.rights, self.omegas] {
            rest.end()?;
        }
        Ok(())
    }
}

impl Stored for Geodesic {
    const KIND: &'static str = "Geodesic";

    fn store(&self, fields: &mut Fields) {
        let columns = self.frame.ncols();
        fields.put_whole("shape", [self.frame.nrows(), self.k(), columns]);
        fields.put_flat("metric", vec![self.metric.alpha()]);
        if self.quotient == Quotient::Subspaces {
            fields.put_flat("subspaces", vec![1.0]);
        }
        let matrices = [
            Some(&self.frame),
            Some(&self.motion.generator),
            self.motion.turning.as_ref(),
        ];
        for (name, matrix) in MATRICES.into_iter().zip(matrices) {
            let mut entries = Vec::new();
            if let Some(matrix) = matrix {
                extend(&mut entries, matrix.as_ref());
            }
            fields.put_flat(name, entries);
        }
    }

    fn restore(fields: &mut Fields, _: Interrupt<'_>) -> Result<Self> {
        let [n, k, columns] = fields.some_whole("shape")?;
        check_shape(n, k)?;
        if columns != k + normal_rank(n, k) {
            return Err(refusal(format!("shape: {columns} columns for k = {k}")));
        }
        let mut metric = fields.parts("metric")?;
        let [alpha] = metric.some()?;
        metric.end()?;
        let metric = Metric::new(alpha)?;
        let mut subspaces = fields.parts_or_zeros("subspaces", 1)?;
        let quotient = quotient_of(subspaces.some()?)?;
        subspaces.end()?;
        let sizes = [(n, columns), (columns, columns), (k, k)];
        let mut matrices = [None, None, None];
        for ((name, (rows, cols)), matrix) in MATRICES.into_iter().zip(sizes).zip(&mut matrices) {
            let mut entries = fields.parts(name)?;
            // If twice the weight is one, the second factor is the identity.
            if name != TURNING || 2.0 * metric.weight() != 1.0 {
                *matrix = Some(entries.matrix(rows, cols)?);
            }
            entries.end()?;
        }
        let [Some(frame), Some(generator), turning] = matrices else {
            unreachable!("both are read")
        };
        for skew in [Some(&generator), turning.as_ref()].into_iter().flatten() {
            check_skew("generator", skew)?;
        }
        check_blocks(&generator, turning.as_ref(), k, metric)?;
        let rates: Vec<f64> = (k..columns)
            .map(|i| norm(generator.as_ref().submatrix(i, 0, 1, k)))
            .collect();
        check_moving("frame", frame.as_ref(), k, &rates, norm(generator.as_ref()))?;
        if quotient == Quotient::Subspaces && norm(generator.as_ref().submatrix(0, 0, k, k)) > 0.0 {
            return Err(refusal(
                "generator: bases of subspaces must not turn within the subspace".to_owned(),
            ));
        }
        Ok(Geodesic {
            quotient,
            frame,
            motion: FrameMotion {
                generator,
                turning,
                k,
            },
            metric,
        })
    }
}

/// The meaning of the points, from the stored 0 or 1.
///
/// # Errors
/// `Stored`.
pub(crate) fn quotient_of([stored]: [f64; 1]) -> Result<Quotient> {
    match stored {
        0.0 => Ok(Quotient::Frames),
        1.0 => Ok(Quotient::Subspaces),
        _ => Err(refusal(format!(
            "subspaces: expected 0 or 1, found {stored}"
        ))),
    }
}

const TURNING: &str = "turning";
const MATRICES: [&str; 3] = ["frame", "generator", TURNING];

/// Return an error unless the matrices of a geodesic are `[[2 w A, -B^T], [B, 0]]` and `(1 - 2 w) A`.
fn check_blocks(
    generator: &Mat<f64>,
    turning: Option<&Mat<f64>>,
    k: usize,
    metric: Metric,
) -> Result<()> {
    let p = generator.nrows() - k;
    let size = norm(generator.as_ref());
    let rest = norm(generator.as_ref().submatrix(k, k, p, p));
    if rest > TANGENT_TOLERANCE * size {
        let problem = format!("generator: {rest:.3e} in place of zeros");
        return Err(refusal(problem));
    }
    let Some(turning) = turning else {
        return Ok(());
    };
    let twice = 2.0 * metric.weight();
    let a = generator.as_ref().submatrix(0, 0, k, k) * Scale((1.0 - twice) / twice);
    let gap = distance(turning.as_ref(), a.as_ref());
    if gap > TANGENT_TOLERANCE * norm(a.as_ref()) {
        let problem = format!("turning: differs from the generator by {gap:.3e}");
        return Err(refusal(problem));
    }
    Ok(())
}

/// Return an error unless a matrix is skew-symmetric.
fn check_skew(name: &str, a: &Mat<f64>) -> Result<()> {
    let defect = skew_defect(a.as_ref());
    if defect <= TANGENT_TOLERANCE * norm(a.as_ref()) {
        return Ok(());
    }
    Err(refusal(format!(
        "{name}: not skew-symmetric, by {defect:.3e}"
    )))
}
