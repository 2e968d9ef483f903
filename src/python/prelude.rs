//! Imports of most files of the binding: the crate's results, arrays in and out, errors, and calls into the core.

pub(super) use std::sync::Arc;

pub(super) use faer::{Mat, MatMut, MatRef};
pub(super) use numpy::{
    PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
pub(super) use pyo3::exceptions::{PyMemoryError, PyTypeError};
pub(super) use pyo3::prelude::*;
pub(super) use pyo3::types::{IntoPyDict, PyDict, PyFloat, PyString, PyTuple};
pub(super) use pyo3::{IntoPyObjectExt, PyClass};

pub(super) use super::batch::{Batch, matrix_batches};
pub(super) use super::call::{Call, SOLVES, Shared, run, run_on};
pub(super) use super::convert::{
    Any, Array, Named, Owned, collected, count, freeze, is_second, named, numpy, read, read_axes,
    to_array, tuple, two, unexpected, whole, write,
};
pub(super) use super::curve::{PyCurve, object, wrap, wrap_checked};
pub(super) use super::error::{PySolverReport, at_knot, at_member, ensure, invalid};
pub(super) use super::field::{Field, FourNumbers, Numbers};
pub(super) use crate::curve::any_curve::AnyCurve;
pub(super) use crate::error::{Error, Result};
pub(super) use crate::interrupt::Interrupt;
pub(super) use crate::report::SolverReport;
