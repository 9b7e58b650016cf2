//! What is wrong with models, and that its place is told.

use super::error;

/// A model with `world` in `<worldbody>` on its third line and `sections` on its fifth.
fn text(world: &str, sections: &str) -> String {
    format!("<mujoco>\n<worldbody>\n{world}\n</worldbody>\n{sections}\n</mujoco>")
}

#[track_caller]
fn check(text: &str, place: &str, said: &str) {
    let message = error(text);
    assert!(message.starts_with(&format!("line {place}: ")), "{message}");
    assert!(message.contains(said), "{message}");
    assert!(
        message.contains("expected") || place.starts_with("1, column 1") || message.contains("XML"),
        "{message}"
    );
}

#[track_caller]
fn world(world: &str, column: usize, said: &str) {
    check(&text(world, ""), &format!("3, column {column}"), said);
}

#[track_caller]
fn sections(sections: &str, column: usize, said: &str) {
    let bodies =
        r#"<body name="a"><joint name="j"/><geom size="1"/><site name="s"/></body><body name="b"><freejoint
        name="f"/><geom size="1"/></body>"#
            .replace('\n', " ");
    check(&text(&bodies, sections), &format!("5, column {column}"), said);
}

#[test]
fn numbers() {
    world(r#"<geom size="1" pos="1 2"/>"#, 16, "worldbody/geom/pos: found 2 numbers, expected 3");
    world(r#"<geom size="1" pos="1 2 3 4"/>"#, 16, "too many numbers, expected 3");
    world(r#"<geom size="1 2 x"/>"#, 7, r#"found "x", expected numbers"#);
    world(r#"<geom size="nan"/>"#, 7, r#"found "nan", expected numbers within 1e18"#);
    world(r#"<geom size="1e30"/>"#, 7, "expected numbers within 1e18");
    world(r#"<geom size="-1"/>"#, 7, "found -1, expected sizes greater than 0");
    world(r#"<geom/>"#, 1, "0 numbers for a sphere, expected 1");
    world(r#"<geom type="box" size="1 2"/>"#, 18, "2 numbers for a box, expected 3");
    world(r#"<geom type="bx" size="1 2"/>"#, 7, r#"found "bx", expected one of sphere, plane"#);
    world(r#"<geom size="1" contype="1.5"/>"#, 16, "expected a whole number");
    world(r#"<geom size="1" condim="2"/>"#, 16, "expected 1, 3, 4 or 6");
    world(r#"<geom size="1" friction="-1"/>"#, 16, "expected none below 0");
    world(r#"<geom size="1" mass="-1"/>"#, 16, "expected a number that is not negative");
    world(r#"<geom size="1" fromto="0 0 0 0 0 1"/>"#, 16, "on a sphere, expected it on a capsule");
    world(r#"<geom type="capsule" size="1" fromto="0 0 0 0 0 0"/>"#, 31, "two ends at one place");
    world(r#"<geom type="capsule" size="1" fromto="0 0 0 0 0 1" pos="0 0 1"/>"#, 31, "expected one of them");
    world(r#"<geom size="1" class="c"/>"#, 16, r#"no default class is named "c""#);
    world(r#"<geom type="mesh" mesh="m"/>"#, 19, r#"no mesh of <asset> is named "m""#);
}

#[test]
fn bodies_and_joints() {
    world(r#"<body quat="1 0 0 0" euler="1 2 3"/>"#, 22, "found quat and euler, expected one of them");
    world(r#"<body quat="0 0 0 0"/>"#, 7, "nearly zero");
    world(r#"<body><joint/></body>"#, 1, "has no mass or no inertia");
    world(r#"<body><joint axis="0 0 0"/><geom size="1"/></body>"#, 14, "expected a direction");
    world(r#"<body><joint range="2 1"/><geom size="1"/></body>"#, 14, "a first number below the second");
    world(r#"<body><joint limited="true"/><geom size="1"/></body>"#, 7, "a first number below the second");
    world(r#"<body><joint type="ball" range="-1 1"/><geom size="1"/></body>"#, 26, "expected 0 as the first");
    world(r#"<body><body><freejoint/><geom size="1"/></body></body>"#, 13, "a free joint within a body");
    world(r#"<body><joint/><freejoint/><geom size="1"/></body>"#, 15, "beside another joint");
    world(
        r#"<body><joint type="ball"/><joint type="ball"/><joint/><geom size="1"/></body>"#,
        47,
        "more than 6 degrees",
    );
    world(
        r#"<body><freejoint/><geom size="1"/><geom type="plane" size="1 1 1"/></body>"#,
        41,
        "a plane on a body that moves",
    );
    world(r#"<joint/>"#, 1, "a `joint` outside of a body");
    world(
        r#"<body><geom size="1"/><replicate count="2"><joint/></replicate></body>"#,
        44,
        "outside of a body",
    );
    world(r#"<body name="x"/><body name="x"/>"#, 23, r#"the name "x" is used twice"#);
    world(r#"<body mocap="true"><joint/></body>"#, 7, "a mocap body");
    world(
        r#"<body><inertial mass="1" pos="0 0 0"/></body>"#,
        7,
        "expected one of `diaginertia` and `fullinertia`",
    );
    world(r#"<body><inertial diaginertia="1 1 1" pos="0 0 0"/></body>"#, 7, "no `mass`");
    world(
        r#"<body><freejoint/><inertial mass="1" pos="0 0 0" diaginertia="1 2 9"/></body>"#,
        1,
        "balanceinertia",
    );
    world(r#"<replicate/>"#, 1, "no `count`");
    world(r#"<replicate count="-1"/>"#, 12, "expected 0 or more");
    world(r#"<attach model="m" prefix="x"/>"#, 9, r#"no <model> of <asset> is named "m""#);
    world(r#"<attach prefix="x"/>"#, 1, "neither `model` nor `body` nor `frame`");
    world(r#"<attach body="q" prefix="x"/>"#, 9, r#"no body of the model is named "q""#);
}

#[test]
fn links() {
    sections(r#"<contact><exclude body1="a" body2="q"/></contact>"#, 29, r#"nothing is named "q""#);
    sections(r#"<contact><exclude body1="a"/></contact>"#, 10, "no `body2`");
    sections(r#"<equality><connect body1="a"/></equality>"#, 11, "no `anchor`");
    sections(r#"<equality><weld site1="s"/></equality>"#, 11, "no `site2`");
    sections(
        r#"<tendon><spatial range="0 1"><site site="s"/><site site="q"/></spatial></tendon>"#,
        52,
        "nothing is named",
    );
    sections(
        r#"<tendon><spatial range="1 0"><site site="s"/><site site="s"/></spatial></tendon>"#,
        18,
        "below the second",
    );
    sections(r#"<actuator><motor joint="q"/></actuator>"#, 18, r#"nothing is named "q""#);
    sections(r#"<actuator><motor joint="j" ctrlrange="1"/></actuator>"#, 28, "found 1 numbers, expected 2");
    sections(r#"<default class="a"/>"#, 10, "on an outermost default");
    sections(r#"<default><default/></default>"#, 10, "no `class`");
    sections(r#"<default><default class="a"/><default class="a"/></default>"#, 39, "is there already");
    sections(r#"<compiler angle="grad"/>"#, 11, r#"found "grad", expected one of radian, degree"#);
    sections(r#"<compiler eulerseq="abc"/>"#, 11, "expected three letters");
    sections(r#"<compiler coordinate="global"/>"#, 11, r#"expected "local""#);
    sections(r#"<option timestep="0"/>"#, 9, "expected a time greater than 0");
    sections(r#"<asset><mesh name="m"/><mesh name="m"/></asset>"#, 30, "used twice");
    sections(r#"<asset><mesh vertex="1 2 3"/></asset>"#, 8, "a mesh without a name");
    sections(r#"<include file="other.xml"/>"#, 10, "this model came from memory");
    sections(r#"<asset><model name="m" file="other.xml"/></asset>"#, 24, "this model came from memory");
}

#[test]
fn meshes() {
    let mesh = |attributes: &str| {
        let asset = format!("<asset><mesh name=\"m\" {attributes}/></asset>");
        text(r#"<geom type="mesh" mesh="m"/>"#, &asset)
    };
    check(&mesh(""), "5, column 8", "without `file` and `vertex`");
    check(&mesh(r#"vertex="0 0 0""#), "5, column 23", "found 3 numbers, expected 12 to");
    check(&mesh(r#"vertex="0 0 0 1 0 0 0 1 0 1 1 0 0""#), "5, column 23", "three for each vertex");
    check(&mesh(r#"vertex="0 0 0 1 0 0 0 1 0 1 1 0""#), "5, column 23", "the mesh has no hull");
    check(
        &mesh(r#"vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 1 7""#),
        "5, column 56",
        "found the index 7, expected 0 up to 3",
    );
    check(&mesh(r#"vertex="0 0 0 1 0 0 0 1 0 0 0 1" face="0 1 2 3""#), "5, column 56", "three for each face");
    check(&mesh(r#"file="a.stl""#), "5, column 23", r#"found "a.stl", expected an OBJ file: convert it"#);
    check(&mesh(r#"file="a.obj""#), "5, column 23", "this model came from memory");
}

#[test]
fn xml() {
    check("", "1, column 1", "no");
    check("<mujoco>\n<a></b></mujoco>", "2, column 4", "not XML: expected 'a' tag, not 'b'");
    check("<mujoco>\n<a", "2, column 3", "not XML");
    check("<mujoco a='1' a='2'/>", "1, column 15", "not XML");
    check("<robot/>", "1, column 1", "the root element is `robot`, expected `mujoco`");
    let message = super::super::Model::from_xml(b"<mujoco>\n\xff</mujoco>", &Default::default()).unwrap_err();
    assert_eq!(message.to_string(), "line 2, column 1: not UTF-8 text");
}
