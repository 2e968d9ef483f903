//! The one error type of the crate.
//!
//! Every variant carries the numbers needed to act on it. Invalid data never cause a panic: they are checked once, at
//! the public entry, and returned as one of these errors.

mod context;

use crate::report::SolverReport;

/// Errors of the crate, with the measured numbers.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Error, QuasiGeodesic};
/// // Many great circles join a point of the sphere and its antipode.
/// let (x, y) = (mat![[1.0], [0.0], [0.0]], mat![[-1.0], [0.0], [0.0]]);
/// let error = QuasiGeodesic::between(x.as_ref(), y.as_ref()).unwrap_err();
/// assert!(matches!(error, Error::NoJoiningCurve { .. }));
/// assert_eq!(error.angle(), Some(std::f64::consts::PI));
/// ```
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An array has a shape that the operation does not take.
    #[error("{name}: expected shape {expected}, found {found}")]
    Shape {
        /// Which argument.
        name: &'static str,
        /// The shape it should have.
        expected: String,
        /// The shape it has.
        found: String,
    },
    /// An entry is NaN or infinite.
    #[error("{name}: entry {index} is not finite")]
    NonFinite {
        /// Which argument.
        name: &'static str,
        /// Index of the first such entry, column by column.
        index: usize,
    },
    /// A scalar argument is out of its range.
    #[error("{name}: must be {requirement}, found {}", short(*found))]
    InvalidArgument {
        /// Which argument.
        name: &'static str,
        /// The range, in words.
        requirement: &'static str,
        /// Its value.
        found: f64,
    },
    /// Steps so long that a single one would turn too far.
    #[error(
        "steps: too few, one exponential would turn by {angle:.6e} radians, must be at most {largest}"
    )]
    TooFewSteps {
        /// The angle of one exponential, in radians.
        angle: f64,
        /// The largest allowed angle.
        largest: f64,
    },
    /// The columns are not orthonormal: `|S^T S - I|_F` exceeds the tolerance.
    #[error(
        "{name}: columns are not orthonormal, |S^T S - I| = {defect:.3e} exceeds {tolerance:.3e}; `Stiefel::project` gives the nearest point"
    )]
    NotOrthonormal {
        /// Which argument.
        name: &'static str,
        /// `|S^T S - I|_F`.
        defect: f64,
        /// What was allowed.
        tolerance: f64,
    },
    /// A vector is not tangent: `|S^T V + V^T S|_F / 2` exceeds the tolerance.
    #[error("{name}: not tangent, |S^T V + V^T S| / 2 = {defect:.3e} exceeds {tolerance:.3e}")]
    NotTangent {
        /// Which argument.
        name: &'static str,
        /// `|S^T V + V^T S|_F / 2`.
        defect: f64,
        /// What was allowed.
        tolerance: f64,
    },
    /// A vector is not tangent to the Grassmann manifold: `|Y^T V|_F` exceeds the tolerance.
    #[error("{name}: not horizontal, |Y^T V| = {defect:.3e} exceeds {tolerance:.3e}")]
    NotHorizontal {
        /// Which argument.
        name: &'static str,
        /// `|Y^T V|_F`.
        defect: f64,
        /// What was allowed.
        tolerance: f64,
    },
    /// A matrix is not skew-symmetric: `|A + A^T|_F / 2` exceeds the tolerance.
    #[error("{name}: not skew-symmetric, |A + A^T| / 2 = {defect:.3e} exceeds {tolerance:.3e}")]
    NotSkew {
        /// Which argument.
        name: &'static str,
        /// `|A + A^T|_F / 2`.
        defect: f64,
        /// What was allowed.
        tolerance: f64,
    },
    /// A complex matrix is not skew-Hermitian: `|A + A^H|_F / 2` exceeds the tolerance.
    #[error("{name}: not skew-Hermitian, |A + A^H| / 2 = {defect:.3e} exceeds {tolerance:.3e}")]
    NotSkewHermitian {
        /// Which argument.
        name: &'static str,
        /// `|A + A^H|_F / 2`.
        defect: f64,
        /// What was allowed.
        tolerance: f64,
    },
    /// A complex matrix is not unitary: `|Q^H Q - I|_F` exceeds the tolerance.
    #[error("{name}: not unitary, |Q^H Q - I| = {defect:.3e} exceeds {tolerance:.3e}")]
    NotUnitary {
        /// Which argument.
        name: &'static str,
        /// `|Q^H Q - I|_F`.
        defect: f64,
        /// What was allowed.
        tolerance: f64,
    },
    /// The nearest point of the manifold is not unique: the matrix has no full column rank.
    #[error(
        "{name}: no unique nearest point, smallest singular value {smallest:.3e}, largest {largest:.3e}"
    )]
    RankDeficient {
        /// Which argument.
        name: &'static str,
        /// The smallest singular value.
        smallest: f64,
        /// The largest singular value.
        largest: f64,
    },
    /// A rotation with an eigenvalue -1 to working precision (or of determinant -1) has no principal
    /// skew logarithm.
    #[error("no principal logarithm: a rotation angle is {angle:.17} (pi to working precision)")]
    OutsideLogDomain {
        /// The offending rotation angle in radians.
        angle: f64,
    },
    /// Half a turn between two rotations at which rates are given that do not decide its direction.
    #[error(
        "a rotation angle is {angle:.17} (pi to working precision), and the rates do not decide the direction"
    )]
    UndecidedTurn {
        /// The rotation angle in radians.
        angle: f64,
    },
    /// A rotation or unitary matrix at which the principal logarithm exists, but is not differentiable: two rotation
    /// angles approach `pi`, as for rotations, or `pi` and `-pi`.
    #[error(
        "the logarithm is not differentiable: two rotation angles have a mean size of {angle:.17} (pi up to 3e-11)"
    )]
    LogNotDifferentiable {
        /// Mean of the sizes of the two angles, in radians.
        angle: f64,
    },
    /// Two points that no unique shortest curve joins.
    #[error(
        "no unique shortest curve joins the points: an angle is {angle:.17} (pi to working precision)"
    )]
    NoJoiningCurve {
        /// The offending principal angle in radians.
        angle: f64,
    },
    /// Two subspaces, one of which holds a direction orthogonal to the other: no unique shortest geodesic joins them.
    #[error(
        "no unique shortest geodesic joins the subspaces: a principal angle is {angle:.17} (pi/2 to working precision)"
    )]
    RightAngle {
        /// The largest principal angle in radians.
        angle: f64,
    },
    /// Intermediate points of a de Casteljau curve cross the cut locus: the curve would jump.
    #[error(
        "no smooth curve: at t = {t:.6} intermediate points of de Casteljau's algorithm are an angle of pi apart, \
         and the quasi-geodesic between them jumps to another branch"
    )]
    BranchJump {
        /// The parameter of the jump.
        t: f64,
    },
    /// Points farther apart than geodesics are known to be the shortest.
    #[error(
        "points {index} and {}: distance {distance:.6} exceeds {bound:.6}, the known lower bound of the injectivity radius",
        index + 1
    )]
    BeyondInjectivity {
        /// The first of the two points.
        index: usize,
        /// Length of the geodesic between them.
        distance: f64,
        /// The known bound of the injectivity radius.
        bound: f64,
    },
    /// Points of O(n) of opposite determinant: no curve joins them.
    #[error(
        "the points lie in different components of O({n}): determinants of opposite sign (angle pi)"
    )]
    DifferentComponents {
        /// The size of the orthogonal matrices.
        n: usize,
    },
    /// A point outside of the range of a retraction: no tangent vector, or no unique one, leads there.
    #[error(
        "no unique inverse of the {retraction} retraction: {quantity} = {value:.3e}, must be {requirement}"
    )]
    OutsideRetractionDomain {
        /// Which retraction.
        retraction: &'static str,
        /// What was measured.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// The range, in words.
        requirement: &'static str,
    },
    /// Two linearly dependent tangent vectors, which do not span a plane.
    #[error(
        "{names}: linearly dependent, their unit vectors span an area of {area:.3e}, must exceed {tolerance:.3e}"
    )]
    LinearlyDependent {
        /// Which arguments.
        names: &'static str,
        /// The sine of the angle between them.
        area: f64,
        /// Largest area at which the vectors count as dependent.
        tolerance: f64,
    },
    /// Ends of a curve that are conjugate along it: the solution of the boundary value problem does not depend smoothly
    /// on its data.
    #[error(
        "the ends are conjugate along the curve: the derivative of the end with respect to the initial data has smallest \
         singular value {smallest:.3e}, largest {largest:.3e}, in the units of flat space"
    )]
    ConjugateEnds {
        /// The smallest singular value.
        smallest: f64,
        /// The largest singular value.
        largest: f64,
    },
    /// Complex data whose computed solution is not complex, because the data have no unique solution.
    #[error(
        "the solution is not complex: its distance from the embedded complex matrices is {defect:.3e}, above {tolerance:.3e} \
         (the data have no unique solution, or an unstable one)"
    )]
    NotComplex {
        /// Distance from the embedded matrices, Frobenius norm.
        defect: f64,
        /// What is allowed.
        tolerance: f64,
    },
    /// A chart coordinate outside of the chart.
    #[error(
        "outside of the chart: {coordinate} = {} is not in the open interval ({lower}, {upper})",
        short(*value)
    )]
    OutsideChart {
        /// The name of the coordinate.
        coordinate: &'static str,
        /// Its value.
        value: f64,
        /// Lower end of the interval.
        lower: f64,
        /// Upper end of the interval.
        upper: f64,
    },
    /// A result is too large for a floating-point number.
    #[error("{quantity}: the result is too large for a floating-point number")]
    Overflow {
        /// What was computed.
        quantity: &'static str,
    },
    /// A factorisation of finite input did not converge.
    #[error("the {kind} did not converge")]
    Decomposition {
        /// Which factorisation.
        kind: &'static str,
    },
    /// An iteration stopped without reaching its tolerance.
    #[error("{solver}: no convergence, {report}")]
    NoConvergence {
        /// Which solver.
        solver: &'static str,
        /// How far it got, and why it stopped.
        report: SolverReport,
    },
    /// An integration needs more steps than allowed: the curve is too long or too fast.
    #[error(
        "{solver}: too long or too fast, needs more than {limit} steps; {} taken, remaining parameter length {:.3e}, about \
         {forecast:.3e} more needed",
        .report.iterations,
        .report.residual
    )]
    TooManySteps {
        /// Which integration.
        solver: &'static str,
        /// Largest number of steps.
        limit: usize,
        /// Estimated number of remaining steps, from the length of the last one.
        forecast: f64,
        /// Steps taken; its residual is the remaining length of the parameter interval.
        report: SolverReport,
    },
    /// An error at a knot of a spline, or between it and the next knot.
    #[error("{}: {source}", place(*knot, source))]
    AtKnot {
        /// Index of the knot.
        knot: usize,
        /// The error.
        source: Box<Error>,
    },
    /// Control points, computed from the velocities, cannot be joined although the points of the piece can: the piece
    /// is too long or too fast for the construction.
    #[error("control points between them: {source}")]
    ControlPoints {
        /// The error.
        source: Box<Error>,
    },
    /// A spline that is not found because of an interval that is much longer than a neighbour: its curve would rush.
    #[error(
        "{source}; this interval is {ratio:.1} times as long as the shorter one beside it, and the spline of flat \
         space would be fast there (speed {speed:.1}, with the interval as the unit of time): add points within it"
    )]
    UnevenTimes {
        /// The error about all knots.
        source: Box<Error>,
        /// The speed at an end of the interval, times its duration.
        speed: f64,
        /// The duration of the interval over that of its shorter neighbour.
        ratio: f64,
    },
    /// Frames that are far apart only because their columns are rotated.
    #[error(
        "{source}; the nearest bases of their spans are {:.3} times as far apart: if only the span of the columns \
         matters, use the Grassmann manifold, or first align the bases with its method align",
        subspaces / frames
    )]
    OnlyBases {
        /// The error about them as frames.
        source: Box<Error>,
        /// The Frobenius distance of the frames; of embedded complex ones the root of 2 times their own.
        frames: f64,
        /// The Frobenius distance of the nearest bases of their spans.
        subspaces: f64,
    },
    /// A stored curve that is damaged, foreign, of another version or inconsistent.
    #[error("stored curve: {problem}")]
    Stored {
        /// Description of the problem.
        problem: String,
    },
    /// The caller asked a running computation to stop.
    #[error("{solver}: interrupted")]
    Interrupted {
        /// Which computation.
        solver: &'static str,
    },
}

/// A number in few characters: whole numbers exactly, others to the last digit, very large and very small ones with a
/// power of ten.
fn short(x: f64) -> String {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    let plain = 1e-4..=EXACT;
    if x == 0.0 || !x.is_finite() || plain.contains(&x.abs()) {
        format!("{x}")
    } else {
        format!("{x:e}")
    }
}

/// The knot of an error, or the two knots that could not be joined.
fn place(knot: usize, error: &Error) -> String {
    match error {
        Error::ControlPoints { .. }
        | Error::OutsideLogDomain { .. }
        | Error::UndecidedTurn { .. }
        | Error::LogNotDifferentiable { .. }
        | Error::NoJoiningCurve { .. }
        | Error::RightAngle { .. }
        | Error::OnlyBases { .. }
        | Error::UnevenTimes { .. }
        | Error::BranchJump { .. }
        | Error::DifferentComponents { .. }
        | Error::ConjugateEnds { .. }
        | Error::Decomposition { .. }
        | Error::NoConvergence { .. }
        | Error::TooManySteps { .. } => format!("knots {knot} and {}", knot + 1),
        _ => format!("knot {knot}"),
    }
}

/// The crate's result type.
pub type Result<T> = std::result::Result<T, Error>;

/// `None` for an attempt that failed; other results, and `Interrupted`, are passed on.
pub(crate) fn unless_interrupted<T>(outcome: Result<T>) -> Result<Option<T>> {
    match outcome {
        Err(error) if error.is_interrupted() => Err(error),
        other => Ok(other.ok()),
    }
}
