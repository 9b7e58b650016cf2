//! Joins coplanar triangles of a hull into polygons.
//!
//! A face starts as the largest triangle left and takes in neighbours whose corners lie within the tolerance of
//! its plane, always staying a disk. Vertices that only two faces share lie within an edge and are taken out.

use super::growth::{FACETS, Facet, Growth, VERTICES, loop_length};
use crate::collide::vector64::{cross, difference, dot, length};

const NONE: u8 = u8::MAX;

/// The corners of a face, counter-clockwise.
pub(super) type Loop = heapless::Vec<u8, VERTICES>;

/// The faces of a hull as loops of its vertices; none when a face is no simple polygon.
pub(super) fn faces(hull: &Growth<'_>, tolerance: f64) -> Option<heapless::Vec<Loop, FACETS>> {
    let (face_of, count) = assign(hull, tolerance);
    let mut faces = heapless::Vec::new();
    for face in 0..count {
        faces.push(rim(hull, &face_of, face)?).ok()?;
    }
    drop_vertices_of_two_faces(&mut faces);
    Some(faces)
}

/// The face of each facet slot (`NONE` for an empty one), and the number of faces.
fn assign(hull: &Growth<'_>, tolerance: f64) -> ([u8; FACETS], u8) {
    let mut face_of = [NONE; FACETS];
    let mut count = 0;
    for slot in slots_by_area(hull) {
        if face_of[usize::from(slot)] == NONE {
            grow_face(hull, &mut face_of, (slot, count), tolerance);
            count += 1;
        }
    }
    (face_of, count)
}

/// Slots of facets, the largest first, the lower slot first among equals.
fn slots_by_area(hull: &Growth<'_>) -> heapless::Vec<u8, FACETS> {
    let mut keyed = heapless::Vec::<(f64, u8), FACETS>::new();
    for (slot, facet) in hull.facets.iter().enumerate() {
        if let Some(facet) = facet {
            let [a, b, c] = [0, 1, 2].map(|i| hull.corner(facet, i));
            let _ = keyed.push((length(cross(difference(b, a), difference(c, a))), slot as u8));
        }
    }
    keyed.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    keyed.iter().map(|&(_, slot)| slot).collect()
}

/// Grows face `id` from the facet `seed` until no neighbour fits.
fn grow_face(hull: &Growth<'_>, face_of: &mut [u8; FACETS], (seed, id): (u8, u8), tolerance: f64) {
    let Some(base) = &hull.facets[usize::from(seed)] else { return };
    let origin = hull.corner(base, 0);
    let coplanar = |facet: &Facet| {
        let close = |i| dot(base.normal, difference(hull.corner(facet, i), origin)).abs() <= tolerance;
        dot(facet.normal, base.normal) > 0.0 && close(0) && close(1) && close(2)
    };
    face_of[usize::from(seed)] = id;
    let mut members = mask(base);
    let mut grown = true;
    while grown {
        grown = false;
        for (slot, facet) in hull.facets.iter().enumerate() {
            if let Some(facet) = facet
                && face_of[slot] == NONE
                && keeps_disk(hull, face_of, (facet, id), members)
                && coplanar(facet)
            {
                face_of[slot] = id;
                members |= mask(facet);
                grown = true;
            }
        }
    }
}

/// True when face `id` together with the facet is a disk again: they share one edge and the third corner is new
/// to the face, or they share two edges.
fn keeps_disk(hull: &Growth<'_>, face_of: &[u8; FACETS], (facet, id): (&Facet, u8), members: u128) -> bool {
    let is_shared = |&(tail, head): &(u8, u8)| {
        let across = hull.owner[usize::from(head)][usize::from(tail)];
        face_of[usize::from(across)] == id
    };
    let shared = facet.edges().iter().filter(|edge| is_shared(edge)).count();
    let known = (mask(facet) & members).count_ones();
    (shared == 1 && known == 2) || shared == 2
}

fn mask(facet: &Facet) -> u128 {
    facet.corners.iter().fold(0, |mask, &corner| mask | 1 << corner)
}

/// The border of a face; none when it is not one simple loop.
fn rim(hull: &Growth<'_>, face_of: &[u8; FACETS], face: u8) -> Option<Loop> {
    let mut next = [NONE; VERTICES];
    let (mut start, mut count) = (NONE, 0);
    for facet in
        hull.facets.iter().zip(face_of).filter(|&(_, &of)| of == face).filter_map(|(f, _)| f.as_ref())
    {
        for (tail, head) in facet.edges() {
            let across = hull.owner[usize::from(head)][usize::from(tail)];
            if face_of[usize::from(across)] != face {
                next[usize::from(tail)] = head;
                start = tail;
                count += 1;
            }
        }
    }
    if start == NONE || loop_length(start, &next) != count {
        return None;
    }
    let mut corners = Loop::new();
    let mut at = start;
    for _ in 0..count {
        corners.push(at).ok()?;
        at = next[usize::from(at)];
    }
    Some(corners)
}

/// Takes out vertices that fewer than three faces share, until there are none, and faces that are left with fewer
/// than three corners: their two neighbours then share the edge.
fn drop_vertices_of_two_faces(faces: &mut heapless::Vec<Loop, FACETS>) {
    loop {
        let mut degree = [0; VERTICES];
        for &corner in faces.iter().flatten() {
            degree[usize::from(corner)] += 1;
        }
        let before: usize = faces.iter().map(|face| face.len()).sum();
        for face in faces.iter_mut() {
            face.retain(|&corner| degree[usize::from(corner)] >= 3);
        }
        faces.retain(|face| face.len() >= 3);
        if before == faces.iter().map(|face| face.len()).sum() {
            return;
        }
    }
}
