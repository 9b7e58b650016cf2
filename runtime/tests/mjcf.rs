//! Models in MJCF that consist of several files: includes, attached models, meshes, and what lies out of reach.
#![cfg(feature = "scene")]

use cellstep::mjcf::{BodyKind, Effect, Form, Model};
use cellstep::scene::{Limits, SceneError};
use std::fs;
use std::path::{Path, PathBuf};

/// A folder of this test alone with these files.
fn folder(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mjcf").join(name);
    let _ = fs::remove_dir_all(&folder);
    for (file, text) in files {
        let file = folder.join(file);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, text).unwrap();
    }
    folder
}

fn read(folder: &Path) -> Result<Model, SceneError> {
    Model::read(&folder.join("main.xml"), &Limits::default())
}

/// What is said of `main.xml`, without the folder.
fn refusal(name: &str, files: &[(&str, &str)]) -> String {
    let folder = folder(name, files);
    let error = read(&folder).expect_err("it is wrong");
    error.to_string().replace(&folder.display().to_string(), "FOLDER")
}

const BODY: &str = "<body name='NAME'><freejoint/><geom class='k'/></body>";

#[test]
fn includes_are_relative_to_the_model() {
    let inner =
        format!("<mujocoinclude>{}<include file='sub/more.xml'/></mujocoinclude>", BODY.replace("NAME", "a"));
    let more = format!("<mujoco><frame pos='0 0 4'>{}</frame></mujoco>", BODY.replace("NAME", "b"));
    let folder = folder(
        "includes",
        &[
            (
                "main.xml",
                "<mujoco><include file='defaults.xml'/><worldbody><include file='./sub/../sub/inner.xml'/>\
                 <geom size='1'/></worldbody></mujoco>",
            ),
            (
                "defaults.xml",
                "<x><default><default class='k'><geom type='box' size='1 1 1' q='0'/></default></default></x>",
            ),
            ("sub/inner.xml", &inner),
            ("sub/more.xml", &more),
        ],
    );
    let model = read(&folder).unwrap_or_else(|error| panic!("{error}"));
    let names: Vec<&str> = model.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["", "a", "b"]);
    assert_eq!(model.bodies[2].placement.position, [0.0, 0.0, 4.0]);
    assert!(model.bodies[1..].iter().all(|body| body.geoms[0].form == Form::Box { half_extents: [1.0; 3] }));
    // Places are those in the files.
    assert_eq!((model.warnings[0].what.as_str(), model.warnings[0].at), ("geom/q", Some((1, 62))));
    assert!(model.warnings[0].file.as_ref().unwrap().ends_with("defaults.xml"));
}

const CHILD: &str = "<mujoco model='child'><compiler angle='radian' meshdir='m'/><option timestep='.01'/>
<asset><mesh file='p.OBJ'/></asset>
<default><geom density='500'/><default class='x'><geom size='.3'/></default></default>
<worldbody><geom name='floor' type='plane' size='1 1 1'/>
<body name='r' pos='1 0 0' childclass='x'><joint name='j' range='-1 1'/><geom/>
  <body name='i' pos='0 0 1'><joint/><geom type='mesh' mesh='p'/></body></body>
<frame name='f' pos='0 0 3'><body name='q'><freejoint/><geom size='1'/></body></frame></worldbody>
<contact><exclude body1='r' body2='i'/><exclude body1='q' body2='i'/></contact>
<actuator><motor joint='j'/></actuator></mujoco>";

/// A tetrahedron of a sixth of a cubic metre.
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

#[test]
fn models_are_attached() {
    let folder = folder(
        "attach",
        &[
            (
                "main.xml",
                "<mujoco><asset><model name='c' file='sub/child.xml'/></asset><worldbody>
                 <body name='base' pos='0 0 10'><freejoint/><geom size='.5'/>
                   <replicate count='2' offset='0 5 0' sep=':'><attach model='c' body='r' prefix='B_'/>
                   </replicate></body>
                 <attach model='c' frame='f' prefix='F_'/>
                 <frame pos='20 0 0'><attach model='c' prefix='W_'/></frame></worldbody>
                 <contact><exclude body1='base' body2='B_r'/></contact>
                 <actuator><position joint='B_j:1'/></actuator></mujoco>",
            ),
            ("sub/child.xml", CHILD),
            ("sub/m/p.OBJ", OBJ),
        ],
    );
    let model = read(&folder).unwrap_or_else(|error| panic!("{error}"));
    let names: Vec<&str> = model.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["", "base", "B_r:0", "B_i:0", "B_r:1", "B_i:1", "F_q", "W_r", "W_i", "W_q"]);
    assert_eq!(model.bodies[4].placement.position, [1.0, 5.0, 10.0]);
    assert_eq!(model.bodies[7].placement.position, [21.0, 0.0, 0.0]);
    assert_eq!(model.bodies[0].geoms[0].name, "W_floor");
    // Those of the child come along where both bodies do.
    let excluded: Vec<[usize; 2]> = model.excludes.iter().map(|exclude| exclude.bodies).collect();
    assert_eq!(excluded, [[2, 3], [4, 5], [7, 8], [9, 8], [1, 2], [1, 4]]);
    assert_eq!(model.actuators.len(), 4);
    assert_eq!(model.joints[0].parts[0].range, Some([-1.0, 1.0]), "radians of its own file");
    // One mesh for all, at the density of its own file.
    assert_eq!(model.meshes.len(), 1);
    let mass = model.bodies[3].mass.expect("it moves");
    assert!((mass.mass - 500.0 / 6.0).abs() < 1.0e-5 && (mass.center[0] - 0.25).abs() < 1.0e-7);
    assert!(
        model
            .warnings
            .iter()
            .any(|warning| warning.effect == Effect::Motion && warning.what.contains("option"))
    );
    assert_eq!(model.options.timestep, 0.002, "that of the model that was opened");
    assert_eq!(model.bodies[6].kind, BodyKind::Free);
}

#[test]
fn meshes_are_found_below_the_model() {
    let main = |compiler: &str, file: &str| {
        format!(
            "<mujoco><compiler {compiler}/><asset><mesh name='m' file='{file}'/></asset><worldbody>\
             <body><freejoint/>\
             <geom type='mesh' mesh='m' mass='1'/></body></worldbody></mujoco>"
        )
    };
    for (compiler, file) in [
        ("", "a/b/p.obj"),
        ("meshdir='a'", "b/p.obj"),
        ("assetdir='a/c'", "../b/p.obj"),
        ("meshdir='a/b' strippath='true'", "/far/away/p.obj"),
    ] {
        let folder = folder("meshes", &[("main.xml", &main(compiler, file)), ("a/b/p.obj", OBJ)]);
        let model = read(&folder).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(model.meshes[0].points.len(), 4);
        model.to_scene().unwrap().scene.build(&folder).unwrap();
    }
    for (file, said) in [
        ("q.obj", "cannot be read"),
        ("q.stl", "expected an OBJ file: convert it"),
        ("../q.obj", "lies outside of where files are read"),
        ("/q.obj", "found \"/q.obj\", expected a file below the model's folder"),
        ("c:q.obj", "expected a file below"),
        ("wrong.obj", "wrong.obj: line 2, column 1: a face"),
    ] {
        let message = refusal("no_mesh", &[("main.xml", &main("", file)), ("wrong.obj", "v 0 0 0\nf x\n")]);
        assert!(
            message.starts_with("FOLDER/main.xml: line 1, column 43: mujoco/asset/mesh[m]/file: "),
            "{message}"
        );
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn files_stay_below_the_model_and_end() {
    let include = |file: &str| format!("<mujoco>\n <include file='{file}'/></mujoco>");
    let one = |file: &str| refusal("reach", &[("main.xml", &include(file))]);
    for (file, said) in [
        ("/etc/passwd", "found \"/etc/passwd\", expected a file below the model's folder \"FOLDER\""),
        ("../x.xml", "\"../x.xml\" does not exist, and it lies outside of where files are read"),
        ("a/../../x.xml", "lies outside"),
        ("", "found \"\", expected a file below"),
        ("absent.xml", "FOLDER/absent.xml: cannot be read"),
        (".", "cannot be read"),
        ("main.xml", "\"main.xml\" is included already, expected each file once"),
    ] {
        let message = one(file);
        assert!(
            message.starts_with("FOLDER/main.xml: line 2, column 11: mujoco/include/file: "),
            "{message}"
        );
        assert!(message.contains(said), "{message}");
    }
    let message = refusal(
        "circle",
        &[("main.xml", &include("b.xml")), ("b.xml", &include("c.xml")), ("c.xml", &include("b.xml"))],
    );
    assert!(message.starts_with("FOLDER/c.xml: line 2, column 11: "), "{message}");
    assert!(message.contains("\"b.xml\" is included already"), "{message}");
    let model = |file: &str| format!("<mujoco><asset><model name='m' file='{file}'/></asset></mujoco>");
    let message = refusal("models", &[("main.xml", &model("b.xml")), ("b.xml", &model("main.xml"))]);
    assert!(message.contains("\"main.xml\" is within itself"), "{message}");
    let message = refusal("absent", &[("main.xml", &model("b.xml"))]);
    assert!(message.contains("b.xml\" does not exist, expected a model's file"), "{message}");
    // Shallow files within each other are deep together.
    let deep = |inside: &str| format!("<mujoco>{}{inside}{}</mujoco>", "<a>".repeat(150), "</a>".repeat(150));
    let files = [("main.xml", deep("<include file='b.xml'/>")), ("b.xml", deep(""))];
    let message = refusal("depth", &[(files[0].0, &files[0].1), (files[1].0, &files[1].1)]);
    assert!(message.contains("nested more than 200 deep"), "{message}");
    let message = refusal("inner", &[("main.xml", &include("b.xml")), ("b.xml", "<mujoco>\n\n<a></mujoco>")]);
    assert!(message.starts_with("FOLDER/b.xml: line 3, column "), "{message}");
}
