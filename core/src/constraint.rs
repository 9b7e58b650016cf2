//! Rows and their projection: pure math, which knows no world.

pub(crate) mod contact;
pub(crate) mod joint;
pub(crate) mod residual;
pub(crate) mod row;
pub(crate) mod velocities;
