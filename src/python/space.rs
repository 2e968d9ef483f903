//! Methods that the manifold classes share: functions mapped over arrays of points and vectors, and random ones.

use super::array_namespace::Namespace;
use super::batch::{Value, map_batch};
use super::membership::{on_manifold, role};
use super::prelude::*;
use super::projection::{Projection, SINGLE};
use crate::manifold::stiefel::POINT_TOLERANCE;
use crate::space::Quotient;

/// A manifold whose points and tangent vectors are `n x k` matrices, real or complex.
pub trait Space {
    /// The manifold on which the core computes; complex matrices are embedded in real ones.
    type Core: Copy + Shared;

    fn core(&self) -> Self::Core;

    /// Rows and columns of a point in the core.
    fn core_shape(&self) -> (usize, usize);

    fn field(&self) -> Field;

    /// The name of the class.
    const NAME: &'static str;

    /// The nearest points.
    fn nearest(&self, Y: &Any) -> PyResult<Numbers>;

    /// The projection of matrices to tangent spaces.
    fn tangent_part(&self, S: &Any, Z: &Any) -> PyResult<Numbers>;

    /// Rows and columns of a point.
    fn shape(&self) -> (usize, usize) {
        self.field().own(self.core_shape())
    }

    /// What the points of the core represent.
    const QUOTIENT: Quotient;

    /// Apply `member` to arbitrary matrices of the shape of points, without projecting them first.
    fn map_any<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N]) -> Result<Mat<f64>> + Shared,
    ) -> PyResult<Numbers> {
        let ((n, k), batches) = (self.core_shape(), self.read(objects, [self.shape(); N])?);
        let numbers = batches.iter().map(Batch::numbers).sum();
        let (py, write) = (
            objects[0].0.py(),
            putting(move |m: &_, data, _| member(m, data)),
        );
        let found = self.write_batches(py, batches, numbers, &[n, k], write)?;
        self.field().numbers(found)?.like(objects)
    }

    /// Which members satisfy `member`, given the tolerances of the tested array and of the points.
    fn are<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        atol: Option<f64>,
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N], [f64; 2]) -> Result<()> + Shared,
    ) -> PyResult<Numbers> {
        let (batches, tolerances) = self.read_with_tolerance(objects, atol)?;
        let numbers = batches.iter().map(Batch::numbers).sum();
        let py = objects[0].0.py();
        let found = self.write_batches(py, batches, numbers, &[], move |m, data, out, _| {
            out[0] = f64::from(u8::from(member(m, data, tolerances).is_ok()));
            Ok(())
        })?;
        Numbers::from(found).truths().like(objects)
    }

    /// Error unless all members satisfy `member`, as in [`Space::are`].
    fn check<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        atol: Option<f64>,
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N], [f64; 2]) -> Result<()> + Shared,
    ) -> PyResult<()> {
        let (batches, tolerances) = self.read_with_tolerance(objects, atol)?;
        let numbers = batches.iter().map(Batch::numbers).sum();
        let py = objects[0].0.py();
        self.write_batches(py, batches, numbers, &[], move |m, data, _, _| {
            member(m, data, tolerances)
        })?;
        Ok(())
    }

    /// Arrays, with the given tolerance and the tolerance of points; defaults depend on the precision of their numbers.
    fn read_with_tolerance<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        atol: Option<f64>,
    ) -> PyResult<([Batch; N], [f64; 2])> {
        let given = atol.unwrap_or(0.0);
        ensure!(given >= 0.0, "atol: must be at least 0, found {given}");
        let batches = self.read(objects, [self.shape(); N])?;
        let tolerance = match batches.iter().any(|batch| batch.single) {
            true => SINGLE,
            false => POINT_TOLERANCE,
        };
        Ok((batches, [atol.unwrap_or(tolerance), tolerance]))
    }

    /// Apply `member` to points and tangent vectors, member by member; its values have shape `core`, as in the core.
    fn map<T: Value, const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        core: &[usize],
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N], Interrupt<'_>) -> Result<T> + Shared,
    ) -> PyResult<Array> {
        self.map_shapes(objects, [self.shape(); N], |_| 1.0, core, member)
    }

    /// [`Space::map`] for values of shape `(n, k)`.
    fn map_matrices<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N]) -> Result<Mat<f64>> + Shared,
    ) -> PyResult<Numbers> {
        let (n, k) = self.core_shape();
        let found = self.map(objects, &[n, k], move |m, data, _| member(m, data))?;
        self.field().numbers(found)?.like(objects)
    }

    /// [`Space::map_matrices`] for a function that writes into a matrix of shape `(n, k)`, whose rows are contiguous.
    fn map_matrices_into<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        member: impl Fn(&Self::Core, MatMut<'_, f64>, [MatRef<'_, f64>; N]) -> Result<()> + Shared,
    ) -> PyResult<Numbers> {
        let (n, k) = self.core_shape();
        let write =
            move |m: &Self::Core, data: [MatRef<'_, f64>; N], out: &mut [f64], _: Interrupt<'_>| {
                member(m, MatMut::from_row_major_slice_mut(out, n, k), data)
            };
        let found = self.write_shapes(objects, [self.shape(); N], |_| 1.0, &[n, k], write)?;
        self.field().numbers(found)?.like(objects)
    }

    /// [`Space::map`] for numbers, which `own` converts from the core to the field.
    fn map_numbers<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        own: fn(Field, f64) -> f64,
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N], Interrupt<'_>) -> Result<f64> + Shared,
    ) -> PyResult<Numbers> {
        let field = self.field();
        let found = self.map(objects, &[], move |m, data, interrupt| {
            Ok(own(field, member(m, data, interrupt)?))
        })?;
        Numbers::from(found).like(objects)
    }

    /// [`Space::map`] for arguments of any shapes; `weight` is the work per number.
    fn map_shapes<T: Value, const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        shapes: [(usize, usize); N],
        weight: impl FnOnce(&[Batch; N]) -> f64,
        core: &[usize],
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N], Interrupt<'_>) -> Result<T> + Shared,
    ) -> PyResult<Array> {
        self.write_shapes(objects, shapes, weight, core, putting(member))
    }

    /// [`Space::map_shapes`] for a function that writes its value row by row.
    fn write_shapes<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        shapes: [(usize, usize); N],
        weight: impl FnOnce(&[Batch; N]) -> f64,
        core: &[usize],
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N], &mut [f64], Interrupt<'_>) -> Result<()>
        + Shared,
    ) -> PyResult<Array> {
        let (py, roles) = (objects[0].0.py(), objects.map(|(_, name)| role(name)));
        let batches = self.read(objects, shapes)?;
        let projection = Projection::OfRoundOff;
        let batches = on_manifold(py, roles, batches, Self::QUOTIENT, projection, at_member)?;
        let numbers: f64 = batches.iter().map(Batch::numbers).sum();
        let work = weight(&batches) * numbers;
        self.write_batches(py, batches, work, core, member)
    }

    /// [`Space::write_shapes`] for arguments that have been read.
    fn write_batches<const N: usize>(
        &self,
        py: Python<'_>,
        batches: [Batch; N],
        work: f64,
        core: &[usize],
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N], &mut [f64], Interrupt<'_>) -> Result<()>
        + Shared,
    ) -> PyResult<Array> {
        let manifold = self.core();
        let call = Call::new(py, None, work)?.over(self.field());
        map_batch(&call, batches, core, move |batches, i, out, interrupt| {
            member(&manifold, batches.map(|batch| batch.get(i)), out, interrupt)
        })
    }

    /// Reads arrays of matrices of given shapes, with their leading axes broadcast.
    fn read<const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        shapes: [(usize, usize); N],
    ) -> PyResult<[Batch; N]> {
        // Arrays of two libraries are rejected before any work.
        Namespace::of(objects)?;
        let batches = match self.field().batches(objects) {
            Err(error) if self.field() == Field::Real => {
                self.check_real(objects)?;
                return Err(error);
            }
            batches => batches?,
        };
        for ((batch, (_, name)), shape) in batches.iter().zip(objects).zip(shapes) {
            batch.check_shape(name, shape)?;
        }
        Ok(batches)
    }

    /// `TypeError` that names the complex manifold if an argument is complex.
    fn check_real<const N: usize>(&self, objects: [Named<'_, '_>; N]) -> PyResult<()> {
        for (object, name) in objects {
            if Field::of([object])? == Field::Complex {
                let ((n, k), class) = (self.shape(), Self::NAME);
                let advice = format!("{class}({n}, {k}, field='complex')");
                let message =
                    format!("{name}: expected real numbers; for complex numbers use {advice}");
                return Err(PyTypeError::new_err(message));
            }
        }
        Ok(())
    }

    /// Standard normal matrices with the leading axes `lead`: the real and the imaginary part of every entry.
    fn normal<'py>(&self, generator: &Any<'py>, lead: &[usize]) -> PyResult<Any<'py>> {
        let (py, (n, k)) = (generator.py(), self.shape());
        let shape = [lead, &[n, k]].concat();
        let parts = if self.field() == Field::Real { 1 } else { 2 };
        let drawn = [&shape[..], &[2][..parts - 1]].concat();
        let normal = generator.call_method1("standard_normal", (PyTuple::new(py, drawn)?,))?;
        if self.field() == Field::Real {
            return Ok(normal);
        }
        let complex = normal.call_method1("view", ("complex128",))?;
        complex.call_method1("reshape", (PyTuple::new(py, shape)?,))
    }

    /// Uniformly distributed points, shape `size + (n, k)`.
    fn random_points(
        &self,
        py: Python<'_>,
        rng: Option<&Any>,
        size: Option<&Any>,
    ) -> PyResult<Numbers> {
        let axes: Vec<i64> = match size {
            None => Vec::new(),
            Some(size) => match size.extract() {
                Ok(one) => vec![one],
                Err(_) => size.extract()?,
            },
        };
        let lead: Option<Vec<_>> = axes.into_iter().map(|x| usize::try_from(x).ok()).collect();
        let Some(lead) = lead else {
            let found = size.map_or(String::new(), |size| size.to_string());
            return Err(invalid!("size: axes must be at least 0, found {found}"));
        };
        self.nearest(&self.normal(&generator(py, rng)?, &lead)?)
    }

    /// Normally distributed tangent vectors at the points `S`, called `name` in errors.
    fn random_tangents(&self, (S, name): Named<'_, '_>, rng: Option<&Any>) -> PyResult<Numbers> {
        let py = S.py();
        let [points] = self.read([(S, name)], [self.shape()])?;
        let stream = tangent_stream(&generator(py, rng)?)?;
        self.tangent_part(S, &self.normal(&stream, &points.shape)?)
    }
}

/// Adapts a function that returns its value to one that writes it.
fn putting<M, T: Value, const N: usize>(
    member: impl Fn(&M, [MatRef<'_, f64>; N], Interrupt<'_>) -> Result<T> + Shared,
) -> impl Fn(&M, [MatRef<'_, f64>; N], &mut [f64], Interrupt<'_>) -> Result<()> + Shared {
    move |m, data, out, interrupt| {
        member(m, data, interrupt)?.put(out);
        Ok(())
    }
}

/// Checks the sizes of a new manifold; `symbol` names it.
pub fn sizes<T>(
    symbol: &str,
    (n, k): (i64, i64),
    field: Field,
    make: fn(usize, usize) -> Result<T>,
) -> PyResult<T> {
    let invalid = || invalid!("{symbol}(n, k): expected 1 <= k <= n, found n = {n}, k = {k}");
    let (Ok(rows), Ok(cols)) = (usize::try_from(n), usize::try_from(k)) else {
        return Err(invalid());
    };
    let [rows, cols] = [rows, cols].map(|size| field.embedded(size));
    make(rows, cols).map_err(|_| invalid())
}

/// Separates the streams of tangent vectors from other streams with the same seed.
const TANGENT_STREAM: u32 = 0x7461_6e67;

/// The generator of `numpy.random.default_rng`.
fn generator<'py>(py: Python<'py>, rng: Option<&Any<'py>>) -> PyResult<Any<'py>> {
    py.import("numpy.random")?
        .call_method1("default_rng", (rng,))
}

/// A stream seeded with 128 random bits of a generator. Points are drawn from the generator itself, so that for the
/// same seed, or a generator in the same state, tangent vectors are independent of the points.
fn tangent_stream<'py>(generator: &Any<'py>) -> PyResult<Any<'py>> {
    let py = generator.py();
    let random = py.import("numpy.random")?;
    let words = [("dtype", "uint32")].into_py_dict(py)?;
    let bits = generator.call_method("integers", (0, 1_u64 << 32, 4), Some(&words))?;
    let key = [("spawn_key", (TANGENT_STREAM,))].into_py_dict(py)?;
    let seed = random.call_method("SeedSequence", (bits,), Some(&key))?;
    random.call_method1("default_rng", (seed,))
}
