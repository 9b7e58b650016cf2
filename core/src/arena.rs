//! One block of 64-byte lines, carved into typed slices.
//!
//! ```text
//! | assets | state | cache | scratch |      each a run of sections, each section a slice that starts on a line
//! ```
//! Nothing in the arena is a pointer: a section is an offset and a count, computed from the capacities alone.

use bytemuck::{Pod, Zeroable};
use core::marker::PhantomData;

/// 64 bytes, aligned to 64: what a world's memory is made of.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Line(pub [u8; 64]);

impl Line {
    /// 64 zeros.
    pub const ZERO: Self = Self([0; 64]);
}

/// Bytes of a line.
pub(crate) const LINE: usize = core::mem::size_of::<Line>();

/// Where a section lies in its region.
pub(crate) struct Span<T> {
    /// Bytes from the start of the region; a multiple of a line.
    pub offset: usize,
    /// Elements.
    pub count: usize,
    kind: PhantomData<T>,
}

impl<T> Clone for Span<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for Span<T> {}

impl<T> core::fmt::Debug for Span<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}[{}]", self.offset, self.count)
    }
}

impl<T> Span<T> {
    pub const fn new(offset: usize, count: usize) -> Self {
        Self { offset, count, kind: PhantomData }
    }

    /// Bytes of an element.
    pub const fn row_bytes(&self) -> usize {
        core::mem::size_of::<T>()
    }

    /// Offset of the next section.
    pub const fn end(&self) -> usize {
        (self.offset + self.count * core::mem::size_of::<T>()).next_multiple_of(LINE)
    }
}

impl<T: Pod> Span<T> {
    /// The section in its region's bytes.
    #[inline(always)]
    pub fn of<'a>(&self, region: &'a [u8]) -> &'a [T] {
        bytemuck::cast_slice(&region[self.offset..self.offset + self.count * core::mem::size_of::<T>()])
    }

    /// The section in its region's bytes, to write.
    #[inline(always)]
    pub fn of_mut<'a>(&self, region: &'a mut [u8]) -> &'a mut [T] {
        bytemuck::cast_slice_mut(
            &mut region[self.offset..self.offset + self.count * core::mem::size_of::<T>()],
        )
    }

    /// Cuts the section off the front of `rest`, which starts at the section's offset.
    #[inline(always)]
    pub fn cut<'a>(&self, rest: &mut &'a mut [u8]) -> &'a mut [T] {
        let (section, after) = core::mem::take(rest).split_at_mut(self.end() - self.offset);
        *rest = after;
        bytemuck::cast_slice_mut(&mut section[..self.count * core::mem::size_of::<T>()])
    }
}

/// Declares a region: its spans, and a view that has a slice for each.
macro_rules! region {
    (
        $(#[$doc:meta])*
        $layout:ident, $view:ident, |$c:ident| {
            $( $(#[$field_doc:meta])* $field:ident : $type:ty = $count:expr ),* $(,)?
        }
    ) => {
        /// Spans of the region of the same name.
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $layout {
            $( pub $field: $crate::arena::Span<$type>, )*
            /// Bytes of the region: a multiple of a line.
            pub bytes: usize,
        }

        impl $layout {
            pub const fn new($c: &$crate::world::Capacities) -> Self {
                let offset = 0;
                $(
                    let $field = $crate::arena::Span::<$type>::new(offset, $count);
                    let offset = $field.end();
                )*
                Self { $($field,)* bytes: offset }
            }

            /// A slice for every section. Written where it is used: a copy of it is some kilobytes.
            #[inline(always)]
            pub fn view<'a>(&self, region: &'a mut [u8]) -> $view<'a> {
                let mut rest = region;
                $( let $field = self.$field.cut(&mut rest); )*
                $view { $($field,)* }
            }
        }

        $(#[$doc])*
        pub(crate) struct $view<'a> {
            $( $(#[$field_doc])* pub $field: &'a mut [$type], )*
        }
    };
}
pub(crate) use region;
