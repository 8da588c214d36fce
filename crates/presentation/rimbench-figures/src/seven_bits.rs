//! Bytes in the text of a page.

/// Writes bytes as text for a script of the page, seven bits a letter, a sixth shorter than base64. The letters that
/// HTML would change or take for the beginning of a tag stand 128 further on, where UTF-8 takes two bytes for them.
pub fn seven_bits(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len() * 6 / 5);
    let (mut held, mut bits) = (0_u32, 0);
    // A last letter takes what is left, filled up with zeros.
    for byte in bytes.iter().copied().map(Some).chain([None]) {
        match byte {
            Some(byte) => (held, bits) = (held << 8 | u32::from(byte), bits + 8),
            None if bits > 0 => (held, bits) = (held << (7 - bits), 7),
            None => {}
        }
        while bits >= 7 {
            bits -= 7;
            let letter = (held >> bits & 127) as u8;
            let shifted = matches!(letter, 0 | b'\r' | b'<');
            text.push(char::from(if shifted { letter + 128 } else { letter }));
        }
        held &= 0x7f;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_from_their_letters_and_none_of_those_means_anything_in_html() {
        for count in 0..300 {
            let bytes: Vec<u8> = (0..count).map(|k| (k * 89 + count * 7) as u8).collect();
            let text = seven_bits(&bytes);
            assert!(!text.contains(['\0', '\r', '<']));
            // As `common.js` reads them.
            let (mut back, mut held, mut bits) = (Vec::new(), 0_u32, 0);
            for letter in text.chars() {
                (held, bits) = (held << 7 | u32::from(letter) & 127, bits + 7);
                if bits >= 8 {
                    bits -= 8;
                    back.push((held >> bits) as u8);
                    held &= 0x7f;
                }
            }
            assert_eq!(back, bytes);
        }
    }
}
