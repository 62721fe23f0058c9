//! Row of one knob: name, control, and a mark if it was changed. Everything is derived from the knob's declaration.

use crate::knobs::{Edits, Knobs, shown};
use egui::{Color32, ComboBox, DragValue, Response, RichText, Slider, TextEdit, Ui};
use pelage_params::{Control, Knob, TableInfo, hex};
use pelage_stage::CONDITIONS;

/// Largest range for which a slider is shown. For larger ranges the number itself is dragged.
const WIDEST_SLIDER: f64 = 1e5;
const CHANGED: Color32 = Color32::from_rgb(232, 176, 92);

enum KnobInput {
    Nothing,
    /// New value during a drag, as TOML. More changes of the same drag may follow.
    Drags(String),
    /// Final new value, as TOML.
    Sets(String),
}

/// Draws the row of a knob of `table` and stores changes in `edits`. Returns whether anything changed. A knob without
/// effect is greyed.
///
/// * `now`: the set of knobs with all edits
/// * `holds`: whether a condition of the application holds ([`Knob::needs`])
pub fn row(
    ui: &mut Ui,
    (table, knob): (&TableInfo, &'static Knob),
    now: &dyn Knobs,
    edits: &mut Edits,
    holds: &dyn Fn(&str) -> bool,
) -> bool {
    let value = now.value(knob);
    let differs = value != now.default_value(knob);
    let idle = table.unmet(knob, |name| now.value_of(name), holds).map(|need| idle_reason(need, now));
    let mut reset = false;
    ui.horizontal(|ui| {
        let name = RichText::new(knob.key().replace('_', " "));
        let name = match (&idle, differs) {
            (Some(_), _) => name.weak(),
            (None, true) => name.color(CHANGED),
            (None, false) => name,
        };
        ui.label(name).on_hover_ui(|ui| explain(ui, knob, now, idle.as_deref()));
        if edits.has(knob.name) {
            let undo = ui.small_button("reset").on_hover_text("to the value in the file");
            reset = undo.clicked();
        }
    });
    let drawn = |ui: &mut Ui| ui.push_id(knob.name, |ui| control(ui, knob, value.as_deref())).inner;
    let drawn = ui.add_enabled_ui(idle.is_none(), drawn);
    if let Some(reason) = &idle {
        drawn.response.on_hover_text(reason);
    }
    let hand = drawn.inner;
    ui.end_row();
    match hand {
        _ if reset => edits.reset(knob.name),
        KnobInput::Nothing => return false,
        KnobInput::Drags(value) => edits.set(knob.name, value, true),
        KnobInput::Sets(value) => {
            edits.set(knob.name, value, false);
            edits.released();
        }
    }
    true
}

/// Returns the reason why a knob has no effect, for its first condition that is not met.
pub fn idle_reason(need: &str, now: &dyn Knobs) -> String {
    let value = |name: &str| now.value_of(name).map_or("none".into(), |value| shown(&value));
    match (need.split_once("!="), need.split_once('=')) {
        (Some((name, word)), _) => format!("No effect while {name} is {word}."),
        (None, Some((name, word))) => format!("No effect while {name} is {}: needs {word}.", value(name)),
        (None, None) => {
            let reason = CONDITIONS.iter().find(|(name, _)| *name == need).map_or(need, |(_, reason)| *reason);
            format!("No effect: {reason}.")
        }
    }
}

/// Shows the meaning, range and default of a knob, and the reason if it has no effect.
fn explain(ui: &mut Ui, knob: &Knob, now: &dyn Knobs, idle: Option<&str>) {
    ui.set_max_width(380.0);
    ui.label(RichText::new(knob.name).monospace().strong());
    if let Some(reason) = idle {
        ui.label(RichText::new(reason).color(CHANGED));
    }
    ui.label(knob.doc.trim());
    ui.label(RichText::new(format!("Takes {}.", (knob.expected)())).weak());
    let default = now.default_value(knob).map_or("left out, chosen automatically".into(), |text| shown(&text));
    ui.label(RichText::new(format!("Default: {default}.")).weak());
}

fn control(ui: &mut Ui, knob: &Knob, value: Option<&str>) -> KnobInput {
    match ((knob.control)(), value) {
        (Control::Toggle, value) => {
            let mut on = value == Some("true");
            if ui.checkbox(&mut on, "").changed() { KnobInput::Sets(on.to_string()) } else { KnobInput::Nothing }
        }
        (Control::Choice(choices), value) => {
            let word = value.map(shown).unwrap_or_default();
            let mut hand = KnobInput::Nothing;
            ComboBox::from_id_salt(knob.name).selected_text(&word).width(140.0).show_ui(ui, |ui| {
                for choice in choices {
                    let answer = ui.selectable_label(choice.word == word, choice.word).on_hover_text(choice.doc.trim());
                    if answer.clicked() {
                        hand = KnobInput::Sets(format!("{:?}", choice.word));
                    }
                }
            });
            hand
        }
        (Control::PowerOfTwo { least, most }, Some(value)) => {
            let (lowest, highest) = (least.trailing_zeros(), most.trailing_zeros());
            let mut power = value.parse::<u32>().map_or(lowest, u32::trailing_zeros);
            let slider =
                Slider::new(&mut power, lowest..=highest).custom_formatter(|n, _| (1_u64 << n as u32).to_string());
            let answer = ui.add(slider);
            dragged(&answer, || (1_u64 << power).to_string())
        }
        (Control::Number { least, most, whole, logarithmic }, Some(value)) if value.parse::<f64>().is_ok() => {
            let mut number: f64 = value.parse().unwrap_or(least);
            let answer = if most - least <= WIDEST_SLIDER || logarithmic {
                let slider = Slider::new(&mut number, least..=most).logarithmic(logarithmic).smart_aim(false);
                let slider = if whole { slider.integer() } else { slider.max_decimals(6) };
                ui.add(slider)
            } else {
                {
                    let speed = speed(number);
                    ui.add(DragValue::new(&mut number).range(least..=most).speed(speed).max_decimals(if whole {
                        0
                    } else {
                        6
                    }))
                }
            };
            let rounds = answer.dragged() && !whole;
            let number = if rounds { rounded(number).clamp(least, most) } else { number };
            dragged(&answer, || number_text(number, whole))
        }
        (Control::Number { least, most, whole, .. }, value) => {
            unset_button(ui, value, || number_text(middle(least, most), whole))
        }
        (Control::Vector { least, most, .. }, Some(value)) if numbers(value).is_some() => {
            let mut numbers = numbers(value).unwrap_or_default();
            let answers: Vec<Response> = ui
                .horizontal(|ui| {
                    let one = |n: &mut f64| {
                        let speed = speed(*n);
                        ui.add(DragValue::new(n).range(least..=most).speed(speed).max_decimals(3))
                    };
                    numbers.iter_mut().map(one).collect()
                })
                .inner;
            let all = answers.into_iter().reduce(|a, b| a.union(b));
            all.map_or(KnobInput::Nothing, |answer| dragged(&answer, || vector_text(&numbers)))
        }
        (Control::Vector { len, least, most }, value) => {
            unset_button(ui, value, || vector_text(&vec![1.0_f64.clamp(least, most); len]))
        }
        (Control::Color, value) => {
            let mut rgb = value.and_then(color).unwrap_or([128; 3]);
            let answer = ui.color_edit_button_srgb(&mut rgb);
            let [r, g, b] = rgb;
            dragged(&answer, || format!("\"#{r:02x}{g:02x}{b:02x}\""))
        }
        (Control::PowerOfTwo { .. } | Control::Text | Control::Tables(_), value) => text(ui, knob, value),
    }
}

/// Draws an unset knob as a button; a click sets it to `begin()`.
fn unset_button(ui: &mut Ui, value: Option<&str>, begin: impl FnOnce() -> String) -> KnobInput {
    let word = value.map_or("chosen".into(), shown);
    let answer = ui.button(word).on_hover_text("chosen automatically; click to set it yourself");
    if answer.clicked() { KnobInput::Sets(begin()) } else { KnobInput::Nothing }
}

/// Draws a text field for values that no other control can express. The value is accepted when the field loses focus,
/// or on Enter.
fn text(ui: &mut Ui, knob: &Knob, value: Option<&str>) -> KnobInput {
    let id = ui.make_persistent_id("text");
    let stands = value.map(shown).unwrap_or_default();
    let mut typed = ui.data_mut(|data| data.get_temp::<String>(id)).unwrap_or_else(|| stands.clone());
    let answer = ui.add(TextEdit::singleline(&mut typed).desired_width(150.0).hint_text("left out"));
    if answer.lost_focus() && typed != stands {
        ui.data_mut(|data| data.remove::<String>(id));
        return KnobInput::Sets(toml_of(knob, &typed));
    }
    if answer.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, typed));
    } else {
        ui.data_mut(|data| data.remove::<String>(id));
    }
    KnobInput::Nothing
}

/// Converts typed text to TOML. Lists, numbers and quoted strings are unchanged; anything else becomes a string.
fn toml_of(knob: &Knob, typed: &str) -> String {
    let as_it_is = typed.starts_with(['[', '{', '"']) || typed.parse::<f64>().is_ok();
    if as_it_is || matches!((knob.control)(), Control::Tables(_)) { typed.to_owned() } else { format!("{typed:?}") }
}

/// Converts the response of a widget that can be dragged.
fn dragged(answer: &Response, text: impl FnOnce() -> String) -> KnobInput {
    match (answer.changed(), answer.dragged()) {
        (true, true) => KnobInput::Drags(text()),
        (true, false) => KnobInput::Sets(text()),
        _ => KnobInput::Nothing,
    }
}

/// Rounds a number to the digits that dragging can set: four.
fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// Formats a number as TOML: the shortest text that gives the same `f32`. If the knob's type is not `whole`, the text
/// has a point or an exponent.
fn number_text(number: f64, whole: bool) -> String {
    if whole { format!("{:.0}", number.round()) } else { format!("{:?}", number as f32) }
}

fn vector_text(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(|n| number_text(*n, false)).collect::<Vec<_>>().join(", "))
}

/// Returns an initial value within a range.
fn middle(least: f64, most: f64) -> f64 {
    if least > 0.0 { (least * most).sqrt() } else { 0.5 * (least + most.min(least + 2.0)) }
}

fn speed(number: f64) -> f64 {
    (0.01 * number.abs()).max(0.01)
}

fn numbers(toml: &str) -> Option<Vec<f64>> {
    let inside = toml.strip_prefix('[')?.strip_suffix(']')?;
    inside.split(',').map(|n| n.trim().parse().ok()).collect()
}

fn color(toml: &str) -> Option<[u8; 3]> {
    let listed =
        || numbers(toml).and_then(|n| <[f64; 3]>::try_from(n).ok()).map(|n| n.map(|c| (255.0 * c).round() as u8));
    hex(&shown(toml)).or_else(listed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_params::Tables as _;
    use pelage_stage::Look;

    /// Returns the idle knobs of a look among some, with their reasons. The package has layers that are drawn, but no
    /// strands, fins or fibres.
    fn idle(look: &Look, names: &[&str]) -> Vec<String> {
        let holds = |condition: &str| matches!(condition, "fur" | "moving hair" | "drawn layers");
        let knobs = Look::TABLES.iter().flat_map(|table| table.knobs.iter().map(move |knob| (table, knob)));
        let named = knobs.filter(|(_, knob)| names.contains(&knob.name));
        let reason = |(table, knob): (&TableInfo, &Knob)| {
            let need = table.unmet(knob, |name| look.value_of(name), holds)?;
            Some(format!("{}: {}", knob.name, idle_reason(need, look)))
        };
        named.filter_map(reason).collect()
    }

    #[test]
    fn knobs_without_effect_say_why() {
        let mut look = Look::default();
        let names = ["shadow.shrink", "fur.detail", "fur.fins", "fur.strand_edges", "motion.gust", "ink.width"];
        let of_ink = "No effect while picture.style is";
        assert_eq!(
            idle(&look, &names),
            [
                "fur.fins: No effect: the package has no fins.".to_owned(),
                "fur.strand_edges: No effect: the picture shows no single strands, because layers replace them.".into(),
                "motion.gust: No effect while motion.wind is [0.0, 0.0, 0.0].".into(),
                format!("ink.width: {of_ink} fur: needs ink."),
            ]
        );
        for set in ["picture.style=ink", "motion.wind=[1, 0, 0]"] {
            assert!(Look::set(&mut look, set).is_ok(), "{set}");
        }
        assert_eq!(
            idle(&look, &names),
            [
                "shadow.shrink: No effect while picture.style is ink.".to_owned(),
                format!("fur.detail: {of_ink} ink: needs fur."),
                format!("fur.fins: {of_ink} ink: needs fur."),
                format!("fur.strand_edges: {of_ink} ink: needs fur."),
                "ink.width: No effect while ink.lines is strokes: needs pixels.".into(),
            ]
        );
    }

    #[test]
    fn knob_values_are_parsed_and_formatted_consistently() {
        assert_eq!(numbers("[1.0, -2.5, 3]"), Some(vec![1.0, -2.5, 3.0]));
        assert_eq!(numbers("auto"), None);
        assert_eq!(color("\"#0a14ff\""), Some([10, 20, 255]));
        assert_eq!(color("[1.0, 0.5, 0.0]"), Some([255, 128, 0]));
        assert_eq!(
            ["0.1", "2.0", "1e-6"].map(|n| number_text(n.parse().unwrap_or(0.0), false)),
            ["0.1", "2.0", "1e-6"]
        );
        // Ends of ranges and numbers with more digits than an f32 can hold.
        assert_eq!(
            [f64::from(0.1_f32), 16_777_217.0, 1.0 / 3.0].map(|n| number_text(n, false)),
            ["0.1", "16777216.0", "0.33333334"]
        );
        assert_eq!([0.437_291_5, 1234.56, 2.0e-6].map(rounded), [0.4373, 1235.0, 2e-6]);
        assert_eq!(number_text(7.6, true), "8");
        assert!((middle(1e-6, 1e3) - 0.0316).abs() < 1e-4);
        assert_eq!(middle(0.0, 1.0), 0.5);
    }
}
