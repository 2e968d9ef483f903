//! Curves: one class with the protocol, one subclass per kind of curve.

use numpy::Complex64;

use super::array_namespace::Namespace;
use super::field::write_sample;
use super::points::{manifold_of, symbol};
use super::prelude::*;
use super::stored::form;
use crate::curve::sampling::rounded_to_end;
use crate::curve::{Quantity, lift_into};
use crate::linalg::complex_embedding::restrict;

/// Smooth curve on a Stiefel or Grassmann manifold: the base class of all curves.
///
/// If one of the arrays that define the curve is complex, the frames are complex, points and vectors are complex, and
/// inner products in costs and lengths are the real parts of Hermitian products.
///
/// All curves share this protocol. Calls with a scalar ``t`` return shape ``(n, k)``, calls with an array of shape
/// ``T`` return ``T + (n, k)``. Many parameters are evaluated in parallel and without the GIL; results are
/// bit-identical for any number of threads.
#[pyclass(name = "Curve", module = "stiefel_rs", subclass, frozen)]
pub struct PyCurve {
    /// The curve of the core; complex frames are embedded in real ones.
    pub(super) inner: Arc<dyn AnyCurve>,
    pub(super) field: Field,
}

/// Makes an object of a curve class from a curve of the core that is complex by construction if its frames are: a spline
/// whose legs were solved in complex unknowns, or checked by the core.
pub(super) fn wrap<S: PyClass<BaseType = PyCurve>>(
    inner: Arc<dyn AnyCurve>,
    field: Field,
    class: S,
) -> PyClassInitializer<S> {
    PyClassInitializer::from(PyCurve { inner, field }).add_subclass(class)
}

/// The same for a curve that real formulas may lead away from the complex frames, or whose numbers are given. For the cubics
/// of a spline, which are computed when they are first read, the check takes a fifth of the time of their solution.
///
/// # Errors
/// `NotComplex` if the frame is complex and the curve of the core is not one of embedded frames.
pub(super) fn wrap_checked<S: PyClass<BaseType = PyCurve>>(
    py: Python<'_>,
    inner: Arc<dyn AnyCurve>,
    field: Field,
    class: S,
) -> PyResult<PyClassInitializer<S>> {
    let curve = PyCurve { inner, field };
    curve.check_complex(py)?;
    Ok(PyClassInitializer::from(curve).add_subclass(class))
}

/// Makes curves callable through the method `_call`, which has a signature and a docstring; a slot `__call__` shows
/// neither.
pub(super) fn make_callable(py: Python<'_>) -> PyResult<()> {
    let class = py.get_type::<PyCurve>();
    class.setattr("__call__", class.getattr("_call")?)
}

/// The object of a class.
pub fn object<T: PyClass>(py: Python<'_>, class: PyClassInitializer<T>) -> PyResult<Py<PyAny>> {
    Ok(Py::new(py, class)?.into_any())
}

impl PyCurve {
    /// Runs work whose duration is not known in advance, such as an integral along the curve; it is always
    /// interruptible.
    pub(super) fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        num_threads: Option<i64>,
        work: impl FnOnce(&dyn AnyCurve, Interrupt<'_>) -> Result<T> + Send + 'static,
    ) -> PyResult<T> {
        let curve = Arc::clone(&self.inner);
        let call = Call::new(py, num_threads, f64::INFINITY)?.over(self.field);
        call.run(move |interrupt| work(&*curve, interrupt))
    }

    /// Rows and columns of a point.
    pub(super) fn shape(&self) -> (usize, usize) {
        self.field.own(self.inner.shape())
    }

    /// `St(n, k)` as messages write it.
    pub(super) fn symbol(&self) -> String {
        symbol(self.inner.quotient(), self.field, self.inner.shape())
    }

    /// Samples at `t`, as an array of the library of `t`.
    fn sample<'py>(
        &self,
        t: &Any<'py>,
        quantity: Quantity,
        extrapolate: Option<bool>,
        num_threads: Option<i64>,
    ) -> PyResult<Any<'py>> {
        let samples = match extrapolate {
            None => self.sample_array(t, quantity, num_threads),
            Some(true) => match self.inner.continued() {
                Some(inner) => {
                    let field = self.field;
                    PyCurve { inner, field }.sample_array(t, quantity, num_threads)
                }
                None => self.sample_array(t, quantity, num_threads),
            },
            Some(false) => self.sample_array(&self.inside(t)?, quantity, num_threads),
        }?;
        Namespace::of(named![t])?.array(samples)
    }

    /// Checks that parameters are in the interval; those within rounding of an end are moved to it.
    fn inside<'py>(&self, t: &Any<'py>) -> PyResult<Any<'py>> {
        let Array { shape, entries } = read(t, "t")?;
        let (start, end) = self.inner.t_span();
        let (first, last) = (start.min(end), start.max(end));
        let moved = entries.iter().map(|t| rounded_to_end(*t, (first, last)));
        let entries: Vec<f64> = moved.collect();
        if let Some(t) = entries.iter().find(|t| **t < first || **t > last) {
            let span = format!("between {first} and {last} unless extrapolate=True");
            return Err(invalid!("t: must be {span}, found {t}"));
        }
        Array { shape, entries }.into_bound_py_any(t.py())
    }

    fn sample_array<'py>(
        &self,
        t: &Any<'py>,
        quantity: Quantity,
        num_threads: Option<i64>,
    ) -> PyResult<Any<'py>> {
        let (py, (n, k), (start, end)) = (t.py(), self.inner.shape(), self.inner.t_span());
        // Outside the interval curves may be integrated further, which takes unknown time.
        let inside = |t: &f64| (start.min(end)..=start.max(end)).contains(t);
        let each = match quantity {
            Quantity::Derivative(0) => n * k,
            _ => DERIVATIVES * n * k,
        };
        if self.field == Field::Real
            && num_threads.is_none()
            && each <= IN_PLACE
            && let Ok(t) = t.cast_exact::<PyFloat>()
            && inside(&t.value())
        {
            return self.sample_one(py, t.value(), quantity);
        }
        let Array { mut shape, entries } = read(t, "t")?;
        let numbers = match entries.iter().all(inside) {
            true => SAMPLE * (each * entries.len()) as f64,
            false => f64::INFINITY,
        };
        let call = Call::new(py, num_threads, numbers)?.over(self.field);
        if self.field == Field::Complex {
            return self.sample_complex(&call, shape, entries, quantity);
        }
        if let Some(frame) = self.inner.frame()
            && n * k * entries.len() > LARGE
            && n > TALL * frame.ncols()
        {
            return self.sample_large(&call, frame, shape, entries, quantity);
        }
        let curve = Arc::clone(&self.inner);
        let samples = call.run(move |interrupt| curve.sample(&entries, quantity, interrupt))?;
        // Stored column by column; the transposed view has the documented shape and copies nothing.
        shape.extend([k, n]);
        let stored = PyArray1::from_vec(py, samples.into_entries()).reshape(shape)?;
        stored.call_method1("swapaxes", (-1, -2))
    }

    /// Samples of embedded frames, restricted piece by piece, since they are four times as many numbers.
    fn sample_complex<'py>(
        &self,
        call: &Call<'py>,
        mut shape: Vec<usize>,
        t: Vec<f64>,
        quantity: Quantity,
    ) -> PyResult<Any<'py>> {
        let (curve, (n, k)) = (Arc::clone(&self.inner), self.shape());
        let piece = (COMPLEX_PIECE / (n * k)).max(1);
        let found = call.run(move |interrupt| {
            let mut out = vec![Complex64::ZERO; t.len() * n * k];
            for (t, out) in t.chunks(piece).zip(out.chunks_mut(piece * n * k)) {
                let samples = curve.sample(t, quantity, interrupt)?;
                for (sample, out) in samples.iter().zip(out.chunks_mut(n * k)) {
                    write_sample(
                        quantity,
                        MatMut::from_column_major_slice_mut(out, n, k),
                        sample,
                    )?;
                }
            }
            Ok(out)
        })?;
        shape.extend([k, n]);
        let stored = to_array(call.py, found, &shape)?;
        stored.call_method1("swapaxes", (-1, -2))
    }

    /// Returns an error unless the frame is real, or points and velocities at some parameters are embedded complex matrices.
    pub(super) fn check_complex(&self, py: Python<'_>) -> PyResult<()> {
        if self.field == Field::Real {
            return Ok(());
        }
        let (curve, (rows, cols)) = (Arc::clone(&self.inner), self.inner.shape());
        self.field.check_shape((rows, cols))?;
        let (start, end) = curve.t_span();
        let duration = faer::Scale(end - start);
        let t: [f64; CHECKED] = std::array::from_fn(|i| {
            let part = i as f64 / (CHECKED - 1) as f64;
            (1.0 - part) * start + part * end
        });
        let numbers = SAMPLE * (2 * CHECKED * DERIVATIVES * rows * cols) as f64;
        let call = Call::new(py, None, numbers)?;
        call.run(move |interrupt| {
            let sampled = |order| curve.sample(&t, Quantity::Derivative(order), interrupt);
            for (point, velocity) in sampled(0)?.iter().zip(sampled(1)?.iter()) {
                restrict(point)?;
                restrict((velocity * duration).as_ref())?;
            }
            Ok(())
        })
    }

    /// Computes the coordinates first, then lifts them piece by piece into an array of NumPy, which requests huge
    /// pages: with ordinary pages the first access to gigabytes costs more than the product. Between pieces it polls
    /// for Ctrl-C.
    fn sample_large<'py>(
        &self,
        call: &Call<'py>,
        frame: MatRef<'_, f64>,
        mut shape: Vec<usize>,
        t: Vec<f64>,
        quantity: Quantity,
    ) -> PyResult<Any<'py>> {
        let curve = Arc::clone(&self.inner);
        let coordinates =
            call.run(move |interrupt| curve.sample_coordinates(&t, quantity, interrupt))?;
        let (py, (n, k)) = (call.py, self.inner.shape());
        shape.extend([k, n]);
        let stored = numpy(py)?.call_method1("empty", (shape,))?;
        let array = stored.cast::<PyArrayDyn<f64>>()?;
        let mut writer = array.readwrite();
        let columns = (PIECE / (n * frame.ncols())).max(1);
        for (i, piece) in writer.as_slice_mut()?.chunks_mut(columns * n).enumerate() {
            let size = piece.len() / n;
            let low = coordinates.as_ref().subcols(i * columns, size);
            let out = MatMut::from_column_major_slice_mut(piece, n, size);
            call.run_here(|| lift_into(frame, low, out))?;
            py.check_signals()?;
        }
        if coordinates.norm_max() > HUGE && !writer.as_slice()?.iter().all(|x| x.is_finite()) {
            return Err(Error::Overflow { quantity: "curve" }.into());
        }
        drop(writer);
        stored.call_method1("swapaxes", (-1, -2))
    }

    /// Evaluates one parameter of a cheap curve in place: releasing the GIL costs more than keeping it.
    fn sample_one<'py>(&self, py: Python<'py>, t: f64, quantity: Quantity) -> PyResult<Any<'py>> {
        let samples = self.inner.sample(&[t], quantity, Interrupt::NEVER)?;
        let (n, k) = self.inner.shape();
        let out = PyArray2::zeros(py, [n, k], false);
        write(samples.get(0), out.readwrite().as_slice_mut()?);
        Ok(out.into_any())
    }
}

/// Result size (32 MB) from which lifting into huge pages pays off, for a frame of few columns.
const LARGE: usize = 1 << 22;
const TALL: usize = 8;

/// Number of parameters at which a supposedly complex curve is checked.
const CHECKED: usize = 9;

/// Complex numbers of one piece of samples.
const COMPLEX_PIECE: usize = 1 << 20;

/// Multiplications per piece of a lift: about a tenth of a second.
const PIECE: usize = 1 << 29;

/// Coordinates below this bound can be lifted without overflow.
const HUGE: f64 = 1e300;

/// Result size up to which a single evaluation keeps the GIL (a few microseconds).
const IN_PLACE: usize = 40;

/// Work per number of a point, relative to one exponential: 15 to 100 ns. In a separate thread 1000 points of S^2 take
/// 141 ns each instead of 76.
const SAMPLE: f64 = 0.05;

/// Time of a derivative relative to that of a position.
const DERIVATIVES: usize = 10;

#[pymethods]
impl PyCurve {
    /// Number of rows of a point.
    #[getter]
    fn n(&self) -> usize {
        self.shape().0
    }

    /// Number of columns of a point.
    #[getter]
    fn k(&self) -> usize {
        self.shape().1
    }

    /// Field of the entries: "real" or "complex".
    #[getter(field)]
    fn field_word(&self) -> &'static str {
        self.field.word()
    }

    /// Manifold of the points: a :class:`Stiefel`, or a :class:`Grassmann` for a curve of subspaces.
    #[getter]
    fn manifold(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let (quotient, shape) = (self.inner.quotient(), self.inner.shape());
        manifold_of(py, quotient, self.field, shape)
    }

    /// Interval ``(start, end)`` on which the curve is defined.
    #[getter]
    fn t_span(&self) -> (f64, f64) {
        self.inner.t_span()
    }

    /// Position, or ambient derivative of order ``nu``, at ``t``; ``curve(t)`` calls this.
    ///
    /// Parameters
    /// ----------
    /// t : array_like, shape T
    ///     Parameters, any finite numbers; the curve is defined on ``t_span`` and may extend beyond it.
    /// nu : int, default 0
    ///     Order of the derivative, 0 to 3; exact, by differentiating the algorithm.
    /// extrapolate : bool, optional
    ///     If True, evaluate the curve outside ``t_span`` too; if False, parameters outside raise. Parameters within 4
    ///     ulp of an end (of the larger end in absolute value) count as that end. By default splines use their own
    ///     ``extrapolate``, and all other curves are evaluated everywhere.
    /// num_threads : int, optional
    ///     Number of threads; by default the size of the global pool.
    ///
    /// Returns
    /// -------
    /// ndarray, shape T + (n, k)
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     ``t`` not finite or outside ``t_span``, ``nu`` out of range.
    /// OutsideDomainError
    ///     No unique quasi-geodesic joins two intermediate points: outside ``t_span``, or for distant or fast data.
    #[pyo3(signature = (t, nu=0, *, extrapolate=None, num_threads=None))]
    fn _call<'py>(
        &self,
        t: &Any<'py>,
        nu: i64,
        extrapolate: Option<bool>,
        num_threads: Option<i64>,
    ) -> PyResult<Any<'py>> {
        let quantity = match usize::try_from(nu) {
            Ok(order @ 0..=3) => Quantity::Derivative(order),
            _ => return Err(invalid!("nu: must be 0, 1, 2 or 3, found {nu}")),
        };
        self.sample(t, quantity, extrapolate, num_threads)
    }

    /// Return the velocity ``S'`` at ``t``, shape ``T + (n, k)``.
    ///
    /// The arguments are the same as for ``curve(t)``.
    #[pyo3(signature = (t, *, extrapolate=None, num_threads=None))]
    fn velocity<'py>(
        &self,
        t: &Any<'py>,
        extrapolate: Option<bool>,
        num_threads: Option<i64>,
    ) -> PyResult<Any<'py>> {
        self.sample(t, Quantity::Derivative(1), extrapolate, num_threads)
    }

    /// Return the covariant acceleration ``D_t S'`` (canonical metric) at ``t``, shape ``T + (n, k)``.
    ///
    /// The arguments are the same as for ``curve(t)``.
    #[pyo3(signature = (t, *, extrapolate=None, num_threads=None))]
    fn acceleration<'py>(
        &self,
        t: &Any<'py>,
        extrapolate: Option<bool>,
        num_threads: Option<i64>,
    ) -> PyResult<Any<'py>> {
        self.sample(t, Quantity::Acceleration, extrapolate, num_threads)
    }

    /// Return the covariant jerk ``D_t D_t S'`` (canonical metric) at ``t``, shape ``T + (n, k)``.
    ///
    /// The arguments are the same as for ``curve(t)``.
    #[pyo3(signature = (t, *, extrapolate=None, num_threads=None))]
    fn jerk<'py>(
        &self,
        t: &Any<'py>,
        extrapolate: Option<bool>,
        num_threads: Option<i64>,
    ) -> PyResult<Any<'py>> {
        self.sample(t, Quantity::Jerk, extrapolate, num_threads)
    }

    /// Return the ambient derivative of order ``nu`` as a function of ``t``.
    ///
    /// Parameters
    /// ----------
    /// nu : int, default 1
    ///     Order, 0 to 3.
    ///
    /// Returns
    /// -------
    /// CurveDerivative
    ///     Callable like the curve; has a method ``derivative`` too.
    ///
    /// Examples
    /// --------
    /// >>> from stiefel_rs import QuasiGeodesic
    /// >>> velocity = QuasiGeodesic([[1.0], [0.0]], [[0.0], [1.0]]).derivative()
    /// >>> velocity(0.0).round(6).ravel().tolist()
    /// [0.0, 1.570796]
    #[pyo3(signature = (nu=1))]
    fn derivative<'py>(slf: &Bound<'py, Self>, nu: i64) -> PyResult<Any<'py>> {
        let module = slf.py().import("stiefel_rs.curve_derivative")?;
        module.getattr("CurveDerivative")?.call1((slf, nu))
    }

    /// Return the cost: the integral of ``|D_t S'|^2`` over ``t_span``, canonical metric.
    ///
    /// With tension, the integral of ``|D_t S'|^2 + tension |S'|^2``.
    ///
    /// The relative error is 1e-12, or the round-off of the acceleration if that is larger.
    ///
    /// Raises
    /// ------
    /// ConvergenceError
    ///     The quadrature did not converge.
    fn cost(&self, py: Python<'_>) -> PyResult<f64> {
        let cost = self.run(py, None, |curve, interrupt| curve.cost(interrupt))?;
        Ok(self.field.squared(cost))
    }

    /// Save all numbers of the curve to a file, from which :func:`load` restores the curve to the last bit.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     Name of the file, usually ending in ``.npz``. An existing file is replaced once the new one is complete.
    ///
    /// Notes
    /// -----
    /// The file is an archive of plain arrays without pickles, which ``numpy.load`` reads too, and states the version
    /// of its format.
    fn save(slf: &Bound<'_, Self>, path: &Any) -> PyResult<()> {
        let storage = slf.py().import("stiefel_rs.storage")?;
        let form = slf.call_method0("_stored")?;
        storage.call_method1("write", (form, path)).map(drop)
    }

    /// For pickle: the stored form.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Any<'py>, (Any<'py>,))> {
        let build = slf.py().import("stiefel_rs._core")?.getattr("_restored")?;
        Ok((build, (slf.call_method0("_stored")?,)))
    }

    /// All numbers of the curve, for files and pickles.
    fn _stored<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (kind, fields) = self.inner.stored();
        form(py, kind, self.field, fields)
    }

    /// Curves are immutable: a copy is the curve itself.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Any) -> Py<Self> {
        slf
    }

    fn __repr__(slf: &Bound<'_, Self>) -> PyResult<String> {
        let (name, manifold) = (slf.get_type().name()?, slf.get().symbol());
        let (start, end) = slf.get().inner.t_span();
        Ok(format!(
            "<{name} on {manifold}, t_span ({start:?}, {end:?})>"
        ))
    }
}
