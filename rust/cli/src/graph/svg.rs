// SPDX-License-Identifier: Apache-2.0
//! Writes a picture as SVG, with the colours of a light and of a dark background, and without scripts.

use std::fmt::Write as _;

use lf_compiler::diagram::ElementKind;

use super::figure::{Drawing, Look, SIGN_WIDTH, TEXT_MARGIN, WireKind, WireLook};
use super::layout::{Placed, Rectangle, Side};
use super::text::{self, Escaped, NAME_SIZE, SMALL_SIZE};
use crate::args::GraphTheme;

/// The distance of the picture from its borders.
const MARGIN: i64 = 12;
/// The radius of corners of wires.
const CORNER: i64 = 5;
/// The distance of the members of a bank that stand behind the first one.
const STACK: i64 = 4;

/// The parts that have the same looks on each background.
const SHAPES: &str = "\
.lf-diagram text{font-family:system-ui,-apple-system,'Segoe UI',Roboto,'Liberation Sans',Arial,sans-serif}
.lf-diagram .name{font-size:13px;font-weight:600}
.lf-diagram .small{font-size:11px}
.lf-diagram .middle{text-anchor:middle}
.lf-diagram .end{text-anchor:end}
.lf-diagram .wire{fill:none;stroke-width:1.4}
.lf-diagram .trigger,.lf-diagram .effect{stroke-dasharray:5 3}
.lf-diagram .use{stroke-dasharray:1.5 3}
.lf-diagram .physical{stroke-dasharray:9 3 2 3}
.lf-diagram .mode{stroke-dasharray:4 3}
.lf-diagram .initial{stroke-dasharray:none;stroke-width:2}
.lf-diagram .federate{stroke-width:1.8}
.lf-diagram .sign{fill:none;stroke-width:1.3}
";

/// The colours on a background.
struct Palette {
    canvas: &'static str,
    ink: &'static str,
    muted: &'static str,
    wire: &'static str,
    /// The fills of reactors, by their depth in turns.
    reactors: [&'static str; 2],
    border: &'static str,
    federate: &'static str,
    reaction: [&'static str; 3],
    event: [&'static str; 3],
    mode: &'static str,
}

const LIGHT: Palette = Palette {
    canvas: "#ffffff",
    ink: "#1f2328",
    muted: "#59636e",
    wire: "#57606a",
    reactors: ["#f6f8fa", "#ffffff"],
    border: "#8c959f",
    federate: "#0969da",
    reaction: ["#ddf4ff", "#54aeff", "#0a3069"],
    event: ["#fff8c5", "#d4a72c", "#4d2d00"],
    mode: "#8250df",
};

const DARK: Palette = Palette {
    canvas: "#0d1117",
    ink: "#e6edf3",
    muted: "#9198a1",
    wire: "#9198a1",
    reactors: ["#161b22", "#21262d"],
    border: "#6e7681",
    federate: "#4493f8",
    reaction: ["#0c2d6b", "#388bfd", "#cae8ff"],
    event: ["#341a00", "#bb8009", "#f8e3a1"],
    mode: "#a371f7",
};

impl Palette {
    fn rules(&self) -> String {
        let Self { canvas, ink, muted, wire, reactors, border, federate, reaction, event, mode } = self;
        let rules = [
            (".canvas", format!("fill:{canvas}")),
            (".name", format!("fill:{ink}")),
            (".small", format!("fill:{ink}")),
            (".muted", format!("fill:{muted}")),
            (".wire", format!("stroke:{wire}")),
            (".transition", format!("stroke:{mode}")),
            (".port,.arrow", format!("fill:{wire}")),
            (".of-mode", format!("fill:{mode}")),
            (".reactor", format!("fill:{};stroke:{border}", reactors[0])),
            (".inner", format!("fill:{}", reactors[1])),
            (".federate", format!("stroke:{federate}")),
            (".reaction", format!("fill:{};stroke:{}", reaction[0], reaction[1])),
            (".of-reaction", format!("fill:{}", reaction[2])),
            (".event", format!("fill:{};stroke:{}", event[0], event[1])),
            (".of-event", format!("fill:{}", event[2])),
            (".sign", format!("stroke:{}", event[2])),
            (".label", format!("fill:{canvas};stroke:{border}")),
            (".mode", format!("fill:none;stroke:{mode}")),
        ];
        let mut text = String::new();
        for (selectors, rule) in rules {
            let selectors: Vec<String> = selectors.split(',').map(|it| format!(".lf-diagram {it}")).collect();
            let _ = writeln!(text, "{}{{{rule}}}", selectors.join(","));
        }
        text
    }
}

/// Writes the picture of a drawing whose parts have these places.
pub(super) fn write(drawing: &Drawing, placed: &Placed, theme: GraphTheme) -> String {
    let whole = placed.blocks.first().copied().unwrap_or_default();
    let (width, height) = (whole.width + 2 * MARGIN, whole.height + 2 * MARGIN);
    let colours = match theme {
        GraphTheme::Light => LIGHT.rules(),
        GraphTheme::Dark => DARK.rules(),
        GraphTheme::Auto => {
            format!("{}@media (prefers-color-scheme:dark){{\n{}}}\n", LIGHT.rules(), DARK.rules())
        }
    };
    let mut svg = Svg { text: String::new() };
    svg.line(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"lf-diagram\" role=\"img\" width=\"{width}\" \
         height=\"{height}\" viewBox=\"{} {} {width} {height}\">",
        -MARGIN, -MARGIN
    ));
    svg.line(format_args!("<title>{}</title>", Escaped(&drawing.title)));
    svg.line(format_args!("<style>\n{SHAPES}{colours}</style>"));
    svg.line(format_args!(
        "<rect class=\"canvas\" x=\"{0}\" y=\"{0}\" width=\"{width}\" height=\"{height}\"/>",
        -MARGIN
    ));
    // Borders lie below wires, and labels on them.
    for (look, rectangle) in drawing.looks.iter().zip(&placed.blocks) {
        svg.container(look, rectangle);
    }
    for (look, points) in drawing.wires.iter().zip(&placed.wires) {
        svg.wire(*look, points);
    }
    for (index, (look, rectangle)) in drawing.looks.iter().zip(&placed.blocks).enumerate() {
        svg.element(look, rectangle);
        let pins = drawing.figure.blocks[index].pins.iter().zip(&placed.pins[index]).zip(&drawing.pins[index]);
        for ((pin, point), name) in pins {
            if let Some((name, title)) = name {
                svg.port(pin.side, *point, name, title);
            }
        }
    }
    svg.line(format_args!("</svg>"));
    svg.text
}

/// The text of a picture, as far as it is written.
struct Svg {
    text: String,
}

impl Svg {
    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{line}");
    }

    fn rectangle(&mut self, class: &str, rectangle: &Rectangle, radius: i64) {
        let Rectangle { x, y, width, height } = rectangle;
        self.line(format_args!(
            "<rect class=\"{class}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"{radius}\"/>"
        ));
    }

    fn words(&mut self, class: &str, x: i64, y: i64, text: &str) {
        if !text.is_empty() {
            self.line(format_args!("<text class=\"{class}\" x=\"{x}\" y=\"{y}\">{}</text>", Escaped(text)));
        }
    }

    /// Draws a reactor or a mode, with its name.
    fn container(&mut self, look: &Look, rectangle: &Rectangle) {
        let (left, top) = (rectangle.x + TEXT_MARGIN, rectangle.y + 17);
        match look {
            Look::Reactor { title, class, subtitle, is_federate, is_bank, depth } => {
                let inner = if depth % 2 == 1 { " inner" } else { "" };
                let federate = if *is_federate { " federate" } else { "" };
                let class_of_box = format!("reactor{inner}{federate}");
                self.line(format_args!("<g><title>{}</title>", Escaped(&full_name(title, class))));
                for behind in if *is_bank { &[2, 1][..] } else { &[] } {
                    let (x, y) = (rectangle.x + behind * STACK, rectangle.y + behind * STACK);
                    self.rectangle(&class_of_box, &Rectangle { x, y, ..*rectangle }, 6);
                }
                self.rectangle(&class_of_box, rectangle, 6);
                self.words("name", left, top, title);
                let right = rectangle.x + rectangle.width - TEXT_MARGIN;
                self.words("small muted end", right, top, class);
                self.words("small muted", left, top + 16, subtitle);
                self.line(format_args!("</g>"));
            }
            Look::Mode { title, is_initial } => {
                let class = if *is_initial { "mode initial" } else { "mode" };
                self.rectangle(class, rectangle, 6);
                self.words("small of-mode", left, top - 1, title);
            }
            Look::Element { .. } | Look::Label { .. } => {}
        }
    }

    /// Draws an element or a label.
    fn element(&mut self, look: &Look, rectangle: &Rectangle) {
        let Rectangle { x, y, width, height } = *rectangle;
        let base = y + height / 2 + 4;
        match look {
            Look::Element { kind: ElementKind::Reaction, name, timing, declaration } => {
                self.line(format_args!("<g><title>{}</title>", Escaped(declaration)));
                let (right, bottom, middle) = (x + width, y + height, y + height / 2);
                self.line(format_args!(
                    "<path class=\"reaction\" d=\"M{x} {y}H{}L{right} {middle}L{} {bottom}H{x}L{} {middle}Z\"/>",
                    right - 7,
                    right - 7,
                    x + 7
                ));
                self.names("of-reaction", x + 7 + TEXT_MARGIN, base, name, timing);
                self.line(format_args!("</g>"));
            }
            Look::Element { kind, name, timing, declaration } => {
                self.line(format_args!("<g><title>{}</title>", Escaped(declaration)));
                self.rectangle("event", rectangle, height / 2);
                self.sign(*kind, x + TEXT_MARGIN + 6, y + height / 2);
                self.names("of-event", x + TEXT_MARGIN + SIGN_WIDTH - 3, base, name, timing);
                self.line(format_args!("</g>"));
            }
            Look::Label { text } => {
                self.rectangle("label", rectangle, height / 2);
                self.words("small middle", x + width / 2, base, text);
            }
            Look::Reactor { .. } | Look::Mode { .. } => {}
        }
    }

    /// Writes a name, and times behind it.
    fn names(&mut self, class: &str, x: i64, y: i64, name: &str, timing: &str) {
        self.words(&format!("small {class}"), x, y, name);
        self.words("small muted", x + text::width(name, SMALL_SIZE) + 4, y, timing);
    }

    /// Draws the sign of an event around a point: a clock, a triangle with the letter of an action, a ring, a square.
    fn sign(&mut self, kind: ElementKind, x: i64, y: i64) {
        let triangle = |x: i64, y: i64| format!("M{x} {}l6 11h-12z", y - 6);
        match kind {
            ElementKind::Timer => self.line(format_args!(
                "<circle class=\"sign\" cx=\"{x}\" cy=\"{y}\" r=\"6\"/><path class=\"sign\" d=\"M{x} {}V{y}L{} {}\"/>",
                y - 4,
                x + 3,
                y + 2
            )),
            ElementKind::LogicalAction => self.line(format_args!("<path class=\"sign\" d=\"{}\"/>", triangle(x, y))),
            ElementKind::PhysicalAction => {
                self.line(format_args!("<path class=\"sign\" d=\"{}\" style=\"stroke-width:2.6\"/>", triangle(x, y)));
            }
            ElementKind::Watchdog => self.line(format_args!(
                "<rect class=\"sign\" x=\"{}\" y=\"{}\" width=\"11\" height=\"11\"/>\
                 <path class=\"sign\" d=\"M{x} {}V{y}L{} {}\"/>",
                x - 5,
                y - 5,
                y - 3,
                x + 3,
                y + 2
            )),
            ElementKind::Startup => self.line(format_args!("<circle class=\"sign\" cx=\"{x}\" cy=\"{y}\" r=\"5\"/>")),
            ElementKind::Shutdown | ElementKind::Reset | ElementKind::Reaction => {
                self.line(format_args!("<path class=\"sign\" d=\"M{x} {}l6 6l-6 6l-6 -6z\"/>", y - 6));
            }
        }
    }

    /// Draws a port at a border, and its name inside.
    fn port(&mut self, side: Side, (x, y): (i64, i64), name: &str, title: &str) {
        self.line(format_args!("<g><title>{}</title>", Escaped(title)));
        self.line(format_args!("<path class=\"port\" d=\"M{} {}l9 5l-9 5z\"/>", x - 4, y - 5));
        match side {
            Side::Left => self.words("small", x + TEXT_MARGIN, y + 4, name),
            Side::Right => self.words("small end", x - TEXT_MARGIN, y + 4, name),
        }
        self.line(format_args!("</g>"));
    }

    /// Draws a wire with round corners.
    fn wire(&mut self, look: WireLook, points: &[(i64, i64)]) {
        let class = match look.kind {
            WireKind::Connection => "connection",
            WireKind::Physical => "physical",
            WireKind::Trigger => "trigger",
            WireKind::Use => "use",
            WireKind::Effect => "effect",
            WireKind::Transition => "transition",
        };
        let [first, .., last] = points else { return };
        let mut path = format!("M{} {}", first.0, first.1);
        for corner in points.windows(3) {
            let [before, at, after] = [corner[0], corner[1], corner[2]];
            let (begin, end) = (towards(at, before), towards(at, after));
            let _ = write!(path, "L{} {}Q{} {} {} {}", begin.0, begin.1, at.0, at.1, end.0, end.1);
        }
        let _ = write!(path, "L{} {}", last.0, last.1);
        self.line(format_args!("<path class=\"wire {class}\" d=\"{path}\"/>"));
        if look.has_arrow {
            let class = if look.kind == WireKind::Transition { "of-mode" } else { "arrow" };
            self.line(format_args!("<path class=\"{class}\" d=\"M{} {}l-8 -4v8z\"/>", last.0, last.1));
        }
    }
}

/// Returns the point at the beginning of a round corner, on the way to its neighbor.
fn towards(corner: (i64, i64), neighbor: (i64, i64)) -> (i64, i64) {
    let part = |from: i64, to: i64| from + ((to - from) / 2).clamp(-CORNER, CORNER);
    (part(corner.0, neighbor.0), part(corner.1, neighbor.1))
}

/// Returns the name of an instance with that of its reactor.
fn full_name(title: &str, class: &str) -> String {
    if class.is_empty() { title.to_owned() } else { format!("{title} = new {class}") }
}

/// The rules for texts have the sizes for which the widths are computed.
const _: () = assert!(NAME_SIZE == 13 && SMALL_SIZE == 11);
