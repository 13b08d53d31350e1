//! Sectional view through the selected position, with dimensions: plane to choose, zoom, pan.

use egui::{Align2, Color32, ComboBox, FontId, Pos2, Rect, RichText, Sense, Shape, Stroke, Ui, Vec2};

use super::positions::breach_words;
use crate::app::model::look::DrawingPart;
use crate::app::model::number::with_minus_signs;
use crate::app::views::theme::{self, Condition};
use crate::app::views::units;
use crate::plunge::Position;
use crate::plunge::inspect::{CutPlane, SectionPoint, SectionView};

/// Half width of the view, in cutter radii.
const HALF_WIDTH_IN_RADII: f64 = 1.75;

/// Height of the drawing in a window of `window` points; the rest is for the table above it.
pub fn height(window: f32) -> f32 {
    (0.24 * window - CONTROLS).clamp(96.0, 210.0)
}

/// Height of the line of controls, points.
const CONTROLS: f32 = 26.0;
/// Height of the dimensions at the top, points.
const DIMENSIONS: f32 = 54.0;
/// Smallest and largest magnification: from the whole tool to the corner of an insert.
const ZOOM: [f64; 2] = [0.1, 40.0];
/// Points of scrolling that double or halve the magnification.
const SCROLL_PER_OCTAVE: f64 = 240.0;

/// Label of a plane.
fn plane_label(plane: CutPlane) -> &'static str {
    match plane {
        CutPlane::Row => "Along the row",
        CutPlane::Across => "Across the row",
        CutPlane::Contact => "Through contact",
        CutPlane::Meridian => "Meridional",
    }
}

/// The line of controls: plane, fit, and, if it can, enlarge; `true` when that was pressed. `now`: the plane
/// that is shown.
pub fn controls(
    ui: &mut Ui,
    (chosen, part): (&mut Option<CutPlane>, &mut DrawingPart),
    now: CutPlane,
    can_enlarge: bool,
) -> bool {
    ui.horizontal(|ui| {
        let label = ui.label("Cut");
        let list = ComboBox::from_id_salt("cut plane").width(112.0).selected_text(plane_label(now));
        let list = list.show_ui(ui, |ui| {
            let automatic = "Automatic: through the contact where the core meets stock, else along the row";
            ui.selectable_value(chosen, None, "Automatic").on_hover_text(automatic);
            for plane in CutPlane::ALL {
                ui.selectable_value(chosen, Some(plane), plane_label(plane));
            }
        });
        list.response.labelled_by(label.id).on_hover_text("Plane of the cut; each contains the tool axis");
        let moved = *part != DrawingPart::default();
        let fit = ui.add_enabled(moved, egui::Button::new("Fit cut").small());
        if fit.on_hover_text("Shows the whole cut again; so does a double-click").clicked() {
            *part = DrawingPart::default();
        }
        can_enlarge && ui.small_button("Enlarge").on_hover_text("Shows the cut in a window").clicked()
    })
    .inner
}

/// Transformation from mm in the section plane to the screen.
struct SectionToScreen {
    rect: Rect,
    scale: f64,
    low: f64,
    /// Shift on the screen, points.
    shift: [f64; 2],
}

impl SectionToScreen {
    fn new(rect: Rect, view: &SectionView, part: &DrawingPart) -> Self {
        let radius = view.tool.radius();
        let (width, height) = (f64::from(rect.width()), f64::from(rect.height()));
        let near = view.hub.iter().filter(|p| p[0].abs() < radius);
        let lowest = near.map(|p| p[1]).fold(0.0, f64::min);
        // From the bottom: a strip of hub, the cutter with its core contact, the dimensions.
        let (below, dimensions) = (0.12 * height, f64::from(DIMENSIONS));
        let room = (height - below - dimensions).max(0.3 * height);
        let shown = view.contact_in_plane().max(0.25 * radius) - lowest;
        let fitting = (width / (2.0 * HALF_WIDTH_IN_RADII * radius)).min(room / shown);
        let low = lowest - below / fitting;
        // Zoomed about the middle of the drawing.
        let (scale, middle) = (fitting * part.zoom, low + 0.5 * height / fitting);
        let shift = part.pan.map(|along| along * part.zoom);
        Self { rect, scale, low: middle - 0.5 * height / scale, shift }
    }

    fn to_screen(&self, [x, y]: SectionPoint) -> Pos2 {
        egui::pos2(
            self.rect.center().x + (x * self.scale + self.shift[0]) as f32,
            self.rect.bottom() - ((y - self.low) * self.scale - self.shift[1]) as f32,
        )
    }

    /// Heights at the lower and upper edge of the drawing, mm.
    fn bottom(&self) -> f64 {
        self.low + self.shift[1] / self.scale
    }

    fn line(&self, points: &[SectionPoint]) -> Vec<Pos2> {
        points.iter().map(|&p| self.to_screen(p)).collect()
    }

    fn top(&self) -> f64 {
        self.bottom() + f64::from(self.rect.height()) / self.scale
    }
}

/// Moves the drawing with the mouse: drag pans, the wheel zooms to the pointer, a double-click fits.
fn mouse(ui: &Ui, response: &egui::Response, part: &mut DrawingPart) {
    if response.double_clicked() {
        *part = DrawingPart::default();
    }
    if response.dragged() {
        let by = response.drag_delta();
        part.pan[0] += f64::from(by.x) / part.zoom;
        part.pan[1] += f64::from(by.y) / part.zoom;
    }
    let Some(at) = response.hover_pos() else { return };
    let scroll = ui.input(|input| f64::from(input.smooth_scroll_delta.y));
    if scroll != 0.0 {
        let zoom = (part.zoom * 2f64.powf(scroll / SCROLL_PER_OCTAVE)).clamp(ZOOM[0], ZOOM[1]);
        // The point under the pointer stays: its distance from the middle grows with the zoom.
        let from_middle = at - response.rect.center();
        for (pan, offset) in part.pan.iter_mut().zip([from_middle.x, from_middle.y]) {
            *pan += f64::from(offset) * (1.0 / zoom - 1.0 / part.zoom);
        }
        part.zoom = zoom;
    }
}

/// Draws the sectional view `height` points high, and the figures of its position. `stale`: they are still
/// those of another position or plane than are selected. `name`: that of the drawing.
pub fn show(
    ui: &mut Ui,
    name: &str,
    shown: (&SectionView, &Position),
    part: &mut DrawingPart,
    stale: bool,
    height: f32,
) {
    let (view, position) = shown;
    let size = Vec2::new(ui.available_width(), height);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    mouse(ui, &response, part);
    let frame = SectionToScreen::new(rect, view, part);
    let painter = ui.painter_at(rect);
    let visuals = ui.visuals();
    painter.rect_filled(rect, 2.0, visuals.extreme_bg_color);
    let dark = visuals.dark_mode;
    let grey = |light: u8, night: u8| Color32::from_gray(if dark { night } else { light });
    let stock = theme::stock(visuals);
    let (radius, core) = (view.tool.radius(), view.tool.core_radius());

    // Stock before this plunge, column by column, as its top may jump.
    let wide = (frame.scale * 2.0 * HALF_WIDTH_IN_RADII * radius / 240.0 * 1.3) as f32;
    let columns = |stretches: &mut dyn Iterator<Item = (f64, [f64; 2])>, colour: Color32| {
        // One mesh: anti-aliased edges of single columns would show as stripes.
        let mut mesh = egui::Mesh::default();
        for (x, [low, top]) in stretches {
            let (a, b) = (frame.to_screen([x, low]), frame.to_screen([x, top]));
            if a.y - b.y > 0.1 {
                let (left, right) = (a.x - wide / 2.0, a.x + wide / 2.0);
                let column =
                    Rect::from_min_max(egui::pos2(left, b.y), egui::pos2(right, a.y.min(rect.bottom())));
                mesh.add_colored_rect(column, colour);
            }
        }
        painter.add(mesh);
    };
    let standing = view.before.iter().zip(&view.hub).map(|(top, hub)| (top[0], [hub[1], top[1]]));
    columns(&mut standing.into_iter(), stock);
    // The cutter: inserts at both sides, the core between them. Without a shank or holder it has no end.
    let segments = view.tool.assembly.segments(view.tool.overhang);
    let end = segments.iter().map(|segment| segment.from).fold(f64::INFINITY, f64::min);
    let high = frame.top().min(end);
    let outline = |from: f64, to: f64| -> Vec<Pos2> {
        let steps = 16;
        let along = (0..=steps).map(|i| from + (to - from) * f64::from(i) / f64::from(steps));
        let mut points = vec![frame.to_screen([from, high])];
        points.extend(along.map(|x| frame.to_screen([x, view.bottom(x)])));
        points.push(frame.to_screen([to, high]));
        points
    };
    let accent = theme::accent(visuals);
    for (from, to) in [(-radius, -core), (core, radius)] {
        painter.add(Shape::convex_polygon(outline(from, to), accent.gamma_multiply(0.28), Stroke::NONE));
    }
    painter.add(Shape::convex_polygon(
        outline(-core, core),
        grey(150, 110).gamma_multiply(0.55),
        Stroke::NONE,
    ));
    painter.line(outline(-radius, radius), Stroke::new(1.5, accent));
    // Every plane of a cut contains the tool axis: shank and holder are seen in profile.
    for segment in &segments {
        let (low, top, [a, b]) = (segment.from, segment.from + segment.length, segment.radii);
        let corners = [[-a, low], [a, low], [b, top], [-b, top]].map(|corner| frame.to_screen(corner));
        let fill = grey(120, 140).gamma_multiply(0.45);
        painter.add(Shape::convex_polygon(corners.into(), fill, Stroke::new(1.0, grey(80, 190))));
    }
    // Stock that the core hits, drawn over the cutter.
    let contact = Condition::Interfering.mark();
    columns(&mut view.contact.iter().copied(), contact.gamma_multiply(0.8));
    // The hub and its allowance.
    columns(&mut view.hub.iter().map(|p| (p[0], [frame.bottom().min(p[1]), p[1]])), grey(190, 75));
    painter.line(frame.line(&view.hub), Stroke::new(1.8, grey(40, 220)));
    let dashes = Shape::dashed_line(&frame.line(&view.allowance), Stroke::new(1.0, grey(60, 190)), 5.0, 3.0);
    painter.extend(dashes);
    painter.line(frame.line(&view.before), Stroke::new(1.4, Condition::Blocked.text(visuals)));
    painter.line(frame.line(&view.after), Stroke::new(1.4, Condition::Sound.text(visuals)));
    let axis = [frame.to_screen([0.0, frame.bottom()]), frame.to_screen([0.0, frame.top()])];
    painter.extend(Shape::dashed_line(&axis, Stroke::new(0.8, grey(90, 160)), 8.0, 4.0));
    dimensions(ui, &painter, &frame, view, position);
    patch(ui, &painter, rect, view);
    if stale {
        painter.rect_filled(rect, 2.0, visuals.panel_fill.gamma_multiply(0.5));
    }
    ui.scope(|ui| {
        if stale {
            ui.multiply_opacity(0.5);
        }
        show_figures(ui, view, position);
    });
}

/// Dimension lines, mm.
fn dimensions(
    ui: &Ui,
    painter: &egui::Painter,
    frame: &SectionToScreen,
    view: &SectionView,
    position: &Position,
) {
    let (ink, units) = (ui.visuals().strong_text_color(), units::display_units(ui));
    let short = |mm: f64| units.short(mm, 2);
    let (radius, core) = (view.tool.radius(), view.tool.core_radius());
    let high = frame.top();
    let under = |points: f32| high - f64::from(points) / frame.scale;
    let mut lines =
        vec![([-radius, under(16.0)], [radius, under(16.0)], units.diameter(view.tool.diameter), ink)];
    if core > 0.0 {
        let text = format!("core Ø{}", short(2.0 * core));
        lines.push(([-core, under(32.0)], [core, under(32.0)], text, ink));
    }
    let text = format!("insert {}", short(view.tool.insert_width));
    lines.push(([core, under(48.0)], [radius, under(48.0)], text, ink));
    let depth = view.contact_in_plane();
    if depth > 0.0 {
        let ink = Condition::Interfering.text(ui.visuals());
        let (x, depth) = if view.shows_deepest() {
            // At the deepest contact, on the side of the axis; with its exact depth.
            let at = view.deepest_along();
            (at - at.signum() * 5.0 / frame.scale, position.evaluation.contact.depth)
        } else {
            // Beside the core, as text over the contact would be unreadable.
            (-core - 6.0 / frame.scale, depth)
        };
        lines.push(([x, 0.0], [x, depth], format!("{} {}", short(depth), units.length_unit()), ink));
    }
    // The step from the previous position lies behind the axis.
    if view.step > 0.0 && view.plane == CutPlane::Row {
        let y = frame.bottom() + 11.0 / frame.scale;
        lines.push(([-view.step, y], [0.0, y], format!("step {}", short(view.step)), ink));
    }
    for (a, b, _, ink) in &lines {
        span(painter, frame, *a, *b, *ink);
    }
    // The texts come last, on a ground of their own: no line runs through them.
    let ground = ui.visuals().extreme_bg_color;
    for (a, b, text, ink) in lines {
        span_text(painter, (frame.to_screen(a), frame.to_screen(b)), text, ink, ground);
    }
}

/// A dimension line with arrows at both ends.
fn span(painter: &egui::Painter, frame: &SectionToScreen, a: SectionPoint, b: SectionPoint, ink: Color32) {
    let (a, b) = (frame.to_screen(a), frame.to_screen(b));
    let stroke = Stroke::new(1.0, ink);
    painter.line_segment([a, b], stroke);
    let along = (b - a).normalized();
    let across = along.rot90();
    if (b - a).length() > 9.0 {
        for (end, way) in [(a, along), (b, -along)] {
            painter.line_segment([end, end + way * 5.0 + across * 2.5], stroke);
            painter.line_segment([end, end + way * 5.0 - across * 2.5], stroke);
        }
    }
}

/// The text of a dimension line: in a gap of it where it is long enough, else after its end.
fn span_text(painter: &egui::Painter, (a, b): (Pos2, Pos2), text: String, ink: Color32, ground: Color32) {
    let galley = painter.layout_no_wrap(text, FontId::proportional(theme::MIN_TEXT_SIZE), ink);
    let size = galley.size() + egui::vec2(6.0, 0.0);
    let flat = (b - a).x.abs() > (b - a).y.abs();
    let at = match flat {
        true if (b - a).x.abs() > size.x + 16.0 => Align2::CENTER_CENTER.anchor_size(a + (b - a) * 0.5, size),
        true => Align2::LEFT_CENTER.anchor_size(egui::pos2(a.x.max(b.x) + 3.0, a.y), size),
        false => Align2::RIGHT_CENTER.anchor_size(a + (b - a) * 0.5 - egui::vec2(4.0, 0.0), size),
    };
    // Within the drawing, also at the end of a line that reaches its edge.
    let edge = painter.clip_rect().right();
    let at = at.translate(egui::vec2((edge - at.right()).min(0.0), 0.0));
    painter.rect_filled(at, 2.0, ground);
    painter.galley(at.min + egui::vec2(3.0, 0.0), galley, ink);
}

/// The core's disc from above, with the stock it hits.
fn patch(ui: &Ui, painter: &egui::Painter, rect: Rect, view: &SectionView) {
    let core = view.tool.core_radius();
    if core <= 0.0 {
        return;
    }
    let radius = 22.0f32;
    let middle = rect.left_top() + egui::vec2(radius + 8.0, radius + 8.0);
    let visuals = ui.visuals();
    painter.circle_filled(middle, radius, theme::overlay(visuals));
    let deepest = view.contact_depth().max(0.1);
    let cell = radius * 2.0 / 25.0;
    let mut mesh = egui::Mesh::default();
    for c in view.patch.iter().filter(|c| c.depth > 0.0) {
        let at = middle + egui::vec2((c.x / core) as f32, (-c.across / core) as f32) * radius;
        let strength = 0.4 + 0.6 * (c.depth / deepest) as f32;
        let fill = Condition::Interfering.mark().gamma_multiply(strength);
        mesh.add_colored_rect(Rect::from_center_size(at, Vec2::splat(cell)), fill);
    }
    painter.add(mesh);
    painter.circle_stroke(middle, radius, Stroke::new(1.0, visuals.strong_text_color()));
    // The plane of the cut.
    let [along, across] = view.x_in_disc.map(|part| part as f32);
    let way = egui::vec2(along, -across) * radius;
    painter.line_segment([middle - way, middle + way], Stroke::new(1.5, theme::accent(visuals)));
    let below = middle + egui::vec2(0.0, radius + 2.0);
    // On a ground of its own: the stock lies behind it.
    let font = FontId::proportional(theme::MIN_TEXT_SIZE);
    let galley = painter.layout_no_wrap("core".to_owned(), font, visuals.text_color());
    let at = Align2::CENTER_TOP.anchor_size(below, galley.size());
    painter.rect_filled(at.expand2(egui::vec2(3.0, 0.0)), 2.0, theme::overlay(visuals));
    painter.galley(at.min, galley, visuals.text_color());
}

/// The figures below the drawing.
fn show_figures(ui: &mut Ui, view: &SectionView, position: &Position) {
    let units = units::display_units(ui);
    let mut facts = vec![format!("lead {:.2}°", position.alpha_rad.to_degrees())];
    // A plunge that is lifted far ends above it.
    let has_hub = view.hub.iter().any(|[x, _]| x.abs() < view.tool.radius());
    if has_hub {
        facts.push(format!("tilt in this cut {:.2}°", view.lead_rad.to_degrees()));
    }
    if view.step > 0.0 {
        facts.push(format!("step {}", units.length(view.step, 2)));
    }
    facts.push(match has_hub {
        true => format!("max residual {}", units.length(view.max_residual, 2)),
        false => "the hub is not in this cut".to_owned(),
    });
    if position.lift > 0.0 {
        facts.push(format!("ends {} above full depth", units.length(position.lift, 2)));
    }
    let facts = RichText::new(with_minus_signs(&facts.join(", "))).small();
    // As high as the longest, so that nothing jumps while the timeline plays.
    let length = units.length(88.88, 2);
    let longest = format!(
        "lead −88.88°, tilt in this cut −88.88°, step {length}, max residual {length}, \
         ends {length} above full depth"
    );
    let longest = egui::WidgetText::from(RichText::new(longest).small());
    let wrap = Some(egui::TextWrapMode::Wrap);
    let height = longest.into_galley(ui, wrap, ui.available_width(), egui::TextStyle::Small).size().y;
    ui.vertical(|ui| {
        ui.set_min_height(height);
        ui.add(egui::Label::new(facts).wrap());
    });
    if let Some(words) = breach_words(position) {
        let colour = Condition::Interfering.text(ui.visuals());
        ui.add(egui::Label::new(RichText::new(words).small().strong().color(colour)).wrap());
    }
    if position.evaluation.contact.interferes() {
        let share = 100.0 * position.evaluation.contact.area_share;
        let depth = units.length(position.evaluation.contact.depth, 2);
        let text = format!("Core hits stock {depth} above the tip, {share:.0} % of its area");
        let colour = Condition::Interfering.text(ui.visuals());
        ui.add(egui::Label::new(RichText::new(text).small().strong().color(colour)).wrap());
        let beside = units.length(view.deepest_beside().abs(), 1);
        // One line either way: the drawing stays where it is while cuts are compared.
        let text = match view.shows_deepest() {
            true => "The deepest contact lies in this cut".to_owned(),
            false => format!("The deepest contact lies {beside} beside this cut"),
        };
        ui.add(egui::Label::new(RichText::new(text).small().color(colour)).wrap());
    }
}
