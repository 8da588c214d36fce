//! Draws the points of a series inside a frame: clipped, broken at NaN, with infinite values in a band above.

use super::chart::{Mode, Series};
use super::clip::{self, Rect};
use super::drawing::{Anchor, Color, Datum, Drawing, Point, SeriesData, Stroke, Text, Weight};
use super::line_style::{LineStyle, Marker};
use super::scale::AxisMap;
use super::{font, marker};

/// Least height of the band for infinite values and lost runs above an axis, px.
pub const BAND: f64 = 22.0;
/// Height of a row of signs in a band with a row for each series, px.
const LOSS_ROW: f64 = 6.6;
/// Signs closer than this lie on each other, px.
const TOUCHING: f64 = 2.2;
/// By how much a sign is larger for each one that lies on it, and for how many.
const NESTED: (f64, usize) = (0.33, 3);
/// Of a series with more points than this signs are too close to show around each other.
const FEW: usize = 20;
/// Size of what is written beside a point, px.
const TAG_SIZE: f64 = 9.4;
/// Half size of a marker, px.
pub const MARKER: f64 = 2.9;
/// Width of the bars at a median, px.
const BAR: f64 = 0.7;
/// Distance of the signs on lines of steps per series, px.
const STEP_SIGNS: f64 = 10.0;
/// Least distance of the triangles in the band, px.
const TRIANGLE_DISTANCE: f64 = 12.0;
/// Beyond this many points a line's markers are thinned to one per …
const MANY: usize = 60;
/// … this distance, px.
const MARKER_DISTANCE: f64 = 32.0;

/// A plotting area with its axes.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// Where values inside the axes' intervals lie.
    pub area: Rect,
    /// Height of the band for infinite values and lost runs that is kept free above the area, px; zero without one.
    pub band: f64,
    /// What stands beside the band.
    pub band_label: &'static str,
    /// Horizontal axis.
    pub x: AxisMap,
    /// Vertical axis.
    pub y: AxisMap,
}

/// A point on the page.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Vertex {
    at: Point,
    /// Its value is infinite, it lies in the band.
    beyond: bool,
}

impl Frame {
    /// The area together with the band.
    pub fn whole(&self) -> Rect {
        Rect { top: self.area.top - self.band, ..self.area }
    }

    /// Height at which infinite values are drawn.
    pub fn beyond(&self) -> f64 {
        self.area.top - 0.5 * self.band
    }

    fn vertex(&self, (x, y): (f64, f64)) -> Option<Vertex> {
        let across = self.x.position(x)?;
        if y == f64::INFINITY && self.band > 0.0 {
            return Some(Vertex { at: (across, self.beyond()), beyond: true });
        }
        Some(Vertex { at: (across, self.y.position(y)?), beyond: false })
    }

    /// Where a point of a series stands, if it is in the frame.
    pub fn place(&self, series: &Series, index: usize) -> Option<Point> {
        let at = self.vertex(series.points[index])?.at;
        self.whole().contains(at).then_some(at)
    }

    /// Pieces of the series between its breaks.
    fn runs(&self, points: &[(f64, f64)]) -> Vec<Vec<Vertex>> {
        let mut runs = vec![Vec::new()];
        for &point in points {
            match (self.vertex(point), runs.last_mut()) {
                (Some(vertex), Some(run)) => run.push(vertex),
                _ => runs.push(Vec::new()),
            }
        }
        runs.retain(|run| !run.is_empty());
        runs
    }
}

/// Draws one of several series; `turn` is its number and their count, `later` are those in front of it.
pub fn draw(drawing: &mut Drawing, frame: &Frame, series: &Series, turn: (usize, usize), later: &[Series]) {
    drawing.group(series.data_name(), |drawing| draw_inside(drawing, frame, series, turn, later));
}

/// Where the signs of a series stand, if it has one at each of its points.
fn signs_of(frame: &Frame, series: &Series) -> Vec<Point> {
    let has_signs = series.mode == Mode::LineMarkers && series.points.len() <= FEW;
    let points = series.points.iter().filter(|_| has_signs);
    points.filter_map(|&point| frame.vertex(point)).map(|vertex| vertex.at).collect()
}

/// Size of a sign: one that others lie on is larger, so that it shows around them.
fn size_below(at: Point, later: &[Vec<Point>]) -> f64 {
    let touches = |signs: &&Vec<Point>| signs.iter().any(|sign| (sign.0 - at.0).hypot(sign.1 - at.1) < TOUCHING);
    let (by, most) = NESTED;
    MARKER * (1.0 + by * later.iter().filter(touches).count().min(most) as f64)
}

/// Writes what is said of points beside them, where neither signs nor lines nor other words are in the way: the ends of
/// each series first.
pub fn draw_tags(drawing: &mut Drawing, frame: &Frame, all: &[Series]) {
    if all.iter().all(|series| series.tags.is_empty()) {
        return;
    }
    // What is in the way: signs, and lines by a point every few px.
    let mut taken: Vec<Rect> = Vec::new();
    let around =
        |at: Point, half: f64| Rect { left: at.0 - half, top: at.1 - half, right: at.0 + half, bottom: at.1 + half };
    for series in all {
        for run in frame.runs(&series.points) {
            taken.extend(run.iter().map(|vertex| around(vertex.at, MARKER + 0.5)));
            for pair in run.windows(2) {
                let (from, to) = (pair[0].at, pair[1].at);
                let pieces = ((to.0 - from.0).hypot(to.1 - from.1) / 4.0).min(400.0) as usize;
                let along = |k: usize| {
                    let share = k as f64 / pieces as f64;
                    (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1))
                };
                taken.extend((1..pieces).map(|k| around(along(k), 0.6)));
            }
        }
    }
    let longest = all.iter().map(|series| series.tags.len()).max().unwrap_or(0);
    for turn in 0..longest {
        for series in all.iter().filter(|series| turn < series.tags.len()) {
            let index = if turn % 2 == 0 { turn / 2 } else { series.tags.len() - 1 - turn / 2 };
            let Some(vertex) = series.points.get(index).and_then(|&point| frame.vertex(point)) else { continue };
            let (tag, at) = (&series.tags[index], vertex.at);
            if tag.is_empty() || !frame.area.contains(at) {
                continue;
            }
            let width = font::width(tag, TAG_SIZE, Weight::Regular);
            let half = 0.5 * TAG_SIZE * font::CAP_HEIGHT;
            let away = MARKER + 2.5;
            let centres = [
                (at.0 + away + 0.5 * width, at.1),
                (at.0 - away - 0.5 * width, at.1),
                (at.0, at.1 - away - half),
                (at.0, at.1 + away + half),
            ];
            let place = |centre: &Point| Rect {
                left: centre.0 - 0.5 * width - 1.0,
                right: centre.0 + 0.5 * width + 1.0,
                top: centre.1 - half - 1.0,
                bottom: centre.1 + half + 1.0,
            };
            let is_free = |centre: &&Point| {
                let own = place(centre);
                let inside = own.corners().iter().all(|corner| frame.area.contains(*corner));
                inside
                    && taken.iter().all(|other| {
                        own.right < other.left
                            || own.left > other.right
                            || own.bottom < other.top
                            || own.top > other.bottom
                    })
            };
            if let Some(&centre) = centres.iter().find(is_free) {
                taken.push(place(&centre));
                let text = Text::new(tag, centre, TAG_SIZE).anchored(Anchor::Middle).centred();
                drawing.text(text.colored(series.style.color.mix(Color::INK, 0.35)));
            }
        }
    }
}

/// Returns the data of one series as they are, each with its place on the page.
pub fn exact(series: &Series, place: impl Fn(usize) -> Option<Point>) -> SeriesData {
    let datum = |(index, &(x, y)): (usize, &(f64, f64))| {
        let range = series.bars.iter().find(|(at, _)| *at == x).map(|(_, range)| *range);
        Datum { x, y, range, note: series.notes.get(index).cloned().unwrap_or_default(), at: place(index) }
    };
    SeriesData { name: series.data_name().to_owned(), points: series.points.iter().enumerate().map(datum).collect() }
}

fn draw_inside(
    drawing: &mut Drawing,
    frame: &Frame,
    series: &Series,
    (index, count): (usize, usize),
    later: &[Series],
) {
    let later: Vec<Vec<Point>> = later.iter().map(|series| signs_of(frame, series)).collect();
    let style = &series.style;
    let thin = Stroke { color: style.color, width: BAR, dash: &[] };
    for &(x, range) in &series.bars {
        let ends: Vec<Point> = range.iter().filter_map(|&y| Some(frame.vertex((x, y))?.at)).collect();
        for piece in clip::polyline(&ends, |_| frame.area) {
            drawing.line(piece, thin);
        }
    }
    let runs = frame.runs(&series.points);
    for run in &runs {
        let path = thinned(if series.mode == Mode::Steps { stepped(run) } else { run.clone() });
        let path = straightened(path, |vertex| (vertex.at, vertex.beyond));
        let points: Vec<Point> = path.iter().map(|vertex| vertex.at).collect();
        let clip_to = |k: usize| if path[k].beyond || path[k + 1].beyond { frame.whole() } else { frame.area };
        for piece in clip::polyline(&points, clip_to) {
            drawing.line(piece, style.stroke());
        }
        if series.mode == Mode::Steps && count > 1 {
            signs_along(drawing, frame, &points, style, (index, count));
        }
    }
    let signs = series.mode == Mode::LineMarkers;
    let apart = if series.points.len() > MANY { MARKER_DISTANCE } else { 0.0 };
    let (mut last_sign, mut last_triangle) = (None, None);
    for vertex in runs.iter().flatten() {
        if vertex.beyond && (frame.area.left..=frame.area.right).contains(&vertex.at.0) {
            if far_enough(&mut last_triangle, vertex.at, TRIANGLE_DISTANCE) {
                marker::draw(drawing, Marker::Beyond, vertex.at, MARKER, style.color);
            }
        } else if signs && frame.area.contains(vertex.at) && far_enough(&mut last_sign, vertex.at, apart) {
            marker::draw(drawing, style.marker, vertex.at, size_below(vertex.at, &later), style.color);
        }
    }
}

/// Puts signs on a line of steps, each series at places of its own: where lines lie on each other, one sees the signs
/// of all.
fn signs_along(
    drawing: &mut Drawing,
    frame: &Frame,
    points: &[Point],
    style: &LineStyle,
    (index, count): (usize, usize),
) {
    let every = (STEP_SIGNS * count as f64).clamp(60.0, 120.0);
    let mut next = frame.area.left + every * (index as f64 + 0.5) / count as f64;
    for pair in points.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        while from.1 == to.1 && next <= to.0 {
            if next >= from.0 && frame.area.contains((next, from.1)) {
                marker::draw(drawing, style.marker, (next, from.1), 0.8 * MARKER, style.color);
            }
            next += every;
        }
    }
}

/// Height of a band with a row for each of so many series.
pub fn height_of_rows(series: usize) -> f64 {
    BAND.max(LOSS_ROW * series as f64 + 8.0)
}

/// The series that lost runs, each of which has a row in the band.
pub fn lossy(all: &[Series]) -> impl Iterator<Item = &Series> {
    all.iter().filter(|series| !series.lost.is_empty())
}

/// The height at which a series leaves the frame on its way to the right, or ends: where all of its last runs failed,
/// at their cross.
pub fn end(frame: &Frame, series: &Series, all: &[Series]) -> Option<f64> {
    let last = series.points.iter().map(|point| point.0).fold(f64::NAN, f64::max);
    if series.lost.iter().any(|(x, loss)| *x >= last && loss.failed >= 1.0) {
        let row = lossy(all).position(|lossy| lossy.data_name() == series.data_name())?;
        return Some(height_of_losses(frame, row, lossy(all).count()));
    }
    let inside = |vertex: &Vertex| vertex.beyond || frame.area.contains(vertex.at);
    frame.runs(&series.points).into_iter().flatten().rfind(inside).map(|vertex| vertex.at.1)
}

/// Where a row of the band for lost runs stands, of so many.
fn height_of_losses(frame: &Frame, row: usize, of: usize) -> f64 {
    frame.whole().top + 4.0 + (row as f64 + 0.5) * (frame.band - 8.0) / of.max(1) as f64
}

/// Marks in the band where runs were lost, a row for each series: an open triangle for some of them, a cross for all. A
/// line that ends because all runs of the next point fail goes on to their cross in dots.
pub fn draw_losses(drawing: &mut Drawing, frame: &Frame, all: &[Series]) {
    for (row, series) in lossy(all).enumerate() {
        let (up, color) = (height_of_losses(frame, row, lossy(all).count()), series.style.color);
        let place = |x: f64| frame.x.position(x).filter(|at| (frame.area.left..=frame.area.right).contains(at));
        for pair in series.points.windows(2) {
            let fails = series.lost.iter().any(|(x, loss)| *x == pair[1].0 && loss.failed >= 1.0);
            let from = frame.vertex(pair[0]).filter(|vertex| frame.area.contains(vertex.at));
            if let (true, Some(from), Some(to)) = (fails, from, place(pair[1].0)) {
                drawing.line(vec![from.at, (to, up)], Stroke { color, width: 1.0, dash: &[1.0, 2.5] });
            }
        }
        for &(x, loss) in &series.lost {
            if let Some(across) = place(x) {
                marker::draw(drawing, loss.sign(), (across, up), MARKER, color);
            }
        }
    }
}

fn far_enough(last: &mut Option<Point>, at: Point, distance: f64) -> bool {
    let far = last.is_none_or(|before| (at.0 - before.0).hypot(at.1 - before.1) >= distance);
    if far {
        *last = Some(at);
    }
    far
}

/// Holds every value until the next point.
fn stepped(run: &[Vertex]) -> Vec<Vertex> {
    let corner = |pair: &[Vertex]| Vertex { at: (pair[1].at.0, pair[0].at.1), beyond: pair[0].beyond };
    let held = run.windows(2).flat_map(|pair| [pair[0], corner(pair)]);
    held.chain(run.last().copied()).collect()
}

/// Keeps of the points within half a px column only the first, lowest, highest and last: the picture stays the same.
fn thinned(run: Vec<Vertex>) -> Vec<Vertex> {
    let column = |vertex: &Vertex| (2.0 * vertex.at.0).floor();
    let mut kept = Vec::new();
    for group in run.chunk_by(|a, b| column(a) == column(b) && a.beyond == b.beyond) {
        let by_height = |a: &usize, b: &usize| group[*a].at.1.total_cmp(&group[*b].at.1);
        let highest = (0..group.len()).min_by(by_height).unwrap_or(0);
        let lowest = (0..group.len()).max_by(by_height).unwrap_or(0);
        let mut chosen = [0, highest, lowest, group.len() - 1];
        chosen.sort_unstable();
        kept.extend(chosen.chunk_by(|a, b| a == b).map(|same| group[same[0]]));
    }
    kept
}

/// Leaves out points that lie on the line between those that stay, to a twentieth of a pixel: numbers have one decimal.
/// `place` says where each is, and of which piece: a point of another one stays.
pub(crate) fn straightened<T: Copy>(run: Vec<T>, place: impl Fn(&T) -> (Point, bool)) -> Vec<T> {
    const OFF: f64 = 0.05;
    let places: Vec<(Point, bool)> = run.iter().map(place).collect();
    // Whether a line from one to another would leave one that is left out.
    let leaves = |from: usize, to: usize| {
        let ((start, piece), (end, _)) = (places[from], places[to]);
        let along = (end.0 - start.0, end.1 - start.1);
        let length = along.0.hypot(along.1);
        let (reach, most) = (length * length, OFF * length);
        places[from + 1..to].iter().any(|&(at, own)| {
            let off = (at.0 - start.0, at.1 - start.1);
            let dot = along.0 * off.0 + along.1 * off.1;
            let is_on = dot >= 0.0 && dot <= reach && (along.0 * off.1 - along.1 * off.0).abs() <= most;
            !(is_on && own == piece)
        })
    };
    let mut kept: Vec<T> = Vec::new();
    let mut anchor = 0;
    for at in 0..run.len() {
        if at > anchor + 1 && (places[at].1 != places[anchor].1 || leaves(anchor, at)) {
            anchor = at - 1;
            kept.push(run[anchor]);
        }
        if at == 0 {
            kept.push(run[0]);
        }
    }
    kept.extend(run.last().filter(|_| run.len() > 1));
    kept
}

#[cfg(test)]
mod tests {
    use super::super::chart::Loss;
    use super::super::chart::Scale;
    use super::super::drawing::Shape;
    use super::*;

    fn frame() -> Frame {
        Frame {
            area: Rect { left: 0.0, top: 50.0, right: 100.0, bottom: 150.0 },
            band: BAND,
            band_label: "∞",
            x: AxisMap { scale: Scale::Linear, low: 0.0, high: 10.0, start: 0.0, end: 100.0 },
            y: AxisMap { scale: Scale::Log10, low: 1.0, high: 100.0, start: 150.0, end: 50.0 },
        }
    }

    fn lines(points: &[(f64, f64)]) -> Vec<Vec<Point>> {
        let mut drawing = Drawing::new(100.0, 200.0);
        draw(
            &mut drawing,
            &frame(),
            &Series::new("m", points.to_vec(), LineStyle::of_name("rim-nonsmooth")),
            (0, 1),
            &[],
        );
        let open = |shape: Shape| match shape {
            Shape::Path { points, closed: false, .. } => Some(points),
            _ => None,
        };
        drawing.shapes.into_iter().filter_map(open).collect()
    }

    #[test]
    fn nan_breaks_the_line() {
        let broken = lines(&[(0.0, 10.0), (1.0, 10.0), (2.0, f64::NAN), (3.0, 10.0), (4.0, 10.0)]);
        assert_eq!(broken, [[(0.0, 100.0), (10.0, 100.0)], [(30.0, 100.0), (40.0, 100.0)]]);
    }

    #[test]
    fn an_infinite_value_is_drawn_in_the_band_with_a_triangle() {
        let points = vec![(1.0, 10.0), (2.0, f64::INFINITY), (3.0, 10.0)];
        assert_eq!(lines(&points), [[(10.0, 100.0), (20.0, 50.0 - 0.5 * BAND), (30.0, 100.0)]]);
        let mut drawing = Drawing::new(100.0, 200.0);
        draw(&mut drawing, &frame(), &Series::new("m", points, LineStyle::of_name("rim-nonsmooth")), (0, 1), &[]);
        let triangle = drawing.shapes.iter().filter(|s| matches!(s, Shape::Path { closed: true, .. })).count();
        assert_eq!(triangle, 1);
    }

    #[test]
    fn a_finite_value_above_the_axis_is_cut_below_the_band() {
        let cut = lines(&[(0.0, 10.0), (2.0, 1.0e9)]);
        assert_eq!(cut[0].last().map(|point| point.1), Some(50.0));
    }

    #[test]
    fn lost_runs_have_a_row_for_each_series_at_the_steps_that_were_run() {
        let all = Loss { failed: 1.0, silent: 0.0 };
        let points: Vec<(f64, Loss)> = (0..10).map(|k| (f64::from(k), all)).collect();
        let losses: Vec<Series> = (0..4)
            .map(|_| Series {
                lost: points.clone(),
                ..Series::new("", Vec::new(), LineStyle::of_name("rim-nonsmooth"))
            })
            .collect();
        let frame = Frame { band: height_of_rows(4), ..frame() };
        let mut drawing = Drawing::new(100.0, 200.0);
        draw_losses(&mut drawing, &frame, &losses);
        // A cross is two strokes; its middle is that of the first.
        let strokes = drawing.shapes.iter().filter_map(|shape| match shape {
            Shape::Path { points, .. } => Some((0.5 * (points[0].0 + points[1].0), 0.5 * (points[0].1 + points[1].1))),
            _ => None,
        });
        let centres: Vec<Point> = strokes.step_by(2).collect();
        let apart = |a: &Point, b: &Point| (a.0 - b.0).hypot(a.1 - b.1) > 2.0 * MARKER;
        assert_eq!(centres.len(), 40);
        assert!((0..40).all(|i| (0..i).all(|j| apart(&centres[i], &centres[j]))), "{centres:?}");
        assert!(centres.iter().all(|centre| points.iter().any(|point| (10.0 * point.0 - centre.0).abs() < 1e-9)));
    }

    #[test]
    fn a_sign_that_others_lie_on_shows_around_them() {
        let series =
            |y: f64| Series::new("m", vec![(5.0, y)], LineStyle::of_name("rim-nonsmooth")).mode(Mode::LineMarkers);
        let radius = |later: &[Series]| {
            let mut drawing = Drawing::new(100.0, 200.0);
            draw(&mut drawing, &frame(), &series(10.0), (0, 1), later);
            drawing.shapes.iter().find_map(|shape| match shape {
                Shape::Disc { radius, .. } => Some(*radius),
                _ => None,
            })
        };
        assert_eq!(radius(&[]), Some(MARKER));
        assert_eq!(radius(&[series(50.0)]), Some(MARKER));
        assert!(radius(&[series(10.0), series(10.1)]) > radius(&[series(10.0)]));
    }

    #[test]
    fn words_beside_points_keep_clear_of_signs_lines_and_each_other() {
        let tags = |text: &str| vec![text.to_owned(); 3];
        let points = vec![(2.0, 3.0), (5.0, 10.0), (8.0, 50.0)];
        let series = |text: &str| Series {
            tags: tags(text),
            ..Series::new(text, points.clone(), LineStyle::of_name("rim-nonsmooth"))
        };
        let mut drawing = Drawing::new(100.0, 200.0);
        // The second lies on the first: there is room for a few words of it, never on those of the first.
        draw_tags(&mut drawing, &frame(), &[series("20"), series("30")]);
        let words: Vec<&Text> = drawing
            .shapes
            .iter()
            .filter_map(|shape| match shape {
                Shape::Text(text) => Some(text),
                _ => None,
            })
            .collect();
        assert!(words.len() >= 3, "{words:?}");
        let apart = |a: &Text, b: &Text| (a.at.0 - b.at.0).abs() > a.width() || (a.at.1 - b.at.1).abs() > 6.0;
        assert!((0..words.len()).all(|i| (0..i).all(|j| apart(words[i], words[j]))), "{words:?}");
    }

    #[test]
    fn thinning_keeps_the_spike() {
        let points: Vec<_> = (0..20_000).map(|k| (f64::from(k) * 5e-4, if k == 7001 { 90.0 } else { 2.0 })).collect();
        let drawn = &lines(&points)[0];
        assert!(drawn.len() < 1000, "{} points", drawn.len());
        let peak = frame().y.position(90.0).expect("inside");
        assert!(drawn.iter().any(|point| point.1 == peak));
    }

    #[test]
    fn a_straight_piece_has_two_points_and_a_corner_stays() {
        let vertex = |x: f64, y: f64| Vertex { at: (x, y), beyond: false };
        let run: Vec<Vertex> = (0..50).map(|k| vertex(f64::from(k), (f64::from(k) - 20.0).max(0.0))).collect();
        let kept = straightened(run.clone(), |vertex| (vertex.at, vertex.beyond));
        assert_eq!(kept, [run[0], run[20], run[49]]);
        // A curve stays within a twentieth of a pixel of what is drawn.
        let run: Vec<Vertex> =
            (0..500).map(|k| vertex(0.1 * f64::from(k), 20.0 * (0.01 * f64::from(k)).sin())).collect();
        let kept = straightened(run.clone(), |vertex| (vertex.at, vertex.beyond));
        assert!(kept.len() < 60, "{}", kept.len());
        for pair in kept.windows(2) {
            for point in run.iter().filter(|point| (pair[0].at.0..=pair[1].at.0).contains(&point.at.0)) {
                let (along, up) = (pair[1].at.0 - pair[0].at.0, pair[1].at.1 - pair[0].at.1);
                let off = along * (point.at.1 - pair[0].at.1) - up * (point.at.0 - pair[0].at.0);
                assert!(off.abs() <= 0.0501 * along.hypot(up), "{point:?}");
            }
        }
    }

    #[test]
    fn steps_hold_the_earlier_value() {
        let vertex = |x, y| Vertex { at: (x, y), beyond: false };
        assert_eq!(stepped(&[vertex(0.0, 1.0), vertex(2.0, 5.0)])[1], vertex(2.0, 1.0));
    }
}
