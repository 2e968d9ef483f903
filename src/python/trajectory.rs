//! Curves across charts: from covariant data to covariant data.

use faer::Mat;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::call::run;
use super::chart::PyChart;
use super::convert::{
    Any, Named, NewArray, collected, count, matrices, named, parameters, to_array, whole, write,
};
use super::discretization::NamedMap;
use super::state::{Kind, on_chart};
use crate::chart::{
    AtlasState, Chart, Composition, CovariantData, DiscretizationMap, integrate_across,
    reference_across, state_from_covariant,
};
use crate::error::{Error, Result};
use crate::interrupt::Interrupt;

type Owned = Py<PyArrayDyn<f64>>;

/// A curve that passes from chart to chart, at times of shape ``T``; ``(steps + 1,)`` for a discrete trajectory.
///
/// Attributes
/// ----------
/// point : ndarray, shape T + (3, k)
/// velocity : ndarray, shape T + (3, k)
/// acceleration : ndarray, shape T + (3, k)
///     Covariant.
/// jerk : ndarray, shape T + (3, k)
///     Covariant.
/// energy : ndarray, shape T
///     The Hamiltonian.
/// momentum : ndarray, shape T + (3,)
///     Momentum of the rotations of space about the three axes, which a Riemannian cubic keeps.
/// states : ndarray, shape T + (4 d,)
///     ``(q, qdot, p_q, p_qdot)`` of the rotated point ``rotations @ point`` in the chart.
/// rotations : ndarray, shape T + (3, 3)
///     Which of the three charts: a cyclic permutation of the axes, the identity for the chart itself.
/// transitions : list of int
///     The positions, in C order, at which the chart is another than before.
#[pyclass(name = "ChartTrajectory", module = "stiefel_rs", frozen, get_all)]
pub struct PyChartTrajectory {
    point: Owned,
    velocity: Owned,
    acceleration: Owned,
    jerk: Owned,
    energy: Owned,
    momentum: Owned,
    states: Owned,
    rotations: Owned,
    transitions: Vec<usize>,
}

#[pymethods]
impl PyChartTrajectory {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = self.point.bind(py).getattr("shape")?;
        let changes = self.transitions.len();
        Ok(format!(
            "<ChartTrajectory {shape}, {changes} changes of chart>"
        ))
    }
}

/// The numbers of a trajectory, state after state.
#[derive(Default)]
struct Rows {
    /// Point, velocity, acceleration, jerk.
    data: [Vec<f64>; 4],
    energy: Vec<f64>,
    momentum: Vec<f64>,
    states: Vec<f64>,
    rotations: Vec<f64>,
    turns: Vec<usize>,
}

impl Rows {
    fn new<C: Chart<X, Z>, const X: usize, const Z: usize>(
        chart: &C,
        states: &[AtlasState<Z>],
    ) -> Result<Self> {
        let mut out = Rows::default();
        for state in states {
            let data = state.covariant(chart)?;
            let parts = [&data.point, &data.velocity, &data.acceleration, &data.jerk];
            for (rows, part) in out.data.iter_mut().zip(parts) {
                push(rows, part);
            }
            out.energy.push(chart.hamiltonian(&state.z));
            out.momentum.extend(data.spatial_momentum());
            out.states.extend_from_slice(state.z.as_slice());
            // Column by column of the transpose: row by row.
            out.rotations
                .extend_from_slice(state.rotation().transpose().as_slice());
            out.turns.push(state.turns);
        }
        let mut derived = out.energy.iter().chain(&out.momentum);
        if derived.all(|x| x.is_finite()) {
            return Ok(out);
        }
        let quantity = "energy or momentum";
        Err(Error::Overflow { quantity })
    }

    fn into_python(
        self,
        py: Python<'_>,
        kind: Kind,
        shape: &[usize],
    ) -> PyResult<PyChartTrajectory> {
        let array = |entries: Vec<f64>, trailing: &[usize]| {
            to_array(py, entries, &[shape, trailing].concat()).map(Bound::unbind)
        };
        let tangent = [3, kind.columns()];
        let data = self.data.map(|entries| array(entries, &tangent));
        let [point, velocity, acceleration, jerk] = collected(data)?;
        let changes = |i: &usize| self.turns[*i] != self.turns[*i - 1];
        Ok(PyChartTrajectory {
            point,
            velocity,
            acceleration,
            jerk,
            energy: array(self.energy, &[])?,
            momentum: array(self.momentum, &[3])?,
            states: array(self.states, &[kind.width()])?,
            rotations: array(self.rotations, &[3, 3])?,
            transitions: (1..self.turns.len()).filter(changes).collect(),
        })
    }
}

fn push(rows: &mut Vec<f64>, part: &Mat<f64>) {
    let first = rows.len();
    rows.resize(first + part.nrows() * part.ncols(), 0.0);
    write(part.as_ref(), &mut rows[first..]);
}

/// What is asked for across charts.
#[derive(Clone)]
enum Flow {
    Steps {
        map: NamedMap,
        composition: Composition,
        steps: usize,
        t_end: f64,
    },
    Times(Vec<f64>),
}

impl Flow {
    fn run<C: Chart<X, Z>, const X: usize, const Z: usize>(
        &self,
        chart: &C,
        data: &CovariantData,
        interrupt: Interrupt<'_>,
    ) -> Result<Rows>
    where
        NamedMap: DiscretizationMap<X>,
    {
        let start = AtlasState::from_covariant(chart, data)?;
        let states = match self {
            Flow::Times(t) => reference_across(chart, &start, t, interrupt)?,
            Flow::Steps {
                map,
                composition,
                steps,
                t_end,
            } => integrate_across(chart, map, composition, &start, *steps, *t_end, interrupt)?,
        };
        Rows::new(chart, &states)
    }
}

fn read_data(objects: [Named<'_, '_>; 4]) -> PyResult<CovariantData> {
    let [point, velocity, acceleration, jerk] = matrices(objects)?;
    Ok(CovariantData {
        point,
        velocity,
        acceleration,
        jerk,
    })
}

impl PyChart {
    fn across(
        &self,
        py: Python<'_>,
        data: CovariantData,
        flow: Flow,
        operations: f64,
        shape: &[usize],
    ) -> PyResult<PyChartTrajectory> {
        let kind = self.0;
        let rows = run(
            py,
            operations,
            move |interrupt| on_chart!(kind, chart => flow.run(chart, &data, interrupt)),
        )?;
        rows.into_python(py, kind, shape)
    }
}

#[pymethods]
#[allow(non_snake_case)]
impl PyChart {
    /// The state of the cubic with the given point, velocity, covariant acceleration and covariant jerk.
    ///
    /// Parameters
    /// ----------
    /// S, V, A, J : array_like, shape (3, k)
    ///     A point and three tangent vectors.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (4 d,)
    ///     ``(q, qdot, p_q, p_qdot)``, angles in ``[-pi, pi]``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent (with the measured defect).
    /// OutsideDomainError
    ///     The first column of ``S`` is a pole of the chart. `integrate_across` and `reference_across` take it.
    ///
    /// Notes
    /// -----
    /// ``p_qdot[i] = <d_i S, A>`` and ``p_q[i] = Gamma[k, i, j] qdot[j] p_qdot[k] - <d_i S, J>``.
    fn state(&self, S: &Any<'_>, V: &Any<'_>, A: &Any<'_>, J: &Any<'_>) -> PyResult<NewArray> {
        let (data, kind) = (read_data(named![S, V, A, J])?, self.0);
        let entries = run(
            S.py(),
            0.0,
            move |_| on_chart!(kind, chart => Ok(state_from_covariant(chart, &data)?.as_slice().to_vec())),
        )?;
        let shape = vec![entries.len()];
        Ok(NewArray { shape, entries })
    }

    /// Point, velocity, covariant acceleration and covariant jerk ``(S, V, A, J)`` of a state: the inverse of `state`.
    ///
    /// Shape (..., 4 d) -> four of shape (..., 3, k).
    fn covariant<'py>(&self, z: &Any<'py>) -> PyResult<Bound<'py, PyTuple>> {
        self.covariant_parts(z)
    }

    /// The discrete trajectory across charts: as `integrate`, with no pole in the way.
    ///
    /// A state with ``sin(theta) < 1/2`` moves before its next step to another chart by a cyclic permutation of the
    /// axes, an isometry, and its cotangent lift: the method stays symplectic.
    ///
    /// Parameters
    /// ----------
    /// S, V, A, J : array_like, shape (3, k)
    ///     Any point, the poles too; velocity, covariant acceleration and covariant jerk.
    /// steps : int
    ///     Equal steps over ``[0, t_end]``, at least 1.
    /// t_end : float, default 1.0
    /// map, order
    ///     As for `integrate`. The trajectory of a map from a retraction does not depend on the charts; the maps
    ///     linear in coordinates are another method in each chart, of the same order.
    ///
    /// Returns
    /// -------
    /// ChartTrajectory
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent; ``steps < 1``, unknown map or order.
    /// OutsideDomainError, ConvergenceError
    ///     A step is too long for a chart, or for its implicit equations.
    ///
    /// Examples
    /// --------
    /// A geodesic over the pole and once around:
    ///
    /// >>> from stiefel_rs import Chart
    /// >>> S, V = np.array([[1.0], [0.0], [0.0]]), np.array([[0.0], [0.0], [2 * np.pi]])
    /// >>> path = Chart.sphere().integrate_across(S, V, 0 * S, 0 * S, 40, map="exponential_midpoint")
    /// >>> bool(abs(path.point[-1] - S).max() < 1e-13)
    /// True
    /// >>> len(path.transitions) > 0
    /// True
    #[pyo3(signature = (S, V, A, J, steps, t_end=1.0, map="midpoint", *, order=None))]
    #[allow(clippy::too_many_arguments)]
    fn integrate_across(
        &self,
        py: Python<'_>,
        S: &Any<'_>,
        V: &Any<'_>,
        A: &Any<'_>,
        J: &Any<'_>,
        #[pyo3(from_py_with = whole)] steps: i64,
        t_end: f64,
        map: &str,
        order: Option<i64>,
    ) -> PyResult<PyChartTrajectory> {
        let map = NamedMap::read(map)?;
        let composition = map.composition(order)?;
        let steps = count("steps", steps, 1)?;
        let data = read_data(named![S, V, A, J])?;
        let flow = Flow::Steps {
            map,
            composition,
            steps,
            t_end,
        };
        let shape = [steps.saturating_add(1)];
        self.across(py, data, flow, 1e6 * steps as f64, &shape)
    }

    /// The exact flow across charts: as `reference`, with no pole in the way.
    ///
    /// Parameters
    /// ----------
    /// S, V, A, J : array_like, shape (3, k)
    ///     Point, velocity, covariant acceleration and covariant jerk at time 0.
    /// t : array_like, shape T
    ///     Finite times in any order.
    ///
    /// Returns
    /// -------
    /// ChartTrajectory
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Shape, not finite, not orthonormal, not tangent.
    /// ConvergenceError
    ///     Too many steps; carries ``report``.
    #[allow(clippy::too_many_arguments)]
    fn reference_across(
        &self,
        py: Python<'_>,
        S: &Any<'_>,
        V: &Any<'_>,
        A: &Any<'_>,
        J: &Any<'_>,
        t: &Any<'_>,
    ) -> PyResult<PyChartTrajectory> {
        let (shape, t) = parameters(t, "t")?;
        let data = read_data(named![S, V, A, J])?;
        // How many steps it takes shows only on the way: always watched.
        self.across(py, data, Flow::Times(t), f64::INFINITY, &shape)
    }
}
