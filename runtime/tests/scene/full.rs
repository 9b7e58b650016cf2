//! A document in which everything is said.

use cellstep::scene::Scene;
use cellstep::scene::format::*;

/// A body with every field set.
fn full_body(turn: RotationDoc) -> BodyDoc {
    let shape = |geometry| ShapeDoc {
        geometry,
        material: Some("wood".to_string()),
        position: [-0.0, 1.0e-38, 0.1],
        rotation: RotationDoc::EulerDegrees([1.0, 2.0, 3.0]),
        filter: FilterDoc { category: 2, mask: 3, group: -4 },
        sensor: true,
        user: u64::MAX,
    };
    BodyDoc {
        name: Some("plate".to_string()),
        kind: KindDoc::Kinematic,
        position: [1.0e7 + 0.1, -2.0f64.powi(-1074), 0.1 + 0.2],
        rotation: turn,
        linear_velocity: [f32::MIN_POSITIVE, 0.3, 16_777_217.0 / 1e3],
        angular_velocity: [0.1, -0.2, 1.0 / 3.0],
        linear_damping: 0.7,
        angular_damping: 1.0e-45,
        gravity_scale: -2.5,
        locks: vec![LockDoc::MoveZ, LockDoc::TurnX],
        mass: Some(MassDoc { mass: 3.0, center: [0.0, -0.0, 0.1], inertia: [1.0, 1.1, 1.2], axes: turn }),
        can_sleep: false,
        bullet: true,
        user: u64::MAX - 1,
        shapes: vec![
            shape(GeometryDoc::Sphere { radius: 0.1 }),
            shape(GeometryDoc::Capsule { half_height: 0.0, radius: 0.1 }),
            shape(GeometryDoc::Box { half_extents: [0.1, 0.2, 0.3] }),
            shape(GeometryDoc::Hull("a.b[0]\"\\ä".to_string())),
            shape(GeometryDoc::HalfSpace),
            shape(GeometryDoc::Mesh("plate".to_string())),
            shape(GeometryDoc::Cylinder { half_height: 0.1, radius: 0.2 }),
            shape(GeometryDoc::Cone { half_height: 0.1, radius: 0.2 }),
            shape(GeometryDoc::RoundedHull { hull: "a.b[0]\"\\ä".to_string(), radius: 0.1 }),
            shape(GeometryDoc::HeightField("plate".to_string())),
            shape(GeometryDoc::Compound("plate".to_string())),
        ],
    }
}

/// A mesh, a height field and a child of a compound with every field set.
fn full_assets(points: &[[f32; 3]], turn: RotationDoc) -> (MeshDoc, HeightFieldDoc, ChildDoc) {
    let inline = MeshDoc::Inline {
        vertices: points.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        surfaces: vec!["wood".to_string()],
        triangle_surfaces: vec![0, 0],
    };
    let field = HeightFieldDoc {
        columns: 3,
        rows: 2,
        spacing: [0.5, 1.0 / 3.0],
        heights: vec![0.0, 0.1, -0.0, 0.3, 0.4, 0.5],
        holes: vec![[1, 0]],
        surfaces: vec!["wood".to_string()],
        cell_surfaces: vec![0, 0],
    };
    let child = ChildDoc {
        geometry: GeometryDoc::Cone { half_height: 0.1, radius: 0.2 },
        position: [0.1, -0.0, 0.3],
        rotation: turn,
    };
    (inline, field, child)
}

fn full_settings() -> SettingsDoc {
    SettingsDoc {
        preset: Some(PresetDoc::Fast),
        dt: Some(0.01),
        substeps: Some(3),
        sweeps: Some(2),
        relax_sweeps: Some(0),
        inner_sweeps: Some(3),
        direct_joints: Some(false),
        contact_model: Some(ContactModelDoc::Rigid),
        friction_model: Some(FrictionModelDoc::Points),
        manifold_drift: Some(0.002),
        contact_frequency: Some(33.3),
        contact_damping_ratio: Some(0.1),
        push_speed: Some(0.2),
        refine: Some(3),
        refine_bodies: Some(50),
        refine_sink: Some(0.001),
        restitution_threshold: Some(0.3),
        block_links: Some(32),
        sleep_time: Some(0.5),
        sleep_speed: Some(0.02),
        continuous: Some(false),
        residual: Some(true),
        tolerance: Some(1.0e-3),
        sweeps_max: Some(16),
    }
}

/// A document with every field set to something other than its default.
pub fn full() -> Scene {
    let turn = RotationDoc::AxisAngle { axis: [0.0, 1.0, 0.5], degrees: -33.3 };
    let body = full_body(turn);
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let obj = MeshDoc::Obj { path: "a/b.obj".to_string(), scale: 0.01, rotation: turn };
    let (inline, field, child) = full_assets(&points, turn);
    Scene {
        version: 1,
        description: "all\nof it".to_string(),
        gravity: [0.1, 0.2, 0.3],
        settings: full_settings(),
        capacities: CapacitiesDoc {
            bodies: Some(9),
            shapes: Some(99),
            pairs: Some(0),
            contacts: Some(1),
            joints: Some(20),
            materials: Some(3),
            pair_rules: Some(2),
            sensor_visits: Some(2),
            events: Some(3),
        },
        materials: [(
            "wood".to_string(),
            MaterialDoc {
                friction: 0.1,
                restitution: 0.2,
                density: 0.3,
                friction_mix: MixDoc::Max,
                restitution_mix: MixDoc::Min,
                rolling: 0.01,
                spinning: 0.02,
                surface_velocity: [1.0, 0.0, -2.0],
                one_way: Some([0.0, 0.0, 1.0]),
            },
        )]
        .into(),
        hulls: [("a.b[0]\"\\ä".to_string(), HullDoc { points })].into(),
        meshes: [("plate".to_string(), inline), ("file".to_string(), obj)].into(),
        height_fields: [("plate".to_string(), field)].into(),
        compounds: [("plate".to_string(), CompoundDoc { children: vec![child] })].into(),
        bodies: vec![
            body,
            BodyDoc {
                mass: None,
                shapes: vec![ShapeDoc::new(GeometryDoc::HalfSpace)],
                kind: KindDoc::Static,
                ..BodyDoc::default()
            },
        ],
        joints: crate::joints::full_joints(turn),
    }
}
