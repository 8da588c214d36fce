//! The display list every figure ends in: filled and stroked paths and lines of text on a white page.
//!
//! Lengths are pixels of the SVG (96 per inch), x to the right, y downwards, as floats: a curve keeps its sub-pixel
//! shape until `paint` hands it to plotters. All colours are opaque; a lighter one is mixed with white beforehand, so
//! that grey-scale printing and old viewers agree.

use super::font;
pub use super::font::Weight;

/// Size of words on what is shown, and the height of their lines, px.
const NOTE_SIZE: f64 = 9.4;
const NOTE_LINE: f64 = 14.0;
/// Size of a title, and the height of its lines, px.
const HEADING_SIZE: f64 = 12.4;
const HEADING_LINE: f64 = 17.0;
/// Room beside words, px.
const BESIDE: f64 = 8.0;

/// A position on the page, px.
pub type Point = (f64, f64);

/// An opaque sRGB colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Color(pub u8, pub u8, pub u8);

impl Color {
    /// Paper.
    pub const WHITE: Color = Color(255, 255, 255);
    /// Text.
    pub const INK: Color = Color(0x22, 0x26, 0x2B);
    /// Secondary text, frames and ticks.
    pub const SOFT_INK: Color = Color(0x5B, 0x62, 0x6A);
    /// Grid lines.
    pub const GRID: Color = Color(0xE4, 0xE7, 0xEA);

    /// Mixes `share` ∈ [0, 1] of `other` into this colour.
    pub fn mix(self, other: Color, share: f64) -> Color {
        let part = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * share).round() as u8;
        Color(part(self.0, other.0), part(self.1, other.1), part(self.2, other.2))
    }

    /// Writes it as style sheets have it.
    pub fn hex(self) -> String {
        format!("#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}

/// Lengths of dashes and gaps in px; empty for a solid line.
pub type DashPattern = &'static [f64];

/// How a path is outlined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Colour of the line.
    pub color: Color,
    /// Width, px.
    pub width: f64,
    /// Dash pattern.
    pub dash: DashPattern,
}

impl Stroke {
    /// A solid line.
    pub fn solid(color: Color, width: f64) -> Self {
        Stroke { color, width, dash: &[] }
    }
}

/// Which point of a text sits at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The first letter.
    Start,
    /// The middle.
    Middle,
    /// The last letter.
    End,
}

/// One line of text.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    /// Position of the anchor, on the baseline.
    pub at: Point,
    /// The letters.
    pub content: String,
    /// Font size (em), px.
    pub size: f64,
    /// Colour of the letters.
    pub color: Color,
    /// Weight of the letters.
    pub weight: Weight,
    /// Horizontal alignment.
    pub anchor: Anchor,
    /// Reads upwards, as the label of a y axis does.
    pub upwards: bool,
}

impl Text {
    /// A line of regular ink starting at `at`; change it with the methods below.
    pub fn new(content: impl Into<String>, at: Point, size: f64) -> Self {
        let (weight, anchor) = (Weight::Regular, Anchor::Start);
        Text { at, content: content.into(), size, color: Color::INK, weight, anchor, upwards: false }
    }

    /// Sets the alignment.
    pub fn anchored(mut self, anchor: Anchor) -> Self {
        self.anchor = anchor;
        self
    }

    /// Sets the colour.
    pub fn colored(mut self, color: Color) -> Self {
        self.color = color;
        self
    }

    /// Makes it semi-bold.
    pub fn bold(mut self) -> Self {
        self.weight = Weight::Bold;
        self
    }

    /// Moves the baseline so that capitals are centred on the given position.
    pub fn centred(mut self) -> Self {
        let shift = 0.5 * font::CAP_HEIGHT * self.size;
        if self.upwards {
            self.at.0 += shift
        } else {
            self.at.1 += shift
        }
        self
    }

    /// Turns it by 90° to read upwards.
    pub fn upwards(mut self) -> Self {
        self.upwards = true;
        self
    }

    /// Width in px.
    pub fn width(&self) -> f64 {
        font::width(&self.content, self.size, self.weight)
    }

    /// Breaks it into lines that have room in every typeface, px.
    pub fn broken(&self, room: f64) -> Vec<Text> {
        let mut lines: Vec<Text> = Vec::new();
        for word in self.content.split_whitespace() {
            let with = |content: String| Text { content, ..self.clone() };
            let longer = lines.last().map(|line| with(format!("{} {word}", line.content)));
            match (longer, lines.last_mut()) {
                (Some(longer), Some(line)) if font::WIDER * longer.width() <= room => *line = longer,
                _ => lines.push(with(word.to_owned())),
            }
        }
        lines
    }

    /// Distance from the first letter to the anchor.
    pub fn lead(&self) -> f64 {
        match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5 * self.width(),
            Anchor::End => self.width(),
        }
    }
}

/// One element of a drawing.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A polyline or polygon.
    Path {
        /// Corners.
        points: Vec<Point>,
        /// Whether the last corner joins the first.
        closed: bool,
        /// Colour of the interior.
        fill: Option<Color>,
        /// Outline.
        stroke: Option<Stroke>,
    },
    /// A round disc.
    Disc {
        /// Its centre.
        centre: Point,
        /// Its radius, px.
        radius: f64,
        /// Colour of the interior.
        fill: Option<Color>,
        /// Outline.
        stroke: Option<Stroke>,
    },
    /// A line of text.
    Text(Text),
    /// What follows, up to its [`Close`](Shape::Close), is one part of this class, with what a script is told of it.
    Open(&'static str, String),
    /// The end of a part.
    Close,
}

/// A datum as it was, and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Datum {
    /// Abscissa.
    pub x: f64,
    /// Ordinate; NaN where runs were lost.
    pub y: f64,
    /// From the least to the largest value, where one is known.
    pub range: Option<[f64; 2]>,
    /// What else is known of it; may be empty.
    pub note: String,
    /// Its place on the page, if it has one there.
    pub at: Option<Point>,
}

/// The data of one series, exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesData {
    /// Its name: that of the group in the picture.
    pub name: String,
    /// Its points.
    pub points: Vec<Datum>,
}

/// The data of one panel, exactly, for tables and for exact values on hover.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PanelData {
    /// Heading.
    pub title: String,
    /// Quantity across.
    pub x: String,
    /// Quantity upwards.
    pub y: String,
    /// The series.
    pub series: Vec<SeriesData>,
}

/// A page with everything on it, back to front.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Width, px.
    pub width: f64,
    /// Height, px.
    pub height: f64,
    /// What a screen reader says; the SVG's title. May be empty.
    pub title: String,
    /// What is shown, in a sentence or two; the SVG's description.
    pub description: String,
    /// Shapes, back to front.
    pub shapes: Vec<Shape>,
    /// The data behind the shapes, panel by panel; a picture of bodies has none.
    pub data: Vec<PanelData>,
}

impl Drawing {
    /// Starts an empty white page.
    pub fn new(width: f64, height: f64) -> Self {
        Drawing {
            width,
            height,
            title: String::new(),
            description: String::new(),
            shapes: Vec::new(),
            data: Vec::new(),
        }
    }

    /// Adds lines of words below everything else, as many as the width asks for, and the height that they need. No
    /// words add nothing.
    pub fn noted(mut self, words: &str) -> Self {
        let text = Text::new(words, (0.5 * self.width, 0.0), NOTE_SIZE).anchored(Anchor::Middle);
        for line in text.broken(self.width - 2.0 * BESIDE) {
            self.height += NOTE_LINE;
            self.text(Text { at: (line.at.0, self.height - BESIDE), ..line.colored(Color::SOFT_INK) });
        }
        self
    }

    /// Adds a title and words on what is shown above everything else, in as many lines as the width asks for, and the
    /// height that they need. The picture is named by its title, and described by the words.
    pub fn headed(mut self, title: &str, words: &str) -> Self {
        let room = self.width - 2.0 * BESIDE;
        let title_lines = Text::new(title, (BESIDE, 0.0), HEADING_SIZE).bold().broken(room);
        let word_lines = Text::new(words, (BESIDE, 0.0), NOTE_SIZE).colored(Color::SOFT_INK).broken(room);
        let (mut y, mut lines) = (BESIDE - 3.0, Vec::new());
        for (line, height) in title_lines
            .into_iter()
            .map(|line| (line, HEADING_LINE))
            .chain(word_lines.into_iter().map(|line| (line, NOTE_LINE)))
        {
            y += height;
            lines.push(Text { at: (BESIDE, y - 2.5), ..line });
        }
        if lines.is_empty() {
            return self;
        }
        self.move_down(y + 3.0);
        lines.into_iter().for_each(|line| self.text(line));
        (self.title, self.description) = (title.to_owned(), words.to_owned());
        self
    }

    /// Moves all there is down on a page that becomes as much higher.
    fn move_down(&mut self, by: f64) {
        self.height += by;
        for shape in &mut self.shapes {
            match shape {
                Shape::Path { points, .. } => points.iter_mut().for_each(|point| point.1 += by),
                Shape::Disc { centre, .. } => centre.1 += by,
                Shape::Text(text) => text.at.1 += by,
                Shape::Open(..) | Shape::Close => {}
            }
        }
        let series = self.data.iter_mut().flat_map(|panel| &mut panel.series);
        let points = series.flat_map(|series| &mut series.points);
        points.filter_map(|point| point.at.as_mut()).for_each(|at| at.1 += by);
    }

    /// Adds an open line. Fewer than two points add nothing.
    pub fn line(&mut self, points: Vec<Point>, stroke: Stroke) {
        if points.len() > 1 {
            self.shapes.push(Shape::Path { points, closed: false, fill: None, stroke: Some(stroke) });
        }
    }

    /// Adds a closed area.
    pub fn area(&mut self, points: Vec<Point>, fill: Option<Color>, stroke: Option<Stroke>) {
        if points.len() > 2 {
            self.shapes.push(Shape::Path { points, closed: true, fill, stroke });
        }
    }

    /// Adds a disc of the given centre and radius.
    pub fn disc(&mut self, centre: Point, radius: f64, fill: Option<Color>, stroke: Option<Stroke>) {
        self.shapes.push(Shape::Disc { centre, radius, fill, stroke });
    }

    /// Adds what belongs to one series; a script finds it by its name.
    pub fn group(&mut self, name: &str, draw: impl FnOnce(&mut Drawing)) {
        self.part("series", name, draw);
    }

    /// Adds a part that a script finds by its class, and what that is told of it.
    pub fn part(&mut self, class: &'static str, told: &str, draw: impl FnOnce(&mut Drawing)) {
        self.shapes.push(Shape::Open(class, told.to_owned()));
        draw(self);
        self.shapes.push(Shape::Close);
    }

    /// Adds a line of text.
    pub fn text(&mut self, text: Text) {
        if !text.content.is_empty() {
            self.shapes.push(Shape::Text(text));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_stands_above_and_moves_shapes_and_data() {
        let mut drawing = Drawing::new(200.0, 100.0);
        drawing.disc((5.0, 1.0), 1.0, None, None);
        let datum = Datum { x: 1.0, y: 1.0, range: None, note: String::new(), at: Some((5.0, 1.0)) };
        let series = vec![SeriesData { name: String::new(), points: vec![datum] }];
        drawing.data = vec![PanelData { series, ..PanelData::default() }];
        let headed = drawing.headed("The finding", "what is shown, in words that do not fit on one line of this page");
        let by = headed.height - 100.0;
        assert!(by > 17.0 + 2.0 * NOTE_LINE, "{by}");
        assert!(matches!(headed.shapes[0], Shape::Disc { centre: (_, y), .. } if y == 1.0 + by));
        assert_eq!(headed.data[0].series[0].points[0].at, Some((5.0, 1.0 + by)));
        assert!(headed.title == "The finding" && headed.description.starts_with("what is shown"));
        // Words below have room of their own as well.
        let noted = headed.clone().noted("2 more cases are not drawn: they are in runs.csv, and nowhere else");
        let fits =
            |shape: &Shape| !matches!(shape, Shape::Text(text) if text.width() > 184.0 || text.at.1 >= noted.height);
        assert!(noted.height >= headed.height + 2.0 * NOTE_LINE && noted.shapes.iter().all(fits));
    }
}
