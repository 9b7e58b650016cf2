//! Which settings are tried, and how a scene file says one of them.

use cellstep::scene::format::SettingsDoc;
use cellstep::{ContactModel, Preset, Settings};

/// Soft contacts at numbers of substeps between and beside the presets.
const SOFT: [u32; 7] = [1, 2, 3, 4, 6, 8, 12];
/// Split contacts likewise.
const SPLIT: [u32; 7] = [2, 3, 4, 6, 8, 12, 16];
/// Relax sweeps beside one, for scenes with joints.
const RELAX: [(Preset, u32); 3] = [(Preset::Fast, 2), (Preset::Balanced, 2), (Preset::Balanced, 4)];

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
        // All that belongs to a model comes from a preset that has it.
        let base = Preset::ALL.map(turned).into_iter().find(|settings| settings.contact_model == model);
        let base = Settings { contact_model: model, ..base.unwrap_or(*scene) };
        for substeps in counts {
            add(format!("{name}/{substeps}"), Settings { substeps, ..base });
        }
        add(format!("{name}/4, 2 inner"), Settings { substeps: 4, inner_sweeps: 2, ..base });
    }
    if has_joints {
        for (preset, relax_sweeps) in RELAX {
            add(
                format!("{}, {relax_sweeps} relax", preset.name()),
                Settings { relax_sweeps, ..turned(preset) },
            );
        }
    }
    all
}

/// The shortest way to say where the dial of some settings stands: a preset, and what differs from it.
pub fn fragment(settings: &Settings) -> SettingsDoc {
    let from = |preset: Preset| {
        let mut base = *settings;
        preset.apply(&mut base);
        SettingsDoc {
            preset: Some(preset.into()),
            substeps: (settings.substeps != base.substeps).then_some(settings.substeps),
            sweeps: (settings.sweeps != base.sweeps).then_some(settings.sweeps),
            relax_sweeps: (settings.relax_sweeps != base.relax_sweeps).then_some(settings.relax_sweeps),
            inner_sweeps: (settings.inner_sweeps != base.inner_sweeps).then_some(settings.inner_sweeps),
            contact_model: (settings.contact_model != base.contact_model)
                .then(|| settings.contact_model.into()),
            contact_frequency: (settings.contact_frequency != base.contact_frequency)
                .then_some(settings.contact_frequency),
            contact_damping_ratio: (settings.contact_damping_ratio != base.contact_damping_ratio)
                .then_some(settings.contact_damping_ratio),
            ..SettingsDoc::default()
        }
    };
    let fields = |doc: &SettingsDoc| {
        let json = serde_json::to_value(doc).ok();
        json.and_then(|json| json.as_object().map(|fields| fields.len()))
    };
    let away = |preset: Preset| Settings::from(preset).substeps.abs_diff(settings.substeps);
    let best = Preset::ALL.into_iter().min_by_key(|&preset| (fields(&from(preset)), away(preset)));
    best.map_or_else(|| SettingsDoc::dial(settings), from)
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
