//! Numbers that shaders and this crate share.

/// The number that `glsl/shared.h` defines for `name`; call it in a `const`, so that a missing name does not compile.
///
/// # Panics
/// If the header has no line `#define name NUMBER`, with a whole number in decimal digits.
pub const fn shared(name: &str) -> u32 {
    match find(name) {
        Some(number) => number,
        None => panic!("shared.h does not define this name"),
    }
}

/// The same; `None` if there is no such line.
pub(super) const fn find(name: &str) -> Option<u32> {
    let (text, name) = (include_str!("../../../glsl/shared.h").as_bytes(), name.as_bytes());
    let mut line = 0;
    while line < text.len() {
        if let Some(at) = skip(text, line, b"#define ")
            && let Some(at) = skip(text, at, name)
            && let Some(mut at) = skip(text, at, b" ")
        {
            let mut number = 0;
            assert!(at < text.len() && text[at].is_ascii_digit(), "shared.h: not a number");
            while at < text.len() && text[at].is_ascii_digit() {
                number = number * 10 + (text[at] - b'0') as u32;
                at += 1;
            }
            assert!(
                at == text.len() || text[at].is_ascii_whitespace(),
                "shared.h: not a whole decimal number"
            );
            return Some(number);
        }
        while line < text.len() && text[line] != b'\n' {
            line += 1;
        }
        line += 1;
    }
    None
}

/// All names that `glsl/shared.h` defines with this prefix, without it, and their numbers.
pub fn shared_names(prefix: &str) -> impl Iterator<Item = (&'static str, u32)> + '_ {
    let defined = include_str!("../../../glsl/shared.h").lines().filter_map(|l| l.strip_prefix("#define "));
    defined.filter_map(move |line| {
        let (name, number) = line.strip_prefix(prefix)?.split_once(' ')?;
        Some((name, number.parse().ok()?))
    })
}

/// Where `text` goes on after `prefix` at `at`.
const fn skip(text: &[u8], at: usize, prefix: &[u8]) -> Option<usize> {
    let mut i = 0;
    while i < prefix.len() {
        if at + i >= text.len() || text[at + i] != prefix[i] {
            return None;
        }
        i += 1;
    }
    Some(at + i)
}
