//! Which settings are tried, and how a scene file says one of them.

use cellstep::scene::format::SettingsDoc;
use cellstep::{ContactModel, Preset, Settings};

/// Soft contacts at numbers of substeps between and beside the presets.
const SOFT: [u32; 7] = [1, 2, 3, 4, 6, 8, 12];
/// Split contacts likewise.
const SPLIT: [u32; 7] = [2, 3, 4, 6, 8, 12, 16];
/// Relax sweeps beside one, for scenes with joints.
const RELAX: [(Preset, u32); 3] = [(Preset::Fast, 2), (Preset::Balanced, 2), (Preset::Balanced, 4)];

/// Joints visited one by one, at numbers of substeps below what the direct solve is worth.
const ITERATIVE: [u32; 3] = [1, 2, 4];

/// Settings with the name by which people are told of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The preset's name, `scene`, or what differs from a preset.
    pub name: String,
    /// Those of the scene, but for the dial.
    pub settings: Settings,
}

/// All places on the dial for a scene with these settings: its own, the presets, and steps between them; each once.
pub fn places(scene: &Settings, has_joints: bool) -> Vec<Place> {
    let mut all: Vec<Place> = Vec::new();
    let mut add = |name: String, settings: Settings| {
        if all.iter().all(|place| place.settings != settings) {
            all.push(Place { name, settings });
        }
    };
    let turned = |preset: Preset| {
        let mut settings = *scene;
        preset.apply(&mut settings);
        settings
    };
    for preset in Preset::ALL {
        add(preset.name().to_string(), turned(preset));
    }
    add("scene".to_string(), *scene);
    for (model, name, counts) in [(ContactModel::Soft, "soft", SOFT), (ContactModel::Split, "split", SPLIT)] {
        // All that belongs to a model comes from the dearest preset below `exact` that has it.
        let presets = Preset::ALL[..3].iter().rev().map(|&preset| turned(preset));
        let base = presets.into_iter().find(|settings| settings.contact_model == model);
        let base = Settings { contact_model: model, ..base.unwrap_or(turned(Preset::Balanced)) };
        for substeps in counts {
            add(format!("{name}/{substeps}"), Settings { substeps, ..base });
        }
        add(format!("{name}/4, 2 inner"), Settings { substeps: 4, inner_sweeps: 2, ..base });
    }
    for preset in Preset::ALL {
        add(format!("{}, no refine", preset.name()), Settings { refine: 1, ..turned(preset) });
    }
    add("balanced, manifolds anew".to_string(), Settings { manifold_drift: 0.0, ..turned(Preset::Balanced) });
    if has_joints {
        for (preset, relax_sweeps) in RELAX {
            add(
                format!("{}, {relax_sweeps} relax", preset.name()),
                Settings { relax_sweeps, ..turned(preset) },
            );
        }
        let loose = Settings { refine: 1, direct_joints: false, ..turned(Preset::Fast) };
        for substeps in ITERATIVE {
            add(format!("iterative joints/{substeps}"), Settings { substeps, ..loose });
        }
    }
    all
}

/// The shortest way to say where the dial of some settings stands: a preset, and what differs from it.
pub fn fragment(settings: &Settings) -> SettingsDoc {
    let fields_of = |settings: &Settings| {
        let mut doc = serde_json::to_value(SettingsDoc::dial(settings)).unwrap_or_default();
        doc.as_object_mut().map(std::mem::take).unwrap_or_default()
    };
    let own = fields_of(settings);
    let others = |preset: Preset| {
        let mut base = *settings;
        preset.apply(&mut base);
        let base = fields_of(&base);
        let mut fields = own.clone();
        fields.retain(|name, value| base.get(name) != Some(value));
        fields
    };
    let away = |preset: Preset| Settings::from(preset).substeps.abs_diff(settings.substeps);
    let nearest = Preset::ALL.into_iter().min_by_key(|&preset| (others(preset).len(), away(preset)));
    let preset = nearest.unwrap_or_default();
    let doc = serde_json::from_value::<SettingsDoc>(others(preset).into());
    let doc = doc.unwrap_or_else(|_| SettingsDoc::dial(settings));
    SettingsDoc { preset: Some(preset.into()), ..doc }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_tried_once_and_can_be_said() {
        let own = Settings { relax_sweeps: 8, sleep_time: 0.5, dt: 0.01, ..Settings::default() };
        let all = places(&own, true);
        assert!(all.len() > 15, "{} places", all.len());
        for (index, place) in all.iter().enumerate() {
            assert_eq!(place.settings.check(), Ok(()), "{}", place.name);
            assert_eq!((place.settings.dt, place.settings.sleep_time), (0.01, 0.5), "{}", place.name);
            let others = &all[..index];
            assert!(others.iter().all(|other| other.settings != place.settings && other.name != place.name));
            let mut again = own;
            fragment(&place.settings).apply(&mut again);
            assert_eq!(again, place.settings, "{}", place.name);
            // The fields of the dial say all of it, whatever stood there.
            let dial = SettingsDoc { preset: None, ..SettingsDoc::dial(&place.settings) };
            for preset in Preset::ALL {
                preset.apply(&mut again);
                dial.apply(&mut again);
                assert_eq!(again, place.settings, "{}", place.name);
            }
        }
        for preset in Preset::ALL {
            let place = all.iter().find(|place| place.name == preset.name()).unwrap();
            assert_eq!(Preset::of(&place.settings), Some(preset));
            let expected = SettingsDoc { preset: Some(preset.into()), ..SettingsDoc::default() };
            assert_eq!(fragment(&place.settings), expected);
        }
        assert!(all.iter().any(|place| place.name == "scene" && place.settings == own));
        assert!(places(&own, false).len() < all.len());
    }
}
