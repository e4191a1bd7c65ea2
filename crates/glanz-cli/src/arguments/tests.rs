//! Parsing of command lines.

use std::path::PathBuf;

use clap::CommandFactory;

use super::*;

fn parse(line: &str) -> Result<Arguments, clap::Error> {
    Arguments::try_parse_from(line.split(' '))
}

#[test]
fn definition_is_consistent() {
    Arguments::command().debug_assert();
}

#[test]
fn values_are_read_as_they_are_written() {
    let Ok(Arguments { command: Command::Render(render) }) =
        parse("glanz render a.pbrt -o a.exr -o a.png --size 64x48 --samples 3..7 --aov N,Z --exposure -1.5")
    else {
        panic!("a valid command line is refused");
    };
    let options = render.render;
    assert_eq!(options.output, [PathBuf::from("a.exr"), PathBuf::from("a.png")]);
    assert_eq!(options.size, Some([64, 48]));
    assert_eq!(options.samples, Some(3..7));
    assert_eq!(options.aov, ["N", "Z"]);
    assert_eq!(options.tone.exposure, -1.5);
}

#[test]
fn memory_is_limited_by_its_own_option_first() {
    for line in
        ["glanz info a.pbrt --memory 2K --limit memory=1K", "glanz info a.pbrt --limit memory=4K --memory 2K"]
    {
        let Ok(Arguments { command: Command::Info(info) }) = parse(line) else {
            panic!("a valid command line is refused: {line}");
        };
        assert_eq!(info.reading.limits().memory, 2048, "{line}");
    }
}

#[test]
fn nonsense_is_wrong_usage() {
    for line in [
        "glanz",
        "glanz paint",
        "glanz render",
        "glanz render a.pbrt --spp 0",
        "glanz render a.pbrt --spp 4 --time 2",
        "glanz render a.pbrt --time -1",
        "glanz render a.pbrt --time nan",
        "glanz render a.pbrt --time 1e40",
        "glanz render a.pbrt --size 64",
        "glanz render a.pbrt --size 0x5",
        "glanz render a.pbrt --samples 5..5",
        "glanz render a.pbrt --samples 5..x",
        "glanz render a.pbrt --resume",
        "glanz render a.pbrt --part 1/2",
        "glanz render a.pbrt --part 3/2 --checkpoint a.glanz",
        "glanz render a.pbrt --part 1/2 --checkpoint a.glanz --time 2",
        "glanz render a.pbrt --part 1/2 --checkpoint a.glanz --noise 0.1",
        "glanz render a.pbrt --part 1/2 --checkpoint a.glanz --turntable 3",
        "glanz render a.pbrt --threads 0",
        "glanz render a.pbrt --exposure inf",
        "glanz render a.pbrt --guide grid=0",
        "glanz render a.pbrt --guide bush",
        "glanz render a.pbrt --samplelights yes",
        "glanz merge a.glanz",
        "glanz bake a.pbrt",
        "glanz bake a.pbrt -o a.glb --texels-per-metre 0",
        "glanz bake a.pbrt -o a.glb --tolerance -1",
        "glanz bake a.pbrt -o a.glb --lightmap jpg",
        "glanz bake a.pbrt -o a.glb --resume",
        "glanz bake a.pbrt -o a.glb --threads 0",
        "glanz compare a.exr b.exr --fail-above -1",
        "glanz compare a.exr b.exr --metric beauty",
        "glanz view",
        "glanz view a.pbrt --port 65536",
        "glanz view a.pbrt --integrator whitted",
        "glanz view a.pbrt --threads 0",
    ] {
        assert_eq!(parse(line).map(|_| ()).map_err(|e| e.exit_code()), Err(2), "{line}");
    }
}
