//! The meaning of a matrix with orthonormal columns: a frame, or the subspace it spans.

/// The quotient of the orthogonal group whose points are represented by matrices with orthonormal columns.
///
/// A curve of subspaces is represented by bases that rotate as little as possible, `Y^T Y' = 0`; vectors at a basis are
/// horizontal, `Y^T V = 0`, and `(Y Q, V Q)` means the same as `(Y, V)` for every orthogonal `Q`.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{IntegrationOptions, RiemannianCubic};
/// use stiefel_rs::{Curve, Interrupt, Quotient};
/// // Lines in the plane through the angle t, as subspaces.
/// let (y, v, zero) = (mat![[1.0], [0.0]], mat![[0.0], [1.0]], mat![[0.0], [0.0]]);
/// let options = IntegrationOptions { quotient: Quotient::Subspaces, ..Default::default() };
/// let [start, v, zero] = [&y, &v, &zero].map(|a| a.as_ref());
/// let curve = RiemannianCubic::from_initial(start, v, zero, zero, &options, Interrupt::NEVER)?;
/// assert!((curve.point(0.5)? - mat![[0.5_f64.cos()], [0.5_f64.sin()]]).norm_l2() < 1e-15);
/// assert_eq!(curve.quotient(), Quotient::Subspaces);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Quotient {
    /// The matrix itself: `St(n, k) = SO(n) / SO(n - k)`.
    #[default]
    Frames,
    /// The span of its columns: `Gr(n, k) = O(n) / (O(k) x O(n - k))`.
    Subspaces,
}

impl Quotient {
    /// Number of independent entries of the skew block that rotates `k` columns among themselves.
    pub(crate) fn turns(self, k: usize) -> usize {
        match self {
            Quotient::Frames => k * k.saturating_sub(1) / 2,
            Quotient::Subspaces => 0,
        }
    }
}
