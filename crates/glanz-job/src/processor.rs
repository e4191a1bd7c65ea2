//! Name of the processor.

/// Name of the processor as its maker writes it, if the system tells it: Linux on x86, and Windows.
#[must_use]
pub fn processor_name() -> Option<String> {
    let listed = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| model_name(&text));
    listed.or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok())
}

/// The value of the first line `model name : VALUE` with single blanks; `None` for one without a name.
fn model_name(text: &str) -> Option<String> {
    let (_, value) =
        text.lines().filter_map(|line| line.split_once(':')).find(|(key, _)| key.trim() == "model name")?;
    let name = value.split_whitespace().collect::<Vec<_>>().join(" ");
    (!name.is_empty() && name != "unknown").then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_is_that_of_the_first_processor() {
        let text = "processor\t: 0\nvendor_id\t: A\nmodel\t\t: 6\nmodel name\t: Maker(R)  Core:  2.40GHz\nprocessor\t: 1\nmodel name\t: B\n";
        assert_eq!(model_name(text).as_deref(), Some("Maker(R) Core: 2.40GHz"));
        for nameless in ["", "model\t: 6\n", "model name\t: \n", "model name\t: unknown\n"] {
            assert_eq!(model_name(nameless), None, "{nameless:?}");
        }
    }
}
