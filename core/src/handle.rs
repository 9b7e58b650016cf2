//! Names of things in a world: a slot and the generation that lives there.

use bytemuck::{Pod, Zeroable};

macro_rules! handle {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
        pub struct $name {
            /// Slot in the pool.
            pub index: u32,
            /// Which tenant of the slot; 0 is never one.
            pub generation: u32,
        }
    };
}

handle! {
    /// Names a body. Goes stale when the body is removed; exact again after a restore to a time when it existed.
    BodyHandle
}
handle! {
    /// Names a shape of a body.
    ShapeHandle
}

handle! {
    /// Names a joint between two bodies.
    JointHandle
}

/// Names a convex hull among the assets. Assets are never removed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
pub struct HullHandle(pub u32);

/// Names a triangle mesh among the assets. Assets are never removed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
pub struct MeshHandle(pub u32);

/// Names a height field among the assets. Assets are never removed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
pub struct HeightFieldHandle(pub u32);

/// Names a compound among the assets. Assets are never removed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
pub struct CompoundHandle(pub u32);
