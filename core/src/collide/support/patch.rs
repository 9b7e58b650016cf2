//! The common part of two features, seen along the contact normal.
//!
//! ```text
//!        A's face             a feature is an outline in the plane across the normal, and a height over it
//!      .-----------.          that is linear; a contact is a corner of the common part of both outlines,
//!      |      .-.  |          its separation the difference of the heights there
//!      |     ( B ) |
//!      |      '-'  |          a disc gives four points of its rim, where its edge crosses the other
//!      '-----------'          outline, and that outline's corners within it
//! ```
//! Of a disc that leans towards the other shape the first rim point is the one that reaches farthest, so a coin
//! that rolls on its edge touches exactly there; of one that lies level they are fixed on the disc, so that a
//! standing cylinder keeps its four points.
//!
//! Features, by bits: 28..32 what meets what, 14..28 name on A, 0..14 name on B.

use super::{Feature, Spot, SupportShape, length};
use crate::collide::clip::Candidates;
use crate::collide::{HULL_VERTICES_MAX, ManifoldPoint};
use glam::{DVec2, DVec3};

/// Slope of a disc towards the other shape from which it leans. Less is what soft contacts do at rest; fixed points
/// miss the lowest one by 3e-4 of this times the radius.
const LEAN: f64 = 5.0e-4;
/// How far beyond an outline a point may lie, as a fraction of the lesser size: equal stacked faces are not to be
/// cut by noise.
const SLACK: f64 = 2.5e-4;
/// Sine up to which two lines run along each other: 3 degrees.
const ALONG: f64 = 0.05;
/// A name on one shape of a point that is named by the other.
const INSIDE: u32 = 0x3fff;
/// Names from here on are edges, by the corner where they start.
const EDGE: u32 = 64;
/// Added to an edge's name where the other outline is left rather than entered.
const LEAVES: u32 = 128;
/// Names of a disc's edge where it is crossed.
const CROSSED: u32 = 16;
/// Most corners of a polygon while it is cut.
const CORNERS_MAX: usize = 2 * HULL_VERTICES_MAX;

/// What meets what.
#[derive(Clone, Copy)]
enum Kind {
    Lines = 1,
    LineFace = 2,
    LineDisc = 3,
    Faces = 4,
    FaceDisc = 5,
    Discs = 6,
}

/// A corner of an outline; its edge goes to the next one.
#[derive(Clone, Copy, Debug)]
struct Seen {
    q: DVec2,
    name: u32,
}

/// A feature as it is seen.
#[expect(clippy::large_enum_variant, reason = "a local: there is no heap to put it on")]
enum Outline {
    Point,
    Line([Seen; 2]),
    /// Counter-clockwise.
    Face(heapless::Vec<Seen, HULL_VERTICES_MAX>),
    Disc {
        center: DVec2,
        radius: f64,
    },
}

/// A feature's height over a point `q`: `base + slope . q`.
#[derive(Clone, Copy, Debug)]
struct Height {
    base: f64,
    slope: DVec2,
}

impl Height {
    fn at(&self, q: DVec2) -> f64 {
        self.base + self.slope.dot(q)
    }
}

/// Two shapes seen along a normal.
pub(super) struct View {
    origin: DVec3,
    /// Two axes across the normal, and the normal.
    u: DVec3,
    v: DVec3,
    n: DVec3,
    features: [Feature; 2],
    outlines: [Outline; 2],
    heights: [Height; 2],
    radii: [f64; 2],
    slack: f64,
}

impl View {
    /// Shapes A and B along the unit normal `n` from A to B, about `origin`.
    pub fn new(n: DVec3, origin: DVec3, (a, b): (&SupportShape<'_>, &SupportShape<'_>)) -> Self {
        let side =
            if n.x * n.x < 1.0 / 3.0 { DVec3::new(0.0, n.z, -n.y) } else { DVec3::new(n.y, -n.x, 0.0) };
        let u = side / length(side);
        let (sa, sb) = (a.size(), b.size());
        let mut view = Self {
            origin,
            u,
            v: n.cross(u),
            n,
            features: [a.feature(n), b.feature(-n)],
            outlines: [Outline::Point, Outline::Point],
            heights: [Height { base: 0.0, slope: DVec2::ZERO }; 2],
            radii: [a.radius, b.radius],
            slack: SLACK * if sa < sb { sa } else { sb },
        };
        for side in 0..2 {
            let (outline, height) = view.seen(&view.features[side], side == 1);
            (view.outlines[side], view.heights[side]) = (outline, height);
        }
        view
    }

    fn q(&self, at: DVec3) -> DVec2 {
        let d = at - self.origin;
        DVec2::new(d.dot(self.u), d.dot(self.v))
    }

    fn seen(&self, feature: &Feature, turned: bool) -> (Outline, Height) {
        let see = |spot: &Spot| Seen { q: self.q(spot.at), name: spot.name };
        let height = |at: DVec3| (at - self.origin).dot(self.n);
        let plane = |at: DVec3, normal: DVec3| {
            let slope = DVec2::new(normal.dot(self.u), normal.dot(self.v)) / -normal.dot(self.n);
            Height { base: height(at) - slope.dot(self.q(at)), slope }
        };
        match feature {
            Feature::Point => (Outline::Point, Height { base: 0.0, slope: DVec2::ZERO }),
            Feature::Segment(ends) => {
                let [p, q] = [see(&ends[0]), see(&ends[1])];
                let along = q.q - p.q;
                let span = along.dot(along);
                if span <= 0.0 {
                    return (Outline::Point, Height { base: 0.0, slope: DVec2::ZERO });
                }
                let slope = along * ((height(ends[1].at) - height(ends[0].at)) / span);
                (Outline::Line([p, q]), Height { base: height(ends[0].at) - slope.dot(p.q), slope })
            }
            Feature::Face(corners, normal) => {
                let outline = if turned {
                    corners.iter().rev().map(see).collect()
                } else {
                    corners.iter().map(see).collect()
                };
                (Outline::Face(outline), plane(corners[0].at, *normal))
            }
            Feature::Disc { center, axes, radius } => {
                (Outline::Disc { center: self.q(*center), radius: *radius }, plane(*center, axes[2]))
            }
        }
    }

    /// True when a point is seen over A's face.
    pub fn is_over_a(&self, at: DVec3) -> bool {
        match &self.outlines[0] {
            Outline::Face(face) => holds(face, self.q(at), self.slack),
            _ => false,
        }
    }

    /// The four rim points of the disc of a side, as they are seen.
    fn rim(&self, side: usize) -> [Seen; 4] {
        let Feature::Disc { center, axes, radius } = &self.features[side] else {
            return [Seen { q: DVec2::ZERO, name: 0 }; 4];
        };
        let rise = self.heights[1].slope - self.heights[0].slope;
        let fall = self.u * -rise.x + self.v * -rise.y;
        rim_points(*center, axes, *radius, fall).map(|spot| Seen { q: self.q(spot.at), name: spot.name })
    }
}

/// Four points of the rim of a disc of these axes, of which the last is its outward normal. `fall` is the direction
/// in which the disc comes nearer to the other shape, as long as the slope by which it does.
pub(super) fn rim_points(center: DVec3, axes: &[DVec3; 3], radius: f64, fall: DVec3) -> [Spot; 4] {
    let [x, y, normal] = *axes;
    let along = fall - normal * normal.dot(fall);
    let (directions, first) = if along.dot(along) <= LEAN * LEAN {
        ([x, y, -x, -y], 0)
    } else {
        let low = along / length(along);
        let side = normal.cross(low);
        ([low, side, -side, -low], 4)
    };
    core::array::from_fn(|i| Spot { at: center + directions[i] * radius, name: first + i as u32 })
}

/// Where contacts are put.
struct Out<'a> {
    view: &'a View,
    kind: Kind,
    distance: f64,
    points: &'a mut Candidates,
}

impl Out<'_> {
    /// The contact over `q`, unless it is too far apart.
    fn push(&mut self, q: DVec2, (on_a, on_b): (u32, u32)) {
        let view = self.view;
        let (low, high) = (view.heights[0].at(q) + view.radii[0], view.heights[1].at(q) - view.radii[1]);
        let separation = high - low;
        if separation <= self.distance {
            let at = view.origin + view.u * q.x + view.v * q.y + view.n * (0.5 * (low + high));
            let feature = (self.kind as u32) << 28 | on_a << 14 | on_b;
            let point = ManifoldPoint { position: at.as_vec3(), separation: separation as f32, feature };
            let _ = self.points.push(point);
        }
    }

    /// The same, for a pair of which B comes first when `turned`.
    fn push_turned(&mut self, q: DVec2, (first, second): (u32, u32), turned: bool) {
        self.push(q, if turned { (second, first) } else { (first, second) });
    }
}

/// Adds the contacts of the common part of both features; none when there is no more to it than a point.
pub(super) fn push(view: &View, distance: f64, points: &mut Candidates) {
    let (kind, turned) = match (&view.outlines[0], &view.outlines[1]) {
        (Outline::Point, _) | (_, Outline::Point) => return,
        (Outline::Line(_), Outline::Line(_)) => (Kind::Lines, false),
        (Outline::Line(_), Outline::Face(_)) => (Kind::LineFace, false),
        (Outline::Face(_), Outline::Line(_)) => (Kind::LineFace, true),
        (Outline::Line(_), Outline::Disc { .. }) => (Kind::LineDisc, false),
        (Outline::Disc { .. }, Outline::Line(_)) => (Kind::LineDisc, true),
        (Outline::Face(_), Outline::Face(_)) => (Kind::Faces, false),
        (Outline::Face(_), Outline::Disc { .. }) => (Kind::FaceDisc, false),
        (Outline::Disc { .. }, Outline::Face(_)) => (Kind::FaceDisc, true),
        (Outline::Disc { .. }, Outline::Disc { .. }) => (Kind::Discs, false),
    };
    let mut out = Out { view, kind, distance, points };
    let first = usize::from(turned);
    match (&view.outlines[first], &view.outlines[1 - first]) {
        (Outline::Line(a), Outline::Line(b)) => lines(a, b, &mut out),
        (Outline::Line(line), Outline::Face(face)) => line_face(line, face, turned, &mut out),
        (Outline::Line(line), Outline::Disc { center, radius }) => {
            line_disc(line, (*center, *radius), turned, &mut out);
        }
        (Outline::Face(a), Outline::Face(b)) => faces(a, b, &mut out),
        (Outline::Face(face), Outline::Disc { center, radius }) => {
            face_disc(face, (*center, *radius), turned, &mut out);
        }
        _ => discs(&mut out),
    }
}

/// The ends of the part where two lines run along each other.
fn lines(a: &[Seen; 2], b: &[Seen; 2], out: &mut Out<'_>) {
    let (da, db) = (a[1].q - a[0].q, b[1].q - b[0].q);
    let (span, sine) = (da.dot(da), da.perp_dot(db));
    if sine * sine > ALONG * ALONG * span * db.dot(db) {
        return;
    }
    let place = |q: DVec2| (q - a[0].q).dot(da) / span;
    let (p, q) = (place(b[0].q), place(b[1].q));
    let (from, to) = if p <= q { ((p, b[0].name), (q, b[1].name)) } else { ((q, b[1].name), (p, b[0].name)) };
    let low = if from.0 > 0.0 { (from.0, (0, from.1)) } else { (0.0, (a[0].name, 0)) };
    let high = if to.0 < 1.0 { (to.0, (0, to.1)) } else { (1.0, (a[1].name, 0)) };
    if low.0 < high.0 {
        out.push(a[0].q + da * low.0, low.1);
        out.push(a[0].q + da * high.0, high.1);
    }
}

/// The ends of the part of a line over a face.
fn line_face(line: &[Seen; 2], face: &[Seen], turned: bool, out: &mut Out<'_>) {
    let along = line[1].q - line[0].q;
    let mut low = (0.0, (line[0].name, INSIDE));
    let mut high = (1.0, (line[1].name, INSIDE));
    for (tail, head) in edges(face) {
        let (p, q) =
            (outside(tail, head, line[0].q, out.view.slack), outside(tail, head, line[1].q, out.view.slack));
        if p > 0.0 && q > 0.0 {
            return;
        }
        let t = p / (p - q);
        if p > 0.0 && t > low.0 {
            low = (t, (EDGE, EDGE + tail.name));
        } else if q > 0.0 && t < high.0 {
            high = (t, (EDGE + 1, EDGE + tail.name));
        }
    }
    if low.0 <= high.0 {
        out.push_turned(line[0].q + along * low.0, low.1, turned);
        out.push_turned(line[0].q + along * high.0, high.1, turned);
    }
}

/// The ends of the part of a line over a disc.
fn line_disc(line: &[Seen; 2], (center, radius): (DVec2, f64), turned: bool, out: &mut Out<'_>) {
    let along = line[1].q - line[0].q;
    let Some((enter, leave)) = crossings(line[0].q, along, center, radius + out.view.slack) else { return };
    let low = if enter > 0.0 { (enter, (EDGE, CROSSED)) } else { (0.0, (line[0].name, INSIDE)) };
    let high = if leave < 1.0 { (leave, (EDGE + 1, CROSSED + 1)) } else { (1.0, (line[1].name, INSIDE)) };
    if low.0 <= high.0 {
        out.push_turned(line[0].q + along * low.0, low.1, turned);
        out.push_turned(line[0].q + along * high.0, high.1, turned);
    }
}

/// A corner of a polygon while it is cut, with the labels of the edges that meet in it: of B's, the corner where
/// the edge starts; of A's, that and [`EDGE`].
#[derive(Clone, Copy)]
struct Cut {
    q: DVec2,
    incoming: u32,
    outgoing: u32,
}

type Polygon = heapless::Vec<Cut, CORNERS_MAX>;

/// The corners of the common part of two faces (Sutherland and Hodgman 1974).
fn faces(a: &[Seen], b: &[Seen], out: &mut Out<'_>) {
    let (mut from, mut to) = (Polygon::new(), Polygon::new());
    for (tail, head) in edges(b) {
        let _ = from.push(Cut { q: head.q, incoming: tail.name, outgoing: head.name });
    }
    for (tail, head) in edges(a) {
        to.clear();
        let height = |corner: &Cut| outside(tail, head, corner.q, out.view.slack);
        for (i, here) in from.iter().enumerate() {
            let before = &from[if i == 0 { from.len() - 1 } else { i - 1 }];
            let (p, q) = (height(before), height(here));
            if (p <= 0.0) != (q <= 0.0) {
                let at = before.q + (here.q - before.q) * (p / (p - q));
                let (edge, side) = (before.outgoing, EDGE + tail.name);
                let (incoming, outgoing) = if p <= 0.0 { (edge, side) } else { (side, edge) };
                // Rounding can bend a polygon of many corners so that it crosses a side twice: never overflow.
                let _ = to.push(Cut { q: at, incoming, outgoing });
            }
            if q <= 0.0 {
                let _ = to.push(*here);
            }
        }
        core::mem::swap(&mut from, &mut to);
    }
    for corner in &from {
        let names = match (corner.incoming < EDGE, corner.outgoing < EDGE) {
            (true, true) => (INSIDE, corner.outgoing),
            (true, false) => (corner.outgoing, EDGE + corner.incoming),
            (false, true) => (corner.incoming, LEAVES + corner.outgoing),
            (false, false) => (corner.outgoing - EDGE, INSIDE),
        };
        out.push(corner.q, names);
    }
}

/// Rim points over a face, corners of the face over the disc, and where its sides cross the rim.
fn face_disc(face: &[Seen], (center, radius): (DVec2, f64), turned: bool, out: &mut Out<'_>) {
    let slack = out.view.slack;
    for rim in out.view.rim(if turned { 0 } else { 1 }) {
        if holds(face, rim.q, slack) {
            out.push_turned(rim.q, (INSIDE, rim.name), turned);
        }
    }
    for (tail, head) in edges(face) {
        let from_center = tail.q - center;
        if from_center.dot(from_center) <= radius * radius {
            out.push_turned(tail.q, (tail.name, INSIDE), turned);
        }
        let Some((enter, leave)) = crossings(tail.q, head.q - tail.q, center, radius) else { continue };
        for (t, more) in [(enter, 0), (leave, LEAVES)] {
            if t > 0.0 && t < 1.0 {
                let q = tail.q + (head.q - tail.q) * t;
                out.push_turned(q, (EDGE + tail.name + more, CROSSED), turned);
            }
        }
    }
}

/// Rim points of each disc over the other, and where the rims cross.
fn discs(out: &mut Out<'_>) {
    let view = out.view;
    let (Outline::Disc { center: ca, radius: ra }, Outline::Disc { center: cb, radius: rb }) =
        (&view.outlines[0], &view.outlines[1])
    else {
        return;
    };
    let within = |q: DVec2, center: DVec2, radius: f64| {
        let (d, reach) = (q - center, radius + view.slack);
        d.dot(d) <= reach * reach
    };
    for rim in view.rim(0).iter().filter(|rim| within(rim.q, *cb, *rb)) {
        out.push(rim.q, (rim.name, INSIDE));
    }
    for rim in view.rim(1).iter().filter(|rim| within(rim.q, *ca, *ra)) {
        out.push(rim.q, (INSIDE, rim.name));
    }
    let d = *cb - *ca;
    let square = d.dot(d);
    // The line through both crossings is this far along d, from A's center.
    let along = 0.5 * (1.0 + (ra * ra - rb * rb) / square);
    let half = ra * ra / square - along * along;
    // Also false for discs of one center, where nothing crosses.
    if half > 0.0 && half.is_finite() {
        let across = d.perp() * libm::sqrt(half);
        out.push(*ca + d * along + across, (CROSSED, CROSSED));
        out.push(*ca + d * along - across, (CROSSED + 1, CROSSED + 1));
    }
}

fn edges(face: &[Seen]) -> impl Iterator<Item = (Seen, Seen)> + '_ {
    (0..face.len()).map(|i| (face[i], face[if i + 1 == face.len() { 0 } else { i + 1 }]))
}

/// How far a point lies outside of an edge of a counter-clockwise outline, less the slack, in units of the edge.
fn outside(tail: Seen, head: Seen, q: DVec2, slack: f64) -> f64 {
    let along = head.q - tail.q;
    (q - tail.q).perp_dot(along) - slack * libm::sqrt(along.dot(along))
}

fn holds(face: &[Seen], q: DVec2, slack: f64) -> bool {
    edges(face).all(|(tail, head)| outside(tail, head, q, slack) <= 0.0)
}

/// Where a line enters and leaves a circle, in units of `along`.
fn crossings(from: DVec2, along: DVec2, center: DVec2, radius: f64) -> Option<(f64, f64)> {
    let to_center = center - from;
    let span = along.dot(along);
    let middle = to_center.dot(along) / span;
    let miss = to_center.perp_dot(along);
    let half = radius * radius / span - miss * miss / (span * span);
    if half > 0.0 && half.is_finite() {
        let half = libm::sqrt(half);
        Some((middle - half, middle + half))
    } else {
        None
    }
}
