//! Facts about a computation: words for people, typed values for programs.

use serde::ser::{Serialize, SerializeMap, Serializer};

use crate::number::{duration, grouped, significant};
use crate::table::{Table, TableCell, printable};

/// A fact: its names and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// Name for people.
    pub name: &'static str,
    /// Name for programs, which ends with the unit: `cell_m`, `goal_seconds`.
    pub key: &'static str,
    /// The value.
    pub value: FactValue,
}

/// The value of a fact.
#[derive(Clone, Debug, PartialEq)]
pub enum FactValue {
    /// Words.
    Text(String),
    /// Whether something holds.
    Flag(bool),
    /// A number of things, whose digits people read in groups.
    Count(u64),
    /// A whole number that counts nothing: a seed.
    Whole(u64),
    /// A number in the unit of the key.
    Number(f64),
    /// A fraction of 1, which people read in per cent.
    Fraction(f64),
    /// A time, seconds.
    Seconds(f64),
    /// Lengths along x, y and z, metres.
    Lengths([f64; 3]),
}

impl From<&str> for FactValue {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for FactValue {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<bool> for FactValue {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl From<u64> for FactValue {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<f64> for FactValue {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl FactValue {
    /// The value as people read it.
    #[must_use]
    pub fn shown(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Flag(flag) => if *flag { "yes" } else { "no" }.to_owned(),
            Self::Count(count) => grouped(*count),
            Self::Whole(number) => number.to_string(),
            Self::Number(number) => significant(*number),
            Self::Fraction(fraction) => format!("{} %", significant(100.0 * fraction)),
            Self::Seconds(seconds) => duration(*seconds),
            Self::Lengths([x, y, z]) => format!("{x} x {y} x {z} m"),
        }
    }
}

/// Numbers are numbers; those that are not finite, which JSON cannot represent, are null.
impl Serialize for FactValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) => serializer.serialize_str(text),
            Self::Flag(flag) => serializer.serialize_bool(*flag),
            Self::Count(number) | Self::Whole(number) => serializer.serialize_u64(*number),
            Self::Number(number) | Self::Fraction(number) | Self::Seconds(number) => {
                number.is_finite().then_some(*number).serialize(serializer)
            }
            Self::Lengths(lengths) => lengths.serialize(serializer),
        }
    }
}

/// Facts in the order of a report, each key once; in JSON an object of their values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FactList(Vec<Fact>);

impl FactList {
    /// Adds a fact at the end, in place of one with the same key.
    pub fn push(&mut self, name: &'static str, key: &'static str, value: impl Into<FactValue>) {
        self.0.retain(|fact| fact.key != key);
        self.0.push(Fact { name, key, value: value.into() });
    }

    /// The value of a key.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&FactValue> {
        self.0.iter().find(|fact| fact.key == key).map(|fact| &fact.value)
    }

    /// The facts whose keys `is_shown` accepts, as a table of two columns with this name, caption, and title of the first column.
    #[must_use]
    pub fn table(
        &self,
        name: &'static str,
        caption: &str,
        title: &'static str,
        is_shown: impl Fn(&str) -> bool,
    ) -> Table {
        let mut table = Table::new(name, caption, &[("fact", title), ("value", "")]);
        for fact in self.iter().filter(|fact| is_shown(fact.key)) {
            table.push([fact.name.into(), TableCell::Text(printable(&fact.value.shown()))]);
        }
        table
    }

    /// The facts in their order.
    pub fn iter(&self) -> impl Iterator<Item = &Fact> {
        self.0.iter()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds all facts of another list, as [`FactList::push`] does.
    pub fn append(&mut self, other: Self) {
        other.0.into_iter().for_each(|Fact { name, key, value }| self.push(name, key, value));
    }
}

impl Serialize for FactList {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        self.0.iter().try_for_each(|fact| map.serialize_entry(fact.key, &fact.value))?;
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_get_values_of_their_types_and_people_words() {
        let mut facts = FactList::default();
        facts.push("method", "method", "trace");
        facts.push("far field", "far_field", true);
        facts.push("particles", "particles", 1_234_567_u64);
        facts.push("seed", "seed", FactValue::Whole(u64::MAX));
        facts.push("particles per second", "particles_per_second", 123_456.789);
        facts.push("relative error", "relative_error", FactValue::Fraction(1e-6));
        facts.push("time", "seconds", FactValue::Seconds(245.25));
        facts.push("room", "room_m", FactValue::Lengths([10.0, 4.5, 3.0]));
        facts.push("pace", "pace", f64::INFINITY);
        let json = serde_json::json!({
            "method": "trace", "far_field": true, "particles": 1_234_567, "seed": u64::MAX,
            "particles_per_second": 123_456.789, "relative_error": 1e-6, "seconds": 245.25, "room_m": [10.0, 4.5, 3.0],
            "pace": null,
        });
        assert_eq!(serde_json::to_value(&facts).unwrap(), json);
        let shown: Vec<String> = facts.iter().map(|fact| fact.value.shown()).collect();
        assert_eq!(
            shown,
            [
                "trace",
                "yes",
                "1 234 567",
                "18446744073709551615",
                "123457",
                "1.00e-4 %",
                "4 min 05 s",
                "10 x 4.5 x 3 m",
                "inf"
            ]
        );
    }

    #[test]
    fn a_key_occurs_once() {
        let (mut facts, mut more) = (FactList::default(), FactList::default());
        facts.push("seed", "seed", FactValue::Whole(1));
        facts.push("method", "method", "trace");
        more.push("seed", "seed", FactValue::Whole(2));
        facts.append(more);
        assert_eq!(facts.iter().map(|fact| fact.key).collect::<Vec<_>>(), ["method", "seed"]);
        assert_eq!(facts.get("seed"), Some(&FactValue::Whole(2)));
        assert_eq!(facts.get("threads"), None);
    }
}
