//! Memory of reading damaged STEP files, counted in bytes by the allocator of this program.

use glanz_formats::{Options, load_str};
use peak_alloc::PeakAlloc;
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes at the peak of reading the model of a file: per byte of the file, and in any case.
const MODEL: [usize; 2] = [300, 1 << 16];

/// Bytes at the peak of making a description of a scene: per byte of the file, and in any case.
const SCENE: [usize; 2] = [2000, 1 << 20];

/// A file with faces on surfaces of all kinds, in a product that occurs twice, with colours and mapped items.
fn sample() -> String {
    let mut data = String::from(
        "#900=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));#901=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
         #902=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.001),#900,'','');
         #910=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#902))GLOBAL_UNIT_ASSIGNED_CONTEXT((#900,#901))
         REPRESENTATION_CONTEXT('',''));#10=AXIS2_PLACEMENT_3D('',#11,$,$);#11=CARTESIAN_POINT('',(0.,0.,0.));
         #12=AXIS2_PLACEMENT_3D('',#13,#14,#15);#13=CARTESIAN_POINT('',(0.,0.,4.));#14=DIRECTION('',(0.,0.,1.));#15=DIRECTION('',(1.,0.,0.));
         #20=CIRCLE('',#10,2.);#21=CIRCLE('',#12,2.);#22=CARTESIAN_POINT('',(2.,0.,0.));#23=CARTESIAN_POINT('',(2.,0.,4.));
         #24=VERTEX_POINT('',#22);#25=VERTEX_POINT('',#23);#26=EDGE_CURVE('',#24,#24,#20,.T.);#27=EDGE_CURVE('',#25,#25,#21,.T.);
         #28=EDGE_CURVE('',#24,#25,#29,.T.);#29=LINE('',#22,#30);#30=VECTOR('',#14,1.);
         #31=ORIENTED_EDGE('',*,*,#26,.T.);#32=ORIENTED_EDGE('',*,*,#27,.F.);#33=ORIENTED_EDGE('',*,*,#28,.T.);
         #34=ORIENTED_EDGE('',*,*,#28,.F.);#35=EDGE_LOOP('',(#31,#33,#32,#34));#36=EDGE_LOOP('',(#31));#37=EDGE_LOOP('',(#32));
         #38=FACE_OUTER_BOUND('',#35,.T.);#39=FACE_BOUND('',#36,.T.);#40=FACE_BOUND('',#37,.T.);
         #41=CARTESIAN_POINT('',(2.,0.,1.));#42=CARTESIAN_POINT('',(3.,0.,2.));#43=CARTESIAN_POINT('',(2.,0.,3.));
         #44=B_SPLINE_CURVE_WITH_KNOTS('',3,(#22,#41,#42,#43,#23),.U.,.F.,.F.,(4,1,4),(0.,1.,2.),.U.);
         #45=AXIS1_PLACEMENT('',#11,#14);#46=CARTESIAN_POINT('',(0.,3.,1.));#47=CARTESIAN_POINT('',(3.,3.,0.));
         #50=CYLINDRICAL_SURFACE('',#10,2.);#51=CONICAL_SURFACE('',#10,2.,0.3);#52=SPHERICAL_SURFACE('',#10,2.);
         #53=TOROIDAL_SURFACE('',#10,2.,1.);#54=PLANE('',#10);#55=SURFACE_OF_REVOLUTION('',#44,#45);
         #56=SURFACE_OF_LINEAR_EXTRUSION('',#44,#57);#57=VECTOR('',#15,5.);#58=OFFSET_SURFACE('',#55,0.5,.F.);
         #59=B_SPLINE_SURFACE_WITH_KNOTS('',2,1,((#11,#41),(#46,#42),(#47,#43)),.U.,.F.,.F.,.F.,(3,3),(2,2),(0.,1.),(0.,1.),.U.);
         #60=RECTANGULAR_TRIMMED_SURFACE('',#50,0.,2.,0.,1.,.T.,.T.);#61=OFFSET_SURFACE('',#59,0.1,.F.);
         #62=CURVE_BOUNDED_SURFACE('',#54,(#63),.F.);#63=BOUNDARY_CURVE('',(#64),.F.);#64=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#20);
         #65=SURFACE_CURVE('',#20,(#66),.PCURVE_S1.);#66=PCURVE('',#50,#67);#67=DEFINITIONAL_REPRESENTATION('',(#68),#910);
         #68=B_SPLINE_CURVE_WITH_KNOTS('',1,(#69,#70),.U.,.F.,.F.,(2,2),(0.,6.283185307),.U.);#69=CARTESIAN_POINT('',(0.,0.));
         #70=CARTESIAN_POINT('',(6.283185307,0.));#71=POLY_LOOP('',(#22,#46,#23));#72=FACE_BOUND('',#71,.T.);#73=FACE('',(#72));",
    );
    let mut faces = vec!["#73".to_owned()];
    for (i, surface) in [50, 51, 52, 53, 55, 56, 58].into_iter().enumerate() {
        let around = 100 + i;
        data += &format!("#{around}=ADVANCED_FACE('f{i}',(#38),#{surface},.T.);");
        faces.push(format!("#{around}"));
    }
    for (i, surface) in [52, 53, 55, 58, 59, 60, 61].into_iter().enumerate() {
        data += &format!("#{}=ADVANCED_FACE('w{i}',(),#{surface},.F.);", 120 + i);
        faces.push(format!("#{}", 120 + i));
    }
    data += &format!(
        "#140=ADVANCED_FACE('',(#39),#54,.T.);#200=CLOSED_SHELL('',({},#140));#201=MANIFOLD_SOLID_BREP('solid',#200);
         #202=GEOMETRIC_SET('',(#60,#62,#59));#203=SHAPE_REPRESENTATION('part',(#201,#202),#910);
         #210=STYLED_ITEM('',(#211),#201);#211=PRESENTATION_STYLE_ASSIGNMENT((#212));#212=SURFACE_STYLE_USAGE(.BOTH.,#213);
         #213=SURFACE_SIDE_STYLE('',(#214));#214=SURFACE_STYLE_RENDERING(.X.,#215);#215=COLOUR_RGB('',1.,0.,0.);
         #216=CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM('',(#217),#101,#210,(#410));#217=PRESENTATION_STYLE_ASSIGNMENT((#218));
         #218=SURFACE_STYLE_USAGE(.BOTH.,#219);#219=SURFACE_SIDE_STYLE('',(#220));#220=SURFACE_STYLE_RENDERING(.X.,#221);
         #221=COLOUR_RGB('',0.,0.,1.);#222=PRESENTATION_LAYER_ASSIGNMENT('layer','',(#140));#223=INVISIBILITY((#222));
         #230=MAPPED_ITEM('',#231,#12);#231=REPRESENTATION_MAP(#10,#232);#232=SHAPE_REPRESENTATION('',(#73),#910);
         #300=PRODUCT_DEFINITION('','',$,$);#301=PRODUCT_DEFINITION_SHAPE('','',#300);#302=SHAPE_DEFINITION_REPRESENTATION(#301,#203);
         #310=PRODUCT_DEFINITION('','',$,$);#311=PRODUCT_DEFINITION_SHAPE('','',#310);#312=SHAPE_DEFINITION_REPRESENTATION(#311,#313);
         #313=SHAPE_REPRESENTATION('whole',(#230),#910);",
        faces.join(",")
    );
    for (usage, to) in [(400, 10), (500, 12)] {
        let [placement, relationship, transformation, property] = [10, 11, 12, 13].map(|i| usage + i);
        data += &format!(
            "#{usage}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('id','name','',#310,#300,$);
             #{placement}=CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relationship},#{property});
             #{property}=PRODUCT_DEFINITION_SHAPE('','',#{usage});
             #{relationship}=(REPRESENTATION_RELATIONSHIP('','',#203,#313)
             REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{transformation})SHAPE_REPRESENTATION_RELATIONSHIP());
             #{transformation}=ITEM_DEFINED_TRANSFORMATION('','',#10,#{to});"
        );
    }
    format!(
        "ISO-10303-21;HEADER;FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));ENDSEC;DATA;{data}ENDSEC;END-ISO-10303-21;"
    )
}

/// A change of a file.
#[derive(Clone, Debug)]
enum Damage {
    /// A character in the place of another.
    Replace(Index, Index),
    /// A part that is missing.
    Remove(Index, usize),
    /// A part that appears again somewhere else.
    Copy(Index, Index, usize),
    /// A reference to another entity.
    Redirect(Index, Index),
    /// A number in the place of another.
    Number(Index, Index),
    /// A reference that is repeated in its list.
    Repeat(Index, usize),
}

/// Characters that mean something in a file.
const MEANINGFUL: &[u8] = b"#(),;='.$*/0123456789-E";

/// Numbers in strange places.
const NUMBERS: &[&str] =
    &["0.", "-1.", "1.E-9", "1.E-300", "1.E9", "1.E15", "1.E300", "1000000.", "-7.5", "1.0000001"];

fn damage() -> impl Strategy<Value = Damage> {
    let index = any::<Index>;
    prop_oneof![
        (index(), index()).prop_map(|(at, byte)| Damage::Replace(at, byte)),
        (index(), 1..100_usize).prop_map(|(at, length)| Damage::Remove(at, length)),
        (index(), index(), 1..3000_usize).prop_map(|(from, to, length)| Damage::Copy(from, to, length)),
        (index(), index()).prop_map(|(at, to)| Damage::Redirect(at, to)),
        (index(), index()).prop_map(|(at, number)| Damage::Number(at, number)),
        (index(), 1..500_usize).prop_map(|(at, count)| Damage::Repeat(at, count)),
    ]
}

/// The first part behind `from` of a character that `start` accepts and those of `others` behind it.
fn token(text: &str, from: usize, start: fn(char) -> bool, others: &str) -> Option<std::ops::Range<usize>> {
    let first = from + text.get(from..)?.find(start)?;
    let length = text.get(first + 1..)?.find(|c| !others.contains(c))?;
    Some(first..first + 1 + length)
}

fn reference(text: &str, at: usize) -> Option<std::ops::Range<usize>> {
    token(text, at, |c| c == '#', "0123456789")
}

fn damaged(mut text: String, changes: &[Damage]) -> String {
    for change in changes {
        let at = |index: &Index| index.index(text.len());
        match change {
            Damage::Replace(place, byte) => {
                let place = at(place);
                text.replace_range(place..=place, &char::from(*byte.get(MEANINGFUL)).to_string());
            }
            Damage::Remove(place, length) => {
                let start = at(place);
                let end = (start + length).min(text.len() - 1);
                text.replace_range(start..end.max(start), "");
            }
            Damage::Copy(from, to, length) => {
                let (start, to) = (at(from), at(to));
                let part = text[start..(start + length).min(text.len())].to_owned();
                text.insert_str(to, &part);
            }
            Damage::Redirect(place, to) => {
                let (place, to) = (reference(&text, at(place)), reference(&text, at(to)));
                if let (Some(place), Some(to)) = (place, to) {
                    let to = text[to].to_owned();
                    text.replace_range(place, &to);
                }
            }
            Damage::Number(place, number) => {
                let is_start = |c: char| c == '.';
                if let Some(place) = token(&text, at(place), is_start, "0123456789E-") {
                    text.replace_range(
                        place.start.saturating_sub(1)..place.end,
                        NUMBERS[number.index(NUMBERS.len())],
                    );
                }
            }
            Damage::Repeat(place, count) => {
                if let Some(place) = reference(&text, at(place)) {
                    let repeated = format!("{},", &text[place.clone()]).repeat(*count);
                    text.insert_str(place.start, &repeated);
                }
            }
        }
    }
    text
}

/// The bytes that a work on a file needs at its peak.
fn peak<T>(work: impl FnOnce() -> T) -> usize {
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    drop(work());
    ALLOCATOR.peak_usage() - before
}

/// The bytes that reading the model of a file, and making a scene of it, need at their peaks.
fn peaks(text: &str) -> [usize; 2] {
    [
        peak(|| glanz_formats::step::read(text.as_bytes())),
        peak(|| load_str("damaged.step", text, &Options::default())),
    ]
}

/// Number of damaged files; `GLANZ_FUZZ` multiplies it.
fn cases() -> u32 {
    100 * std::env::var("GLANZ_FUZZ").ok().and_then(|v| v.parse().ok()).unwrap_or(1)
}

#[test]
fn memory_is_in_proportion_to_the_size_of_damaged_files() {
    let whole = sample();
    // Threads and tables are made once.
    peaks(&whole);
    let loaded =
        load_str("sample.step", &whole, &Options::default()).unwrap_or_else(|error| panic!("{error:?}"));
    let report = loaded.cad.unwrap();
    assert!(report.shapes.len() >= 20, "{report:?}");
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases()) };
    // The same files in each run.
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(config, rng);
    let outcome = runner.run(&prop::collection::vec(damage(), 1..12), |changes| {
        let text = damaged(whole.clone(), &changes);
        let limits = [MODEL, SCENE].map(|[factor, constant]| factor * text.len() + constant);
        let found = peaks(&text);
        let holds = found.iter().zip(limits).all(|(found, limit)| *found <= limit);
        prop_assert!(holds, "{found:?} bytes for {} bytes", text.len());
        Ok(())
    });
    assert!(outcome.is_ok(), "{outcome:?}");
}
