//! Real and complex matrices: reading arrays of both kinds, and converting results back to arrays.
//!
//! The core has real matrices. Complex matrices are embedded in real matrices of twice the size when they are read, and results
//! are restricted to complex matrices when they are written ([`crate::linalg::complex_embedding`]); squared lengths are then
//! halved.

use std::f64::consts::FRAC_1_SQRT_2;

use numpy::Complex64;
use pyo3::exceptions::PyException;

use super::array_namespace::{Namespace, as_numpy};
use super::batch::read_batches;
use super::convert::{array_of, is_plain};
use super::prelude::*;
use crate::curve::Quantity;
use crate::linalg::complex_embedding::{nearest_into, restrict_into};
use crate::stored::refusal;

/// Field of the entries of matrices.
pub(crate) use crate::space::ScalarField as Field;

/// Names of the fields.
const WORDS: [&str; 2] = ["real", "complex"];

impl Field {
    /// The field with a given name, the argument `field`.
    pub(crate) fn from_word(word: &str) -> PyResult<Self> {
        Ok(match is_second("field", word, WORDS)? {
            false => Field::Real,
            true => Field::Complex,
        })
    }

    /// The name of the field.
    pub(crate) fn word(self) -> &'static str {
        WORDS[usize::from(self == Field::Complex)]
    }

    /// The field that contains all given arrays: complex if one of them is.
    pub(crate) fn of<'a, 'py: 'a>(
        objects: impl IntoIterator<Item = &'a Any<'py>>,
    ) -> PyResult<Self> {
        for object in objects {
            if is_complex(object)? {
                return Ok(Field::Complex);
            }
        }
        Ok(Field::Real)
    }

    /// The field of arguments.
    pub(crate) fn of_named<const N: usize>(objects: &[Named<'_, '_>; N]) -> PyResult<Self> {
        Field::of(objects.iter().map(|(object, _)| *object))
    }

    /// Number of rows or columns in the core.
    pub(crate) fn embedded(self, size: usize) -> usize {
        match self {
            Field::Real => size,
            Field::Complex => size.saturating_mul(2),
        }
    }

    /// The shape of the user's matrices for a shape of the core.
    pub(crate) fn own(self, (rows, cols): (usize, usize)) -> (usize, usize) {
        match self {
            Field::Real => (rows, cols),
            Field::Complex => (rows / 2, cols / 2),
        }
    }

    /// Error for a shape of the core that embedded matrices cannot have, as in a damaged file.
    pub(crate) fn check_shape(self, (rows, cols): (usize, usize)) -> Result<()> {
        match self == Field::Complex && (rows % 2, cols % 2) != (0, 0) {
            true => Err(refusal(format!(
                "embedded complex matrices of odd shape ({rows}, {cols})"
            ))),
            false => Ok(()),
        }
    }

    /// `St(n, k)` as in messages, for a shape of the core.
    pub(crate) fn manifold(self, shape: (usize, usize)) -> String {
        let (n, k) = self.own(shape);
        match self {
            Field::Real => format!("St({n}, {k})"),
            Field::Complex => format!("St({n}, {k}, C)"),
        }
    }

    /// Converts a squared length, or another product of two vectors, from the core.
    pub(crate) fn squared(self, x: f64) -> f64 {
        match self {
            Field::Real => x,
            Field::Complex => x / 2.0,
        }
    }

    /// Converts a length from the core.
    pub(crate) fn length(self, x: f64) -> f64 {
        match self {
            Field::Real => x,
            Field::Complex => x * FRAC_1_SQRT_2,
        }
    }

    /// One matrix, shape `(n, k)`.
    pub(crate) fn matrix(self, object: &Any, name: &str) -> PyResult<Mat<f64>> {
        Ok(self.one(object, name)?.get(0).to_owned())
    }

    /// One matrix as a batch without axes.
    pub(crate) fn one(self, object: &Any, name: &str) -> PyResult<Batch> {
        let array = self.array(object, name)?;
        match *array.shape() {
            [rows, cols] => Batch::read_of(self, &[], [rows, cols], &array),
            _ => Err(unexpected(name, "(n, k)", array.shape())),
        }
    }

    /// Several matrices.
    pub(crate) fn matrices<const N: usize>(
        self,
        objects: [Named<'_, '_>; N],
    ) -> PyResult<[Mat<f64>; N]> {
        collected(objects.map(|(object, name)| self.matrix(object, name)))
    }

    /// An array of shape `(count, n, k)`; errors state `expected` as the shape.
    pub(crate) fn batch(self, object: &Any, name: &str, expected: &str) -> PyResult<Batch> {
        let array = self.array(object, name)?;
        match *array.shape() {
            [count, rows, cols] => Batch::read_of(self, &[count], [rows, cols], &array),
            _ => Err(unexpected(name, expected, array.shape())),
        }
    }

    /// Arrays of shape `(..., n, k)`, with their leading axes broadcast.
    pub(crate) fn batches<const N: usize>(
        self,
        objects: [Named<'_, '_>; N],
    ) -> PyResult<[Batch; N]> {
        read_batches(self, objects, 2)
    }

    /// An array of numbers of the field, from any array-like object.
    pub(crate) fn array<'py>(
        self,
        object: &Any<'py>,
        name: &str,
    ) -> PyResult<Bound<'py, PyUntypedArray>> {
        match self {
            Field::Real => array_of::<f64>(object, name),
            Field::Complex => array_of::<Complex64>(object, name),
        }
    }

    /// Converts matrices of the core, shape `(..., n, k)`, to an array of the field.
    ///
    /// # Errors
    /// `NotComplex` for matrices that are not embedded complex matrices.
    pub(crate) fn numbers(self, array: Array) -> PyResult<Numbers> {
        self.converted(array, restrict_into)
    }

    /// [`Field::numbers`] for vectors along curves whose points are embedded: vectors that vanish by cancellation are as large
    /// as round-off in the time of the curve, and are not checked.
    pub(crate) fn vectors(self, array: Array) -> PyResult<Numbers> {
        self.converted(array, |out, matrix| {
            nearest_into(out, matrix);
            Ok(())
        })
    }

    /// An array of the field from matrices of the core, shape `(..., n, k)`; complex ones are written by a function.
    ///
    /// # Errors
    /// Those of the function.
    fn converted(
        self,
        array: Array,
        write: impl Fn(MatMut<'_, Complex64>, MatRef<'_, f64>) -> Result<()>,
    ) -> PyResult<Numbers> {
        if self == Field::Real {
            return Ok(Numbers::from(array));
        }
        let Array { mut shape, entries } = array;
        let [.., rows, cols] = shape[..] else {
            unreachable!("an array of matrices");
        };
        self.check_shape((rows, cols))?;
        let (n, k) = self.own((rows, cols));
        let mut out = vec![Complex64::ZERO; entries.len() / 4];
        let size = (n * k).max(1);
        for (matrix, out) in entries.chunks(4 * size).zip(out.chunks_mut(size)) {
            let matrix = MatRef::from_row_major_slice(matrix, rows, cols);
            write(MatMut::from_row_major_slice_mut(out, n, k), matrix)?;
        }
        let axes = shape.len();
        shape[axes - 2..].copy_from_slice(&[n, k]);
        let entries = out;
        Ok(Numbers {
            entries: Values::Complex { shape, entries },
            namespace: Namespace::default(),
        })
    }

    /// One matrix as an array.
    pub(crate) fn number_matrix(self, matrix: Mat<f64>) -> PyResult<Numbers> {
        self.numbers(Array::from(matrix))
    }

    /// Four matrices as a Python tuple, in the library of the arguments: data of a curve, or gradients with respect to them.
    pub(crate) fn four<const N: usize>(
        self,
        matrices: [Mat<f64>; 4],
        arguments: [Named<'_, '_>; N],
    ) -> PyResult<FourNumbers> {
        let matrices = matrices.map(|matrix| self.vectors(Array::from(matrix))?.like(arguments));
        let [first, second, third, fourth] = collected(matrices)?;
        Ok((first, second, third, fourth))
    }
}

/// Whether an array-like object holds complex numbers.
fn is_complex(object: &Any) -> PyResult<bool> {
    if is_plain::<f64>(object) || object.is_instance_of::<PyString>() {
        return Ok(false);
    }
    let array = match as_numpy(object, "") {
        // Objects that are not arrays cause an error when they are read, with their name.
        Err(error) if error.is_instance_of::<PyException>(object.py()) => return Ok(false),
        other => other?,
    };
    let kind: char = array.getattr("dtype")?.getattr("kind")?.extract()?;
    Ok(kind == 'c')
}

/// An array of real or complex results, in the library of the arguments of the call.
pub(crate) struct Numbers {
    entries: Values,
    namespace: Namespace,
}

enum Values {
    Real(Array),
    /// Whether each number is nonzero.
    Truths(Array),
    Complex {
        shape: Vec<usize>,
        entries: Vec<Complex64>,
    },
}

impl From<Array> for Numbers {
    fn from(array: Array) -> Self {
        Numbers {
            entries: Values::Real(array),
            namespace: Namespace::default(),
        }
    }
}

/// Four arrays as a Python tuple.
pub(crate) type FourNumbers = (Numbers, Numbers, Numbers, Numbers);

impl<'py> IntoPyObject<'py> for Numbers {
    type Target = PyAny;
    type Output = Any<'py>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Any<'py>> {
        let array = match self.entries {
            Values::Real(array) => array.into_pyobject(py)?.into_any(),
            Values::Truths(array) if array.shape.is_empty() && self.namespace.is_numpy() => {
                return (array.entries[0] != 0.0).into_bound_py_any(py);
            }
            Values::Truths(array) => {
                let truths = array.entries.iter().map(|x| *x != 0.0).collect();
                to_array(py, truths, &array.shape)?.into_any()
            }
            Values::Complex { shape, entries } => to_array(py, entries, &shape)?.into_any(),
        };
        self.namespace.array(array)
    }
}

impl Numbers {
    /// Real numbers as booleans: whether they are nonzero.
    pub(crate) fn truths(self) -> Self {
        let entries = match self.entries {
            Values::Real(array) => Values::Truths(array),
            other => other,
        };
        Numbers { entries, ..self }
    }

    /// The numbers as booleans, in the library of the arguments.
    pub(crate) fn like<const N: usize>(self, arguments: [Named<'_, '_>; N]) -> PyResult<Self> {
        let namespace = Namespace::of(arguments)?;
        Ok(Numbers { namespace, ..self })
    }

    /// A read-only NumPy array.
    pub(crate) fn frozen(self, py: Python<'_>) -> PyResult<Owned> {
        let array = self.into_pyobject(py)?;
        freeze(&array)?;
        Ok(array.unbind())
    }
}

/// Writes a sample of an embedded curve as a complex matrix. Points must be embedded ones; derivatives that vanish by
/// cancellation are as large as round-off in the time of the curve, and are not checked.
///
/// # Errors
/// `NotComplex`.
pub(super) fn write_sample(
    quantity: Quantity,
    out: MatMut<'_, Complex64>,
    sample: MatRef<'_, f64>,
) -> Result<()> {
    if quantity == Quantity::Derivative(0) {
        return restrict_into(out, sample);
    }
    nearest_into(out, sample);
    Ok(())
}
