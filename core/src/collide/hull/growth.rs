//! A hull of triangles that grows by one point at a time.
//!
//! It starts as a tetrahedron. Each facet knows the input point that is farthest above its plane; the highest of
//! these points joins the hull next: the facets it sees are taken away and the rim of the hole (the horizon) is
//! joined to it by new facets (Barber, Dobkin and Huhdanpaa 1996, without their outside sets: a facet's farthest
//! point never changes, so the input is read once for each facet and nothing is stored for each point).
//!
//! Coordinates are f64 made from f32, so differences are exact and planes are good to about 1e-15 of the extent,
//! far below the tolerance.

use super::HullError;
use crate::collide::vector64::{Vector, cross, difference, dot, length, to_f64};
use crate::math::Vec3;

/// Working vertices: some more than a hull may have, for those that turn out to lie within a face or an edge.
pub(super) const VERTICES: usize = 80;
/// Facets of a triangulated hull with that many vertices: 2 V - 4.
pub(super) const FACETS: usize = 2 * VERTICES - 4;
const NONE: u8 = u8::MAX;

/// A triangle of the growing hull.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    /// Vertices, counter-clockwise seen from outside.
    pub corners: [u8; 3],
    /// Outward unit normal.
    pub normal: Vector,
    /// Height of the highest input point above the plane.
    height: f64,
}

impl Facet {
    /// The directed edges.
    pub fn edges(&self) -> [(u8, u8); 3] {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
    }
}

/// The growing hull.
pub(super) struct Growth<'a> {
    points: &'a [Vec3],
    pub vertices: heapless::Vec<Vector, VERTICES>,
    /// Slots; an empty one is filled again.
    pub facets: [Option<Facet>; FACETS],
    /// The facet left of each directed edge.
    pub owner: [[u8; VERTICES]; VERTICES],
    /// Points that lie no higher than this above a plane count as inside.
    tolerance: f64,
}

impl<'a> Growth<'a> {
    /// Grows the hull of `points` until none lies more than `tolerance` outside.
    pub fn of(points: &'a [Vec3], corners: [Vector; 4], tolerance: f64) -> Result<Self, HullError> {
        let mut hull = Self {
            points,
            vertices: heapless::Vec::new(),
            facets: [None; FACETS],
            owner: [[NONE; VERTICES]; VERTICES],
            tolerance,
        };
        hull.start(corners);
        while let Some((slot, facet)) = hull.highest() {
            let point = hull.outermost(&facet);
            if hull.vertices.is_full() {
                return Err(HullError::TooManyVertices);
            }
            hull.insert(slot, point)?;
        }
        Ok(hull)
    }

    fn start(&mut self, mut corners: [Vector; 4]) {
        let [a, b, c, d] = corners;
        if dot(cross(difference(b, a), difference(c, a)), difference(d, a)) > 0.0 {
            corners.swap(0, 1);
        }
        self.vertices.extend(corners);
        for corners in [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]] {
            self.add_facet(corners);
        }
    }

    /// The facet with the highest point above it, if that is outside.
    fn highest(&self) -> Option<(usize, Facet)> {
        let mut best: Option<(usize, Facet)> = None;
        for (slot, facet) in self.facets.iter().enumerate() {
            if let Some(facet) = facet
                && facet.height > best.map_or(self.tolerance, |(_, best)| best.height)
            {
                best = Some((slot, *facet));
            }
        }
        best
    }

    /// Among the points that are highest above the facet, but for rounding, the one farthest from its middle.
    /// Where a whole face of the hull is highest, that is one of the face's corners.
    fn outermost(&self, facet: &Facet) -> Vector {
        let base = self.corner(facet, 0);
        let (b, c) = (self.corner(facet, 1), self.corner(facet, 2));
        let middle = [0, 1, 2].map(|i| (base[i] + b[i] + c[i]) / 3.0);
        let (mut best, mut best_distance) = (base, -1.0);
        for &point in self.points {
            let point = to_f64(point);
            let height = dot(facet.normal, difference(point, base));
            if height >= facet.height - 0.5 * self.tolerance {
                let d = difference(point, middle);
                if dot(d, d) > best_distance {
                    (best, best_distance) = (point, dot(d, d));
                }
            }
        }
        best
    }

    /// Joins a point above facet `seed` to the hull.
    fn insert(&mut self, seed: usize, point: Vector) -> Result<(), HullError> {
        // A facet that contains the point, but for rounding, may be kept or replaced. Keeping is tried first; in
        // rare cases the hole has no simple rim then.
        let rounding = 0.01 * self.tolerance;
        for above in [rounding, 0.0, -rounding] {
            let visible = self.visible(seed, point, above);
            if let Some((start, next)) = self.horizon(&visible)
                && self.is_proper(start, &next, point)
            {
                self.replace(&visible, start, &next, point);
                return Ok(());
            }
        }
        Err(HullError::Irregular)
    }

    /// The connected facets around `seed` whose planes lie more than `above` below the point.
    fn visible(&self, seed: usize, point: Vector, above: f64) -> [bool; FACETS] {
        let mut visible = [false; FACETS];
        let mut stack = heapless::Vec::<usize, FACETS>::new();
        visible[seed] = true;
        // A facet is pushed once, so the stack cannot overflow.
        let _ = stack.push(seed);
        while let Some(slot) = stack.pop() {
            for (tail, head) in self.facets[slot].iter().flat_map(Facet::edges) {
                let across = usize::from(self.owner[usize::from(head)][usize::from(tail)]);
                if let Some(Some(facet)) = self.facets.get(across)
                    && !visible[across]
                    && dot(facet.normal, difference(point, self.corner(facet, 0))) > above
                {
                    visible[across] = true;
                    let _ = stack.push(across);
                }
            }
        }
        visible
    }

    /// The rim of the visible facets as one loop: a vertex on it, and the vertex after each. None when it is not
    /// one simple loop.
    fn horizon(&self, visible: &[bool; FACETS]) -> Option<(u8, [u8; VERTICES])> {
        let mut next = [NONE; VERTICES];
        let (mut start, mut count) = (NONE, 0);
        for (facet, _) in self.facets.iter().zip(visible).filter(|&(_, &visible)| visible) {
            for (tail, head) in facet.iter().flat_map(Facet::edges) {
                let across = self.owner[usize::from(head)][usize::from(tail)];
                if visible[usize::from(across)] {
                    continue;
                }
                if next[usize::from(tail)] != NONE {
                    return None;
                }
                next[usize::from(tail)] = head;
                start = tail;
                count += 1;
            }
        }
        (count >= 3 && loop_length(start, &next) == count).then_some((start, next))
    }

    /// True when every new facet has an area.
    fn is_proper(&self, start: u8, next: &[u8; VERTICES], point: Vector) -> bool {
        let mut tail = start;
        loop {
            let head = next[usize::from(tail)];
            let (a, b) = (self.vertices[usize::from(tail)], self.vertices[usize::from(head)]);
            let (edge, side) = (difference(b, a), difference(point, a));
            // The height of the triangle over its edge must be far above rounding.
            if length(cross(edge, side)) <= 1.0e-4 * self.tolerance * length(edge) {
                return false;
            }
            tail = head;
            if tail == start {
                return true;
            }
        }
    }

    /// Takes the visible facets away and joins their rim to the point.
    fn replace(&mut self, visible: &[bool; FACETS], start: u8, next: &[u8; VERTICES], point: Vector) {
        for (slot, _) in visible.iter().enumerate().filter(|&(_, &visible)| visible) {
            for (tail, head) in self.facets[slot].iter().flat_map(Facet::edges) {
                self.owner[usize::from(tail)][usize::from(head)] = NONE;
            }
            self.facets[slot] = None;
        }
        let apex = self.vertices.len() as u8;
        // `of` has seen to it that there is room.
        let _ = self.vertices.push(point);
        let mut tail = start;
        loop {
            let head = next[usize::from(tail)];
            self.add_facet([tail, head, apex]);
            tail = head;
            if tail == start {
                return;
            }
        }
    }

    fn add_facet(&mut self, corners: [u8; 3]) {
        let [a, b, c] = corners.map(|corner| self.vertices[usize::from(corner)]);
        let cross = cross(difference(b, a), difference(c, a));
        let size = length(cross);
        let normal = cross.map(|x| x / size);
        let mut height = 0.0;
        for &point in self.points {
            let above = dot(normal, difference(to_f64(point), a));
            height = if above > height { above } else { height };
        }
        let facet = Facet { corners, normal, height };
        // By Euler's formula there is a free slot: visible facets were taken away before.
        let slot = self.facets.iter().position(Option::is_none).expect("2 V - 4 facets at most");
        self.facets[slot] = Some(facet);
        for (tail, head) in facet.edges() {
            self.owner[usize::from(tail)][usize::from(head)] = slot as u8;
        }
    }

    /// A corner of a facet.
    pub fn corner(&self, facet: &Facet, i: usize) -> Vector {
        self.vertices[usize::from(facet.corners[i])]
    }
}

/// Number of steps after which a walk comes back to its start; at most one for each vertex.
pub(super) fn loop_length(start: u8, next: &[u8; VERTICES]) -> usize {
    let mut at = start;
    for steps in 1..=VERTICES {
        at = next[usize::from(at)];
        if at == start {
            return steps;
        }
        if at == NONE {
            break;
        }
    }
    usize::MAX
}
