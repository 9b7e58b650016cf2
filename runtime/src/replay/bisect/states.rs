//! Two states side by side: the first number that differs.

use crate::Memory;
use cellstep_core::{BodyHandle, Field, FieldKind, World};
use std::fmt;

/// Sections of a state with their names.
pub(super) type Sections = Vec<(&'static str, Vec<u8>)>;

/// Sections that say most to people, in the order in which they are looked at; the others come after, in the order
/// of the state, and its header last.
const FIRST: [&str; 9] = [
    "motions",
    "bodies",
    "shapes",
    "joints",
    "joint_axes",
    "contacts",
    "asleep_contacts",
    "pairs",
    "asleep_pairs",
];

/// A number that two states do not share.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldDifference {
    /// The section of the state, as in [`World::checksum_by_section`](cellstep_core::World::checksum_by_section).
    pub section: &'static str,
    /// The row in the section: of bodies and what is theirs, the slot.
    pub row: usize,
    /// The field of the row.
    pub field: &'static str,
    /// Which number of the field, from 0.
    pub component: usize,
    /// How its bits are read.
    pub kind: FieldKind,
    /// The bits in both states; `None` where the state does not have the row.
    pub bits: [Option<u64>; 2],
    /// The bodies that the row is about.
    pub bodies: [Option<BodyHandle>; 2],
    /// How many bodies differ, in motion or properties.
    pub bodies_that_differ: usize,
    /// Where the first byte that differs lies in its section.
    byte: usize,
}

impl FieldDifference {
    /// A value as a decimal number: of a float the shortest that is read as the same bits.
    pub fn decimal(&self, bits: u64) -> String {
        match self.kind {
            FieldKind::F32 => format!("{:?}", f32::from_bits(bits as u32)),
            FieldKind::I32 => (bits as u32 as i32).to_string(),
            _ => bits.to_string(),
        }
    }

    /// Where the first byte that differs lies in its section.
    pub(super) fn byte(&self) -> usize {
        self.byte
    }

    /// A value as hexadecimal bits.
    pub fn hex(&self, bits: u64) -> String {
        format!("0x{bits:0width$x}", width = 2 * self.kind.size())
    }

    /// Section, row, field and number, as in `motions[3].linear[0]`.
    pub fn place(&self) -> String {
        format!("{}[{}].{}[{}]", self.section, self.row, self.field, self.component)
    }
}

impl fmt::Display for FieldDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (body, name) in self.bodies.iter().flatten().zip(["body", ", body"]) {
            write!(f, "{name} {} (generation {})", body.index, body.generation)?;
        }
        let gap = if self.bodies[0].is_some() { ": " } else { "" };
        write!(f, "{gap}{}", self.place())?;
        for (bits, and) in self.bits.into_iter().zip([" is ", " and "]) {
            match bits {
                Some(bits) => write!(f, "{and}{} ({})", self.hex(bits), self.decimal(bits))?,
                None => write!(f, "{and}absent")?,
            }
        }
        write!(f, "; bodies that differ: {}", self.bodies_that_differ)
    }
}

/// The sections of a snapshot that the world would take; none of another.
pub(super) fn sections_of(world: &World<Memory>, snapshot: &[u8]) -> Sections {
    match world.snapshot_sections(snapshot) {
        Ok(sections) => sections.map(|section| (section.name, snapshot[section.range].to_vec())).collect(),
        Err(_) => Vec::new(),
    }
}

/// Bytes of a row of each section.
pub(super) fn row_bytes(world: &World<Memory>, section: &str) -> usize {
    let mut snapshot = Vec::new();
    super::super::play::save(world, &mut snapshot);
    let sections = world.snapshot_sections(&snapshot);
    let found = sections.ok().and_then(|mut all| all.find(|other| other.name == section));
    found.map_or(1, |section| section.row_bytes)
}

/// The first number that differs; the world tells whose it is.
pub(super) fn first_difference(world: &World<Memory>, a: &Sections, b: &Sections) -> Option<FieldDifference> {
    let bytes = |of: &Sections, name: &str| {
        of.iter().find(|(other, _)| *other == name).map(|(_, bytes)| bytes.clone()).unwrap_or_default()
    };
    let rest = a.iter().map(|(name, _)| *name).filter(|name| !FIRST.contains(name) && *name != "header");
    for name in FIRST.into_iter().chain(rest).chain(["header"]) {
        let (x, y) = (bytes(a, name), bytes(b, name));
        if x == y {
            continue;
        }
        let size = row_bytes(world, name);
        let at = x.iter().zip(&y).position(|(x, y)| x != y).unwrap_or(x.len().min(y.len()));
        let (row, byte) = (at / size, at % size);
        let field = Field::at(name, byte)?;
        let component = (byte - field.offset) / field.kind.size();
        let start = row * size + field.offset + component * field.kind.size();
        let value = |bytes: &[u8]| {
            let own = bytes.get(start..start + field.kind.size())?;
            let mut eight = [0; 8];
            eight[..own.len()].copy_from_slice(own);
            Some(u64::from_le_bytes(eight))
        };
        return Some(FieldDifference {
            section: name,
            row,
            field: field.name,
            component,
            kind: field.kind,
            bits: [value(&x), value(&y)],
            bodies: world.bodies_of_row(name, row),
            bodies_that_differ: bodies_that_differ(world, [a, b]),
            byte: at,
        });
    }
    None
}

/// Slots of bodies whose motion or properties differ.
fn bodies_that_differ(world: &World<Memory>, states: [&Sections; 2]) -> usize {
    let mut differ = Vec::new();
    for name in ["motions", "bodies"] {
        let size = row_bytes(world, name);
        let [x, y] = states.map(|state| state.iter().find(|(other, _)| *other == name));
        let (Some((_, x)), Some((_, y))) = (x, y) else { continue };
        let count = x.len().max(y.len()) / size;
        differ.resize(differ.len().max(count), false);
        for (slot, differs) in differ.iter_mut().enumerate() {
            let range = slot * size..(slot + 1) * size;
            *differs |= x.get(range.clone()) != y.get(range);
        }
    }
    differ.into_iter().filter(|differs| *differs).count()
}
