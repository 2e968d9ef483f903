//! The one-parameter family of metrics on `St(n, k)` that contains the canonical and the Euclidean one.

use std::hash::{Hash, Hasher};

use crate::error::{Error, Result};

/// A left-invariant metric of the alpha family.
///
/// With `V = S Omega + K`, `S^T K = 0`:
///
/// ```math
/// \langle V, W \rangle_S = \mathrm{tr}\, V^T \Big( I - \frac{2\alpha + 1}{2(\alpha + 1)} S S^T \Big) W,\qquad
/// |V|^2 = |K|^2 + \frac{1}{2(\alpha + 1)} |\Omega|^2
/// ```
///
/// # Source
/// Hueper, Markina, Silva Leite (2021), "A Lagrangian approach to extremal curves on Stiefel manifolds", J. Geometric
/// Mechanics 13, 55-72.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::{Metric, Stiefel};
/// // A turn within the columns: the Euclidean metric counts its squared norm, the canonical one half of it.
/// let s = mat![[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
/// let v = mat![[0.0, -1.0], [1.0, 0.0], [0.0, 0.0]];
/// let canonical = Stiefel::new(3, 2)?;
/// let euclidean = canonical.with_metric(Metric::EUCLIDEAN);
/// assert!((canonical.norm(s.as_ref(), v.as_ref())? - 1.0).abs() < 1e-14);
/// assert!((euclidean.norm(s.as_ref(), v.as_ref())? - 2.0_f64.sqrt()).abs() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Metric {
    alpha: f64,
}

impl Metric {
    /// `alpha = 0`: the metric of the quotient `SO(n) / SO(n-k)`.
    pub const CANONICAL: Metric = Metric { alpha: 0.0 };

    /// `alpha = -1/2`: the metric of the embedding in `R^{n x k}`.
    pub const EUCLIDEAN: Metric = Metric { alpha: -0.5 };

    /// The metric with parameter `alpha > -1`.
    ///
    /// # Errors
    /// `InvalidArgument` unless `alpha` is finite and above -1.
    pub fn new(alpha: f64) -> Result<Self> {
        if alpha.is_finite() && alpha > -1.0 {
            // Adding zero makes -0 equal to 0.
            return Ok(Metric { alpha: alpha + 0.0 });
        }
        Err(Error::InvalidArgument {
            name: "alpha",
            requirement: "finite and above -1",
            found: alpha,
        })
    }

    /// The parameter.
    pub fn alpha(self) -> f64 {
        self.alpha
    }

    /// The weight of `|Omega|^2`, `1 / (2 (alpha + 1))`: 1/2 for the canonical metric, 1 for the Euclidean one.
    pub fn weight(self) -> f64 {
        0.5 / (self.alpha + 1.0)
    }
}

impl Default for Metric {
    fn default() -> Self {
        Metric::CANONICAL
    }
}

// Never NaN, so equality is an equivalence relation; -0 does not occur.
impl Eq for Metric {}

impl Hash for Metric {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.alpha.to_bits().hash(state);
    }
}
