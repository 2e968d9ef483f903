//! Initial value problems in equal steps: splittings, and the method in the embedding.

pub(crate) mod composition;
pub(crate) mod embedded;
pub(crate) mod embedded_field;
pub(crate) mod embedded_state;
pub(crate) mod frame_flow;
pub(crate) mod space_flow;
pub(crate) mod split_state;
pub(crate) mod splitting;
pub(crate) mod trajectory;
