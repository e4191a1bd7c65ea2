//! The report of `glanz illuminate` on paper: sheets of A4 by the print layout of the browser.

use data_encoding::BASE64;
use serde_json::{Value, json};

use super::page::Page;
use crate::command_line::support::Folder;

/// Width and height of a sheet of A4 inside the margins of the report, pixels of CSS: 180 mm x 264 mm.
const SHEET: [f64; 2] = [680.3, 997.8];

/// Elements that reach beyond the sheet, texts that reach beyond their drawing, and things that may not be divided but are higher than a sheet.
const FAULTS: &str = "(([width, height]) => {
    const faults = [];
    const name = (e) => `${e.tagName} ${e.className?.baseVal ?? e.className} ${e.textContent.slice(0, 60)}`;
    for (const e of document.querySelectorAll('body *')) {
        const box = e.getBoundingClientRect();
        if (box.right > width + 1 || box.left < -1) faults.push('beyond the sheet: ' + name(e));
    }
    for (const text of document.querySelectorAll('svg text')) {
        const [inner, outer] = [text.getBoundingClientRect(), text.ownerSVGElement.getBoundingClientRect()];
        if (inner.left < outer.left - 1 || inner.right > outer.right + 1 || inner.top < outer.top - 1 || inner.bottom > outer.bottom + 1)
            faults.push('beyond the drawing: ' + name(text));
    }
    for (const e of document.querySelectorAll('figure, .card, tr')) {
        if (e.getBoundingClientRect().height > height) faults.push('higher than a sheet: ' + name(e));
    }
    return faults.slice(0, 10);
})";

/// The sheets of a report: their number, and the bytes of the PDF.
fn printed(folder: &Folder, report: &str) -> (usize, Vec<u8>, Page) {
    let mut page = Page::document(&folder.path(report), [SHEET[0] as u32, SHEET[1] as u32]);
    page.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
    assert_eq!(page.evaluate(&format!("{FAULTS}({SHEET:?})")), json!([]), "{report}");
    let print = json!({ "preferCSSPageSize": true, "printBackground": true });
    let answer = page.call("Page.printToPDF", print);
    let pdf = BASE64.decode(answer["data"].as_str().unwrap().as_bytes()).unwrap();
    let count = |words: &str| pdf.windows(words.len()).filter(|window| *window == words.as_bytes()).count();
    let sheets = count("/Type /Page") - count("/Type /Pages");
    // Letters, no pictures of them.
    assert!(count("/ToUnicode") > 0 && count("/Subtype /Image") == 0, "{report}");
    (sheets, pdf, page)
}

fn folder_with_panel() -> Folder {
    let folder = Folder::new();
    folder.write(
        "panel.ies",
        "IESNA:LM-63-2002\n[MANUFAC] A maker with a long name & sons <GmbH>\n[LUMINAIRE] Паннель 照明 600x600\n[_CCT] 4000 K\nTILT=NONE\n\
         1 -1 1 7 1 1 2 0.6 0.6 0 1 1 30\n0 15 30 45 60 75 90\n0\n1000 966 866 707 500 259 0\n",
    );
    folder
}

#[test]
fn report_of_a_room_fills_sheets_without_losing_anything() {
    let folder = folder_with_panel();
    // An office with a title that no line holds, and a hall with more luminaires than can be numbered.
    let title = "Überlange-Bezeichnung-ohne-Leerzeichen".repeat(6);
    let common =
        "--luminaire panel.ies --rays 20000 --directions 16 --task 34.2 --maintenance 0.9x1x0.95x0.94";
    folder.succeed(&format!("illuminate --room 6 4 2.8 --grid 3x2 {common} --title {title} -o office"));
    folder.succeed(&format!("illuminate --room 40 9 6 --grid 30x5 --eye 1.6 {common} -o hall"));
    for (report, words) in
        [("office/report.html", "Паннель 照明"), ("hall/report.html", "Luminaires: 30 more in report.json.")]
    {
        let (sheets, pdf, mut page) = printed(&folder, report);
        let mut count = |selector: &str| {
            page.evaluate(&format!("document.querySelectorAll('{selector}').length")).as_u64().unwrap()
                as usize
        };
        // Short sections share sheets with those before them, if there is room.
        let (sections, short) = (count("section"), count("section.short"));
        assert!(
            (sections - short..=2 * sections).contains(&sheets),
            "{report}: {sheets} sheets, {sections} sections"
        );
        assert!(pdf.starts_with(b"%PDF"));
        let selected = "getSelection().selectAllChildren(document.body), getSelection().toString()";
        let text = page.evaluate(selected);
        for words in
            [words, "A maker with a long name & sons <GmbH>", "maintained illuminance, lx", "Scale 1 : "]
        {
            assert!(text.as_str().unwrap().contains(words), "{report}: {words}");
        }
        assert_eq!(page.evaluate("document.querySelectorAll('script, link, img').length"), Value::from(0));
    }
}
