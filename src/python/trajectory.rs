//! Curves across charts: from covariant data to covariant data.

use super::chart::PyChart;
use super::points::Points;
use super::prelude::*;
use super::projection::Projection;
use super::state::{ChartKind, Steps, on_chart};
use crate::chart::rows::Rows;
use crate::chart::{
    AtlasState, Chart, CovariantData, DiscretizationMap, NamedMap, integrate_across,
    reference_across, state_from_covariant,
};

/// Curve across charts, at times of shape ``T``; ``(steps + 1,)`` for a discrete trajectory.
#[pyclass(name = "ChartTrajectory", module = "stiefel_rs", frozen, get_all)]
pub struct PyChartTrajectory {
    /// Points, shape T + (3, k).
    point: Owned,
    /// Velocities, shape T + (3, k).
    velocity: Owned,
    /// Covariant accelerations, shape T + (3, k).
    acceleration: Owned,
    /// Covariant jerks, shape T + (3, k).
    jerk: Owned,
    /// Hamiltonian, shape T.
    energy: Owned,
    /// Momentum of rotations of space about the three axes, conserved along a Riemannian cubic, shape T + (3,).
    momentum: Owned,
    /// States ``(q, qdot, p_q, p_qdot)`` of the points ``rotations @ point`` in the chart, shape T + (4 d,).
    states: Owned,
    /// Chart of each point as a cyclic permutation of the axes, shape T + (3, 3); identity: the original chart.
    rotations: Owned,
    /// Indices, in C order, at which the chart differs from the one before.
    transitions: Vec<usize>,
}

#[pymethods]
impl PyChartTrajectory {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = self.point.bind(py).getattr("shape")?;
        let changes = format!("{} changes of chart", self.transitions.len());
        Ok(format!("<ChartTrajectory {shape}, {changes}>"))
    }
}

impl PyChartTrajectory {
    /// `shape` is the shape of the times.
    fn of(py: Python<'_>, rows: Rows, kind: ChartKind, shape: &[usize]) -> PyResult<Self> {
        let (tangent, width) = ([3, kind.columns()], [kind.width()]);
        let own: [&[usize]; 4] = [&[], &[3], &width, &[3, 3]];
        let own = [&tangent[..]; 4].into_iter().chain(own);
        let arrays = rows.columns.into_iter().zip(own).map(|(entries, own)| {
            let shape = [shape, own].concat();
            PyResult::Ok(to_array(py, entries, &shape)?.into_any().unbind())
        });
        let mut arrays = arrays.collect::<PyResult<Vec<_>>>()?.into_iter();
        let mut next = || arrays.next().expect("eight arrays");
        let changes = |i: &usize| rows.turns[*i] != rows.turns[*i - 1];
        Ok(PyChartTrajectory {
            point: next(),
            velocity: next(),
            acceleration: next(),
            jerk: next(),
            energy: next(),
            momentum: next(),
            states: next(),
            rotations: next(),
            transitions: (1..rows.turns.len()).filter(changes).collect(),
        })
    }
}

/// The requested flow across charts.
enum FlowAcross {
    Steps(Steps),
    Times(Vec<f64>),
}

impl FlowAcross {
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
            FlowAcross::Times(t) => reference_across(chart, &start, t, interrupt)?,
            FlowAcross::Steps(s) => {
                let (map, composition) = (&s.map, &s.composition);
                integrate_across(chart, map, composition, &start, s.count, s.t_end, interrupt)?
            }
        };
        Rows::new(chart, &states)
    }
}

fn read_data(objects: [Named<'_, '_>; 4]) -> PyResult<CovariantData> {
    let [point, velocity, acceleration, jerk] =
        Points::frames(Projection::OfRoundOff).matrices(Field::Real, objects)?;
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
        objects: [Named<'_, '_>; 4],
        flow: FlowAcross,
        shape: &[usize],
    ) -> PyResult<PyChartTrajectory> {
        let (py, kind, data) = (objects[0].0.py(), self.0, read_data(objects)?);
        // Always interruptible: the number of steps may become known only during the integration.
        let work =
            move |stop: Interrupt<'_>| on_chart!(kind, chart => flow.run(chart, &data, stop));
        PyChartTrajectory::of(py, run(py, Field::Real, f64::INFINITY, work)?, kind, shape)
    }
}

#[pymethods]
impl PyChart {
    /// Return the state of the cubic with the given point, velocity, covariant acceleration and covariant jerk.
    ///
    /// Parameters
    /// ----------
    /// S, V, A, J : array_like, shape (3, k)
    ///     Point, velocity, covariant acceleration and covariant jerk.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (4 d,)
    ///     State ``(q, qdot, p_q, p_qdot)``, angles in ``[-pi, pi]``.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent (with the measured defect).
    /// OutsideDomainError
    ///     The first column of ``S`` is a pole of the chart; :meth:`integrate_across` and :meth:`reference_across`
    ///     accept it.
    ///
    /// Notes
    /// -----
    /// ``p_qdot[i] = <d_i S, A>`` and ``p_q[i] = Gamma[k, i, j] qdot[j] p_qdot[k] - <d_i S, J>``.
    fn state(&self, S: &Any, V: &Any, A: &Any, J: &Any) -> PyResult<Numbers> {
        let (data, kind) = (read_data(named![S, V, A, J])?, self.0);
        let state = run(S.py(), Field::Real, 0.0, move |_| {
            on_chart!(kind, chart => {
                let state = state_from_covariant(chart, &data)?;
                Ok(Array::flat(state.as_slice().to_vec()))
            })
        })?;
        Numbers::from(state).like(named![S, V, A, J])
    }

    /// Integrate as :meth:`integrate` does, changing charts to avoid their poles.
    ///
    /// A state with ``sin(theta) < 1/2`` is moved to another chart before its next step, by a cyclic permutation of the
    /// axes, which is an isometry, and its cotangent lift; so the method remains symplectic.
    ///
    /// Parameters
    /// ----------
    /// S, V, A, J : array_like, shape (3, k)
    ///     Point, which may be a pole, velocity, covariant acceleration and covariant jerk.
    /// steps : int
    ///     Number of equal steps over ``[0, t_end]``, at least 1.
    /// t_end : float, default 1.0
    ///     End time.
    /// map, order
    ///     As for :meth:`integrate`. With a map of a retraction the trajectory does not depend on the charts; the maps
    ///     "initial_point" and "midpoint", which are linear in coordinates, give a different method of the same order
    ///     in each chart.
    ///
    /// Returns
    /// -------
    /// ChartTrajectory
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent; ``steps < 1``, unknown map or
    ///     order.
    /// OutsideDomainError, ConvergenceError
    ///     A step is too long for a chart, or for its implicit equations to be solved.
    ///
    /// Examples
    /// --------
    /// A geodesic over the pole, once around the sphere:
    ///
    /// >>> from stiefel_rs import Chart
    /// >>> S, V = np.array([[1.0], [0.0], [0.0]]), np.array([[0.0], [0.0], [2 * np.pi]])
    /// >>> path = Chart.sphere().integrate_across(S, V, 0 * S, 0 * S, 40, map="exponential_midpoint")
    /// >>> bool(abs(path.point[-1] - S).max() < 1e-13)
    /// True
    /// >>> len(path.transitions) > 0
    /// True
    #[pyo3(signature = (S, V, A, J, steps, t_end=1.0, map="midpoint", *, order=None))]
    fn integrate_across(
        &self,
        S: &Any,
        V: &Any,
        A: &Any,
        J: &Any,
        #[pyo3(from_py_with = whole)] steps: i64,
        t_end: f64,
        map: &str,
        order: Option<i64>,
    ) -> PyResult<PyChartTrajectory> {
        let steps = Steps::read(map, order, steps, t_end)?;
        let shape = [steps.count.saturating_add(1)];
        self.across(named![S, V, A, J], FlowAcross::Steps(steps), &shape)
    }

    /// Evaluate the exact flow as :meth:`reference` does, changing charts to avoid their poles.
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
    ///     Wrong shape, non-finite entries, points not orthonormal, vectors not tangent.
    /// ConvergenceError
    ///     Too many steps; carries ``report``.
    fn reference_across(
        &self,
        S: &Any,
        V: &Any,
        A: &Any,
        J: &Any,
        t: &Any,
    ) -> PyResult<PyChartTrajectory> {
        let Array { shape, entries } = read(t, "t")?;
        self.across(named![S, V, A, J], FlowAcross::Times(entries), &shape)
    }
}
