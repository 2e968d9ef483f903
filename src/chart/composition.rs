//! Higher order by composition: several steps of fractional length replace one step.
//!
//! A symmetric method of order 2, applied with step lengths `gamma_1 h, ..., gamma_s h` for symmetric fractions, is
//! again symmetric and symplectic, and of order 4, 6 or 8 if the fractions satisfy the order conditions. A method of
//! order 1 and its adjoint, with half a step each, first form a symmetric method of order 2.
//!
//! # Source
//! Suzuki (1990), "Fractal decomposition of exponential operators", Phys. Lett. A 146, 319-323 (order 4); Kahan, Li
//! (1997), "Composition constants for raising the orders of unconventional schemes for ordinary differential
//! equations", Math. Comp. 66, 1089-1099 (orders 6 and 8); Hairer, Lubich, Wanner (2006), "Geometric Numerical
//! Integration", section V.3.

use nalgebra::SVector;

use super::discretization::{Blocks, DiscretizationMap, Expansion};
use crate::error::{Error, Result};

/// Suzuki's five steps: `1 / (4 - 4^(1/3))` four times, around the middle one that makes the sum 1.
const ORDER_4: [f64; 5] = [
    0.414_490_771_794_375_7,
    0.414_490_771_794_375_7,
    -0.657_963_087_177_503,
    0.414_490_771_794_375_7,
    0.414_490_771_794_375_7,
];

/// Nine steps of Kahan and Li.
const ORDER_6: [f64; 9] = [
    0.392_161_444_007_314_1,
    0.332_599_136_789_359_43,
    -0.706_246_172_557_639_3,
    0.082_213_596_293_550_8,
    0.798_543_990_934_83,
    0.082_213_596_293_550_8,
    -0.706_246_172_557_639_3,
    0.332_599_136_789_359_43,
    0.392_161_444_007_314_1,
];

/// Seventeen steps of Kahan and Li.
const ORDER_8: [f64; 17] = [
    0.130_202_483_088_890_07,
    0.561_162_981_775_108_4,
    -0.389_474_962_644_847_27,
    0.158_841_906_555_155_6,
    -0.395_903_894_133_237_57,
    0.184_539_640_978_315_7,
    0.258_374_387_686_322_04,
    0.295_011_723_609_310_3,
    -0.605_508_533_830_034_6,
    0.295_011_723_609_310_3,
    0.258_374_387_686_322_04,
    0.184_539_640_978_315_7,
    -0.395_903_894_133_237_57,
    0.158_841_906_555_155_6,
    -0.389_474_962_644_847_27,
    0.561_162_981_775_108_4,
    0.130_202_483_088_890_07,
];

/// The composition of one step from steps of fractional length.
///
/// # Examples
/// ```
/// use stiefel_rs::chart::Composition;
/// use stiefel_rs::chart::composition::Stage;
/// let composition = Composition::new(2, 4)?;
/// let fractions: Vec<f64> = composition
///     .stages()
///     .map(|stage| match stage {
///         Stage::Method(fraction) | Stage::Adjoint(fraction) => fraction,
///     })
///     .collect();
/// // Five parts of one step; their cubes cancel, which leaves an error of order 4.
/// assert_eq!(fractions.len(), 5);
/// assert!((fractions.iter().sum::<f64>() - 1.0).abs() < 1e-14);
/// assert!(fractions.iter().map(|fraction| fraction.powi(3)).sum::<f64>().abs() < 1e-14);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Composition {
    fractions: &'static [f64],
    base: Base,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Base {
    /// The method itself.
    Method,
    /// The adjoint method for half of the fraction, then the method for the other half.
    WithAdjoint,
}

/// A stage of a step: the method or its adjoint, with a fraction of the step's length.
///
/// # Examples
/// ```
/// use stiefel_rs::chart::Composition;
/// use stiefel_rs::chart::composition::Stage;
/// // Order 2 from order 1: half of the step by the adjoint, half by the method.
/// let stages: Vec<Stage> = Composition::new(1, 2)?.stages().collect();
/// assert_eq!(stages, [Stage::Adjoint(0.5), Stage::Method(0.5)]);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stage {
    /// The method of the discretization map.
    Method(f64),
    /// The method of the [`Adjoint`] map.
    Adjoint(f64),
}

impl Default for Composition {
    /// One step of the method itself.
    fn default() -> Self {
        Composition {
            fractions: &[1.0],
            base: Base::Method,
        }
    }
}

impl Composition {
    /// The composition that raises a method of order `base`, 1 or 2 (then symmetric), to `order`.
    ///
    /// # Errors
    /// `InvalidArgument` unless `order` is 2, 4, 6, 8 or the order of the method.
    pub fn new(base: usize, order: usize) -> Result<Self> {
        let fractions: &'static [f64] = match order {
            _ if order == base => return Ok(Composition::default()),
            2 if base == 1 => &[1.0],
            4 => &ORDER_4,
            6 => &ORDER_6,
            8 => &ORDER_8,
            _ => {
                return Err(Error::InvalidArgument {
                    name: "order",
                    requirement: "the order of the map (1 or 2), or a larger one of 2, 4, 6, 8",
                    found: order as f64,
                });
            }
        };
        let base = if base == 1 {
            Base::WithAdjoint
        } else {
            Base::Method
        };
        Ok(Composition { fractions, base })
    }

    /// The stages of one step, in order.
    pub fn stages(&self) -> impl Iterator<Item = Stage> {
        let base = self.base;
        self.fractions.iter().flat_map(move |&fraction| {
            let (first, second) = match base {
                Base::Method => (None, Stage::Method(fraction)),
                Base::WithAdjoint => (
                    Some(Stage::Adjoint(0.5 * fraction)),
                    Stage::Method(0.5 * fraction),
                ),
            };
            first.into_iter().chain([second])
        })
    }
}

/// The adjoint map `R_d^*(x, v) = (R_2(x, -v), R_1(x, -v))`; its step is the inverse of the step backwards.
///
/// # Examples
/// ```
/// use nalgebra::SVector;
/// use stiefel_rs::chart::composition::Adjoint;
/// use stiefel_rs::chart::{DiscretizationMap, LinearMap};
/// let (x, v) = (SVector::from([1.0, 2.0, 3.0, 4.0]), SVector::from([0.5, 0.0, -1.0, 0.25]));
/// // That of the initial-point map is the end-point map; the mid-point map is its own.
/// assert_eq!(Adjoint(&LinearMap::INITIAL_POINT).map(&x, &v), [x - v, x]);
/// assert_eq!(Adjoint(&LinearMap::MIDPOINT).map(&x, &v), LinearMap::MIDPOINT.map(&x, &v));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Adjoint<'a, M>(pub &'a M);

impl<const X: usize, M: DiscretizationMap<X>> DiscretizationMap<X> for Adjoint<'_, M> {
    fn map(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> [SVector<f64, X>; 2] {
        let [first, second] = self.0.map(x, &-v);
        [second, first]
    }

    fn jacobian(&self, x: &SVector<f64, X>, v: &SVector<f64, X>) -> Blocks<X> {
        reversed(self.0.jacobian(x, &-v))
    }

    fn second_derivative(
        &self,
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        lambda: &[SVector<f64, X>; 2],
    ) -> Blocks<X> {
        let [[xx, xv], [vx, vv]] = self.0.second_derivative(x, &-v, &[lambda[1], lambda[0]]);
        [[xx, -xv], [-vx, vv]]
    }

    fn expansion(
        &self,
        x: &SVector<f64, X>,
        v: &SVector<f64, X>,
        lambda: &[SVector<f64, X>; 2],
    ) -> Expansion<X> {
        let inner = self.0.expansion(x, &-v, &[lambda[1], lambda[0]]);
        let [[xx, xv], [vx, vv]] = inner.second_derivative;
        let [first, second] = inner.points;
        Expansion {
            points: [second, first],
            jacobian: reversed(inner.jacobian),
            second_derivative: [[xx, -xv], [-vx, vv]],
        }
    }

    fn order(&self) -> usize {
        self.0.order()
    }
}

/// The derivatives of `(R_2, R_1)` with respect to `(x, -v)`.
fn reversed<const X: usize>([[r1x, r1v], [r2x, r2v]]: Blocks<X>) -> Blocks<X> {
    [[r2x, -r2v], [r1x, -r1v]]
}
