//! Symmetric compositions of two exact flows, for Hamiltonians of which one part commutes with its bracket.
//!
//! A step of length `h` is `e^{b_0 h B} e^{a_1 h A} e^{b_1 h B} ... e^{a_s h A} e^{b_s h B}`, both lists palindromes.
//! For the cubics `A` is linear in `x` and `B` depends on `p` alone, so
//!
//! ```math
//! [B, [B, A]] = 0
//! ```
//!
//! and most order conditions of general splittings are void: a symmetric composition has order 4 after 3 conditions
//! (general: 4), 6 after 5 (general: 10), 8 after 9 (general: 28). With this relation the enveloping algebra has the
//! words without `BBA` as its basis (`BBA = 2 BAB - ABB` rewrites every other one), and the conditions are that the
//! product of exponentials agrees with `e^{h(A + B)}` word by word. The coefficients were computed by Newton's method
//! with 50 digits; if there are more of them than conditions, the free ones minimise the first words that disagree.
//!
//! # Error constants
//! `C = error (s / h)^p` is the error at `t = 1` for equal work, where `s` counts the flows of `A`, the expensive ones.
//! Values are geometric means over random cubics on St(3,1), St(3,2), St(5,2), St(6,3) and O(4), with velocity,
//! acceleration and jerk of norm 5 to 8, computed by `python -m benchmarks.study.compositions`, which also checks the
//! order conditions of every row to round-off. Only ratios within one order are meaningful. The last row is uncertain
//! by a factor of 3: its error is near round-off wherever the others are in their asymptotic regime.
//!
//! | order | composition | flows of A | C |
//! |---|---|---|---|
//! | 2 | Strang: **used** | 1 | 30 |
//! | 4 | Yoshida; Forest and Ruth | 3 | 1.4e4 |
//! | 4 | Suzuki, fractal | 5 | 7.8e3 |
//! | 4 | Chin, weights of Simpson | 2 | 1.7e2 |
//! | 4 | Blanes and Moan, S6 | 6 | 8.5e2 |
//! | 4 | Blanes and Moan, SRKN6b | 6 | 49 |
//! | 4 | three flows, all coefficients positive | 3 | 10 |
//! | 4 | four flows, all coefficients positive: **used** | 4 | 8.0 |
//! | 6 | Yoshida, A | 7 | 6.8e6 |
//! | 6 | Kahan and Li | 9 | 4.0e6 |
//! | 6 | Blanes and Moan, S10 | 10 | 3.7e5 |
//! | 6 | Blanes and Moan, SRKN11b | 11 | 5.0e4 |
//! | 6 | Blanes and Moan, SRKN14a | 15 | 9.8e4 |
//! | 6 | four flows, the fewest | 4 | 3.5e5 |
//! | 6 | five flows: **used** | 5 | 1.5e3 |
//! | 6 | six flows | 6 | 2.1e3 |
//! | 8 | Yoshida, D | 15 | 2.3e12 |
//! | 8 | Suzuki and Umeno | 15 | 1.1e10 |
//! | 8 | Kahan and Li | 17 | 3.4e9 |
//! | 8 | ten flows | 10 | 2.2e6 |
//! | 8 | twelve flows: **used** | 12 | 4e5 |
//!
//! # Source
//! Blanes, Moan (2002), J. Comput. Appl. Math. 142, 313-330; Chin (1997), Phys. Lett. A 226, 344-348; Kahan, Li (1997),
//! Math. Comp. 66, 1089-1099; Suzuki, Umeno (1993), Springer Proc. Phys. 76, 74-86; Yoshida (1990), Phys. Lett. A 150,
//! 262-268, coefficients as in Hairer, Lubich, Wanner (2006), "Geometric Numerical Integration", section V.3. The
//! compositions used for orders 4, 6 and 8 are our own.

use crate::error::{Error, Result};

/// The order of a splitting.
///
/// # Examples
/// ```
/// use faer::mat;
/// use stiefel_rs::cubic::{IntegrationOptions, RiemannianCubic, SplittingOptions, SplittingOrder, integrate_cubic};
/// use stiefel_rs::{Curve, Interrupt};
/// let (s, v) = (mat![[1.0], [0.0], [0.0]], mat![[0.0], [1.0], [0.0]]);
/// let (a, j) = (mat![[0.0], [0.0], [2.0]], mat![[0.0], [3.0], [0.0]]);
/// let [s, v, a, j] = [&s, &v, &a, &j].map(|a| a.as_ref());
/// let end = RiemannianCubic::from_initial(s, v, a, j, &IntegrationOptions::default(), Interrupt::NEVER)?.point(1.0)?;
/// let error = |order, steps| -> stiefel_rs::Result<f64> {
///     let options = SplittingOptions { order, ..Default::default() };
///     Ok((integrate_cubic(s, v, a, j, steps, &options, Interrupt::NEVER)?.points()?.get(steps) - &end).norm_l2())
/// };
/// // Half the step: a quarter of the error of order 2, a sixteenth of that of order 4.
/// assert!((error(SplittingOrder::Two, 16)? / error(SplittingOrder::Two, 32)? - 4.0).abs() < 0.1);
/// assert!((error(SplittingOrder::Four, 16)? / error(SplittingOrder::Four, 32)? - 16.0).abs() < 1.0);
/// # Ok::<(), stiefel_rs::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum SplittingOrder {
    /// Strang's splitting, one exponential per step.
    Two,
    /// Four exponentials per step.
    Four,
    /// Five exponentials per step.
    #[default]
    Six,
    /// Twelve exponentials per step.
    Eight,
}

impl SplittingOrder {
    /// The order as a number.
    pub fn number(self) -> usize {
        match self {
            SplittingOrder::Two => 2,
            SplittingOrder::Four => 4,
            SplittingOrder::Six => 6,
            SplittingOrder::Eight => 8,
        }
    }

    /// Exponentials per step.
    pub fn stages(self) -> usize {
        self.composition().stages
    }

    pub(crate) fn composition(self) -> &'static SplittingComposition {
        match self {
            SplittingOrder::Two => &TWO,
            SplittingOrder::Four => &FOUR,
            SplittingOrder::Six => &SIX,
            SplittingOrder::Eight => &EIGHT,
        }
    }
}

impl TryFrom<i64> for SplittingOrder {
    type Error = Error;

    fn try_from(order: i64) -> Result<Self> {
        match order {
            2 => Ok(SplittingOrder::Two),
            4 => Ok(SplittingOrder::Four),
            6 => Ok(SplittingOrder::Six),
            8 => Ok(SplittingOrder::Eight),
            _ => Err(Error::InvalidArgument {
                name: "order",
                requirement: "2, 4, 6 or 8",
                found: order as f64,
            }),
        }
    }
}

/// The first halves of the two palindromes, including the middle: `s` flows of `A` between `s + 1` flows of `B`.
pub(crate) struct SplittingComposition {
    stages: usize,
    a: &'static [f64],
    b: &'static [f64],
}

impl SplittingComposition {
    /// Fractions of the step for the flows of `A`, each after the fraction for the preceding flow of `B`.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = (f64, f64)> {
        let s = self.stages;
        (0..s).map(move |i| (self.b[i.min(s - i)], self.a[i.min(s - 1 - i)]))
    }

    /// Fraction of the step for the final flow of `B`.
    pub(crate) fn last(&self) -> f64 {
        self.b[0]
    }
}

const TWO: SplittingComposition = SplittingComposition {
    stages: 1,
    a: &[1.0],
    b: &[0.5],
};

const FOUR: SplittingComposition = SplittingComposition {
    stages: 4,
    a: &[0.2041835327197221, 0.29581646728027794],
    b: &[
        0.06370219032429467,
        0.29415940009693015,
        0.28427681915755043,
    ],
};

const SIX: SplittingComposition = SplittingComposition {
    stages: 5,
    a: &[0.1645635274955401, 0.3824380854505102, -0.09400322589210065],
    b: &[
        0.04679037505239178,
        0.26260778243982275,
        0.19060184250778547,
    ],
};

const EIGHT: SplittingComposition = SplittingComposition {
    stages: 12,
    a: &[
        0.1053660676085698,
        0.21417341062611012,
        0.0494182057456452,
        -0.25534565911385765,
        0.19231317192404293,
        0.1940748032094896,
    ],
    b: &[
        0.03009813103709189,
        0.1761827300145743,
        -0.06760958961465136,
        0.03047841994033425,
        -0.009433995621757752,
        0.25994938444933324,
        0.1606698395901509,
    ],
};
