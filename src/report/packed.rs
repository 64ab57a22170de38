//! Binary encoding of arrays for the page: little-endian integers in base64, described by JSON.

use base64::prelude::{BASE64_STANDARD, Engine};
use serde_json::{Value, json};

/// Quantises numbers to 16-bit integers times `scale`; the error is at most `scale / 2`, 1.6e-5 of the largest
/// magnitude.
pub fn numbers(shape: &[usize], values: &[f64]) -> Value {
    debug_assert_eq!(shape.iter().product::<usize>(), values.len());
    let largest = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let scale = if largest > 0.0 { largest / f64::from(i16::MAX) } else { 1.0 };
    let bytes: Vec<u8> = values.iter().flat_map(|v| ((v / scale).round() as i16).to_le_bytes()).collect();
    json!({ "type": "i16", "shape": shape, "scale": scale, "base64": base64(&bytes) })
}

/// Packs unsigned integers, 16 bits each if they fit, otherwise 32.
pub fn indices(shape: &[usize], values: &[u32]) -> Value {
    debug_assert_eq!(shape.iter().product::<usize>(), values.len());
    let short: Option<Vec<u16>> = values.iter().map(|v| u16::try_from(*v).ok()).collect();
    let (name, bytes): (_, Vec<u8>) = match short {
        Some(short) => ("u16", short.iter().flat_map(|v| v.to_le_bytes()).collect()),
        None => ("u32", values.iter().flat_map(|v| v.to_le_bytes()).collect()),
    };
    json!({ "type": name, "shape": shape, "base64": base64(&bytes) })
}

/// Encodes bytes in base64.
pub fn base64(bytes: &[u8]) -> String {
    BASE64_STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_the_nearest_step_and_indices_take_what_they_need() {
        let packed = numbers(&[3], &[-0.5, 0.25, 0.0]);
        // -32767, 16384 (16383.5 rounded away from zero), 0.
        assert_eq!(packed["base64"], base64(&[0x01, 0x80, 0x00, 0x40, 0, 0]));
        assert_eq!(packed["scale"], 0.5 / 32767.0);
        assert_eq!(numbers(&[1], &[0.0])["scale"], 1.0);
        assert_eq!(indices(&[2], &[1, 65535])["type"], "u16");
        assert_eq!(indices(&[2], &[1, 65536])["type"], "u32");
    }
}
