//! Loops compiled for the vector instructions that are found at run time.

/// Runs `work` compiled for the widest vector instructions that this processor has.
///
/// Everything that is to profit must be inlined into `work`. No fused multiply-add is formed, so a loop gives the
/// same bits on every processor.
#[inline(always)]
pub(crate) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
