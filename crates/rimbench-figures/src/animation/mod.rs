//! A case in motion, as an SVG that a page embeds like any image: movement by CSS alone, no script, one file for light and
//! one for dark pages. Readers who ask for less motion get the decisive instant as a still.
//!
//! | file | concept |
//! |---|---|
//! | here | what is shown, and where on the page |
//! | `palette` | light and dark pages |
//! | `timing` | when an instant is shown; the rules that move a part |
//! | `scene` | the case with one scheme, and the reference as a thin outline |
//! | `curves` | the force over time, and the key |
//! | `path` | corners and curves as the data of a path |

mod curves;
mod palette;
mod path;
mod scene;
mod timing;

pub use palette::Page;
pub use timing::Timing;

use super::case_picture::Motion;
use super::drawing::Color;
use super::vector::escaped;
use curves::{CHART, KEY};
use rimbench_cases::cases::Drawing as CaseDrawing;
use rimbench_core::error::Result;
use scene::Stage;

/// One scheme in motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Moving {
    /// What stands above it.
    pub label: String,
    /// What came of it in two or three words; nothing if empty.
    pub verdict: String,
    /// Its colour.
    pub color: Color,
    /// How it moves.
    pub motion: Motion,
}

/// A curve below the drawings.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its colour; none is that of the page's ink.
    pub color: Option<Color>,
    /// Time, s, and force, N.
    pub points: Vec<(f64, f64)>,
}

/// The whole picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// What a screen reader says.
    pub title: String,
    /// What the case looks like.
    pub of: CaseDrawing,
    /// How the reference moves.
    pub reference: Motion,
    /// By how much differences from the reference are larger than they are.
    pub enlarged: f64,
    /// When what is shown.
    pub timing: Timing,
    /// Schemes, side by side.
    pub schemes: Vec<Moving>,
    /// Curves, the first at the back.
    pub curves: Vec<Curve>,
    /// Interval of the force shown, N.
    pub force_n: [f64; 2],
}

const WIDTH: f64 = 760.0;
const MARGIN: f64 = 8.0;
const HEADER: f64 = 24.0;

impl Animation {
    /// Writes the picture for one kind of page.
    ///
    /// # Errors
    /// [`Error::Incompatible`](rimbench_core::error::Error::Incompatible) for a shape between two frames that both move, other than a cylinder.
    pub fn svg(&self, page: Page) -> Result<String> {
        let palette = page.palette();
        let cell = (WIDTH - 2.0 * MARGIN - 12.0) / 2.0;
        let [[from, to], [low, high]] = self.of.view;
        let scale = cell / (to - from);
        let (top, drawing) = (HEADER, (high - low) * scale);
        let chart = top + drawing + 26.0;
        let height = chart + CHART + 20.0 + KEY;
        let (mut style, mut body) = (String::new(), String::new());
        for (index, scheme) in self.schemes.iter().take(2).enumerate() {
            let left = MARGIN + index as f64 * (cell + 12.0);
            let stage = Stage { left, top, cell, drawing, scale, page, index };
            self.scheme(&stage, scheme, &palette, &mut style, &mut body)?;
        }
        self.chart(chart, page, &palette, &mut style, &mut body);
        self.key(chart + CHART + 20.0 + 0.4 * KEY, page, &palette, &mut body);
        Ok(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height:.0}\" viewBox=\"0 0 {WIDTH} {height:.0}\" role=\"img\" \
             font-family=\"sans-serif\" font-size=\"12\" stroke-linejoin=\"round\">\n<title>{}</title>\n<style>{style}</style>\n\
             <rect width=\"{WIDTH}\" height=\"{height:.0}\" rx=\"6\" fill=\"{}\"/>\n{body}</svg>\n",
            escaped(&self.title),
            palette.paper.hex(),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_cases::cases::standard_cases;

    fn animation() -> Animation {
        let case = standard_cases().into_iter().find(|case| case.name == "wedge-box").unwrap();
        let of = (case.drawing)(&case.default_parameters()).unwrap();
        let times_s: Vec<f64> = (0..=400).map(|k| f64::from(k) * 5e-3).collect();
        let value = |column: &str, t: f64| match column {
            "box_x_m" => 0.3 * t,
            "box_y_m" => 0.4 + if t > 1.7 { 4e-3 } else { 0.0 },
            _ => 0.0,
        };
        let all = |column: &'static str| (column, times_s.iter().map(|&t| value(column, t)).collect::<Vec<_>>());
        let columns = of.columns().into_iter().map(all).collect();
        let motion = Motion { follow: times_s.iter().map(|t| 0.3 * t).collect(), columns, times_s: times_s.clone() };
        let scheme = |label: &str| Moving {
            label: label.to_owned(),
            verdict: "lifts off 4 mm".to_owned(),
            color: Color(200, 80, 0),
            motion: motion.clone(),
        };
        Animation {
            title: "a < b".to_owned(),
            of,
            reference: motion.clone(),
            enlarged: 12.0,
            timing: Timing { shown_s: [1.0, 2.0], slow_s: [1.6, 1.8], still_s: 1.75 },
            schemes: vec![scheme("one"), scheme("two")],
            curves: vec![Curve { color: None, points: times_s.iter().map(|&t| (t, 100.0)).collect() }],
            force_n: [-2000.0, 2000.0],
        }
    }

    #[test]
    fn it_moves_without_a_script_stands_still_for_those_who_ask_and_asks_for_no_other_file() {
        for page in [Page::Light, Page::Dark] {
            let svg = animation().svg(page).unwrap();
            assert!(svg.contains("<title>a &lt; b</title>") && !svg.contains("<script") && !svg.contains("href"));
            assert_eq!(svg.matches(">lifts off 4 mm</text>").count(), 2);
            assert!(!svg.contains("NaN") && !svg.contains("inf,"), "{svg}");
            // Nothing moves but where motion is welcome, and the still is the state that everything else starts from.
            let rules = svg.matches("@keyframes").count();
            assert!(
                rules > 6 && svg.matches("@media(prefers-reduced-motion:no-preference)").count() == rules,
                "{rules}"
            );
            assert_eq!(svg.matches("animation:").count(), rules);
        }
        assert_ne!(animation().svg(Page::Light).unwrap(), animation().svg(Page::Dark).unwrap());
    }

    #[test]
    fn bodies_lie_where_they_belong_without_a_style_sheet_as_well() {
        let svg = animation().svg(Page::Light).unwrap();
        let moving: Vec<&str> = svg.split("<g class=").skip(1).filter_map(|rest| rest.split('>').next()).collect();
        assert!(moving.len() > 6 && moving.iter().all(|group| group.contains(" transform=\"translate(")), "{moving:?}");
        // What an attribute does not understand is not drawn at all.
        let attributes = svg.split(" transform=\"").skip(1).filter_map(|rest| rest.split('"').next());
        assert!(attributes.into_iter().all(|value| !value.contains("px") && !value.contains("deg")));
    }

    #[test]
    fn a_key_says_what_curves_and_arrows_are_and_what_is_cut_off() {
        let mut animation = animation();
        let svg = animation.svg(Page::Light).unwrap();
        assert!(svg.contains(">reference</text>") && svg.contains(">one</text>") && !svg.contains("cut off"));
        animation.curves[0].points[300].1 = -31_200.0;
        let svg = animation.svg(Page::Dark).unwrap();
        assert!(svg.contains("cut off at ±2 kN: the largest is 31 kN") && svg.contains(">contact force</text>"));
    }
}
