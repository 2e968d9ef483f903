//! What the classes of manifolds share: functions mapped over arrays of points and vectors, and random ones.

use super::batch::{Value, map_batch};
use super::prelude::*;

/// A manifold whose points and tangent vectors are `n x k` matrices.
pub trait Space {
    /// The manifold of the core.
    type Core: Copy + Shared;

    fn core(&self) -> Self::Core;

    /// `(n, k)`.
    fn shape(&self) -> (usize, usize);

    /// The nearest points.
    fn nearest(&self, Y: &Any) -> PyResult<Array>;

    /// The projection of matrices on tangent spaces.
    fn tangent_part(&self, S: &Any, Z: &Any) -> PyResult<Array>;

    /// Apply `member` to points and tangent vectors, member by member; its values have shape `core`.
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
    ) -> PyResult<Array> {
        let (n, k) = self.shape();
        self.map(objects, &[n, k], move |m, data, _| member(m, data))
    }

    /// [`Space::map`] for arguments of any shapes; `weight` is the work of a number of theirs.
    fn map_shapes<T: Value, const N: usize>(
        &self,
        objects: [Named<'_, '_>; N],
        shapes: [(usize, usize); N],
        weight: impl FnOnce(&[Batch; N]) -> f64,
        core: &[usize],
        member: impl Fn(&Self::Core, [MatRef<'_, f64>; N], Interrupt<'_>) -> Result<T> + Shared,
    ) -> PyResult<Array> {
        let (py, manifold) = (objects[0].0.py(), self.core());
        let batches = matrix_batches(objects)?;
        for ((batch, (_, name)), shape) in batches.iter().zip(objects).zip(shapes) {
            batch.check_shape(name, shape)?;
        }
        let numbers: f64 = batches.iter().map(Batch::numbers).sum();
        let call = Call::new(py, None, weight(&batches) * numbers)?;
        map_batch(&call, batches, core, move |batches, i, out, interrupt| {
            member(&manifold, batches.map(|batch| batch.get(i)), interrupt)?.put(out);
            Ok(())
        })
    }

    /// Uniformly distributed points, shape `size + (n, k)`.
    fn random_points(
        &self,
        py: Python<'_>,
        rng: Option<&Any>,
        size: Option<&Any>,
    ) -> PyResult<Array> {
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
        self.nearest(&normal(&generator(py, rng)?, &lead, self.shape())?)
    }

    /// Normally distributed tangent vectors at the points `S`, called `name` in errors.
    fn random_tangents(&self, (S, name): Named<'_, '_>, rng: Option<&Any>) -> PyResult<Array> {
        let py = S.py();
        let [points] = matrix_batches([(S, name)])?;
        points.check_shape(name, self.shape())?;
        let stream = tangent_stream(&generator(py, rng)?)?;
        self.tangent_part(S, &normal(&stream, &points.shape, self.shape())?)
    }
}

/// The sizes of a manifold that is to be made; `symbol` names it.
pub fn sizes<T>(
    symbol: &str,
    (n, k): (i64, i64),
    make: fn(usize, usize) -> Result<T>,
) -> PyResult<T> {
    let invalid = || invalid!("{symbol}(n, k): expected 1 <= k <= n, found n = {n}, k = {k}");
    let (Ok(rows), Ok(cols)) = (usize::try_from(n), usize::try_from(k)) else {
        return Err(invalid());
    };
    make(rows, cols).map_err(|_| invalid())
}

/// Draw standard normal matrices with the leading axes `lead`.
fn normal<'py>(generator: &Any<'py>, lead: &[usize], (n, k): (usize, usize)) -> PyResult<Any<'py>> {
    let shape = PyTuple::new(generator.py(), [lead, &[n, k]].concat())?;
    generator.call_method1("standard_normal", (shape,))
}

/// What sets the streams of tangent vectors apart from others that the same numbers are the seed of: a number of its own.
const TANGENT_STREAM: u32 = 0x7461_6e67;

/// The generator of `numpy.random.default_rng`.
fn generator<'py>(py: Python<'py>, rng: Option<&Any<'py>>) -> PyResult<Any<'py>> {
    py.import("numpy.random")?
        .call_method1("default_rng", (rng,))
}

/// A stream that 128 random bits of a generator start. Points are made of the numbers that follow in the generator itself, so
/// that a seed, or a generator in the same state, gives tangent vectors that know nothing of the points.
fn tangent_stream<'py>(generator: &Any<'py>) -> PyResult<Any<'py>> {
    let py = generator.py();
    let random = py.import("numpy.random")?;
    let words = [("dtype", "uint32")].into_py_dict(py)?;
    let bits = generator.call_method("integers", (0, 1_u64 << 32, 4), Some(&words))?;
    let key = [("spawn_key", (TANGENT_STREAM,))].into_py_dict(py)?;
    let seed = random.call_method("SeedSequence", (bits,), Some(&key))?;
    random.call_method1("default_rng", (seed,))
}
