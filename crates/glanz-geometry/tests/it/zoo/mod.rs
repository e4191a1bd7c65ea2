//! Roots of rays with freeform surfaces against an independent reference, over a collection of patches.
//!
//! `reference` isolates roots by interval arithmetic, `collection` has the surfaces, `rays` generates the rays, `comparison` compares. `cost` measures the hardest rays
//! of `pathologies`.
//! Every run of the tests traces a fraction of the rays; `cargo xtask zoo` traces all of them: `GLANZ_ZOO_RAYS` random and
//! `GLANZ_ZOO_ADVERSARIAL` adversarial ones over all surfaces, including the bicubic patches of the files in `GLANZ_ZOO_PATCHES`
//! (paths separated by colons). `GLANZ_ZOO_ONLY` restricts them to surfaces with this text in their names. Seeds are fixed.

mod batch;
mod cell;
mod collection;
mod comparison;
mod cost;
mod files;
mod interval;
mod patch;
mod pathologies;
mod rays;
mod reference;
mod run;
mod test_surface;
mod validation;

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|n| n.parse().ok()).unwrap_or(default)
}

#[test]
fn every_root_is_found_once_and_none_is_invented() {
    let (rays, adversarial) = (number("GLANZ_ZOO_RAYS", 20_000), number("GLANZ_ZOO_ADVERSARIAL", 10_000));
    let mut surfaces = collection::all();
    let files = std::env::var("GLANZ_ZOO_PATCHES").unwrap_or_default();
    surfaces.extend(files.split(':').filter(|path| !path.is_empty()).map(collection::of_file));
    if let Ok(only) = std::env::var("GLANZ_ZOO_ONLY") {
        surfaces.retain(|tested| tested.name.contains(&only));
    }
    let count = surfaces.len() as u64;
    let mut messages = Vec::new();
    let mut failures = 0;
    println!("{}", run::HEADER);
    for tested in &surfaces {
        let tally = run::trace(tested, rays.div_ceil(count), adversarial.div_ceil(count));
        println!("{}", tally.row(&tested.name));
        if tally.undecidable > 0 {
            println!("    the reference cannot decide {} of the undecided rays either", tally.undecidable);
        }
        assert!(tally.roots * 20 > tally.rays, "{}: too few rays hit it", tested.name);
        for message in &tally.messages {
            println!("    {message}");
            messages.push(format!("{}: {message}", tested.name));
        }
        failures += tally.failures();
    }
    assert!(failures == 0, "{failures} faults\n{}", messages.join("\n"));
}
