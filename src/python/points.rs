//! What the points of a curve are: the argument `manifold` of everything that makes one, and the attribute.

use super::grassmann::PyGrassmann;
use super::prelude::*;
use super::space::Space;
use super::stiefel::PyStiefel;
use crate::manifold::Metric;
use crate::space::Quotient;

/// The manifold of the points of a curve that is to be made.
pub(super) struct Points {
    pub(super) quotient: Quotient,
    /// Of the manifold, where one is given.
    given: Option<Given>,
}

struct Given {
    field: Field,
    shape: (usize, usize),
    name: String,
}

impl Points {
    /// Frames of the arrays' numbers where there is no manifold.
    pub(super) fn read(manifold: Option<&Any>) -> PyResult<Self> {
        let Some(object) = manifold else {
            return Ok(Points {
                quotient: Quotient::Frames,
                given: None,
            });
        };
        let name = object.repr()?.to_string();
        if let Ok(manifold) = object.cast::<PyGrassmann>() {
            let (field, shape) = (manifold.get().field(), manifold.get().shape());
            return Ok(Points {
                quotient: Quotient::Subspaces,
                given: Some(Given { field, shape, name }),
            });
        }
        let Ok(manifold) = object.cast::<PyStiefel>() else {
            let found = object.get_type().name()?;
            let message = format!("manifold: expected a Stiefel or a Grassmann, found {found}");
            return Err(PyTypeError::new_err(message));
        };
        let manifold = manifold.get();
        ensure!(
            manifold.core().metric() == Metric::CANONICAL,
            "manifold: curves are those of the canonical metric, found {name}"
        );
        let (field, shape) = (manifold.field(), manifold.shape());
        Ok(Points {
            quotient: Quotient::Frames,
            given: Some(Given { field, shape, name }),
        })
    }

    /// The field of the manifold, or of the arrays where there is none; `TypeError` for complex arrays on a real manifold.
    pub(super) fn field<'a, 'py: 'a>(
        &self,
        objects: impl IntoIterator<Item = &'a Any<'py>>,
    ) -> PyResult<Field> {
        let found = Field::of(objects)?;
        match &self.given {
            None => Ok(found),
            Some(given) if given.field == Field::Complex || found == Field::Real => Ok(given.field),
            Some(given) => {
                let name = &given.name;
                let message = format!("manifold: {name} has real points, found complex arrays");
                Err(PyTypeError::new_err(message))
            }
        }
    }

    /// `InvalidInputError` unless points of that shape of the core are those of the manifold.
    pub(super) fn check_shape(&self, field: Field, core: (usize, usize)) -> PyResult<()> {
        let Some(given) = &self.given else {
            return Ok(());
        };
        let (n, k) = field.own(core);
        ensure!(
            given.shape == (n, k),
            "manifold: {} has points of shape {:?}, found points of shape ({n}, {k})",
            given.name,
            given.shape
        );
        Ok(())
    }

    /// `InvalidInputError` for what there is of frames only.
    pub(super) fn only_frames(&self, what: &str) -> PyResult<()> {
        ensure!(
            self.quotient == Quotient::Frames,
            "{what}: not available on a Grassmann manifold, only for frames"
        );
        Ok(())
    }
}

/// The manifold of points of the core as an object of Python's.
pub(super) fn manifold_of(
    py: Python<'_>,
    quotient: Quotient,
    field: Field,
    core: (usize, usize),
) -> PyResult<Py<PyAny>> {
    match quotient {
        Quotient::Frames => PyStiefel::of_core(core, field)?.into_py_any(py),
        Quotient::Subspaces => PyGrassmann::of_core(core, field)?.into_py_any(py),
    }
}

/// `St(n, k)` or `Gr(n, k)` as messages write it, for a shape of the core.
pub(super) fn symbol(quotient: Quotient, field: Field, core: (usize, usize)) -> String {
    let name = field.manifold(core);
    match quotient {
        Quotient::Frames => name,
        Quotient::Subspaces => name.replacen("St", "Gr", 1),
    }
}
