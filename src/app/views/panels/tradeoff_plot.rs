//! The plot of time against stock: the curve, its handle, and plans of other strategies.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo};

use crate::app::model::units::DisplayUnits;
use crate::app::views::theme::{self, Condition};
use crate::app::views::ticks::ticks;
use crate::app::views::units;

/// Room for the scales at the left and below, and above and at the right, points.
const MARGIN: [Vec2; 2] = [Vec2::new(38.0, 32.0), Vec2::new(14.0, 10.0)];
/// Totals are shown up to this multiple of the least: the few long ones would press the curve together.
const TOTALS_SHOWN: f64 = 1.6;
/// Plans of other strategies are shown up to this share of the size of the curve away from it: others stand
/// at the border.
const OTHERS_SHOWN: f64 = 0.75;
/// Width of a curve at least, as a share of its time.
const MIN_WIDTH: f64 = 0.2;
/// Radius of the handle, points.
const HANDLE: f32 = 6.0;
/// Least distance of a name from the line of the handle, points.
const BESIDE_LINE: f32 = 3.0;
/// Length of a mark at the border, points.
const BORDER_MARK: f32 = 7.0;

/// A plan as a point: time of a channel in minutes, 95th percentile of the stock in mm.
pub type CurvePlace = (f64, f64);

/// The plan of another policy in the plot.
pub struct Marker {
    /// Its policy.
    pub name: &'static str,
    /// Its time and stock.
    pub at: CurvePlace,
    /// Whether plunges of it interfere.
    pub interferes: bool,
}

impl Marker {
    /// What stands beside it at the border.
    fn words_at_border(&self, units: DisplayUnits) -> String {
        format!("{}: {:.0} min, {}", self.name, self.at.0, units.length(self.at.1, 2))
    }
}

/// What the plot shows.
pub struct Curves<'a> {
    /// The plans of `minimal`, by falling time.
    pub plunging: &'a [CurvePlace],
    /// The same with the time of semi-finishing; empty where the goal does not count it.
    pub totals: &'a [CurvePlace],
    /// Where the shown plan stands among the totals; `None` where it is not what the handle stands for.
    pub total_of_plan: Option<CurvePlace>,
    /// Plans of other strategies.
    pub others: &'a [Marker],
}

/// Ends of the scales of the plot.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlotScale {
    /// Times, minutes.
    times: (f64, f64),
    /// Largest stock, mm.
    stock: f64,
}

impl PlotScale {
    /// Whether a place is within the scales.
    fn holds(&self, (time, stock): CurvePlace) -> bool {
        (self.times.0..=self.times.1).contains(&time) && stock <= self.stock
    }

    /// The nearest place within the scales.
    fn nearest(&self, (time, stock): CurvePlace) -> CurvePlace {
        (time.clamp(self.times.0, self.times.1), stock.clamp(0.0, self.stock))
    }
}

impl Curves<'_> {
    /// Scales on which the curve takes up most of the plot. Totals much longer than the least are left out,
    /// and plans of other strategies that are far from the curve stand at the border.
    fn scale(&self) -> PlotScale {
        let least = self.totals.iter().map(|at| at.0).fold(f64::INFINITY, f64::min);
        let totals = self.totals.iter().map(|at| at.0.min(TOTALS_SHOWN * least));
        let ends = |times: &mut dyn Iterator<Item = f64>| {
            times.fold((f64::MAX, 0.0f64), |(low, high), time| (low.min(time), high.max(time)))
        };
        let (low, high) = ends(&mut self.plunging.iter().map(|at| at.0).chain(totals));
        let stocks = self.plunging.iter().map(|at| at.1).filter(|stock| stock.is_finite());
        let top = stocks.fold(0.1, f64::max);
        // A curve of one point has no width of its own.
        let margin = OTHERS_SHOWN * (high - low).max(MIN_WIDTH * high);
        let is_near = |&(time, stock): &CurvePlace| {
            (low - margin..=high + margin).contains(&time) && stock <= (1.0 + OTHERS_SHOWN) * top
        };
        let near: Vec<CurvePlace> = self.others.iter().map(|other| other.at).filter(is_near).collect();
        let (low, high) = ends(&mut [low, high].into_iter().chain(near.iter().map(|at| at.0)));
        let top = 1.1 * near.iter().map(|at| at.1).fold(top, f64::max);
        let span = (high - low).max(1e-3);
        // Some margin at both ends, so that handle and markers are not cut off.
        PlotScale { times: (low - 0.05 * span, high + 0.08 * span), stock: top }
    }
}

/// The two points of the curve beside a time of `minutes`, and how far it is from the first to the second,
/// 0…1.
fn between(curve: &[CurvePlace], minutes: f64) -> Option<([usize; 2], f64)> {
    let next = curve.iter().position(|(time, _)| *time <= minutes).unwrap_or(curve.len().saturating_sub(1));
    let pair = [next.saturating_sub(1), next];
    let [slow, fast] = [curve.get(pair[0])?.0, curve.get(pair[1])?.0];
    let share = if slow > fast { (slow - minutes) / (slow - fast) } else { 0.0 };
    Some((pair, share.clamp(0.0, 1.0)))
}

/// Stock of the curve at a time of `minutes`, between its points.
pub fn stock_at(curve: &[CurvePlace], minutes: f64) -> Option<f64> {
    let ([slow, fast], share) = between(curve, minutes)?;
    Some(curve[slow].1 + (curve[fast].1 - curve[slow].1) * share)
}

/// Time with semi-finishing, `totals` for the points of `curve`, where plunging takes `minutes`.
pub fn total_at(curve: &[CurvePlace], minutes: f64, totals: &[CurvePlace]) -> Option<f64> {
    let ([slow, fast], share) = between(curve, minutes)?;
    let (slow, fast) = (totals.get(slow)?.0, totals.get(fast)?.0);
    Some(slow + (fast - slow) * share)
}

/// Draws the plot with its handle at a time and, if that is known, a stock; returns the time that the handle
/// was dragged or clicked to.
pub fn plot(ui: &mut Ui, curves: &Curves, (handle, stock): (f64, Option<f64>), height: f32) -> Option<f64> {
    let &Curves { plunging: curve, totals, total_of_plan, others } = curves;
    let size = Vec2::new(ui.available_width(), height);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Hub stock over time of a channel"));
    let inner = Rect::from_min_max(
        rect.min + Vec2::new(MARGIN[0].x, MARGIN[1].y),
        rect.max - Vec2::new(MARGIN[1].x, MARGIN[0].y),
    );
    let scale = curves.scale();
    let ((low, high), top) = (scale.times, scale.stock);
    let place = |(time, stock): CurvePlace| {
        let across = ((time - low) / (high - low)) as f32;
        Pos2::new(
            inner.left() + inner.width() * across,
            inner.bottom() - inner.height() * (stock / top) as f32,
        )
    };
    let (painter, units) = (ui.painter_at(rect), units::display_units(ui));
    let font = FontId::proportional(theme::MIN_TEXT_SIZE);
    let (ink, weak) = (ui.visuals().text_color(), ui.visuals().weak_text_color());
    painter.rect_filled(inner, 2.0, ui.visuals().extreme_bg_color);
    let (times, decimals) = ticks((low, high));
    for time in times {
        let (below, text) = (place((time, 0.0)) + Vec2::new(0.0, 2.0), format!("{time:.decimals$}"));
        painter.text(below, Align2::CENTER_TOP, text, font.clone(), weak);
    }
    // Round in the unit that is shown.
    let per_mm = units.of_mm(1.0);
    let (stocks, decimals) = ticks((0.0, top * per_mm));
    for stock in stocks {
        let left = place((low, stock / per_mm)) - Vec2::new(4.0, 0.0);
        let text = format!("{stock:.decimals$}");
        painter.text(left, Align2::RIGHT_CENTER, text, font.clone(), weak);
    }
    let below = Pos2::new(inner.center().x, rect.bottom());
    let axes = format!("min per channel; hub stock, 95 %, {}", units.length_unit());
    painter.text(below, Align2::CENTER_BOTTOM, axes, font.clone(), weak);
    let accent = theme::accent(ui.visuals());
    painter.line(curve.iter().map(|&at| place(at)).collect(), Stroke::new(1.6, accent));
    draw_totals(&painter.with_clip_rect(inner), totals, total_of_plan, place, (&font, ink));
    let mut names: Vec<Rect> = Vec::with_capacity(others.len());
    // Names at the border first: they have no other place.
    let mut ordered: Vec<&Marker> = others.iter().collect();
    ordered.sort_by_key(|other| scale.holds(other.at));
    for other in ordered {
        let condition = if other.interferes { Condition::Interfering } else { Condition::Sound };
        let colour = condition.text(ui.visuals());
        let (at, name) = if scale.holds(other.at) {
            let at = place(other.at);
            painter.circle_stroke(at, 4.0, Stroke::new(1.6, colour));
            (at, other.name.to_owned())
        } else {
            let inside = inner.shrink(BORDER_MARK + 2.0);
            let at = inside.clamp(place(scale.nearest(other.at)));
            draw_arrow(&painter, at, (place(other.at) - at).normalized(), colour);
            (at, other.words_at_border(units))
        };
        // The name goes to the side with more space, and below those that stand there.
        let (side, align) =
            if at.x > inner.center().x { (-9.0, Align2::RIGHT_CENTER) } else { (9.0, Align2::LEFT_CENTER) };
        let text = painter.layout_no_wrap(name, font.clone(), ink);
        let wanted = align.anchor_size(at + Vec2::new(side, 0.0), text.size());
        let wanted = beside_line(wanted, place((handle, 0.0)).x, inner);
        let free = free_place(wanted, &names);
        painter.galley(free.min, text, ink);
        names.push(free);
    }
    if let Some(stock) = stock {
        let at = place((handle, stock));
        painter.vline(at.x, inner.y_range(), Stroke::new(1.0, accent.gamma_multiply(0.5)));
        let edge = if response.hovered() { ink } else { Color32::TRANSPARENT };
        painter.circle(at, HANDLE, accent, Stroke::new(1.5, edge));
    }
    let pointer = response.interact_pointer_pos().filter(|_| response.dragged() || response.clicked())?;
    let share = f64::from((pointer.x - inner.left()) / inner.width().max(1.0));
    let (fastest, slowest) = (curve.last()?.0, curve.first()?.0);
    Some((low + (high - low) * share).clamp(fastest, slowest))
}

/// The place of a text at `wanted`; where the vertical line at `x` would go through it, beside that line: on
/// the nearer side, or on the other one where the text would leave `plot`.
fn beside_line(wanted: Rect, x: f32, plot: Rect) -> Rect {
    if x < wanted.left() - BESIDE_LINE || x > wanted.right() + BESIDE_LINE {
        return wanted;
    }
    let (right, left) = (x + BESIDE_LINE - wanted.left(), x - BESIDE_LINE - wanted.right());
    let fits = |by: f32| wanted.left() + by >= plot.left() && wanted.right() + by <= plot.right();
    let nearer_first = if right < -left { [right, left] } else { [left, right] };
    let by = nearer_first.into_iter().find(|&by| fits(by)).unwrap_or(0.0);
    wanted.translate(Vec2::new(by, 0.0))
}

/// The place of a text at `wanted`, or so far below that it is on none of `taken`.
fn free_place(wanted: Rect, taken: &[Rect]) -> Rect {
    let mut free = wanted;
    // Each step passes one of them.
    for _ in 0..taken.len() {
        let Some(other) = taken.iter().find(|other| other.shrink(0.5).intersects(free)) else { break };
        free = free.translate(Vec2::new(0.0, other.bottom() - free.top()));
    }
    free
}

/// Draws a mark at the border of the plot that points to a place outside of it.
fn draw_arrow(painter: &Painter, at: Pos2, to: Vec2, colour: Color32) {
    let (tip, across) = (at + to * BORDER_MARK, to.rot90() * 0.6 * BORDER_MARK);
    let foot = at - to * 0.4 * BORDER_MARK;
    painter.add(Shape::convex_polygon(vec![tip, foot + across, foot - across], colour, Stroke::NONE));
}

/// Draws the curve with semi-finishing, and a mark at its least time: of the shown plan where that is known,
/// so that it stands at the height of the handle.
fn draw_totals(
    painter: &Painter,
    totals: &[CurvePlace],
    of_plan: Option<CurvePlace>,
    place: impl Fn(CurvePlace) -> Pos2,
    (font, ink): (&FontId, Color32),
) {
    let Some(&least) = totals.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    let line: Vec<Pos2> = totals.iter().map(|&at| place(at)).collect();
    painter.extend(Shape::dashed_line(&line, Stroke::new(1.4, ink), 5.0, 3.0));
    let marked = of_plan.unwrap_or(least);
    let at = place(marked);
    painter.circle_filled(at, 3.0, ink);
    let text = format!("with semi-finishing: {:.1} min", marked.0);
    painter.text(at + Vec2::new(8.0, -8.0), Align2::LEFT_BOTTOM, text, font.clone(), ink);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marker(time: f64, stock: f64) -> Marker {
        Marker { name: "Stepped", at: (time, stock), interferes: false }
    }

    #[test]
    fn plans_far_from_the_curve_do_not_press_it_together() {
        let curve = [(30.0, 1.0), (20.0, 2.0)];
        let scale =
            |others: &[Marker]| Curves { plunging: &curve, totals: &[], total_of_plan: None, others }.scale();
        let alone = scale(&[]);
        assert!(alone.times.0 < 20.0 && alone.times.1 > 30.0 && alone.stock > 2.0, "{alone:?}");
        // One that is near is in the plot.
        let near = marker(36.0, 2.6);
        let with_near = scale(&[marker(36.0, 2.6)]);
        assert!(with_near.holds(near.at) && !alone.holds(near.at), "{with_near:?}");
        for far in [marker(135.0, 1.2), marker(25.0, 30.0)] {
            let at = far.at;
            let with_far = scale(&[far]);
            assert_eq!(with_far, alone, "{at:?}");
            assert!(!with_far.holds(at) && with_far.holds(with_far.nearest(at)), "{at:?}");
        }
        assert_eq!(marker(135.0, 1.2).words_at_border(DisplayUnits::Metric), "Stepped: 135 min, 1.20 mm");
    }

    #[test]
    fn names_of_plans_that_are_near_each_other_do_not_overlap() {
        let at = |y: f32| Rect::from_min_size(Pos2::new(20.0, y), Vec2::new(60.0, 14.0));
        let mut names = vec![at(10.0), at(40.0)];
        for wanted in [at(12.0), at(15.0), at(80.0)] {
            let free = free_place(wanted, &names);
            assert!(names.iter().all(|other| !other.shrink(0.5).intersects(free)), "{free}");
            names.push(free);
        }
        assert_eq!(names[4], at(80.0), "it has its place");
    }

    #[test]
    fn the_line_of_the_handle_goes_through_no_name() {
        let plot = Rect::from_min_size(Pos2::ZERO, Vec2::new(200.0, 100.0));
        let name = Rect::from_min_size(Pos2::new(100.0, 20.0), Vec2::new(60.0, 14.0));
        assert_eq!(beside_line(name, 90.0, plot), name, "the line is beside it");
        assert_eq!(beside_line(name, 102.0, plot).left(), 105.0, "moved to the right");
        assert_eq!(beside_line(name, 158.0, plot).right(), 155.0, "moved to the left");
        assert_eq!(beside_line(name.translate(Vec2::new(38.0, 0.0)), 142.0, plot).right(), 139.0, "no room");
    }

    #[test]
    fn a_curve_of_one_plan_has_room_for_others() {
        let curve = [(30.0, 1.0)];
        let others = [marker(33.0, 1.3)];
        let scale = Curves { plunging: &curve, totals: &[], total_of_plan: None, others: &others }.scale();
        assert!(scale.holds(others[0].at) && scale.holds(curve[0]), "{scale:?}");
    }

    #[test]
    fn the_total_is_found_between_the_same_points() {
        let curve = [(100.0, 1.0), (60.0, 2.0)];
        let totals = [(110.0, 1.0), (90.0, 2.0)];
        assert_eq!(total_at(&curve, 80.0, &totals), Some(100.0));
        assert_eq!(total_at(&curve, 80.0, &[]), None, "the goal does not count it");
    }

    #[test]
    fn between_points_the_curve_is_straight() {
        let curve = [(100.0, 1.0), (60.0, 2.0), (50.0, 4.0)];
        for (minutes, stock) in
            [(120.0, 1.0), (100.0, 1.0), (80.0, 1.5), (60.0, 2.0), (55.0, 3.0), (40.0, 4.0)]
        {
            assert_eq!(stock_at(&curve, minutes), Some(stock), "{minutes} min");
        }
        assert_eq!(stock_at(&curve[..1], 70.0), Some(1.0));
    }
}
