//! Colours of light and dark pages.

use crate::drawing::Color;

/// Page that the picture stands on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Page {
    /// White.
    Light,
    /// Nearly black.
    Dark,
}

/// Colours of a page.
pub(super) struct Palette {
    pub(super) paper: Color,
    pub(super) ink: Color,
    pub(super) soft: Color,
    pub(super) ground: Color,
    pub(super) ledge: Color,
    pub(super) metal: Color,
    pub(super) force: Color,
}

impl Page {
    /// What its file name ends in.
    pub fn name(self) -> &'static str {
        match self {
            Page::Light => "light",
            Page::Dark => "dark",
        }
    }

    pub(super) fn palette(self) -> Palette {
        match self {
            Page::Light => Palette {
                paper: Color::WHITE,
                ink: Color::INK,
                soft: Color::SOFT_INK,
                ground: Color(0xEE, 0xF0, 0xF2),
                ledge: Color(0xD3, 0xD8, 0xDD),
                metal: Color(0xF4, 0xF6, 0xF8),
                force: Color(0x7A, 0x1F, 0x7A),
            },
            Page::Dark => Palette {
                paper: Color(0x0D, 0x11, 0x17),
                ink: Color(0xE6, 0xE9, 0xED),
                soft: Color(0xA3, 0xAA, 0xB3),
                ground: Color(0x1C, 0x21, 0x29),
                ledge: Color(0x36, 0x3D, 0x47),
                metal: Color(0x26, 0x2C, 0x35),
                force: Color(0xE3, 0x8F, 0xE3),
            },
        }
    }

    /// A scheme's colour on it.
    pub(super) fn of(self, color: Color) -> Color {
        match self {
            Page::Light => color,
            Page::Dark => color.mix(Color::WHITE, 0.35),
        }
    }
}
