//! Prints the lines that are compared with another machine's.
//!
//! `cross [STEPS]` prints all of them; `cross trace SCENE [STEPS]` prints the checksum of every section of a
//! scene's state after every step, to find where two machines part.

use cellstep_core::Line;
use cellstep_cross::{line, lines, run_watched, scenes};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] => print_all(scenes::STEPS),
        ["trace", scene] => trace(scene, scenes::STEPS),
        ["trace", scene, steps] => trace(scene, steps.parse().expect("STEPS is a number")),
        [steps] => print_all(steps.parse().expect("STEPS is a number")),
        _ => panic!("usage: cross [STEPS] | cross trace SCENE [STEPS]"),
    }
}

fn print_all(steps: u32) {
    for line in (0..).map_while(|index| line(index, steps)) {
        println!("{line}");
    }
}

fn trace(name: &str, steps: u32) {
    let scene = scenes::ALL.iter().find(|scene| scene.name == name).expect("SCENE is the name of one");
    run_watched(&mut vec![Line::ZERO; lines(scene)], scene, steps, |step, world| {
        for (section, sum) in world.checksum_by_section() {
            println!("{step} {section} {sum:016x}");
        }
    });
}
