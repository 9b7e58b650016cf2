//! The header is that of the source. `UPDATE=1 cargo test -p cellstep-capi --test header` writes it anew.

use std::path::Path;

/// The header that cbindgen makes of the source.
fn generate() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("the configuration is valid");
    let sources =
        ["error", "types", "world", "bodies", "shapes", "assets", "joints", "queries", "events", "snapshots"];
    let mut builder = cbindgen::Builder::new().with_config(config);
    for name in sources {
        builder = builder.with_src(root.join("src").join(name).with_extension("rs"));
    }
    let mut text = Vec::new();
    builder.generate().expect("the source has a header").write(&mut text);
    String::from_utf8(text).expect("a header is text")
}

#[test]
fn the_header_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/cellstep.h");
    let made = generate();
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &made).expect("the header can be written");
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(kept == made, "{}: run UPDATE=1 cargo test -p cellstep-capi --test header", path.display());
}

/// Every exported function is in it, and nothing that C cannot name.
#[test]
fn the_header_has_every_function() {
    let made = generate();
    let mut functions = 0;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in std::fs::read_dir(folder).expect("the folder is there") {
        let text = std::fs::read_to_string(entry.expect("an entry").path()).expect("a source file");
        for name in text.split("extern \"C\" fn ").skip(1).filter_map(|rest| rest.split('(').next()) {
            assert!(made.contains(&format!("{name}(")), "{name} is not in the header");
            functions += 1;
        }
    }
    assert!(functions > 80, "{functions} functions");
    for word in ["Option", "MaybeUninit", "Vec<", "Result<"] {
        assert!(!made.contains(word), "`{word}` in the header");
    }
}
