//! Registering compounds.

use super::World;
use super::assets::{bytes, run_mut};
use super::checksum::hash;
use crate::arena::Line;
use crate::collide::bounds::aabb;
use crate::collide::cast::support::inner_radius;
use crate::collide::compound::{CHILDREN_MAX, Child, Compound, CompoundError, convex_solid};
use crate::collide::tree;
use crate::error::Error;
use crate::handle::CompoundHandle;
use crate::math::{Pose, min};
use crate::shape::Geometry;
use crate::state::CompoundRow;
use crate::validate;

/// A convex part of a compound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompoundChild {
    /// A sphere, capsule, box, hull, cylinder, cone or rounded hull.
    pub geometry: Geometry,
    /// Where it stands in the compound's frame; position at most 1e5 m from the origin.
    pub pose: Pose,
}

impl<M: AsRef<[Line]> + AsMut<[Line]>> World<M> {
    /// Registers a compound of at most 4096 convex children; they may overlap. The mass of a body with it is that
    /// of all children: where they overlap it counts twice.
    ///
    /// # Errors
    /// [`Error::AssetsSealed`] after the first step, [`Error::Full`], or [`Error::Compound`] naming the child.
    pub fn add_compound(&mut self, children: &[CompoundChild]) -> Result<CompoundHandle, Error> {
        self.check_unsealed()?;
        let hulls = self.layout.assets.header.of(self.bytes())[0].hulls;
        check(children, hulls).map_err(Error::Compound)?;
        let scratch_layout = self.layout.scratch;
        let (assets, scratch) = self.assets_mut();
        let scratch = scratch_layout.view(scratch);
        let header = &assets.header[0];
        let index = header.compounds;
        if index as usize >= assets.compounds.len() {
            return Err(Error::Full { name: "compounds" });
        }
        if children.len() > assets.children.len() - header.children as usize {
            return Err(Error::Full { name: "compound_children" });
        }
        let row = CompoundRow {
            first_child: header.children,
            children: children.len() as u32,
            first_node: header.child_nodes,
            nodes: tree::node_count(children.len()) as u32,
        };
        let mut inner = f32::MAX;
        let own = run_mut(assets.children, row.first_child, row.children);
        for (i, (slot, child)) in own.iter_mut().zip(children).enumerate() {
            let (kind, size) = child.geometry.to_row();
            let pose = Pose::new(child.pose.position, child.pose.rotation.normalized());
            *slot = Child { kind, size, pose };
            let solid = convex_solid(kind, size, assets.hulls);
            scratch.child_boxes[i] = aabb(&solid, &pose);
            inner = min(inner_radius(&solid), inner);
        }
        tree::build(
            scratch.child_boxes,
            0..row.children,
            scratch.child_words,
            run_mut(assets.child_order, row.first_child, row.children),
            run_mut(assets.child_nodes, row.first_node, row.nodes),
        );
        assets.compounds[index as usize] = row;
        assets.compound_radii[index as usize] = inner;
        let seed = hash(bytemuck::bytes_of(&row), assets.header[0].hash ^ 4);
        let header = &mut assets.header[0];
        header.compounds += 1;
        header.children += row.children;
        header.child_nodes += row.nodes;
        header.hash = hash(bytes(run_mut(assets.children, row.first_child, row.children)), seed);
        Ok(CompoundHandle(index))
    }

    /// The tables of a registered compound.
    ///
    /// # Errors
    /// [`Error::Stale`].
    pub fn compound(&self, compound: CompoundHandle) -> Result<Compound<'_>, Error> {
        let count = self.layout.assets.header.of(self.bytes())[0].compounds;
        if compound.0 < count {
            Ok(self.asset_tables().compound(compound.0))
        } else {
            Err(Error::Stale { what: "compound" })
        }
    }
}

fn check(children: &[CompoundChild], hulls: u32) -> Result<(), CompoundError> {
    if children.is_empty() {
        return Err(CompoundError::Empty);
    }
    if children.len() > CHILDREN_MAX {
        return Err(CompoundError::TooManyChildren);
    }
    for (child, def) in (0..).zip(children) {
        match def.geometry {
            Geometry::HalfSpace | Geometry::Mesh(_) | Geometry::HeightField(_) | Geometry::Compound(_) => {
                return Err(CompoundError::NotConvex { child });
            }
            Geometry::Hull(hull) | Geometry::RoundedHull { hull, .. } if hull.0 >= hulls => {
                return Err(CompoundError::NoSuchHull { child });
            }
            _ => {}
        }
        if def.geometry.check().is_err() || validate::pose("pose", &def.pose).is_err() {
            return Err(CompoundError::OutOfRange { child });
        }
    }
    Ok(())
}
