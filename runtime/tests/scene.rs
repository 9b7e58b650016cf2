//! Scene documents: what is read comes back, what is wrong is told where, what is too much is refused.
#![cfg(feature = "scene")]

use cellstep::Serial;
#[path = "scene/full.rs"]
mod full;
#[path = "scene/joints.rs"]
mod joints;

use full::full;

use cellstep::scene::builtin::BUILTIN;
use cellstep::scene::format::*;
use cellstep::scene::{Build, Limits, Scene, SceneError, load};
use std::fs;
use std::path::{Path, PathBuf};

fn read(text: &str) -> Result<Scene, SceneError> {
    Scene::from_json(text.as_bytes(), &Limits::default())
}

/// The message of a document that must be refused.
fn refusal(text: &str) -> String {
    read(text).err().unwrap_or_else(|| panic!("accepted: {text}")).to_string()
}

/// A folder of this test alone, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn a_full_document_comes_back() {
    let scene = full();
    let text = scene.to_json();
    let back = read(&text).unwrap();
    assert_eq!(scene, back);
    // Equality of floats does not see the sign of zero: the text does.
    assert_eq!(text, back.to_json());
    assert!(text.contains("-0.0"));
}

#[test]
fn an_empty_document_is_the_default() {
    assert_eq!(read("{}").unwrap(), Scene::default());
    assert_eq!(read("\u{feff} {}\r\n").unwrap(), Scene::default());
}

#[test]
fn the_documentation_is_true() {
    let text = include_str!("../../SCENES.md");
    let example = text.split("```json\n").nth(1).unwrap().split("```").next().unwrap();
    let scene = read(example).unwrap();
    assert_eq!((scene.bodies.len(), scene.joints.len()), (6, 1));
    scene.build(Path::new("")).unwrap();
    // Every field that exists is described.
    let json = full().to_json();
    let fields = json
        .split('"')
        .skip(1)
        .step_by(2)
        .filter(|word| word.chars().all(|c| c.is_ascii_lowercase() || c == '_'));
    for field in fields.filter(|field| !["wood", "plate", "file", ""].contains(field)) {
        assert!(text.contains(&format!("`{field}`")) || text.contains(&format!("\"{field}\"")), "{field}");
    }
}

/// Documents, where the mistake of each is, its path, and a word of what was expected.
const MISTAKES: &[(&str, &str, &str, &str)] = &[
    ("", "line 1, column 1", "", "EOF"),
    ("{\n  \"bodies\": [\n}", "line 3, column 1", "bodies[0]", "expected value"),
    ("{} x", "line 1, column 4", "", "trailing"),
    ("[1]", "line 1, column 1", "", "sequence, expected a scene object"),
    ("{\"bodies\": [[\"static\"]]}", "line 1, column 13", "bodies[0]", "sequence, expected a body object"),
    (
        "{\"bodies\": [{\"shapes\": [{\"geometry\": {\"sphere\": [1]}}]}]}",
        "line 1, column 49",
        "bodies[0].shapes[0].geometry.sphere",
        "sequence, expected a geometry, as",
    ),
    ("{\n\"joint\": []}", "line 2, column 10", "joint", "expected one of `version`"),
    ("{\"version\": 2}", "line 1, column 13", "version: found 2", "expected 1"),
    ("{\"gravity\": [0, 0]}", "line 1, column 13", "gravity", "array of length 3"),
    ("{\"gravity\": [0, \"a\", 0]}", "line 1, column 17", "gravity[1]", "expected f32"),
    ("{\"gravity\": [0, 1e999, 0]}", "line 1, column 21", "gravity[1]", "number out of range"),
    ("{\"gravity\": [0, 0, 1e39]}", "line 1, column 23", "gravity[2]", "number out of range"),
    ("{\"gravity\": [0, NaN, 0]}", "line 1, column 17", "gravity[1]", "expected value"),
    ("{\"settings\": {\"dt\": -1}}", "line 1, column 21", "settings.dt: found -1", "in 0.0..=0.25"),
    (
        "{\"settings\": {\"substeps\": 257}}",
        "line 1, column 27",
        "settings.substeps: found 257",
        "in 1..=256",
    ),
    (
        "{\"settings\": {\"contact_model\": \"hard\"}}",
        "line 1, column 32",
        "settings.contact_model",
        "expected one of `soft`, `rigid`, `split`",
    ),
    (
        "{\"settings\": {\"friction_model\": \"cone\"}}",
        "line 1, column 33",
        "settings.friction_model",
        "expected `patch` or `points`",
    ),
    (
        "{\"settings\": {\"manifold_drift\": 0.01}}",
        "line 1, column 33",
        "settings.manifold_drift: found 0.01",
        "in 0.0..=0.005",
    ),
    ("{\"materials\": {\"a\": {}, \"a\": {}}}", "line 1, column 15", "materials", "used twice"),
    (
        "{\"materials\": {\"a\": {\"friction\": -1}}}",
        "line 1, column 34",
        "materials.a.friction: found -1",
        "in 0.0..=1000000.0",
    ),
    (
        "{\"materials\": {\"a\": {\"rolling\": 2e3}}}",
        "line 1, column 33",
        "materials.a.rolling: found 2000",
        "in 0.0..=1000.0",
    ),
    (
        "{\"materials\": {\"a\": {\"friction_mix\": \"least\"}}}",
        "line 1, column 38",
        "materials.a.friction_mix",
        "expected one of `unset`",
    ),
    (
        "{\"materials\": {\"a\": {\"surface_velocity\": [0, 1e5, 0]}}}",
        "line 1, column 46",
        "materials.a.surface_velocity[1]: found 100000",
        "in -10000.0..=10000.0",
    ),
    (
        "{\"materials\": {\"a\": {\"one_way\": [0, 0, 0]}}}",
        "line 1, column 33",
        "materials.a.one_way: found [0.0, 0.0, 0.0]",
        "a direction of length 1e-5 at least",
    ),
    (
        "{\"hulls\": {\"h\": {\"points\": [[0,0,0]]}}}",
        "line 1, column 28",
        "hulls.h.points: found 1 points",
        "at least 4",
    ),
    (
        "{\"meshes\": {\"m\": {\"inline\": {\"vertices\": [[0,0,0]], \"triangles\": [[0,0,1]]}}}}",
        "line 1, column 67",
        "meshes.m.inline.triangles[0]: found index 1",
        "below 1",
    ),
    (
        "{\"meshes\": {\"m\": {\"obj\": {\"path\": \"../x.obj\"}}}}",
        "line 1, column 35",
        "meshes.m.obj.path: found \"../x.obj\"",
        "below the folder",
    ),
    (
        "{\"meshes\": {\"m\": {\"inline\": {\"vertices\": [[0,0,0],[1,0,0],[0,1,0]], \"triangles\": [[0,1,2]],\n\
         \"surfaces\": [\"ice\"], \"triangle_surfaces\": [0]}}}}",
        "line 2, column 14",
        "meshes.m.inline.surfaces[0]: no material is named \"ice\"",
        "`materials`, which has none",
    ),
    (
        "{\"height_fields\": {\"f\": {\"columns\": 2, \"rows\": 2, \"spacing\": [1, 1],\n\
         \"heights\": [0, 0, 0]}}}",
        "line 2, column 12",
        "height_fields.f.heights: found 3 heights",
        "4, columns times rows",
    ),
    (
        "{\"height_fields\": {\"f\": {\"columns\": 2, \"rows\": 2, \"spacing\": [1, 1],\n\
         \"heights\": [0, 0, 0, 0], \"holes\": [[0, 1]]}}}",
        "line 2, column 36",
        "height_fields.f.holes[0]: found [0, 1]",
        "a row below 1",
    ),
    (
        "{\"materials\": {\"a\": {}},\n\
         \"height_fields\": {\"f\": {\"columns\": 2, \"rows\": 2, \"spacing\": [1, 1],\n\
         \"heights\": [0, 0, 0, 0], \"surfaces\": [\"a\"], \"cell_surfaces\": [1]}}}",
        "line 3, column 63",
        "height_fields.f.cell_surfaces[0]: found 1",
        "below 1, the number of surfaces",
    ),
    (
        "{\"compounds\": {\"c\": {\"children\": [\n\
         {\"geometry\": {\"cone\": {\"half_height\": 0, \"radius\": 1}}}]}}}",
        "line 2, column 39",
        "compounds.c.children[0].geometry.cone.half_height: found 0",
        "expected a number in",
    ),
    (
        "{\"compounds\": {\"c\": {\"children\": [{\"geometry\": \"half_space\"}]}}}",
        "line 1, column 48",
        "compounds.c.children[0].geometry",
        "\"static\" or \"kinematic\"",
    ),
    (
        "{\"bodies\": [{\"shapes\": [{\"geometry\": {\"height_field\": \"x\"}}]}]}",
        "line 1, column 55",
        "no height field is named \"x\"",
        "`height_fields`, which has none",
    ),
    (
        "{\"bodies\": [{\"kind\": \"soft\"}]}",
        "line 1, column 22",
        "bodies[0].kind",
        "`static`, `kinematic`, `dynamic`",
    ),
    (
        "{\"bodies\": [{\"mass\": {\"mass\": 1}}]}",
        "line 1, column 22",
        "bodies[0].mass",
        "missing field `inertia`",
    ),
    (
        "{\"bodies\": [{\"mass\": {\"mass\": 1, \"inertia\": [1, 1, 9]}}]}",
        "line 1, column 45",
        "bodies[0].mass.inertia",
        "none exceeds",
    ),
    ("{\"bodies\": [{}]}", "line 1, column 13", "bodies[0].shapes", "at least one shape"),
    (
        "{\"bodies\": [{\"rotation\": {\"quaternion\": [0, 0, 0, 0]}}]}",
        "line 1, column 26",
        "bodies[0].rotation",
        "not zero",
    ),
    (
        "{\"bodies\": [{\"rotation\": {\"degrees\": 1}}]}",
        "line 1, column 26",
        "bodies[0].rotation",
        "`quaternion`, `axis_angle`, `euler_degrees`",
    ),
    ("{\"bodies\": [{\"position\": [1e11, 0, 0]}]}", "line 1, column 26", "bodies[0].position", "metres in"),
    ("{\"bodies\": [{\"user\": -1}]}", "line 1, column 22", "bodies[0].user", "expected u64"),
    ("{\"bodies\": [{\"locks\": [\"move_w\"]}]}", "line 1, column 24", "bodies[0].locks[0]", "`move_x`"),
    (
        "{\"bodies\": [\n{\"shapes\": [{\"geometry\": {\"sphere\": {\"radius\":\n -1}}}]}]}",
        "line 3, column 2",
        "bodies[0].shapes[0].geometry.sphere.radius: found -1",
        "expected a number in",
    ),
    (
        "{\"bodies\": [{\"shapes\": [{\"geometry\": {\"torus\": 1}}]}]}",
        "line 1, column 38",
        "bodies[0].shapes[0].geometry",
        "`sphere`, `capsule`",
    ),
    (
        "{\"bodies\": [{\"shapes\": [{\"geometry\": \"half_space\"}]}]}",
        "line 1, column 38",
        "bodies[0].shapes[0].geometry",
        "\"static\" or \"kinematic\"",
    ),
    (
        "{\"bodies\": [{\"shapes\": [{\"geometry\": {\"hull\": \"x\"}}]}]}",
        "line 1, column 47",
        "no hull is named \"x\"",
        "`hulls`, which has none",
    ),
    (
        "{\"materials\": {\"ice\": {}}, \"bodies\": [{\"kind\": \"static\",\n\
         \"shapes\": [{\"geometry\": \"half_space\", \"material\": \"ise\"}]}]}",
        "line 2, column 51",
        "bodies[0].shapes[0].material: no material is named \"ise\"",
        "one of ice",
    ),
];

#[test]
fn mistakes_are_told_where_they_are() {
    for (text, place, path, expected) in MISTAKES {
        let message = refusal(text);
        assert!(message.starts_with(&format!("{place}: ")), "{text}\n{message}\nshould start with {place}");
        assert!(message.contains(path), "{text}\n{message}\nshould contain {path}");
        assert!(message.contains(expected), "{text}\n{message}\nshould contain {expected}");
    }
}

#[test]
fn too_much_is_refused_before_memory_is_taken() {
    let cases = [
        (
            "{\"capacities\": {\"bodies\": 1000000000}}",
            "1000000000 bodies are too many, expected at most 262144",
        ),
        ("{\"capacities\": {\"shapes\": 4294967295}}", "4294967295 shapes are too many"),
        ("{\"capacities\": {\"contacts\": 1000000000}}", "1000000000 contacts are too many"),
        ("{\"capacities\": {\"pairs\": 1e9}}", "expected u32"),
        ("{\"capacities\": {\"bodies\": 5000000000}}", "expected u32"),
        ("{\"bodies\": [{}], \"capacities\": {\"bodies\": 0}}", "at least 1"),
    ];
    for (text, expected) in cases {
        let message = refusal(text);
        assert!(message.contains(expected), "{text}\n{message}");
        assert!(message.starts_with("line 1, column"), "{message}");
    }
    let many = format!("{{\"bodies\": [{}{{}}]}}", "{},".repeat(BODIES_MAX));
    let message = refusal(&many);
    assert!(
        message.contains("expected a list of at most 262144 entries") && message.contains("bodies"),
        "{message}"
    );
    let shapes = "{\"geometry\":\"half_space\"},".repeat(SHAPES_PER_BODY_MAX);
    assert!(refusal(&format!("{{\"bodies\":[{{\"shapes\":[{shapes}{{}}]}}]}}")).contains("bodies[0].shapes"));
}

#[test]
fn limits_are_kept() {
    let strict =
        Limits { file_bytes: 10_000, bodies: 2, shapes: 2, contacts: 100, joints: 2, memory_bytes: 1 << 20 };
    let strictly = |text: &str| {
        Scene::from_json(text.as_bytes(), &strict).map(|scene| scene.build_within(Path::new(""), &strict))
    };
    let body = "{\"kind\":\"static\",\"shapes\":[{\"geometry\":\"half_space\"}]}";
    assert!(strictly(&format!("{{\"bodies\":[{body},{body}]}}")).is_ok_and(|world| world.is_ok()));
    let error = |text: String| match strictly(&text) {
        Ok(Err(error)) | Err(error) => error.to_string(),
        Ok(Ok(_)) => panic!("accepted: {text}"),
    };
    assert!(
        error(format!("{{\"bodies\":[{body},{body},{body}]}}"))
            .contains("3 bodies are too many, expected at most 2")
    );
    assert!(error(" ".repeat(10_001)).contains("10001 bytes are too many"));
    assert!(error("{\"capacities\":{\"contacts\":101}}".to_string()).contains("101 contacts"));
    let tiny = Limits { memory_bytes: 64, ..strict };
    let scene = read(&format!("{{\"bodies\":[{body}]}}")).unwrap();
    let message = scene.build_within(Path::new(""), &tiny).err().unwrap().to_string();
    assert!(message.contains("bytes of memory are too many, expected at most 64"), "{message}");
}

#[test]
fn a_scene_made_by_hand_is_checked_too() {
    let mut scene = full();
    scene.bodies[0].linear_damping = f32::NAN;
    let message = scene.build(Path::new("")).err().unwrap().to_string();
    assert_eq!(message, "bodies[0].linear_damping: found NaN, expected a number in 0.0..=10000.0");
}

#[test]
fn hostile_text_never_panics() {
    for deep in ["[", "{\"bodies\":", "{\"a\":[", "[[[{\"x\":"] {
        refusal(&deep.repeat(100_000));
        refusal(&format!("{{\"bodies\": {}", deep.repeat(100_000)));
        refusal(&format!("{{\"hulls\": {{\"h\": {{\"points\": {}", deep.repeat(100_000)));
    }
    // Every cut and many a changed byte of a full document: read or refused, never more.
    let text = full().to_json().into_bytes();
    let mut seed = 7u64;
    for end in 0..text.len() {
        assert!(
            Scene::from_json(&text[..end], &Limits::default()).is_err()
                || text[end..].trim_ascii().is_empty()
        );
        let mut changed = text.clone();
        for _ in 0..4 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = (seed >> 33) as usize % changed.len();
            changed[at] = (seed >> 24) as u8;
        }
        if let Ok(scene) = Scene::from_json(&changed, &Limits::default()) {
            assert_eq!(read(&scene.to_json()).unwrap().to_json(), scene.to_json());
        }
    }
}

#[test]
fn builtin_scenes_build() {
    for builtin in BUILTIN {
        for size in [1, builtin.golden_size] {
            let scene = builtin.scene(size).unwrap();
            let built =
                scene.build(Path::new("")).unwrap_or_else(|error| panic!("{}: {error}", builtin.name));
            assert_eq!(built.bodies.len(), scene.bodies.len(), "{}", builtin.name);
            assert!(built.notes.is_empty(), "{}: {:?}", builtin.name, built.notes);
            for (handle, doc) in built.bodies.iter().zip(&scene.bodies) {
                // Built-in positions are exact; the world keeps centers of mass, and turns back to the
                // origin.
                let position = built.world.position(*handle).unwrap().to_f64();
                let close = position.iter().zip(doc.position).all(|(a, b)| (a - b).abs() < 1.0e-5);
                assert!(close, "{}: {position:?} and {:?}", builtin.name, doc.position);
            }
        }
    }
}

#[test]
fn sensors_detect_and_have_no_mass_of_their_own() {
    let text = r#"{ "capacities": { "events": 8 }, "materials": { "wood": { "density": 500 } }, "bodies": [
        { "kind": "static", "shapes": [{ "geometry": { "sphere": { "radius": 2 } }, "sensor": true }] },
        { "position": [0, 0, 1], "shapes": [
            { "geometry": { "sphere": { "radius": 0.5 } } },
            { "geometry": { "sphere": { "radius": 9 } }, "sensor": true },
            { "geometry": { "sphere": { "radius": 1 } }, "sensor": true, "material": "wood" }
        ] } ] }"#;
    let Build { mut world, bodies, .. } = read(text).unwrap().build(Path::new("")).unwrap();
    let mass = world.mass_properties(bodies[1]).unwrap().mass;
    let balls = 1000.0 * 0.125 + 500.0;
    assert!((mass / (balls * 4.0 / 3.0 * std::f32::consts::PI) - 1.0).abs() < 1.0e-5, "{mass}");
    world.step(&mut Serial);
    let zone = world.shapes_of(bodies[0]).unwrap().next().unwrap();
    let told: Vec<_> = world.visits(zone).unwrap().map(|visit| visit.visitor_body).collect();
    assert_eq!((told, world.events().count()), (vec![bodies[1]], 1));
    let refused = refusal(&text.replace("\"events\": 8", "\"sensor_visits\": 0"));
    assert!(refused.contains("capacities.sensor_visits: found 0"), "{refused}");
}

#[test]
fn far_positions_are_exact() {
    let far = [1.0e7 + 0.25, -3.0e9, 31.5];
    let body = BodyDoc { kind: KindDoc::Static, position: far, ..BodyDoc::default() };
    let scene = read(&Scene { bodies: vec![body], ..Scene::default() }.to_json()).unwrap();
    let built = scene.build(Path::new("")).unwrap();
    assert_eq!(built.world.position(built.bodies[0]).unwrap().to_f64(), far);
}

#[test]
fn meshes_come_from_files_beside_the_scene() {
    let folder = folder("meshes");
    fs::create_dir(folder.join("deep")).unwrap();
    // An L in the plane, an empty face, a repeated one, and a vertex given twice.
    let obj = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\n\
               f 1 2 3 4 5 6\nf 1 2 7\nf 1 7 2 2\no again\nf 3 2 4 4\nf 7 2 1\nf 2 3 4\nf 4 3 2\n";
    fs::write(folder.join("deep/l.obj"), obj).unwrap();
    let text = r#"{
        "meshes": { "l": { "obj": { "path": "deep/l.obj", "scale": 2 } } },
        "bodies": [{ "kind": "static", "shapes": [{ "geometry": { "mesh": "l" } }] }]
    }"#;
    fs::write(folder.join("scene.json"), text).unwrap();
    let built = load(&folder.join("scene.json"), &Limits::default()).unwrap();
    let (name, notes) = &built.notes[0];
    assert_eq!(name, "l");
    assert_eq!((notes.degenerate_faces, notes.merged_vertices), (0, 1));
    assert!(notes.empty_triangles >= 2 && notes.repeated_triangles >= 1, "{notes}");
}

#[test]
fn wrong_files_are_named() {
    let folder = folder("wrong");
    let scene = |path: &str| format!("{{\n\"meshes\": {{\"m\": {{\"obj\":\n{{\"path\": \"{path}\"}}}}}}}}");
    let file = folder.join("scene.json");
    let error = |path: &str| {
        fs::write(&file, scene(path)).unwrap();
        load(&file, &Limits { file_bytes: 100, ..Limits::default() }).err().unwrap().to_string()
    };
    fs::write(folder.join("bad.obj"), "v 0 0 0\nv 1 0 0\nv 1 one 0\nf 1 2 3\n").unwrap();
    let message = error("bad.obj");
    assert!(message.contains("bad.obj: line 3, column 1: meshes.m.obj.path: a vertex"), "{message}");
    fs::write(folder.join("index.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 4\n").unwrap();
    let message = error("index.obj");
    assert!(message.contains("index.obj: meshes.m.obj.path: a face has the index"), "{message}");
    fs::write(folder.join("nan.obj"), "v 0 0 nan\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").unwrap();
    assert!(error("nan.obj").contains("expected finite numbers"));
    fs::write(folder.join("huge.obj"), "#".repeat(101)).unwrap();
    assert!(error("huge.obj").contains("101 bytes are too many, expected at most 100"));
    fs::write(folder.join("flat.obj"), "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").unwrap();
    let message = error("flat.obj");
    assert!(
        message.contains("scene.json: line 2, column 17: meshes.m: nothing is left (1 triangles"),
        "{message}"
    );
    assert!(error("missing.obj").contains("missing.obj: meshes.m.obj.path: cannot be read"));
    fs::create_dir(folder.join("folder.obj")).unwrap();
    assert!(error("folder.obj").contains("not an ordinary file"));
    let missing = load(&folder.join("none.json"), &Limits::default()).err().unwrap().to_string();
    assert!(missing.contains("none.json: cannot be read"), "{missing}");
}
