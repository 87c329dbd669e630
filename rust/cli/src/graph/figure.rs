// SPDX-License-Identifier: Apache-2.0
//! Makes blocks and wires of a diagram: a block for each reactor, mode, element and delay.

use std::collections::BTreeMap;

use lf_compiler::deployment::{Deployment, Platform, RtiHome};
use lf_compiler::diagram::{Diagram, DiagramEdge, DiagramElement, DiagramReactor, EdgeEnd, EdgeKind, ElementKind};
use lf_compiler::plan::Coordination;

use super::layout::{Block, Figure, Pin, Side, Wire};
use super::text::{self, NAME_SIZE, SMALL_SIZE};

/// The height of the line with a reactor's name.
const TITLE_ROW: i64 = 24;
/// The height of the line below that.
const SUBTITLE_ROW: i64 = 16;
/// The height of a reaction, and of the other elements.
const ELEMENT_HEIGHT: i64 = 26;
/// The height of a delay.
const DELAY_HEIGHT: i64 = 18;
/// The distance of a text from the borders at its sides.
pub(super) const TEXT_MARGIN: i64 = 9;
/// The width of the sign in an element.
pub(super) const SIGN_WIDTH: i64 = 20;

/// A figure, and how its parts look.
pub(super) struct Drawing {
    /// The name and the kind of the program.
    pub(super) title: String,
    pub(super) figure: Figure,
    /// One for each block.
    pub(super) looks: Vec<Look>,
    /// Per block, the names of its pins and what they say in more words; none for those of modes.
    pub(super) pins: Vec<Vec<Option<(String, String)>>>,
    /// One for each wire.
    pub(super) wires: Vec<WireLook>,
}

/// The look of a block.
pub(super) enum Look {
    /// A reactor.
    Reactor {
        title: String,
        class: String,
        subtitle: String,
        is_federate: bool,
        is_bank: bool,
        /// The number of reactors around it.
        depth: usize,
    },
    /// A mode of a reactor.
    Mode { title: String, is_initial: bool },
    /// A reaction, or what triggers reactions.
    Element { kind: ElementKind, name: String, timing: String, declaration: String },
    /// A text on a wire: the delay of a connection, or the kind of a transition.
    Label { text: String },
}

/// The look of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WireLook {
    pub(super) kind: WireKind,
    /// Whether it has an arrow at its end.
    pub(super) has_arrow: bool,
}

/// The kinds of wires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WireKind {
    Connection,
    Physical,
    Trigger,
    Use,
    Effect,
    Transition,
}

/// Returns the drawing of a diagram, with the contents of reactors up to this depth.
pub(super) fn drawing(diagram: &Diagram, deployment: Option<&Deployment>, depth: usize) -> Drawing {
    let coordination = diagram.coordination.map(|coordination| match coordination {
        Coordination::Centralized => "centralized coordination",
        Coordination::Decentralized => "decentralized coordination",
    });
    let kind = coordination.map_or_else(|| "reactors".to_owned(), |word| format!("federation with {word}"));
    let mut maker = Maker {
        diagram,
        drawing: Drawing {
            title: format!("{}: {kind}", diagram.name),
            figure: Figure::default(),
            looks: Vec::new(),
            pins: Vec::new(),
            wires: Vec::new(),
        },
        blocks: vec![None; diagram.reactors.len()],
        modes: vec![Vec::new(); diagram.reactors.len()],
    };
    let mut depths = vec![0; diagram.reactors.len()];
    for (index, reactor) in diagram.reactors.iter().enumerate() {
        depths[index] = reactor.parent.map_or(0, |parent| depths[parent] + 1);
        if depths[index] > depth {
            continue;
        }
        let subtitle = match reactor.parent {
            None => main_place(diagram, deployment),
            Some(_) => place(reactor, deployment),
        };
        let has_contents = depths[index] < depth;
        maker.reactor(index, depths[index], has_contents, subtitle);
    }
    for (index, depth_of) in depths.iter().enumerate() {
        if *depth_of < depth {
            maker.contents(index);
        }
    }
    maker.drawing
}

/// Returns where a federate runs.
fn place(reactor: &DiagramReactor, deployment: Option<&Deployment>) -> String {
    if reactor.federates.is_empty() {
        return String::new();
    }
    let Some(deployment) = deployment else {
        return reactor.host.as_ref().map(|host| format!("at {host}")).unwrap_or_default();
    };
    let mut places: Vec<String> = Vec::new();
    for federate in &reactor.federates {
        let place = deployment.place(federate);
        let ip = place.network.map(|network| format!(", {}", network.ip)).unwrap_or_default();
        let rti = if deployment.is_joint(federate) { ", with the RTI" } else { "" };
        let text = match &place.platform {
            Platform::Host => format!("this computer{ip}"),
            Platform::Zephyr(board) => format!("{board}{ip}{rti}"),
        };
        if !places.contains(&text) {
            places.push(text);
        }
    }
    match &places[..] {
        [one] => one.clone(),
        [first, others @ ..] => format!("{first} and {} more", others.len()),
        [] => String::new(),
    }
}

/// Returns the coordination of a federation, and where its RTI runs.
fn main_place(diagram: &Diagram, deployment: Option<&Deployment>) -> String {
    let Some(coordination) = diagram.coordination else { return String::new() };
    let word = match coordination {
        Coordination::Centralized => "centralized",
        Coordination::Decentralized => "decentralized",
    };
    let rti = match deployment.map(|deployment| &deployment.rti) {
        None => diagram.reactors.first().and_then(|main| main.host.clone()).unwrap_or_default(),
        Some(rti) => {
            let ip = rti.ip.map(|ip| ip.to_string()).unwrap_or_default();
            match &rti.home {
                RtiHome::Program if ip.is_empty() => "this computer".to_owned(),
                RtiHome::Program => format!("this computer, {ip}"),
                RtiHome::Image(place) => match &place.platform {
                    Platform::Zephyr(board) => format!("{board} {ip}"),
                    Platform::Host => ip,
                },
                RtiHome::Joint(federate) => federate.clone(),
            }
        }
    };
    if rti.is_empty() { word.to_owned() } else { format!("{word}; RTI: {}", rti.trim_end()) }
}

struct Maker<'a> {
    diagram: &'a Diagram,
    drawing: Drawing,
    /// Per reactor its block, if it is drawn.
    blocks: Vec<Option<usize>>,
    /// Per reactor the blocks of its modes.
    modes: Vec<Vec<usize>>,
}

impl Maker<'_> {
    fn block(&mut self, block: Block, look: Look) -> usize {
        self.drawing.pins.push(vec![None; block.pins.len()]);
        self.drawing.figure.blocks.push(block);
        self.drawing.looks.push(look);
        self.drawing.looks.len() - 1
    }

    /// Adds the block of a reactor, and those of its modes if its contents are drawn.
    fn reactor(&mut self, index: usize, depth: usize, has_contents: bool, subtitle: String) {
        let reactor = &self.diagram.reactors[index];
        let parent = reactor.parent.and_then(|parent| match reactor.mode {
            Some(mode) => self.modes[parent].get(mode).copied(),
            None => self.blocks[parent],
        });
        let title = match reactor.members {
            Some(members) => format!("{}[{members}]", reactor.name),
            None => reactor.name.clone(),
        };
        // The main reactor has the name of its class, or none.
        let class = if reactor.parent.is_none() { String::new() } else { reactor.class.clone() };
        let names: Vec<String> = reactor
            .ports
            .iter()
            .map(|port| port.width.map_or_else(|| port.name.clone(), |width| format!("{}[{width}]", port.name)))
            .collect();
        let pins = reactor.ports.iter().zip(&names).map(|(port, name)| Pin {
            side: if port.is_input { Side::Left } else { Side::Right },
            width: text::width(name, SMALL_SIZE) + TEXT_MARGIN + 4,
        });
        let title_width = text::width(&title, NAME_SIZE) * 11 / 10 + text::width(&class, SMALL_SIZE) + 3 * TEXT_MARGIN;
        let width = title_width.max(text::width(&subtitle, SMALL_SIZE) + 2 * TEXT_MARGIN);
        let header = TITLE_ROW + if subtitle.is_empty() { 0 } else { SUBTITLE_ROW };
        let least = (width, header + 8);
        let block = Block { parent, least, header, pins: pins.collect(), keeps_order: true, is_delay: false };
        let (is_federate, is_bank) = (!reactor.federates.is_empty(), reactor.members.is_some());
        let own = self.block(block, Look::Reactor { title, class, subtitle, is_federate, is_bank, depth });
        for (pin, (port, name)) in reactor.ports.iter().zip(names).enumerate() {
            let word = if port.is_input { "input" } else { "output" };
            self.drawing.pins[own][pin] = Some((name.clone(), format!("{word} {name}: {}", port.ty)));
        }
        self.blocks[index] = Some(own);
        if !has_contents {
            return;
        }
        for mode in &reactor.modes {
            let title = format!("mode {}", mode.name);
            let least = (text::width(&title, SMALL_SIZE) + 2 * TEXT_MARGIN, TITLE_ROW + 8);
            let pins = Vec::new();
            let header = TITLE_ROW;
            let block = Block { parent: Some(own), least, header, pins, keeps_order: true, is_delay: false };
            let mode = self.block(block, Look::Mode { title, is_initial: mode.is_initial });
            self.modes[index].push(mode);
        }
    }

    /// Adds the elements and the wires of a reactor.
    fn contents(&mut self, index: usize) {
        let diagram = self.diagram;
        let reactor = &diagram.reactors[index];
        let Some(own) = self.blocks[index] else { return };
        let mut elements = Vec::new();
        for element in &reactor.elements {
            let parent = element.mode.map_or(own, |mode| self.modes[index][mode]);
            elements.push(self.element(element, parent));
        }
        let mut wiring =
            Wiring { maker: self, own, reactor: index, elements, labels: BTreeMap::new(), borders: BTreeMap::new() };
        for edge in &reactor.edges {
            wiring.edge(edge);
        }
    }

    fn element(&mut self, element: &DiagramElement, parent: usize) -> usize {
        let DiagramElement { kind, name, timing, declaration, .. } = element.clone();
        let mut width = text::width(&name, SMALL_SIZE) + 2 * TEXT_MARGIN;
        if !timing.is_empty() {
            width += text::width(&timing, SMALL_SIZE) + 6;
        }
        width += if kind == ElementKind::Reaction { 14 } else { SIGN_WIDTH };
        let pins = [Side::Left, Side::Right].map(|side| Pin { side, width: 0 });
        let least = (width, ELEMENT_HEIGHT);
        let block = Block { parent: Some(parent), least, pins: pins.to_vec(), ..Block::default() };
        self.block(block, Look::Element { kind, name, timing, declaration })
    }
}

/// A block and one of its pins.
type PinOf = (usize, usize);

/// The wires of one reactor.
struct Wiring<'m, 'd> {
    maker: &'m mut Maker<'d>,
    own: usize,
    reactor: usize,
    /// The blocks of the elements.
    elements: Vec<usize>,
    /// The blocks of labels, by the pin that they follow and their text.
    labels: BTreeMap<(PinOf, String, usize), usize>,
    /// The pins at the borders of modes, by mode, whether it is the left one, the pin at the wires' beginning, and
    /// style. Transitions into a mode end at one pin, wherever they begin.
    borders: BTreeMap<(usize, bool, Option<PinOf>, usize), usize>,
}

/// One end of a wire.
#[derive(Clone, Copy)]
struct WireEnd {
    /// The block and the pin.
    pin: PinOf,
    /// The block in which the wire ends.
    container: usize,
}

impl Wiring<'_, '_> {
    fn edge(&mut self, edge: &DiagramEdge) {
        let (kind, label) = match &edge.kind {
            EdgeKind::Connection { delay, physical: false } => (WireKind::Connection, delay.clone()),
            EdgeKind::Connection { delay, physical: true } => {
                let text = delay.as_ref().map_or_else(|| "physical".to_owned(), |delay| format!("physical, {delay}"));
                (WireKind::Physical, Some(text))
            }
            EdgeKind::Trigger => (WireKind::Trigger, None),
            EdgeKind::Use => (WireKind::Use, None),
            EdgeKind::Effect => (WireKind::Effect, None),
            EdgeKind::Transition { history } => (WireKind::Transition, history.then(|| "history".to_owned())),
        };
        let (Some(from), Some(to)) = (self.end(edge.from, true), self.end(edge.to, false)) else { return };
        let has_arrow = matches!(edge.to, EdgeEnd::Element(_) | EdgeEnd::Mode(_));
        let Some(label) = label else { return self.wire(from, to, kind, has_arrow) };
        let container = if from.container == to.container { from.container } else { self.own };
        let middle = self.label(from, container, &label, kind != WireKind::Transition);
        // Another wire may have brought the label here already.
        if !self.has_wire(from.pin, middle, kind) {
            self.wire(from, WireEnd { pin: (middle, 0), container }, kind, false);
        }
        self.wire(WireEnd { pin: (middle, 1), container }, to, kind, has_arrow);
    }

    /// Returns the pin at which an edge begins or ends; none for a reactor that is not drawn.
    fn end(&mut self, end: EdgeEnd, begins: bool) -> Option<WireEnd> {
        let parent = |block: usize| self.maker.drawing.figure.blocks[block].parent;
        match end {
            EdgeEnd::Own(port) => Some(WireEnd { pin: (self.own, port), container: self.own }),
            EdgeEnd::Contained { reactor, port } => {
                let block = self.maker.blocks[reactor]?;
                Some(WireEnd { pin: (block, port), container: parent(block)? })
            }
            EdgeEnd::Element(element) => {
                let block = self.elements[element];
                Some(WireEnd { pin: (block, usize::from(begins)), container: parent(block)? })
            }
            EdgeEnd::Mode(mode) => {
                let block = *self.maker.modes[self.reactor].get(mode)?;
                let pin = self.border(block, Side::Left, None, WireKind::Transition);
                Some(WireEnd { pin: (block, pin), container: self.own })
            }
        }
    }

    /// Returns the block of a text behind the beginning of a wire.
    fn label(&mut self, from: WireEnd, container: usize, text: &str, is_delay: bool) -> usize {
        let key = (from.pin, text.to_owned(), container);
        if let Some(block) = self.labels.get(&key) {
            return *block;
        }
        let width = text::width(text, SMALL_SIZE) + 12;
        let pins = [Side::Left, Side::Right].map(|side| Pin { side, width: 0 });
        let least = (width, DELAY_HEIGHT);
        let block = Block { parent: Some(container), least, pins: pins.to_vec(), is_delay, ..Block::default() };
        let block = self.maker.block(block, Look::Label { text: text.to_owned() });
        self.labels.insert(key, block);
        block
    }

    fn has_wire(&self, from: PinOf, to: usize, kind: WireKind) -> bool {
        let drawing = &self.maker.drawing;
        let mut wires = drawing.figure.wires.iter().zip(&drawing.wires);
        wires.any(|(wire, look)| wire.from == from && wire.to.0 == to && look.kind == kind)
    }

    /// Adds a wire, which crosses the borders of modes at pins of its own.
    fn wire(&mut self, mut from: WireEnd, to: WireEnd, kind: WireKind, has_arrow: bool) {
        let style = kind as usize;
        if from.container != to.container && from.container != self.own {
            let mode = from.container;
            let known = self.borders.contains_key(&(mode, false, Some(from.pin), style));
            let pin = self.border(mode, Side::Right, Some(from.pin), kind);
            if !known {
                self.part(mode, from.pin, (mode, pin), kind, false);
            }
            from = WireEnd { pin: (mode, pin), container: self.own };
        }
        if from.container != to.container {
            let mode = to.container;
            let known = self.borders.contains_key(&(mode, true, Some(from.pin), style));
            let pin = self.border(mode, Side::Left, Some(from.pin), kind);
            if !known {
                self.part(self.own, from.pin, (mode, pin), kind, false);
            }
            from = WireEnd { pin: (mode, pin), container: mode };
        }
        self.part(from.container, from.pin, to.pin, kind, has_arrow);
    }

    fn part(&mut self, container: usize, from: PinOf, to: PinOf, kind: WireKind, has_arrow: bool) {
        let drawing = &mut self.maker.drawing;
        drawing.figure.wires.push(Wire { container, from, to, style: kind as usize });
        drawing.wires.push(WireLook { kind, has_arrow });
    }

    /// Returns the pin at the border of a mode for wires that begin at a pin.
    fn border(&mut self, mode: usize, side: Side, from: Option<PinOf>, kind: WireKind) -> usize {
        let drawing = &mut self.maker.drawing;
        *self.borders.entry((mode, side == Side::Left, from, kind as usize)).or_insert_with(|| {
            let pins = &mut drawing.figure.blocks[mode].pins;
            pins.push(Pin { side, width: 0 });
            drawing.pins[mode].push(None);
            pins.len() - 1
        })
    }
}
