//! Models that were made to break readers: each is refused, or read within bounds, on a thread with little stack.

use super::{error, read, try_read};
use crate::mjcf::Model;
use crate::scene::{Limits, Problem};

/// What the limits of a small server are.
const SMALL: Limits = Limits {
    file_bytes: 1 << 20,
    bodies: 100,
    shapes: 200,
    contacts: 1000,
    joints: 200,
    memory_bytes: 1 << 24,
};

#[test]
fn nesting() {
    let deep = format!("<mujoco><worldbody>{}", "<body>".repeat(1_000_000));
    assert!(error(&deep).contains("elements nested 201 deep, expected at most 200"));
    // The deepest that is allowed, on the smallest stack that threads commonly have.
    let inside = "<body><joint/><geom size='1'/>".repeat(195);
    let text = format!("<mujoco><worldbody>{inside}{}</worldbody></mujoco>", "</body>".repeat(195));
    let frames = "<frame pos='0 0 1'>".repeat(195);
    let framed =
        format!("<mujoco><worldbody>{frames}<geom size='1'/>{}</worldbody></mujoco>", "</frame>".repeat(195));
    let thread = std::thread::Builder::new().stack_size(1 << 20);
    let both =
        thread.spawn(move || (read(&text).bodies.len(), read(&framed).bodies[0].geoms[0].placement.position));
    assert_eq!(both.expect("a thread").join().expect("no overflow"), (196, [0.0, 0.0, 195.0]));
}

#[test]
fn entities() {
    let laughs = "<!DOCTYPE m [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;\">]><mujoco>&b;</mujoco>";
    assert!(error(laughs).contains("a document type or entities, expected none"));
    assert!(error("<mujoco>&unknown;</mujoco>").contains("not XML"));
    let file = "<!DOCTYPE m [<!ENTITY a SYSTEM \"file:///etc/passwd\">]><mujoco>&a;</mujoco>";
    assert!(error(file).contains("document type"));
}

#[test]
fn copies() {
    let world = |inside: &str| format!("<mujoco><worldbody>{inside}</worldbody></mujoco>");
    let nested = |count: &str, levels: usize, inside: &str| {
        let open = format!("<replicate count='{count}'>");
        world(&(open.repeat(levels) + inside + &"</replicate>".repeat(levels)))
    };
    assert!(error(&nested("2000000000", 1, "")).contains("copies are too many"));
    assert!(error(&nested("99999999999999999999", 1, "")).contains("expected a whole number"));
    assert!(error(&nested("2", 9, "")).contains("at most 8 replicates"));
    for text in [nested("1000", 3, ""), nested("1000", 3, "<body/>"), nested("1000", 2, "<geom size='1'/>")] {
        let error = Model::from_xml(text.as_bytes(), &SMALL).unwrap_err();
        assert!(matches!(error.problem, Problem::TooLarge { .. }), "{error}");
    }
    // Each body attaches itself once more.
    let endless = world("<body name='a'><attach body='a' prefix='x'/><attach body='a' prefix='y'/></body>");
    assert!(error(&endless).contains("deep"));
}

#[test]
fn references() {
    let sites = "<replicate count='3000'><site name='NAME'/></replicate>";
    let text = format!(
        "<mujoco><worldbody>{}{}</worldbody><tendon><spatial range='0 1'><site site='a'/><site site='b'/></spatial>\
         </tendon></mujoco>",
        sites.replace("NAME", "a"),
        sites.replace("NAME", "b")
    );
    assert!(error(&text).contains("references to copies are too many"));
}

#[test]
fn sizes() {
    let many: String = (0..100).map(|i| format!("a{i}='' ")).collect();
    assert!(error(&format!("<mujoco {many}/>")).contains("100 attributes of one element"));
    let name = "a".repeat(1000);
    assert!(
        error(&format!("<mujoco><worldbody><body name='{name}'/></worldbody></mujoco>"))
            .contains("1000 bytes")
    );
    let long = " ".repeat(2 << 20);
    let error = Model::from_xml(format!("<mujoco>{long}</mujoco>").as_bytes(), &SMALL).unwrap_err();
    assert!(matches!(error.problem, Problem::TooLarge { what: "bytes", .. }), "{error}");
    let words: String = (0..5000).map(|i| format!("<w{i}/>")).collect();
    let told = read(&format!("<mujoco>{words}</mujoco>")).warnings;
    assert_eq!((told.len(), told[1000].what.as_str(), told[1000].count), (1001, "others", 4000));
    let nested: String = (0..100).map(|i| format!("<default class='c{i}'><geom mass='1'/>")).collect();
    let classes = format!("<mujoco><default>{nested}{}</mujoco>", "</default>".repeat(101));
    assert!(try_read(&classes).is_ok());
}

#[test]
fn changed_models_never_panic() {
    let text = include_str!("seed.xml");
    assert!(try_read(text).is_ok());
    let bytes = text.as_bytes();
    let mut seed = 3u64;
    let mut sound = 0;
    for round in 0..20_000 {
        let mut changed = bytes.to_vec();
        for _ in 0..1 + round % 3 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = (seed >> 33) as usize % changed.len();
            changed[at] = b"0123456789.e- \"<>/=abcxyz\xff"[(seed >> 20) as usize % 26];
        }
        let Ok(model) = Model::from_xml(&changed, &SMALL) else { continue };
        sound += 1;
        for body in &model.bodies {
            let numbers =
                body.placement.position.into_iter().chain(body.mass.map_or([1.0; 3], |mass| mass.inertia));
            assert!(numbers.into_iter().all(f64::is_finite), "{}", String::from_utf8_lossy(&changed));
        }
        if let Ok(conversion) = model.to_scene() {
            // The engine may refuse, but it does not panic.
            let _ = conversion.scene.build_within(std::path::Path::new(""), &SMALL);
        }
    }
    assert!(sound > 1000, "{sound}");
}
