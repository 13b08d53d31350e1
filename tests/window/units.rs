//! Lengths and feed rates in inches: shown and typed, while files stay in mm.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use vanecut::app::model::file_purpose::Purpose;
use vanecut::app::model::look::Operation;
use vanecut::app::model::units::DisplayUnits;
use vanecut::app::tasks::engine::Engine;
use vanecut::io::project_file::read_project;
use vanecut::job::PlanOutcome;

use crate::fake;
use crate::harness::{Window, labels, settle, snapshot_view, type_into, window, with_sample};
use crate::machine::{line_of_axes, with_machine};

/// Chooses a unit in the menu.
fn choose(window: &mut Window, unit: &str) {
    window.get_by_label("View").click();
    window.run_steps(3);
    window.get_by_label_contains("Units").click();
    window.run_steps(3);
    window.get_by_role_and_label(Role::RadioButton, unit).click();
    window.run_steps(3);
}

fn allowance(window: &Window) -> f64 {
    window.state().state().document.edited.setup.allowances.hub_allowance
}

#[test]
fn clearances_beside_a_fine_allowance_have_a_decimal_more() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1100.0, 1400.0));
    window.run_steps(3);
    let of_both = |window: &Window| ["0.50 mm", "0.500 mm"].map(|text| labels(window, text).len());
    assert_eq!(of_both(&window), [2, 0], "of hub and blades");
    type_into(&mut window, ("Hub allowance", 0), "0.025");
    assert_eq!(allowance(&window), 0.025);
    assert_eq!(of_both(&window), [1, 1], "the allowance of the blades is still of tenths");
}

/// The fake planner, whose tool has this diameter.
fn engine_with_tool_of(diameter: f64) -> Engine {
    let (engine, _) = fake::engine();
    let sized = move |outcome: &mut PlanOutcome| {
        for plan in [&mut outcome.before.plan, &mut outcome.after.plan] {
            plan.sections[0].tool.diameter = diameter;
        }
    };
    fake::with_changed_plans(engine, sized)
}

#[test]
fn the_diameter_of_a_tool_has_all_its_digits_in_the_table() {
    let mut window = with_sample(engine_with_tool_of(9.525));
    for (unit, text) in [("Units: mm", "9.525"), ("Units: inch", "0.375")] {
        choose(&mut window, unit);
        window.run_steps(3);
        let shown = labels(&window, text);
        assert!(shown.iter().any(|shown| shown == text), "{unit}: {shown:?}");
        // It fits between the columns beside it.
        let cell = window.query_all_by_label(text).next().expect("a cell").rect();
        let head = |name: &str| window.get_by_label(name).rect();
        assert!(cell.left() > head("Sort by row").right(), "{cell} {}", head("Sort by row"));
        assert!(cell.right() <= head("Sort by lead angle").left(), "{cell}");
    }
}

#[test]
fn a_setup_sheet_says_its_units_whatever_the_window_shows() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    choose(&mut window, "Units: inch");
    let path = folder.path().join("sheet.html");
    let ctx = window.ctx.clone();
    let purpose = Purpose::ExportSheet { operation: Operation::Roughing };
    window.state_mut().file_chosen(&ctx, purpose, path.clone());
    settle(&mut window);
    if window.query_by_label("Export anyway").is_some() {
        window.get_by_label("Export anyway").click();
        window.run_steps(3);
        settle(&mut window);
    }
    let notice = window.state().state().notice.clone().expect("a word about it");
    assert!(notice.text.ends_with("in mm"), "{notice:?}");
    let page = std::fs::read_to_string(&path).expect("a page");
    assert!(page.contains("Lengths are in mm and feed rates in mm/min"));
    assert!(page.contains("⌀30 R0 mm, insert width 10 mm"));
}

/// Whether some label says `text`.
fn says(window: &Window, text: &str) -> bool {
    window.query_all_by(|node| node.value().is_some_and(|value| value.contains(text))).next().is_some()
}

#[test]
fn every_length_is_shown_in_inches_when_asked_for() {
    let (engine, _) = fake::engine();
    let mut window = with_sample(engine);
    window.set_size(egui::vec2(1280.0, 900.0));
    window.run_steps(3);
    window.get_by_label("Position 3").click();
    window.run_steps(3);
    window.get_by_label("Figures").click_accesskit();
    window.run_steps(3);
    let said = labels(&window, "");
    assert!(says(&window, "532.0 mm") && says(&window, "300 mm/min"), "the part, and a feed rate: {said:?}");
    choose(&mut window, "Units: inch");
    // Names and tips of the machine's files and the words of the planner stay.
    for unit in [" mm", "mm/min"] {
        let left: Vec<String> = labels(&window, "").into_iter().filter(|text| text.contains(unit)).collect();
        assert!(left.is_empty(), "still in mm: {left:?}");
    }
    assert!(says(&window, "20.945 in") && says(&window, "11.8 in/min"), "{:?}", labels(&window, ""));
    window.get_by_label("Sectional view").click_accesskit();
    window.run_steps(3);
    settle(&mut window);
    snapshot_view(&mut window, "inches");
    choose(&mut window, "Units: mm");
    assert!(says(&window, "532.0 mm"));
}

#[test]
fn the_axes_of_the_machine_have_the_unit_of_lengths() {
    let mut window = with_machine("ac-trunnion");
    for (choice, unit, other) in [("Units: inch", " in  A ", " mm  "), ("Units: mm", " mm  A ", " in  ")] {
        choose(&mut window, choice);
        let line = line_of_axes(&window).expect("the axes");
        assert!(line.contains(unit) && !line.contains(other), "{line}");
    }
}

#[test]
fn typed_numbers_are_inches_then_and_files_stay_in_mm() {
    let folder = tempfile::tempdir().expect("a folder");
    let (engine, _) = fake::engine();
    let mut first = with_sample(engine.clone());
    first.state_mut().set_home(folder.path().join("home"));
    first.set_size(egui::vec2(1100.0, 1000.0));
    first.run_steps(3);
    choose(&mut first, "Units: inch");
    // A field that is only visited keeps its value, which is not quite what it shows.
    let kept = allowance(&first);
    first.get_by_role_and_label(Role::SpinButton, "Hub allowance").click();
    first.run_steps(3);
    first.key_press(egui::Key::Tab);
    first.run_steps(3);
    settle(&mut first);
    assert_eq!(allowance(&first).to_bits(), kept.to_bits());
    type_into(&mut first, ("Hub allowance", 0), "0.03");
    assert!((allowance(&first) - 0.762).abs() < 1e-12, "{}", allowance(&first));
    type_into(&mut first, ("Hub allowance", 0), "0.9 mm");
    assert!((allowance(&first) - 0.9).abs() < 1e-12, "a unit that is typed counts");
    type_into(&mut first, ("Hub allowance", 0), "1/20");
    assert!((allowance(&first) - 1.27).abs() < 1e-12, "{}", allowance(&first));
    let path = folder.path().join("p.vanecut");
    let ctx = first.ctx.clone();
    first.state_mut().file_chosen(&ctx, Purpose::SaveProject, path.clone());
    settle(&mut first);
    let written = read_project(&path).expect("reads").setup.allowances.hub_allowance;
    assert_eq!(written, allowance(&first));
    drop(first);
    let mut second = window(engine);
    second.state_mut().set_home(folder.path().join("home"));
    second.run_steps(2);
    assert_eq!(second.state().state().look.units, DisplayUnits::Inch, "it is a preference");
}

/// Numbers in inches have more digits than those in mm.
#[test]
fn the_cells_of_the_table_do_not_touch_in_inches() {
    let (engine, _) = fake::engine();
    let deep = move |outcome: &mut PlanOutcome| {
        outcome.after.plan.positions[0].evaluation.contact.depth = 9.0;
    };
    let mut window = with_sample(fake::with_changed_plans(engine, deep));
    choose(&mut window, "Units: inch");
    window.set_size(egui::vec2(1100.0, 700.0));
    window.run_steps(4);
    let row = window.get_by_role_and_label(Role::Row, "Position 1").rect();
    let texts = window.query_all_by(|node| node.role() == Role::Label && node.value().is_some());
    let mut cells: Vec<egui::Rect> = texts
        .map(|node| node.rect())
        .filter(|rect| row.left() <= rect.left() && (rect.center().y - row.center().y).abs() < 3.0)
        .collect();
    cells.sort_by(|a, b| a.left().total_cmp(&b.left()));
    assert!(cells.len() >= 6, "{cells:?}");
    for pair in cells.windows(2) {
        let space = pair[1].left() - pair[0].right();
        assert!(space >= 10.0, "{space} points between {} and {}", pair[0], pair[1]);
    }
}

/// A deviation that is rounded away is on neither side.
#[test]
fn what_is_shown_as_zero_has_no_sign() {
    let text = |value| DisplayUnits::Inch.deviation(value);
    assert_eq!(text(-0.000_01), "0.00000 in");
    assert_eq!(text(0.0), "0.00000 in");
    assert_eq!(text(-0.01), "−0.00039 in");
    assert_eq!(text(0.01), "+0.00039 in");
}
