//! The manifold of the points of a curve, and how points are read: the arguments `manifold` and `project` of all constructors.

use super::grassmann::PyGrassmann;
use super::membership::{Role, at_knot_of, on_manifold, role};
use super::prelude::*;
use super::projection::Projection;
use super::space::Space;
use super::stiefel::PyStiefel;
use crate::linalg::structure::distance;
use crate::manifold::Metric;
use crate::space::Quotient;

/// The manifold of the points of a curve under construction.
pub(super) struct Points {
    pub(super) quotient: Quotient,
    projection: Projection,
    /// On the given manifold, if any.
    given: Option<GivenManifold>,
}

struct GivenManifold {
    field: Field,
    shape: (usize, usize),
    name: String,
}

impl Points {
    /// On the Stiefel manifold over the field of the arrays if no manifold is given.
    pub(super) fn read(manifold: Option<&Any>, project: bool) -> PyResult<Self> {
        let projection = Projection::of(project);
        let Some(object) = manifold else {
            return Ok(Points::frames(projection));
        };
        let name = object.repr()?.to_string();
        if let Ok(manifold) = object.cast::<PyGrassmann>() {
            let (field, shape) = (manifold.get().field(), manifold.get().shape());
            return Ok(Points {
                quotient: Quotient::Subspaces,
                projection,
                given: Some(GivenManifold { field, shape, name }),
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
            "manifold: curves need the canonical metric, found {name}"
        );
        let (field, shape) = (manifold.field(), manifold.shape());
        Ok(Points {
            quotient: Quotient::Frames,
            projection,
            given: Some(GivenManifold { field, shape, name }),
        })
    }

    /// On the Stiefel manifold over the field of the arrays.
    pub(super) fn frames(projection: Projection) -> Self {
        Points {
            quotient: Quotient::Frames,
            projection,
            given: None,
        }
    }

    /// Points and vectors over the field, one matrix each.
    pub(super) fn matrices<const N: usize>(
        &self,
        field: Field,
        arguments: [Named<'_, '_>; N],
    ) -> PyResult<[Mat<f64>; N]> {
        let single = self.single(field, arguments)?;
        Ok(single.each_ref().map(|batch| batch.get(0).to_owned()))
    }

    /// The same as batches without axes, whose entries are not copied once more.
    pub(super) fn single<const N: usize>(
        &self,
        field: Field,
        arguments: [Named<'_, '_>; N],
    ) -> PyResult<[Batch; N]> {
        let batches = arguments.map(|(object, name)| field.one(object, name));
        self.put(arguments, collected(batches)?)
    }

    /// Points and vectors of problems, with their leading axes broadcast.
    pub(super) fn batches<const N: usize>(
        &self,
        field: Field,
        arguments: [Named<'_, '_>; N],
    ) -> PyResult<[Batch; N]> {
        self.put(arguments, field.batches(arguments)?)
    }

    fn put<const N: usize>(
        &self,
        arguments: [Named<'_, '_>; N],
        batches: [Batch; N],
    ) -> PyResult<[Batch; N]> {
        let (py, first) = (arguments[0].0.py(), &batches[0]);
        self.check_shape(first.field(), (first.rows, first.cols))?;
        let roles = arguments.map(|(_, name)| role(name));
        let (quotient, projection) = (self.quotient, self.projection);
        on_manifold(py, roles, batches, quotient, projection, at_member)
    }

    /// Points at knots.
    pub(super) fn at_knots(&self, field: Field, S: &Any) -> PyResult<Batch> {
        self.points(S.py(), "S", field.batch(S, "S", "(N, n, k)")?, at_knot_of)
    }

    /// Control points.
    pub(super) fn control_points(&self, field: Field, P: &Any) -> PyResult<Batch> {
        let points = field.batch(P, "P", "(degree + 1, n, k)")?;
        self.points(P.py(), "P", points, |error, _, _| error.clone().into())
    }

    fn points(
        &self,
        py: Python<'_>,
        name: &'static str,
        points: Batch,
        place: fn(&Error, usize, &[usize]) -> PyErr,
    ) -> PyResult<Batch> {
        self.check_shape(points.field(), (points.rows, points.cols))?;
        let (quotient, projection) = (self.quotient, self.projection);
        let found = on_manifold(py, [role(name)], [points], quotient, projection, place);
        found.map(|[points]| points)
    }

    /// Vectors at knots, of the same shape as the points there.
    pub(super) fn vectors_at_knots(&self, points: &Batch, V: Named<'_, '_>) -> PyResult<Batch> {
        let vectors = points.field().batch(V.0, V.1, "(N, n, k)")?;
        self.vectors(points, V, vectors, at_knot_of)
    }

    /// A vector at a point.
    pub(super) fn vector_at(&self, point: &Batch, V: Named<'_, '_>) -> PyResult<Mat<f64>> {
        let vector = self.vectors(point, V, point.field().one(V.0, V.1)?, at_member)?;
        Ok(vector.get(0).to_owned())
    }

    fn vectors(
        &self,
        points: &Batch,
        (object, name): Named<'_, '_>,
        vectors: Batch,
        place: fn(&Error, usize, &[usize]) -> PyErr,
    ) -> PyResult<Batch> {
        let roles = [role("S"), (Role::Vector, name)];
        let (data, quotient) = ([points.clone(), vectors], self.quotient);
        let found = on_manifold(object.py(), roles, data, quotient, self.projection, place);
        found.map(|[_, vectors]| vectors)
    }

    /// Makes the last point exactly equal to the first, if points are projected anyway and their distance is within the
    /// limit of the projection.
    pub(super) fn close(&self, points: &mut Batch) {
        let Some(limit) = self.projection.limit(points.single) else {
            return;
        };
        if let Some(last) = points.len().checked_sub(1)
            && self.quotient == Quotient::Frames
            && distance(points.get(0), points.get(last)) <= limit
        {
            points.repeat(0, last);
        }
    }

    /// The field of the manifold, or of the arrays if there is none; `TypeError` for complex arrays on a real manifold.
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

    /// `InvalidInputError` unless points of a given shape of the core belong to the manifold.
    fn check_shape(&self, field: Field, core: (usize, usize)) -> PyResult<()> {
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

    /// `InvalidInputError` for features that are available for frames only.
    pub(super) fn only_frames(&self, what: &str) -> PyResult<()> {
        ensure!(
            self.quotient == Quotient::Frames,
            "{what}: not available on a Grassmann manifold, only for frames"
        );
        Ok(())
    }
}

/// The manifold for a shape of the core, as a Python object.
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

/// `St(n, k)` or `Gr(n, k)` as in messages, for a shape of the core.
pub(super) fn symbol(quotient: Quotient, field: Field, core: (usize, usize)) -> String {
    let name = field.manifold(core);
    match quotient {
        Quotient::Frames => name,
        Quotient::Subspaces => name.replacen("St", "Gr", 1),
    }
}
