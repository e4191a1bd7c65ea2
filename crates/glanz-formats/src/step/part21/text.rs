//! Strings with their control directives.

use super::alphabets::ALPHABETS;

/// The text of a string, given without its outer quotes.
///
/// Line ends and other control characters are left out: they only wrap lines of the file. Bytes from 0x80 on are UTF-8 if they are valid
/// as such, else Latin-1. Directives that cannot be read remain as they are.
///
/// # Source
/// @iso10303-21 section 6.4.3.
pub(in crate::step) fn decode(bytes: &[u8]) -> String {
    let wide = bytes.iter().any(|b| *b >= 0x80);
    let raw = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) if wide => bytes.iter().copied().map(char::from).collect(),
        Err(_) => String::new(),
    };
    let mut text = String::with_capacity(raw.len());
    // ISO 8859-1.
    let mut alphabet = 0;
    let mut rest = raw.as_str();
    while let Some(next) = rest.chars().next() {
        if let Some((decoded, length)) = directive(rest, &mut alphabet) {
            text.push_str(&decoded);
            rest = rest.get(length..).unwrap_or_default();
            continue;
        }
        if rest.starts_with("''") {
            rest = rest.get(1..).unwrap_or_default();
        }
        if !next.is_control() {
            text.push(next);
        }
        rest = rest.get(next.len_utf8()..).unwrap_or_default();
    }
    text
}

/// The text of the control directive at the start of `rest`, with its number of bytes.
fn directive(rest: &str, alphabet: &mut usize) -> Option<(String, usize)> {
    let bytes = rest.as_bytes();
    let one = |c: char, length: usize| Some((c.to_string(), length));
    match bytes {
        [b'\\', b'\\', ..] => one('\\', 2),
        [b'\\', b'N', b'\\', ..] => one('\n', 3),
        [b'\\', b'F', b'\\', ..] => one('\n', 3),
        [b'\\', b'T', b'\\', ..] => one('\t', 3),
        [b'\\', b'P', page @ b'A'..=b'I', b'\\', ..] => {
            *alphabet = usize::from(page - b'A');
            Some((String::new(), 4))
        }
        [b'\\', b'S', b'\\', code @ 0x20..=0x7e, ..] => {
            let upper = match alphabet.checked_sub(1).and_then(|i| ALPHABETS.get(i)) {
                Some(table) => {
                    table.chars().nth(usize::from(code - 0x20)).unwrap_or(char::REPLACEMENT_CHARACTER)
                }
                None => char::from(code + 0x80),
            };
            // A quote as the code is doubled like any other.
            one(upper, if bytes.get(3..5) == Some(b"''") { 5 } else { 4 })
        }
        [b'\\', b'X', b'\\', ..] => {
            let code = *hexadecimal(bytes.get(3..5)?, 2)?.first()?;
            Some((visible(char::from_u32(code)), 5))
        }
        [b'\\', b'X', size @ (b'2' | b'4'), b'\\', ..] => {
            let is_inside = |b: &&u8| b.is_ascii_hexdigit() || b.is_ascii_whitespace();
            let run = bytes.iter().skip(4).take_while(is_inside).count();
            bytes.get(4 + run..)?.strip_prefix(b"\\X0\\")?;
            let digits = bytes.get(4..4 + run)?;
            Some((if *size == b'2' { utf16(digits)? } else { utf32(digits)? }, run + 8))
        }
        _ => None,
    }
}

/// Characters without those that control terminals.
fn visible(characters: impl IntoIterator<Item = char>) -> String {
    characters.into_iter().filter(|c| !c.is_control()).collect()
}

fn utf16(digits: &[u8]) -> Option<String> {
    let units = hexadecimal(digits, 4)?.into_iter().map(|unit| unit as u16);
    Some(visible(char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))))
}

fn utf32(digits: &[u8]) -> Option<String> {
    let codes = hexadecimal(digits, 8)?.into_iter();
    Some(visible(codes.map(|code| char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER))))
}

/// Numbers of `size` digits each. Lines may be wrapped inside.
fn hexadecimal(digits: &[u8], size: usize) -> Option<Vec<u32>> {
    let digits: Vec<u8> = digits.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
    if !digits.len().is_multiple_of(size) {
        return None;
    }
    let digit = |number: u32, b: &u8| Some(number << 4 | char::from(*b).to_digit(16)?);
    digits.chunks_exact(size).map(|chunk| chunk.iter().try_fold(0, digit)).collect()
}
