//! Arrays of other libraries: reading them, and returning results in the library of the arguments.
//!
//! A library is identified by the namespace of its arrays, `__array_namespace__` of the array API standard, and PyTorch, which
//! has none, by its class. Data pass through NumPy, without a copy if the library shares memory with it.

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::intern;
use pyo3::types::{PyInt, PyList};

use super::prelude::*;

/// The library of the arguments of a call: `None` for NumPy, whose arrays mix with those of any other library.
#[derive(Default)]
pub struct Namespace(Option<Owned>);

impl Namespace {
    /// The library of arguments.
    ///
    /// # Errors
    /// `TypeError` for arrays of two libraries.
    pub fn of<const N: usize>(arguments: [Named<'_, '_>; N]) -> PyResult<Self> {
        let mut found: Option<(Any<'_>, &str)> = None;
        for (argument, name) in arguments {
            let Some(namespace) = namespace_of(argument)? else {
                continue;
            };
            match &found {
                Some((known, first)) if !known.is(&namespace) => {
                    let names = [known, &namespace].map(|it| it.getattr("__name__"));
                    let [one, other] = collected(names)?;
                    let message = format!(
                        "{first} and {name}: arrays of different libraries, {one} and {other}"
                    );
                    return Err(PyTypeError::new_err(message));
                }
                Some(_) => {}
                None => found = Some((namespace, name)),
            }
        }
        Ok(Namespace(found.map(|(namespace, _)| namespace.unbind())))
    }

    /// Whether the library is NumPy.
    pub fn is_numpy(&self) -> bool {
        self.0.is_none()
    }

    /// Converts a NumPy array to the library; for NumPy itself an array without axes becomes a number.
    pub fn array<'py>(&self, array: Any<'py>) -> PyResult<Any<'py>> {
        match &self.0 {
            Some(namespace) => {
                let namespace = namespace.bind(array.py());
                // By default PyTorch would use the default device.
                let options = PyDict::new(array.py());
                if is_torch(namespace)? {
                    options.set_item("device", "cpu")?;
                }
                namespace.call_method("asarray", (array,), Some(&options))
            }
            None if array
                .cast::<PyUntypedArray>()
                .is_ok_and(|array| array.ndim() == 0) =>
            {
                array.get_item(())
            }
            None => Ok(array),
        }
    }

    fn converted<'py>(&self, value: Any<'py>) -> PyResult<Any<'py>> {
        match value.is_instance_of::<PyUntypedArray>() {
            true => self.array(value),
            false => Ok(value),
        }
    }
}

/// The namespace of an array that is not NumPy's; `None` for anything else.
fn namespace_of<'py>(object: &Any<'py>) -> PyResult<Option<Any<'py>>> {
    if is_native(object) {
        return Ok(None);
    }
    let py = object.py();
    if let Some(namespace) = object.getattr_opt("__array_namespace__")? {
        let namespace = namespace.call0()?;
        return Ok((!namespace.is(numpy(py)?)).then_some(namespace));
    }
    match is_tensor(object)? {
        true => Ok(Some(py.import("torch")?.into_any())),
        false => Ok(None),
    }
}

fn is_torch(namespace: &Any) -> PyResult<bool> {
    namespace.getattr("__name__")?.eq("torch")
}

/// Whether an object belongs to NumPy or to Python itself.
fn is_native(object: &Any) -> bool {
    object.is_instance_of::<PyUntypedArray>()
        || object.is_exact_instance_of::<PyFloat>()
        || object.is_instance_of::<PyInt>()
        || object.is_instance_of::<PyList>()
        || object.is_instance_of::<PyTuple>()
}

/// Whether an object is a PyTorch tensor; does not import PyTorch.
fn is_tensor(object: &Any) -> PyResult<bool> {
    let modules = object.py().import("sys")?.getattr("modules")?;
    match modules.cast::<PyDict>()?.get_item("torch")? {
        Some(torch) => object.is_instance(&torch.getattr("Tensor")?),
        None => Ok(false),
    }
}

/// The NumPy array that an argument is, or shares its data with.
///
/// # Errors
/// `TypeError` for arrays that derivatives are taken of, which other functions accept; `InvalidInputError` where
/// NumPy raises `ValueError`, as for items of different shapes; errors of the library.
pub fn as_numpy<'py>(object: &Any<'py>, name: &str) -> PyResult<Any<'py>> {
    let numpy = numpy(object.py())?;
    if !is_native(object) && !object.hasattr("__array__")? && object.hasattr("__dlpack__")? {
        return numpy.call_method1("from_dlpack", (object,));
    }
    let array = match detached(object, name)? {
        Some(data) => numpy.call_method1(intern!(object.py(), "asarray"), (data,)),
        None => numpy.call_method1(intern!(object.py(), "asarray"), (object,)),
    };
    array.map_err(|error| match traced(object, name) {
        Some(message) => PyTypeError::new_err(message),
        None => named_error(object.py(), &error, name).unwrap_or(error),
    })
}

/// The NumPy array of a tensor of PyTorch, which shares its data, or a list of those in a list; `None` for other objects.
///
/// # Errors
/// `TypeError` for tensors that derivatives are taken of, or that PyTorch transforms.
fn detached<'py>(object: &Any<'py>, name: &str) -> PyResult<Option<Any<'py>>> {
    if !is_native(object) {
        return match is_tensor(object)? {
            true => array_of_tensor(object, name).map(Some),
            false => Ok(None),
        };
    }
    let is_sequence = object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>();
    if !is_sequence
        || !object
            .get_item(0)
            .is_ok_and(|first| is_tensor(&first).unwrap_or(false))
    {
        return Ok(None);
    }
    let items = PyList::empty(object.py());
    for item in object.try_iter()? {
        let item = item?;
        match is_tensor(&item)? {
            true => items.append(array_of_tensor(&item, name)?)?,
            false => items.append(item)?,
        }
    }
    Ok(Some(items.into_any()))
}

/// The NumPy array that shares its data with a tensor of PyTorch.
fn array_of_tensor<'py>(tensor: &Any<'py>, name: &str) -> PyResult<Any<'py>> {
    let py = tensor.py();
    if tensor_requires_gradient(tensor) {
        return Err(differentiated(name, "requires a gradient"));
    }
    let forward = py.import("torch.autograd.forward_ad")?;
    let dual = forward.call_method1("unpack_dual", (tensor,))?;
    if !dual.getattr("tangent")?.is_none() {
        return Err(differentiated(name, "has a tangent"));
    }
    // Resolves lazy conjugates and signs.
    let resolved = tensor
        .call_method0("resolve_conj")?
        .call_method0("resolve_neg")?;
    let array = resolved.call_method0("numpy");
    array.map_err(|error| {
        if !error.is_instance_of::<PyRuntimeError>(py) {
            return error;
        }
        let message = format!(
            "{name}: a tensor without data of its own, as inside of transformations of torch.func; use the functions \
             of stiefel_rs.torch"
        );
        let named = PyTypeError::new_err(message);
        named.set_cause(py, Some(error));
        named
    })
}

fn differentiated(name: &str, what: &str) -> PyErr {
    let advice = "use the functions of stiefel_rs.torch, or detach()";
    PyTypeError::new_err(format!("{name}: a tensor that {what}; {advice}"))
}

fn tensor_requires_gradient(tensor: &Any) -> bool {
    let flag = tensor.getattr("requires_grad");
    flag.is_ok_and(|flag| flag.is_truthy().unwrap_or(false))
}

/// NumPy's `ValueError` with the name of the argument.
fn named_error(py: Python<'_>, error: &PyErr, name: &str) -> Option<PyErr> {
    if !error.is_instance_of::<PyValueError>(py) {
        return None;
    }
    let text = error.value(py).to_string();
    let found = match text.contains("inhomogeneous") {
        true => "found items of different shapes",
        false => &text,
    };
    let named = invalid!("{name}: {found}");
    named.set_cause(py, Some(error.clone_ref(py)));
    Some(named)
}

/// The NumPy array of an argument, for functions written in Python.
#[pyfunction]
pub fn _as_numpy<'py>(name: &str, object: &Any<'py>) -> PyResult<Any<'py>> {
    as_numpy(object, name)
}

/// Advice for an array that derivatives are taken of.
fn traced(object: &Any, name: &str) -> Option<String> {
    let class = object.get_type().name().ok()?.to_string();
    let is_tracer = class.ends_with("Tracer");
    is_tracer.then(|| format!("{name}: traced by JAX; use the functions of stiefel_rs.jax"))
}

/// Convert a NumPy array, or a tuple of NumPy arrays, to the library of an argument.
///
/// Returns other objects unchanged. For results that are computed in Python.
#[pyfunction]
pub fn _in_library_of<'py>(argument: &Any<'py>, value: &Any<'py>) -> PyResult<Any<'py>> {
    let namespace = Namespace::of(named![argument])?;
    if let Ok(values) = value.cast_exact::<PyTuple>() {
        let values = values.iter().map(|value| namespace.converted(value));
        let values = values.collect::<PyResult<Vec<_>>>()?;
        return Ok(PyTuple::new(value.py(), values)?.into_any());
    }
    namespace.converted(value.clone())
}
