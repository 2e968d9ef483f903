//! Times and end conditions of splines, in the forms that SciPy accepts.

use super::array_namespace::as_numpy;
use super::points::Points;
use super::prelude::*;
use super::stored::Form;
use crate::spline::{EndCondition, EndConditions};

/// Times from anything array-like, shape (N,).
///
/// # Errors
/// `TypeError` for objects that are not numbers (for dates, with how to convert them), `InvalidInputError` for other
/// shapes and integers that no float represents exactly.
pub(super) fn times(object: &Any) -> PyResult<Vec<f64>> {
    if object.cast::<PyArrayDyn<f64>>().is_err() {
        check_numbers(object)?;
    }
    let ([_], times) = read_axes(object, "t", "(N,)")?;
    Ok(times)
}

/// Error for dates and durations, and for integers that would be rounded.
fn check_numbers(object: &Any) -> PyResult<()> {
    let array = as_numpy(object, "t")?;
    let array = array.cast_into::<PyUntypedArray>()?;
    let kind: char = array.dtype().getattr("kind")?.extract()?;
    let (found, advice) = match kind {
        'M' => ("datetimes", "(t - t[0]) / np.timedelta64(1, 's')"),
        'm' => ("durations", "t / np.timedelta64(1, 's')"),
        'O' if holds(&array, "date")? => {
            ("datetimes", "[(time - t[0]).total_seconds() for time in t]")
        }
        'O' if holds(&array, "timedelta")? => ("durations", "[time.total_seconds() for time in t]"),
        'i' | 'u' => return check_exact(array.as_any()),
        _ => return Ok(()),
    };
    let message = format!("t: {found} are not numbers; convert them to seconds: {advice}");
    Err(PyTypeError::new_err(message))
}

/// Whether the first object of an array is an instance of a class of the module `datetime`.
fn holds(array: &Bound<'_, PyUntypedArray>, class: &str) -> PyResult<bool> {
    if array.len() == 0 {
        return Ok(false);
    }
    let class = array.py().import("datetime")?.getattr(class)?;
    array.call_method1("item", (0,))?.is_instance(&class)
}

/// Error if an integer is not exactly a float, such as a time stamp in nanoseconds.
fn check_exact(array: &Any) -> PyResult<()> {
    let exact = array.call_method0("ravel")?.call_method0("tolist")?;
    let rounded = array.call_method1("astype", ("float64",))?;
    let rounded = rounded.call_method0("ravel")?.call_method0("tolist")?;
    // Python compares integers with floats exactly.
    if exact.eq(&rounded)? {
        return Ok(());
    }
    for (knot, pair) in exact.try_iter()?.zip(rounded.try_iter()?).enumerate() {
        let exact = pair.0?;
        if !exact.eq(pair.1?)? {
            let problem = "is not exactly a float; pass differences: t - t[0]";
            let error = invalid!("t: entry {knot}, {exact}, {problem}");
            return Err(at_knot(error, knot));
        }
    }
    Ok(())
}

/// End conditions as given, and their meaning.
pub(super) struct GivenEnds {
    /// A word, or a pair of words and pairs of an order and an array.
    pub(super) given: Py<PyAny>,
    pub(super) conditions: EndConditions,
}

const NATURAL: &str = "natural";
const CLAMPED: &str = "clamped";
const PERIODIC: &str = "periodic";

/// The argument `bc_type`: a word, or any other object, which is then a pair.
#[derive(FromPyObject)]
pub(super) enum BcType<'py> {
    Word(String),
    Pair(Any<'py>),
}

impl Default for BcType<'_> {
    fn default() -> Self {
        BcType::Word(NATURAL.to_owned())
    }
}

impl BcType<'_> {
    pub(super) fn is_periodic(&self) -> bool {
        matches!(self, BcType::Word(word) if word == PERIODIC)
    }

    /// The conditions for points of a given shape of the core.
    pub(super) fn read(
        &self,
        py: Python<'_>,
        field: Field,
        shape: (usize, usize),
    ) -> PyResult<GivenEnds> {
        self.read_by(py, field, shape, |_, object| {
            of_shape(field, shape, field.matrix(object, "bc_type")?)
        })
    }

    /// The conditions for points at knots; the vectors are projected to their tangent spaces.
    pub(super) fn read_at(
        &self,
        py: Python<'_>,
        points: &Batch,
        manifold: &Points,
    ) -> PyResult<GivenEnds> {
        let (field, shape) = (points.field(), (points.rows, points.cols));
        let Some(last) = points.len().checked_sub(1) else {
            return self.read(py, field, shape);
        };
        self.read_by(py, field, shape, |which, object| {
            let point = points.member(which * last);
            of_shape(
                field,
                shape,
                manifold.vector_at(&point, (object, "bc_type"))?,
            )
        })
    }

    /// The vectors in the conditions. Errors in them are reported where they are read.
    pub(super) fn vectors(&self) -> PyResult<Vec<Any<'_>>> {
        let mut vectors = Vec::new();
        // Objects without a length, such as iterators, can be read only once.
        if let BcType::Pair(items) = self
            && items.len().is_ok()
        {
            for end in items.try_iter().into_iter().flatten() {
                let end = end?;
                if end.len().is_ok_and(|count| count == 2) && !end.is_instance_of::<PyString>() {
                    vectors.push(end.get_item(1)?);
                }
            }
        }
        Ok(vectors)
    }

    /// The conditions, with a function that reads the vector of the first or the last end.
    pub(super) fn read_by(
        &self,
        py: Python<'_>,
        field: Field,
        shape: (usize, usize),
        vector: impl Fn(usize, &Any) -> PyResult<Mat<f64>>,
    ) -> PyResult<GivenEnds> {
        match self {
            BcType::Word(word) => {
                let conditions = conditions_of(word, shape)?;
                let given = word.into_py_any(py)?;
                Ok(GivenEnds { given, conditions })
            }
            BcType::Pair(items) => {
                let items = pair(items, "bc_type", "two end conditions")?;
                let [first, last] = &items;
                let each = [(0, first), (1, last)];
                let ends = each.map(|(which, item)| end(item, field, shape, |v| vector(which, v)));
                let [(first, first_given), (last, last_given)] = collected(ends)?;
                let given = (first_given, last_given).into_py_any(py)?;
                let conditions = EndConditions::Each(Box::new([first, last]));
                Ok(GivenEnds { given, conditions })
            }
        }
    }
}

/// A vector with the shape of a point; both shapes are of the core.
fn of_shape(field: Field, shape: (usize, usize), vector: Mat<f64>) -> PyResult<Mat<f64>> {
    if vector.shape() == shape {
        return Ok(vector);
    }
    let shapes = [shape, vector.shape()].map(|shape| field.own(shape));
    let [expected, found] = shapes.map(|(n, k)| [n, k]);
    Err(unexpected("bc_type", &tuple(&expected), &found))
}

/// The conditions of a word for both ends.
fn conditions_of(word: &str, shape: (usize, usize)) -> PyResult<EndConditions> {
    match word {
        NATURAL => Ok(EndConditions::Natural),
        PERIODIC => Ok(EndConditions::Periodic),
        _ => {
            let expected = "'natural', 'clamped', 'periodic' or a pair";
            let end = condition_of(word, shape).ok_or_else(|| unknown(word, expected))?;
            Ok(EndConditions::Each(Box::new([end.clone(), end])))
        }
    }
}

/// The condition at one end, and its stored form.
fn end<'py>(
    object: &Any<'py>,
    field: Field,
    shape: (usize, usize),
    read: impl Fn(&Any) -> PyResult<Mat<f64>>,
) -> PyResult<(EndCondition, Any<'py>)> {
    let py = object.py();
    if let Ok(word) = object.extract::<String>() {
        let expected = "'natural', 'clamped' or a pair for one end";
        let condition = condition_of(&word, shape).ok_or_else(|| unknown(&word, expected))?;
        return Ok((condition, word.into_bound_py_any(py)?));
    }
    let [order, vector] = pair(object, "bc_type", "an order and a tangent vector")?;
    let order = whole(&order)?;
    let vector = read(&vector)?;
    let given = (order, field.number_matrix(vector.clone())?.frozen(py)?);
    let condition = match order {
        1 => EndCondition::Velocity(vector),
        2 => EndCondition::Acceleration(vector),
        _ => {
            let expected =
                "order of an end condition must be 1 (velocity) or 2 (covariant acceleration)";
            return Err(invalid!("bc_type: the {expected}, found {order}"));
        }
    };
    Ok((condition, given.into_bound_py_any(py)?))
}

/// The condition of a word.
fn condition_of(word: &str, (n, k): (usize, usize)) -> Option<EndCondition> {
    match word {
        NATURAL => Some(EndCondition::Acceleration(Mat::zeros(n, k))),
        CLAMPED => Some(EndCondition::Velocity(Mat::zeros(n, k))),
        _ => None,
    }
}

fn unknown(word: &str, expected: &str) -> PyErr {
    let advice = match word {
        "not-a-knot" => "; for that of SciPy give estimated velocities, ((1, V0), (1, V1))",
        _ => "",
    };
    invalid!("bc_type: expected {expected}, found '{word}'{advice}")
}

/// The two items of a pair.
pub(super) fn pair<'py>(object: &Any<'py>, name: &str, expected: &str) -> PyResult<[Any<'py>; 2]> {
    if object.try_iter().is_err() {
        let found = object.get_type().name()?;
        let message = format!("{name}: expected a pair ({expected}), found {found}");
        return Err(PyTypeError::new_err(message));
    }
    two(object)?
        .map_err(|found| invalid!("{name}: expected a pair ({expected}), found {found} items"))
}

/// Names of the end conditions and their vectors in a stored form.
const BC_TYPE: &str = "bc_type";
const ENDS: [(&str, &str); 2] = [
    ("bc_first", "bc_first_vector"),
    ("bc_last", "bc_last_vector"),
];

/// The word for separate conditions at both ends.
const EACH: &str = "each";

/// Words for the given vector, by the order of the derivative.
const GIVEN: [&str; 2] = ["velocity", "acceleration"];

/// Writes end conditions into a stored form, in the form that [`GivenEnds`] reads.
pub(super) fn store_ends(given: &Any, field: Field, form: &Bound<'_, PyDict>) -> PyResult<()> {
    if given.is_instance_of::<PyString>() {
        return form.set_item(BC_TYPE, given);
    }
    form.set_item(BC_TYPE, EACH)?;
    for ((name, vector_name), end) in ENDS.into_iter().zip(given.try_iter()?) {
        let end = end?;
        if end.is_instance_of::<PyString>() {
            form.set_item(name, end)?;
        } else {
            let (order, vector): (usize, Any<'_>) = end.extract()?;
            form.set_item(name, GIVEN[order - 1])?;
            let vector = field.matrix(&vector, vector_name)?;
            form.set_item(vector_name, Array::from(vector))?;
        }
    }
    Ok(())
}

/// Reads end conditions from a stored form.
pub(super) fn restore_ends<'py>(py: Python<'py>, form: &mut Form) -> PyResult<BcType<'py>> {
    let word = form.word(BC_TYPE)?;
    if word != EACH {
        return Ok(BcType::Word(word));
    }
    let end = |(name, vector_name): (&str, &str)| {
        let word = form.word(name)?;
        match GIVEN.iter().position(|given| word == *given) {
            None => word.into_bound_py_any(py),
            Some(i) => {
                let vector = form.fields.take(vector_name)?;
                if vector.shape.len() != 2 {
                    return Err(unexpected(vector_name, "(n, k)", &vector.shape));
                }
                (i + 1, form.field.numbers(vector)?).into_bound_py_any(py)
            }
        }
    };
    let ends = collected(ENDS.map(end))?;
    Ok(BcType::Pair(PyTuple::new(py, ends)?.into_any()))
}
