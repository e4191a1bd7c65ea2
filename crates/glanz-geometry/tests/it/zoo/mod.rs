//! The library's roots of rays with freeform surfaces against an independent reference, over a zoo of patches.
//!
//! `reference` isolates roots by interval arithmetic, `collection` has the surfaces, `rays` makes the rays, `verdict` compares.
//! Every run of the tests shoots a share of the rays; `cargo xtask zoo` shoots all of them:
//! `GLANZ_ZOO_RAYS` random and `GLANZ_ZOO_ADVERSARIAL` hard ones over the whole zoo, and over the bicubic patches of the files in
//! `GLANZ_ZOO_PATCHES` (paths with colons between). `GLANZ_ZOO_ONLY` restricts it to surfaces with this in their names. Seeds are
//! fixed.

mod animal;
mod cell;
mod collection;
mod files;
mod interval;
mod patch;
mod rays;
mod reference;
mod run;
mod validation;
mod verdict;

fn number(variable: &str, otherwise: u64) -> u64 {
    std::env::var(variable).ok().and_then(|n| n.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn every_root_in_the_zoo_is_found_once_and_none_is_invented() {
    let (rays, adversarial) = (number("GLANZ_ZOO_RAYS", 20_000), number("GLANZ_ZOO_ADVERSARIAL", 10_000));
    let mut animals = collection::all();
    let files = std::env::var("GLANZ_ZOO_PATCHES").unwrap_or_default();
    animals.extend(files.split(':').filter(|path| !path.is_empty()).map(collection::of_file));
    if let Ok(only) = std::env::var("GLANZ_ZOO_ONLY") {
        animals.retain(|animal| animal.name.contains(&only));
    }
    let count = animals.len() as u64;
    let mut told = Vec::new();
    let mut bad = 0;
    println!("{}", run::HEADER);
    for animal in &animals {
        let tally = run::shoot(animal, rays.div_ceil(count), adversarial.div_ceil(count));
        println!("{}", tally.row(&animal.name));
        if tally.undecidable > 0 {
            println!("    the reference cannot decide {} of the undecided rays either", tally.undecidable);
        }
        assert!(tally.roots * 20 > tally.rays, "{}: the rays hardly meet it", animal.name);
        for what in &tally.told {
            println!("    {what}");
            told.push(format!("{}: {what}", animal.name));
        }
        bad += tally.bad();
    }
    assert!(bad == 0, "{bad} faults\n{}", told.join("\n"));
}
