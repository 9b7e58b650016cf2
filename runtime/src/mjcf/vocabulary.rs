//! The words of MJCF, and what becomes of each: read, or left out with a warning. One pass over a tree.
//!
//! After the reference of MuJoCo's XML format. Sections that are left out whole are not looked into.

use super::tree::{Files, Spot, Tree};
use super::warning::{Effect, Warning, Warnings};

/// An element at a place: the tags that it may be within, and what becomes of its attributes.
struct Word {
    tag: &'static str,
    within: &'static str,
    /// Attributes that are read.
    read: &'static str,
    /// Attributes with an effect that is left out.
    motion: &'static str,
    /// Attributes of MuJoCo's solver.
    solver: &'static str,
    /// Attributes without effect on motion.
    nothing: &'static str,
}

/// Where elements with a place in space may be.
const SPACE: &str = "worldbody body frame replicate";
const NONE: Word = Word { tag: "", within: "", read: "", motion: "", solver: "", nothing: "" };

const WORDS: &[Word] = &[
    Word { tag: "mujoco", read: "model", ..NONE },
    Word {
        tag: "compiler",
        within: "mujoco",
        read: "angle autolimits coordinate eulerseq meshdir assetdir strippath inertiafromgeom inertiagrouprange \
               boundmass boundinertia balanceinertia settotalmass",
        motion: "fitaabb",
        nothing: "texturedir discardvisual usethread fusestatic saveinertial alignfree conflict",
        ..NONE
    },
    Word {
        tag: "option",
        within: "mujoco",
        read: "timestep gravity",
        motion: "wind density viscosity",
        solver: "impratio tolerance ls_tolerance noslip_tolerance ccd_tolerance sleep_tolerance o_margin o_solref \
                 o_solimp o_friction integrator cone jacobian solver iterations ls_iterations noslip_iterations \
                 ccd_iterations mpr_iterations mpr_tolerance sdf_iterations sdf_initpoints apirate collision",
        nothing: "magnetic actuatorgroupdisable",
    },
    Word {
        tag: "flag",
        within: "option",
        read: "constraint equality frictionloss limit contact spring damper passive gravity filterparent actuation",
        motion: "clampctrl override",
        solver: "warmstart refsafe midphase eulerdamp nativeccd island multiccd sleep diagexact",
        nothing: "sensor autoreset energy fwdinv invdiscrete",
    },
    Word { tag: "asset", within: "mujoco", ..NONE },
    Word {
        tag: "mesh",
        within: "asset default",
        read: "name class content_type file vertex face refpos refquat scale inertia",
        motion: "builtin params",
        // Hulls have at most 64 corners here.
        solver: "maxhullvert",
        nothing: "normal texcoord smoothnormal material",
    },
    Word { tag: "model", within: "asset", read: "name file content_type", ..NONE },
    Word { tag: "default", within: "mujoco default", read: "class", ..NONE },
    Word { tag: "worldbody", within: "mujoco", ..NONE },
    Word {
        tag: "body",
        within: SPACE,
        read: "name childclass pos quat axisangle xyaxes zaxis euler mocap gravcomp",
        nothing: "user sleep simple",
        ..NONE
    },
    Word {
        tag: "frame",
        within: SPACE,
        read: "name childclass pos quat axisangle xyaxes zaxis euler",
        ..NONE
    },
    Word { tag: "replicate", within: SPACE, read: "count offset euler sep childclass", ..NONE },
    Word { tag: "attach", within: SPACE, read: "model body frame prefix", ..NONE },
    Word {
        tag: "inertial",
        within: "body frame",
        read: "pos quat axisangle xyaxes zaxis euler mass diaginertia fullinertia",
        ..NONE
    },
    Word {
        tag: "joint",
        within: "body frame default",
        read: "name class type pos axis limited stiffness range ref springref armature damping frictionloss",
        motion: "springdamper actuatorfrclimited actuatorfrcrange actuatorgravcomp",
        solver: "solreflimit solimplimit solreffriction solimpfriction margin",
        nothing: "group user",
    },
    Word { tag: "freejoint", within: "body frame", read: "name", nothing: "group align", ..NONE },
    Word {
        tag: "geom",
        within: "worldbody body frame replicate default",
        read: "name class type contype conaffinity condim group size friction mass density fromto pos quat \
               axisangle xyaxes zaxis euler mesh",
        motion: "priority shellinertia margin gap surfacevel adhesion hfield fitscale fluidshape fluidcoef",
        // Of `solref` only the damping is read.
        solver: "solmix solref solimp",
        nothing: "material rgba user",
    },
    Word {
        tag: "site",
        within: "worldbody body frame replicate default",
        read: "name class pos quat axisangle xyaxes zaxis euler fromto",
        nothing: "type group material size rgba user",
        ..NONE
    },
    Word { tag: "contact", within: "mujoco", ..NONE },
    Word { tag: "exclude", within: "contact", read: "name body1 body2", ..NONE },
    Word { tag: "equality", within: "mujoco", ..NONE },
    Word {
        tag: "connect",
        within: "equality",
        read: "name class active body1 body2 anchor site1 site2",
        solver: "solref solimp",
        ..NONE
    },
    Word {
        tag: "weld",
        within: "equality",
        read: "name class active body1 body2 anchor relpose site1 site2",
        solver: "solref solimp torquescale",
        ..NONE
    },
    Word { tag: "equality", within: "default", solver: "solref solimp", read: "active", ..NONE },
    Word { tag: "tendon", within: "mujoco", ..NONE },
    Word {
        tag: "spatial",
        within: "tendon",
        read: "name class limited range springlength stiffness damping frictionloss",
        motion: "actuatorfrclimited actuatorfrcrange armature",
        solver: "solreflimit solimplimit solreffriction solimpfriction margin",
        nothing: "group width material rgba user",
    },
    Word {
        tag: "tendon",
        within: "default",
        read: "limited range springlength stiffness damping frictionloss",
        motion: "actuatorfrclimited actuatorfrcrange armature",
        solver: "solreflimit solimplimit solreffriction solimpfriction margin",
        nothing: "group width material rgba user",
    },
    Word { tag: "site", within: "spatial", read: "site", ..NONE },
    Word { tag: "actuator", within: "mujoco", ..NONE },
    Word { tag: "motor", within: "actuator default", read: ACTUATOR, motion: DRIVE, nothing: IDLE, ..NONE },
    Word {
        tag: "position",
        within: "actuator default",
        read: "name class ctrllimited ctrlrange forcelimited forcerange gear joint slidersite cranksite \
               cranklength kp kv",
        motion: "jointinparent tendon site refsite damping armature timeconst dampratio inheritrange delay",
        nothing: IDLE,
        ..NONE
    },
    Word {
        tag: "velocity",
        within: "actuator default",
        read: "name class ctrllimited ctrlrange forcelimited forcerange gear joint slidersite cranksite \
               cranklength kv",
        motion: DRIVE,
        nothing: IDLE,
        ..NONE
    },
];

const ACTUATOR: &str = "name class ctrllimited ctrlrange forcelimited forcerange gear joint slidersite cranksite \
                        cranklength";
const DRIVE: &str = "jointinparent tendon site refsite damping armature delay";
const IDLE: &str = "group user nsample interp lengthrange";

/// Elements that are left out with all that they hold.
const LEFT_OUT: &[(&str, &str, Effect)] = &[
    ("lengthrange", "compiler", Effect::Nothing),
    ("size", "mujoco", Effect::Nothing),
    ("statistic", "mujoco", Effect::Nothing),
    ("visual", "mujoco", Effect::Nothing),
    ("custom", "mujoco", Effect::Nothing),
    ("sensor", "mujoco", Effect::Nothing),
    // A model starts as it is written, in MuJoCo as here.
    ("keyframe", "mujoco", Effect::Nothing),
    ("extension", "mujoco", Effect::Motion),
    ("deformable", "mujoco", Effect::Motion),
    ("texture", "asset", Effect::Nothing),
    ("material", "asset default", Effect::Nothing),
    ("skin", "asset", Effect::Nothing),
    // Its geoms are told of.
    ("hfield", "asset", Effect::Nothing),
    ("plugin", "mesh geom worldbody body frame replicate actuator", Effect::Motion),
    ("camera", "worldbody body frame replicate default", Effect::Nothing),
    ("light", "worldbody body frame replicate default", Effect::Nothing),
    ("composite", SPACE, Effect::Motion),
    ("flexcomp", SPACE, Effect::Motion),
    ("pair", "contact default", Effect::Motion),
    ("joint", "equality", Effect::Motion),
    ("tendon", "equality", Effect::Motion),
    ("flex", "equality", Effect::Motion),
    ("flexvert", "equality", Effect::Motion),
    ("flexstrain", "equality", Effect::Motion),
    ("fixed", "tendon", Effect::Motion),
    ("geom", "spatial", Effect::Motion),
    ("pulley", "spatial", Effect::Motion),
    ("general", "actuator default", Effect::Motion),
    ("intvelocity", "actuator default", Effect::Motion),
    ("orientation", "actuator default", Effect::Motion),
    ("pid", "actuator default", Effect::Motion),
    ("damper", "actuator default", Effect::Motion),
    ("cylinder", "actuator default", Effect::Motion),
    ("muscle", "actuator default", Effect::Motion),
    ("adhesion", "actuator default", Effect::Motion),
    ("dcmotor", "actuator default", Effect::Motion),
];

fn has(words: &str, word: &str) -> bool {
    words.split_ascii_whitespace().any(|each| each == word)
}

/// Warns of every word that is left out.
pub(super) fn check(tree: &Tree, files: &Files, warnings: &mut Warnings) {
    let mut stack = vec![(0, "")];
    while let Some((index, within)) = stack.pop() {
        let element = &tree.elements[index];
        let tag = element.tag.as_str();
        let place = format!("{within}{}{tag}", if within.is_empty() { "" } else { "/" });
        let mut warn = |effect, what: String, spot: Spot| {
            let file = files.shown(spot.file);
            warnings.add(Warning { effect, what, count: 1, file, at: Some(spot.at) });
        };
        if let Some(&(_, _, effect)) = LEFT_OUT.iter().find(|left| left.0 == tag && has(left.1, within)) {
            warn(effect, place, element.spot);
            continue;
        }
        let fits = |word: &&Word| word.tag == tag && (has(word.within, within) || word.within == within);
        let Some(word) = WORDS.iter().find(fits) else {
            warn(Effect::Unknown, super::tree::shortened(&place), element.spot);
            continue;
        };
        let sites = tree.with_tag(index, "site").count();
        if tag == "spatial" && (sites, element.children.len()) != (2, 2) {
            warn(Effect::Motion, "tendon/spatial with other than two sites".to_string(), element.spot);
        }
        for attribute in &element.attributes {
            let name = attribute.name.as_str();
            let effect = match () {
                () if has(word.read, name) => continue,
                () if has(word.motion, name) => Effect::Motion,
                () if has(word.solver, name) => Effect::Solver,
                () if has(word.nothing, name) => Effect::Nothing,
                () => Effect::Unknown,
            };
            let what = format!("{tag}/{}", super::tree::shortened(name));
            warn(effect, what, Spot { file: element.spot.file, at: attribute.at });
        }
        // Backwards onto the stack: the first child comes off first.
        stack.extend(element.children.iter().rev().map(|&child| (child, word.tag)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_told_once() {
        for word in WORDS {
            let all: Vec<&str> = [word.read, word.motion, word.solver, word.nothing]
                .iter()
                .flat_map(|words| words.split_ascii_whitespace())
                .collect();
            for (index, name) in all.iter().enumerate() {
                assert!(!all[..index].contains(name), "{} of {}", name, word.tag);
            }
            if word.within == SPACE {
                continue;
            }
            for outer in word.within.split_ascii_whitespace() {
                assert!(
                    !LEFT_OUT.iter().any(|left| left.0 == word.tag && has(left.1, outer)),
                    "{}",
                    word.tag
                );
            }
        }
    }
}
