//! Facts about the syntax.

use glanz_job::ResourceBudget;

use super::*;

/// A file with these instances.
fn wrap(data: &str) -> String {
    format!(
        "ISO-10303-21;HEADER;FILE_SCHEMA(('CONFIG_CONTROL_DESIGN','X'));ENDSEC;DATA;{data}ENDSEC;END-ISO-10303-21;"
    )
}

/// The numbers of the instances that are read, and the faults.
fn outline(text: &str) -> (Vec<u64>, Vec<String>) {
    let budget = ResourceBudget::default();
    let file = ExchangeFile::parse(text.as_bytes(), &budget).unwrap();
    let fault = |f: &SyntaxFault| format!("{}:{} {:?} {}", f.line, f.column, f.instance, f.reason);
    (file.entities().map(|e| e.id().0).collect(), file.faults.iter().map(fault).collect())
}

#[test]
fn every_encoding_of_strings_is_decoded() {
    for (file, text) in [
        ("", ""),
        ("it''s", "it's"),
        (r"C:\\dir", r"C:\dir"),
        (r"\X\C4rger", "Ärger"),
        (r"\X2\03A603A9\X0\!", "ΦΩ!"),
        (r"\X2\D83DDE00\X0\", "😀"),
        (r"\X4\0001F600000000E9\X0\", "😀é"),
        (r"\S\Drger", "Ärger"),
        (r"\PG\\S\a", "α"),
        (r"\PB\\S\1\PA\\S\1", "ą±"),
        (r"a\N\b\T\c", "a\nb\tc"),
        ("wrapped\r\n over", "wrapped over"),
        ("\\X2\\03\nA6\\X0\\", "Φ"),
        ("größe", "größe"),
        (r"\X2\03A\X0\", r"\X2\03A\X0\"),
        (r"\q", r"\q"),
    ] {
        assert_eq!(decode(file.as_bytes()), text, "{file}");
    }
    assert_eq!(decode(b"gr\xf6\xdfe"), "größe");
}

#[test]
fn parameters_of_every_kind_are_read() {
    let text = wrap("#7=A('t',1,-2.,1.E-05,.5,+3,.T.,\"0A\",$,*,(1,(2.,#9)),PARAMETER_VALUE(0.5),());");
    let budget = ResourceBudget::default();
    let file = ExchangeFile::parse(text.as_bytes(), &budget).unwrap();
    let entity = file.find(7).unwrap();
    let attributes = entity.simple();
    assert_eq!(attributes.text(0), "t");
    assert_eq!(attributes.count(1).unwrap(), 1);
    let numbers: Vec<f64> = [1, 2, 3, 4, 5, 11].iter().map(|i| attributes.number(*i).unwrap()).collect();
    assert_eq!(numbers, [1.0, -2.0, 1e-5, 0.5, 3.0, 0.5]);
    assert!(attributes.boolean(6).unwrap());
    assert!(!attributes.is_missing(7) && attributes.is_missing(8) && attributes.is_missing(9));
    assert!(attributes.is_missing(13));
    assert_eq!(attributes.list(10).unwrap().count_items(), 2);
    assert_eq!(attributes.list(12).unwrap().count_items(), 0);
    let outer: Vec<u32> = attributes.list(10).unwrap().collect();
    let inner: Vec<TapeToken> = attributes.sublist(outer[1]).map(|at| attributes.token(at)).collect();
    assert_eq!(inner, [TapeToken::Real(2.0), TapeToken::Reference(9)]);
    assert_eq!(attributes.reference(1).unwrap_err().reason, "attribute 2 must be a reference");
    assert_eq!(
        attributes.reference_at(outer[1]).unwrap_err().reason,
        "an item of a list must be a reference"
    );
    assert_eq!(attributes.number(13).unwrap_err().reason, "attribute 14 is missing");
    assert_eq!(file.schemas, ["CONFIG_CONTROL_DESIGN", "X"]);
}

#[test]
fn attributes_of_complex_instances_follow_one_another_as_in_simple_ones() {
    let text = wrap(
        "#1=(B_SPLINE_CURVE(2,(#2))BOUNDED_CURVE()B_SPLINE_CURVE_WITH_KNOTS((3,3),(0.,1.))REPRESENTATION_ITEM('n'));
         #2=(B_SPLINE_CURVE(2,(#2))UNKNOWN_TYPE(1)B_SPLINE_CURVE_WITH_KNOTS((3,3),(0.,1.)));",
    );
    let budget = ResourceBudget::default();
    let file = ExchangeFile::parse(text.as_bytes(), &budget).unwrap();
    for (number, name) in [(1, "n"), (2, "")] {
        let entity = file.find(number).unwrap();
        assert!(entity.is(Keyword::BSplineCurve) && !entity.is(Keyword::BSplineSurface));
        let parts = [Keyword::RepresentationItem, Keyword::BSplineCurve, Keyword::BSplineCurveWithKnots];
        let attributes = entity.attributes(&parts);
        assert_eq!((attributes.text(0), attributes.count(1).unwrap()), (name.to_owned(), 2));
        assert_eq!(attributes.counts(3).unwrap(), [3, 3]);
        assert_eq!(attributes.numbers(4).unwrap(), [0.0, 1.0]);
    }
}

#[test]
fn spaces_and_comments_may_stand_between_all_tokens() {
    let spaced = "\u{feff}/* a ; #9=X(); */ISO-10303-21 ;\nHEADER ; ENDSEC\n; DATA /* */ ;\n#1 /*;*/ = /**/ PLANE\n(\n'' , #2 /* ' */ ) \r\n;\
                  #2\t=\tplane ( '/* no comment */' ) ; ENDSEC ; END-ISO-10303-21 ;";
    let budget = ResourceBudget::default();
    let file = ExchangeFile::parse(spaced.as_bytes(), &budget).unwrap();
    assert_eq!(file.faults, []);
    let one = file.find(1).unwrap();
    assert_eq!(one.keyword(), Keyword::Plane);
    let two = one.simple().reference(1).unwrap();
    assert_eq!((two.keyword(), two.simple().text(0)), (Keyword::Plane, "/* no comment */".to_owned()));
}

#[test]
fn sections_of_all_editions_are_read_or_skipped() {
    let text = "ISO-10303-21;HEADER;FILE_NAME('','',(''),(''),'','','');ENDSEC;ANCHOR;<a>=#1;ENDSEC;REFERENCE;#5=<x#y>;ENDSEC;\
                DATA('one',('S'));#1=A();ENDSEC;DATA;#2=B();ENDSEC;SIGNATURE;TWFu==;ENDSEC;END-ISO-10303-21;";
    assert_eq!(outline(text), (vec![1, 2], vec![]));
}

#[test]
fn damaged_instances_are_reported_by_line_and_column_and_the_others_are_read() {
    let (read, faults) =
        outline(&wrap("\n#1=A(1);\n #2=B(1,;\n#3=C((2);\n#4=D();#5;#6=E(1.2.3);\n#7=F();#7=G();"));
    assert_eq!(read, [1, 4, 7]);
    assert_eq!(
        faults,
        [
            "3:9 Some(2) a parameter must begin here",
            "4:9 Some(3) \",\" or \")\" is missing",
            "5:10 Some(5) \"=\" is missing",
            "5:21 Some(6) the number cannot be read",
            "6:8 Some(7) another instance has this number; the first one counts",
        ]
    );
}

#[test]
fn quote_too_many_costs_its_own_instance_only() {
    let (read, faults) = outline(&wrap("\n#1=A('x);\n#2=B();\n#3=C('y');\n#4=D();\n"));
    assert_eq!(read, [2, 3, 4]);
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert!(faults[0].contains("Some(1)"), "{faults:?}");
}

#[test]
fn truncated_file_gives_what_is_there_and_says_so() {
    let text = "ISO-10303-21;HEADER;ENDSEC;DATA;\n#1=A();\n#2=B('";
    assert_eq!(
        outline(text),
        (
            vec![1],
            vec![
                "3:1 Some(2) the file ends inside of this instance".to_owned(),
                "3:7 None the file ends without END-ISO-10303-21; it is incomplete".to_owned()
            ]
        )
    );
}

#[test]
fn nesting_and_numbers_have_limits() {
    let nested = |depth: usize| wrap(&format!("#1=A({}{});", "(".repeat(depth), ")".repeat(depth)));
    assert_eq!(outline(&nested(63)).0, [1]);
    assert!(outline(&nested(64)).1[0].contains("64 levels"));
    assert!(outline(&nested(1_000_000)).1[0].contains("64 levels"));
    assert_eq!(outline(&wrap("#18446744073709551615=A();")).0, [u64::MAX]);
    assert!(outline(&wrap("#18446744073709551616=A();")).1[0].contains("2^64"));
    assert!(outline(&wrap("#1=A(1.E999);")).1[0].contains("too large"));
}

#[test]
fn instances_are_found_with_and_without_gaps_between_their_numbers() {
    for step in [1, 1000, 1 << 50] {
        let data: String = (1..=50_u64).rev().map(|i| format!("#{}=A({i});", i * step)).collect();
        let text = wrap(&data);
        let budget = ResourceBudget::default();
        let file = ExchangeFile::parse(text.as_bytes(), &budget).unwrap();
        for i in 1..=50 {
            assert_eq!(file.find(i * step).unwrap().simple().count(0).unwrap(), i as usize);
        }
        assert!(file.find(0).is_none() && file.find(51 * step).is_none());
    }
}

#[test]
fn files_of_other_kinds_are_refused() {
    assert_eq!(
        ExchangeFile::parse(b"solid cube", &ResourceBudget::default()).unwrap_err(),
        StepError::NotStep
    );
    assert_eq!(ExchangeFile::parse(b"", &ResourceBudget::default()).unwrap_err(), StepError::NotStep);
    assert_eq!(
        ExchangeFile::parse(b"ISO-10303-21;HEADER;ENDSEC;", &ResourceBudget::default()).unwrap_err(),
        StepError::NoData
    );
}

/// Repeated damage must not make reading quadratic: this takes minutes if every comment is searched to the end of the file.
#[test]
fn many_comments_without_an_end_are_read_in_linear_time() {
    let text = wrap(&"#1=A(/* ;#2=B(' ;".repeat(50_000));
    let start = std::time::Instant::now();
    assert!(ExchangeFile::parse(text.as_bytes(), &ResourceBudget::default()).unwrap().fault_count > 0);
    assert!(start.elapsed().as_secs() < 10);
}

#[test]
fn stray_semicolon_between_sections_costs_nothing() {
    let (read, faults) =
        outline("ISO-10303-21;HEADER;ENDSEC;;DATA;#1=A();ENDSEC;;\nDATA ;#2=B();ENDSEC;END-ISO-10303-21;");
    assert_eq!(read, [1, 2]);
    assert_eq!(faults.len(), 2, "{faults:?}");
    let unknown = "ISO-10303-21;HEADER;ENDSEC;OTHER;METADATA;X_DATA('DATA');ENDSEC;DATA;#1=A();ENDSEC;END-ISO-10303-21;";
    assert_eq!(outline(unknown).0, [1]);
}

#[test]
fn header_without_its_end_costs_no_data() {
    for data in ["DATA;#1=A();", "DATA('one',('S'));#1=A();", "\n#1=A();", "FILE_NAME(;DATA;#1=A();"] {
        let text = format!("ISO-10303-21;HEADER;FILE_SCHEMA(('X'));{data}#2=B();ENDSEC;END-ISO-10303-21;");
        let (read, faults) = outline(&text);
        assert_eq!(read, [1, 2], "{data}");
        assert!(faults.iter().any(|fault| fault.contains("ENDSEC is missing")), "{faults:?}");
    }
}

#[test]
fn instances_behind_a_damaged_one_are_read() {
    for (data, numbers) in [
        ("#1=A(1;\n/* bolt */\n#2=B();#3=C();", [2, 3]),
        ("#1=A(1;/* ; */ /* */\n#2=B();#3=C();", [2, 3]),
        ("#1=A(1)\n#2=B();\n#3=C();", [2, 3]),
        ("#1=A(1 /* one */ #2=B();\n#3=C();", [2, 3]),
        ("#1=A((1)\n #2 = B();\n#3=C();", [2, 3]),
    ] {
        let (read, faults) = outline(&wrap(data));
        assert_eq!((read.as_slice(), faults.len()), (numbers.as_slice(), 1), "{data}: {faults:?}");
        assert!(faults[0].contains("Some(1)"), "{faults:?}");
    }
}

/// This takes minutes if every look-ahead passes all comments behind it.
#[test]
fn semicolons_in_comments_are_passed_in_linear_time() {
    let text = wrap(&format!("#1=A('{}*/{}", "/*;".repeat(200_000), "/**/".repeat(200_000)));
    let start = std::time::Instant::now();
    assert!(ExchangeFile::parse(text.as_bytes(), &ResourceBudget::default()).unwrap().fault_count > 0);
    assert!(start.elapsed().as_secs() < 10);
}

#[test]
fn codes_of_characters_are_hexadecimal_digits_and_give_no_control_characters() {
    for (file, text) in [
        (r"\X\+Fa", r"\X\+Fa"),
        (r"\X2\+3A6\X0\", r"\X2\+3A6\X0\"),
        (r"\X2\03A6\X2\03A9\X0\", r"\X2\03A6Ω"),
        (r"a\X\00\X\07b", "ab"),
        (r"a\X2\0000001B0062\X0\", "ab"),
        (r"a\X4\0000001B00000062\X0\", "ab"),
    ] {
        assert_eq!(decode(file.as_bytes()), text, "{file}");
    }
}

#[test]
fn directives_without_an_end_are_read_in_linear_time() {
    let start = std::time::Instant::now();
    assert_eq!(decode(r"\X2\q".repeat(400_000).as_bytes()).len(), 2_000_000);
    assert!(start.elapsed().as_secs() < 10);
}

#[test]
fn complex_instances_have_at_most_64_types() {
    let complex = |count: usize| wrap(&format!("#1=({});", "A()".repeat(count)));
    assert_eq!(outline(&complex(64)).0, [1]);
    assert!(outline(&complex(65)).1[0].contains("64 types"));
}
