//! Drawing a world, layer by layer.

mod joints;

use super::{Contact, World, WorldManifold};
use crate::arena::Line;
use crate::body::{BodyKind, BodyRow, Motion, Position, QUARANTINED};
use crate::collide::bounds;
use crate::debug::wireframe::Pen;
use crate::debug::{Color, DebugDraw, DebugLayers, DebugOptions, colors};
use crate::math::{Aabb, Pose, Vec3, length};
use crate::pipeline::solid;
use crate::pool;
use crate::shape::BOX_STALE;
use core::fmt::Write;

/// Characters of a label.
type Label = heapless::String<48>;

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Draws the world as it is, relative to a place: see [`DebugDraw`] and [`DebugOptions`].
    pub fn debug_draw(&self, origin: Position, options: &DebugOptions, draw: &mut impl DebugDraw) {
        let has = |layer| options.layers.has(layer);
        if has(DebugLayers::SHAPES) {
            self.draw_shapes(origin, options, draw);
        }
        if has(DebugLayers::FAT_BOXES) {
            self.draw_fat_boxes(origin, options, draw);
        }
        // What stands on bodies, and what links them.
        self.draw_bodies(origin, options, draw);
        if has(DebugLayers::JOINTS) || has(DebugLayers::JOINT_LIMITS) {
            self.draw_joints(origin, options, draw);
        }
        if has(DebugLayers::CONTACTS) || has(DebugLayers::IMPULSES) {
            self.draw_contacts(origin, options, draw);
        }
    }

    /// Visits the rows of the shapes with those of their bodies.
    fn each_shape(&self, mut visit: impl FnMut(&crate::shape::ShapeRow, &BodyRow, &Motion)) {
        let spans = &self.layout.state;
        let (shapes, bodies) = (spans.shapes.of(self.state()), spans.bodies.of(self.state()));
        let motions = spans.motions.of(self.state());
        for slot in pool::iterate(spans.shape_used.of(self.state()), self.header().shapes.high) {
            let shape = &shapes[slot as usize];
            visit(shape, &bodies[shape.body as usize], &motions[shape.body as usize]);
        }
    }

    fn draw_shapes(&self, origin: Position, options: &DebugOptions, draw: &mut impl DebugDraw) {
        let tables = self.asset_tables();
        let reach = Aabb::around(Vec3::ZERO, Vec3::splat(options.reach));
        self.each_shape(|shape, body, motion| {
            let local = motion.local_to_center(body, &shape.pose);
            let pose = Pose::new(local.position + motion.center.minus(origin), local.rotation);
            let solid = solid(shape, &tables);
            if bounds::aabb(&solid, &pose).overlaps(&reach) {
                let color = if shape.is_sensor() { colors::SENSOR } else { color_of(body) };
                let mut pen = Pen { draw: &mut *draw, color, reach: options.reach };
                pen.solid(&solid, &pose);
            }
        });
    }

    fn draw_fat_boxes(&self, origin: Position, options: &DebugOptions, draw: &mut impl DebugDraw) {
        let reach = Aabb::around(Vec3::ZERO, Vec3::splat(options.reach));
        self.each_shape(|shape, _, motion| {
            let shift = Position { offset: Vec3::ZERO, ..motion.center }.minus(origin);
            let bounds = Aabb { min: shape.fat_box.min + shift, max: shape.fat_box.max + shift };
            // The boxes of half-spaces have no end, and new ones are not made yet.
            let is_drawn =
                shape.flags & BOX_STALE == 0 && bounds.half_extents().max_element() < options.reach;
            if is_drawn && bounds.overlaps(&reach) {
                let mut pen = Pen { draw: &mut *draw, color: colors::FAT_BOX, reach: options.reach };
                pen.cuboid(&bounds);
            }
        });
    }

    fn draw_bodies(&self, origin: Position, options: &DebugOptions, draw: &mut impl DebugDraw) {
        let spans = &self.layout.state;
        let (bodies, motions) = (spans.bodies.of(self.state()), spans.motions.of(self.state()));
        for slot in pool::iterate(spans.body_used.of(self.state()), self.header().bodies.high) {
            let (body, motion) = (&bodies[slot as usize], &motions[slot as usize]);
            let center = motion.center.minus(origin);
            if length(center) > options.reach {
                continue;
            }
            let place = center + motion.origin_offset(body);
            if options.layers.has(DebugLayers::AXES) {
                let axes = motion.rotation.matrix();
                for (axis, color) in [axes.x_axis, axes.y_axis, axes.z_axis].into_iter().zip(colors::AXES) {
                    draw.line(place, place + axis * options.axis_length, color);
                }
            }
            if options.layers.has(DebugLayers::CENTERS) {
                draw.point(center, colors::CENTER);
            }
            if options.layers.has(DebugLayers::LABELS) {
                let mut label = Label::new();
                let _ = write!(label, "{slot}");
                if body.is_dynamic() {
                    let _ = write!(label, ": {} kg", body.mass);
                }
                draw.text(center, &label, color_of(body));
            }
        }
    }

    fn draw_contacts(&self, origin: Position, options: &DebugOptions, draw: &mut impl DebugDraw) {
        for contact in self.contacts() {
            self.manifolds(contact.shapes[0], contact.shapes[1], |manifold| {
                let near =
                    |point: &crate::ContactPoint| length(point.position.minus(origin)) <= options.reach;
                if manifold.child == contact.child && manifold.points.iter().all(near) {
                    draw_manifold(manifold, origin, options, draw);
                    draw_impulses(&contact, manifold, (origin, options), draw);
                }
            });
        }
    }
}

fn color_of(body: &BodyRow) -> Color {
    match body.kind() {
        _ if body.has(QUARANTINED) => colors::QUARANTINED,
        BodyKind::Static => colors::STATIC,
        BodyKind::Kinematic => colors::KINEMATIC,
        BodyKind::Dynamic => colors::DYNAMIC,
    }
}

fn draw_manifold(
    manifold: &WorldManifold,
    origin: Position,
    options: &DebugOptions,
    draw: &mut impl DebugDraw,
) {
    if !options.layers.has(DebugLayers::CONTACTS) {
        return;
    }
    for point in &manifold.points {
        let at = point.position.minus(origin);
        draw.point(at, if point.separation < 0.0 { colors::OVERLAP } else { colors::CONTACT });
        draw.line(at, at + manifold.normal * options.axis_length, colors::NORMAL);
    }
}

/// The sum of the impulses at the middle of the points: those of the last substep, on the second body.
fn draw_impulses(
    contact: &Contact,
    manifold: &WorldManifold,
    (origin, options): (Position, &DebugOptions),
    draw: &mut impl DebugDraw,
) {
    if !options.layers.has(DebugLayers::IMPULSES) {
        return;
    }
    let mut sum = Vec3::ZERO;
    for point in &manifold.points {
        sum += point.position.minus(origin);
    }
    let middle = sum / manifold.points.len() as f32;
    let impulse = contact.normal_impulse();
    draw.line(middle, middle + manifold.normal * (impulse * options.impulse_scale), colors::IMPULSE);
    draw.line(middle, middle + contact.friction * options.impulse_scale, colors::FRICTION);
    if options.layers.has(DebugLayers::LABELS) {
        let mut label = Label::new();
        let _ = write!(label, "{impulse:.3} N s");
        draw.text(middle, &label, colors::IMPULSE);
    }
}
