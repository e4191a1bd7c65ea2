//! Reports as self-contained pages of HTML.

use glanz_report::svg::{escaped, shortened};

use super::client_page::{client_sections, origin, section};
use super::text::{calculation, closing, far_field, flux, intervals, receivers};
use super::{LuxComparison, LuxReport, PolarPlot};

/// Colours of the light or dark theme, whichever the reader prefers; on paper always dark on white. Sections begin sheets of A4.
const STYLE: &str = "\
:root { color-scheme: light dark; --paper: #ffffff; --ink: #1a1a1a; --faint: #d0d0d0; }
@media (prefers-color-scheme: dark) { :root { --paper: #16181c; --ink: #e6e6e6; --faint: #464a52; } }
@media print { :root { color-scheme: light; --paper: #ffffff; --ink: #000000; --faint: #c0c0c0; } }
body { background: var(--paper); color: var(--ink); font: 16px/1.5 'DejaVu Sans', Helvetica, Arial, sans-serif;
  margin: 2rem auto; max-width: 76rem; padding: 0 1rem; }
h1 { font-size: 1.6rem; overflow-wrap: anywhere; } h2 { font-size: 1.2rem; margin-top: 2.2rem; overflow-wrap: anywhere; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 1rem 0; }
caption { text-align: left; font-weight: bold; padding-bottom: 0.4rem; overflow-wrap: anywhere; }
th, td { border-bottom: 1px solid var(--faint); padding: 0.25rem 0.8rem; text-align: left; vertical-align: top;
  overflow-wrap: anywhere; }
th.number, td.number { text-align: right; }
td.number { white-space: nowrap; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 33rem), 1fr)); gap: 1.5rem; }
.small { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 19rem), 1fr)); gap: 1rem; }
.card { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr)); gap: 1.5rem; align-items: start; }
.origin, .note, figcaption { font-size: 0.85em; overflow-wrap: anywhere; }
.warning { border: 2px solid #c04000; padding: 0.5rem 0.8rem; font-weight: bold; }
figure { margin: 0; max-width: 100%; break-inside: avoid; }
figure svg { max-width: 100%; height: auto; }
svg .paper { fill: var(--paper); } svg .ink { fill: var(--ink); }
svg .line { stroke: var(--ink); } svg .halo { stroke: var(--paper); }
@media print {
  body { margin: 0; max-width: none; padding: 0; font-size: 12px; line-height: 1.4; }
  h1 { font-size: 22px; margin: 0 0 4px; } h2 { font-size: 16px; margin-top: 14px; break-after: avoid; }
  th, td { padding: 1px 7px; } table { margin: 8px 0; } thead { display: table-header-group; }
  .wide { overflow: visible; } tr, figure, .card { break-inside: avoid; } caption { break-after: avoid; }
  .figures, .card { grid-template-columns: 1fr 1fr; gap: 14px; } .small { grid-template-columns: 1fr 1fr; gap: 12px; }
  section { break-before: page; } section:first-of-type, section.short { break-before: auto; }
  .short ul { break-inside: avoid; }
  section > figure { margin-bottom: 8px; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
";

impl LuxReport {
    /// The report as one page. It begins with what a client gets, on sheets of A4 in print: summary of room and results, luminaires, plan, requirements, assumptions, isolux lines and values of each
    /// area, other surfaces; then the appendix on the calculation: intervals, where the light went, the light that left the scene, and all facts.
    ///
    /// It needs no other file, no script and no network, and follows the reader's choice of light or dark; on paper it is dark on white.
    #[must_use]
    pub fn html(&self) -> String {
        let body = client_sections(self) + &section("Appendix: calculation", &self.appendix());
        page(&self.title, &sheet_style(&self.title, &origin(self)), &body)
    }

    /// What matters for the calculation alone.
    fn appendix(&self) -> String {
        let mut body = String::new();
        if let Some(plan) = &self.plan {
            body += &plan.fact_table().html();
        }
        if !self.maps.is_empty() {
            body += "<p class=\"note\">The tables below have the illuminance of the new installation.</p>\n";
            body += &(receivers(&self.maps).html() + &intervals(&self.maps).html());
        }
        if let Some(balance) = &self.balance {
            body += &flux(balance).html();
            body += &format!("<p>{}</p>\n", escaped(&closing(balance)));
        }
        body += &polars("Candela distributions", self);
        if !self.facts.is_empty() {
            body += &calculation(&self.facts).html();
        }
        body
    }
}

/// The size of sheets, with head and foot: title, origin and number of each sheet. Browsers that do not know margin boxes print without them.
fn sheet_style(title: &str, origin: &str) -> String {
    const FONT: &str = "font: 9px 'DejaVu Sans', Helvetica, Arial, sans-serif; color: #404040;";
    format!(
        "@page {{ size: A4; margin: 17mm 15mm 16mm;\n  @top-left {{ content: \"{}\"; {FONT} }}\n  @bottom-left {{ content: \"{}\"; {FONT} }}\n  \
         @bottom-right {{ content: \"Page \" counter(page) \" of \" counter(pages); {FONT} }} }}\n",
        quoted(&shortened(title, 90)),
        quoted(&shortened(origin, 110)),
    )
}

/// Words for a string of CSS inside HTML: characters that could end either are written by their numbers.
fn quoted(words: &str) -> String {
    let letter = |letter: char| match letter {
        ' ' => letter.to_string(),
        _ if letter.is_alphanumeric() => letter.to_string(),
        _ if letter.is_control() => "\u{fffd}".to_owned(),
        _ => format!("\\{:x} ", u32::from(letter)),
    };
    words.chars().map(letter).collect()
}

impl LuxComparison<'_> {
    /// Both designs as one page, of the same kind as [`LuxReport::html`]: the figures with their change, then for each
    /// receiver both maps with one scale and the same contours, and their difference where the cells are the same.
    #[must_use]
    pub fn html(&self) -> String {
        let titles = [("A", self.a), ("B", self.b)];
        let mut body = "<p>".to_owned();
        let named = titles.map(|(letter, report)| format!("{letter}: {}", escaped(&report.title)));
        body += &format!("{}</p>\n{}", named.join("<br>\n"), self.table().html());
        for pair in &self.pairs {
            body += &format!("<h2>{}</h2>\n", escaped(pair.name()));
            let [a, b] = pair.isolux();
            for ((letter, _), map) in titles.iter().zip([&a, &b]) {
                if map.is_none() {
                    body += &format!("<p>Design {letter} has no such receiver.</p>\n");
                }
            }
            body += &figures([a, b, pair.difference()].into_iter().flatten());
            if pair.a.zip(pair.b).is_some_and(|(a, b)| a.cells != b.cells) {
                body += "<p>The cells differ, so there is no map of the difference.</p>\n";
            }
        }
        for (letter, report) in titles {
            if let Some(balance) = &report.balance {
                let sentence = escaped(&closing(balance));
                body += &format!(
                    "<h2>Flux balance of {letter}</h2>\n{}<p>{sentence}</p>\n",
                    flux(balance).html()
                );
            }
            body += &polars(&format!("Candela distributions of {letter}"), report);
            if !report.facts.is_empty() {
                let table = calculation(&report.facts).html();
                body += &format!("<h2>Calculation of {letter}</h2>\n{table}");
            }
        }
        page(&format!("{} / {}", self.a.title, self.b.title), "", &body)
    }
}

fn page(title: &str, style: &str, body: &str) -> String {
    let title = escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}{style}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}</body>\n</html>\n"
    )
}

fn polars(heading: &str, report: &LuxReport) -> String {
    if report.polars.is_empty() {
        return String::new();
    }
    let figures = figures(report.polars.iter().map(PolarPlot::svg));
    let table = report.far_field.as_ref().map_or_else(String::new, |far| far_field(far).html());
    format!("<h2>{heading}</h2>\n{figures}{table}")
}

fn figures(drawings: impl Iterator<Item = String>) -> String {
    let figures: String = drawings.map(|svg| format!("<figure>\n{svg}</figure>\n")).collect();
    format!("<div class=\"figures\">\n{figures}</div>\n")
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::planning::PlanningSettings;
    use crate::{DaylightFactors, FluxBalance, LuxMap};
    use glanz_math::DVec3;
    use glanz_report::FactList;

    const NASTY: &str = "<script>alert('1')</script> & \"co\"";

    fn report(title: &str, cells: [u32; 2]) -> LuxReport {
        let map = LuxMap {
            name: NASTY.into(),
            cells,
            size: [2.0, 1.0],
            positions: vec![DVec3::ZERO; 4],
            areas: vec![0.5; 4],
            lux: vec![100.0, 200.0, 300.0, 400.0],
            errors: vec![1.0; 4],
            statistics: None,
        };
        let mut facts = FactList::default();
        facts.push(NASTY, "nasty", NASTY);
        LuxReport {
            title: title.into(),
            maps: vec![map],
            balance: Some(FluxBalance { emitted: 500.0, escaped: 500.0, ..FluxBalance::default() }),
            far_field: None,
            daylight: vec![DaylightFactors { name: NASTY.into(), mean: 0.5, median: 0.5, minimum: 0.5 }],
            plan: None,
            planning: PlanningSettings::default(),
            layout: None,
            facts,
            polars: vec![PolarPlot::sample(NASTY, 0.0, &[], |_, _| 1.0)],
        }
    }

    /// Names of elements without a closing or an opening tag.
    pub(in crate::report) fn unbalanced(html: &str) -> Vec<String> {
        let mut open = Vec::new();
        for tag in html.split('<').skip(1) {
            let (inner, _) = tag.split_once('>').unwrap();
            let name = inner.split_whitespace().next().unwrap_or_default().trim_end_matches('/');
            let is_void = ["!DOCTYPE", "meta", "br"].contains(&name) || inner.ends_with('/');
            match name.strip_prefix('/') {
                Some(closed) if open.last().map(String::as_str) == Some(closed) => _ = open.pop(),
                Some(_) => return vec![name.to_owned()],
                None if !is_void => open.push(name.to_owned()),
                None => {}
            }
        }
        open
    }

    #[test]
    fn pages_are_well_formed_and_names_are_escaped() {
        let (a, b) = (report(NASTY, [2, 2]), report("B", [2, 2]));
        for html in [a.html(), LuxComparison::between(&a, &b).html(), LuxReport::default().html()] {
            assert_eq!(unbalanced(&html), Vec::<String>::new());
            assert!(!html.contains("<script") && !html.contains("href") && !html.contains("src="));
            // The only address is the namespace of SVG, which is not fetched.
            assert_eq!(
                html.matches("http").count(),
                html.matches("xmlns=\"http://www.w3.org/2000/svg\"").count()
            );
            assert_eq!(html.matches("<svg ").count(), html.matches(" aria-label=\"").count());
        }
    }

    #[test]
    fn a_page_shows_every_map_and_table() {
        let html = report("office", [2, 2]).html();
        // Isolux lines, values, and a polar plot; room, daylight, results, receivers, intervals, flux and facts.
        assert_eq!((html.matches("<svg ").count(), html.matches("<table>").count()), (3, 7));
        assert!(html.contains("<td class=\"number\">250.0</td>"));
    }

    #[test]
    fn maps_with_different_cells_have_no_difference() {
        let (a, b) = (report("A", [2, 2]), report("B", [4, 1]));
        let alike = LuxComparison::between(&a, &a).html();
        let other = LuxComparison::between(&a, &b).html();
        // Two maps, two polar plots and the difference.
        assert_eq!((alike.matches("<svg ").count(), other.matches("<svg ").count()), (5, 4));
        assert!(other.contains("The cells differ") && !alike.contains("The cells differ"));
        let dark = LuxReport { maps: Vec::new(), ..b };
        assert!(LuxComparison::between(&a, &dark).html().contains("Design B has no such receiver"));
    }
}
