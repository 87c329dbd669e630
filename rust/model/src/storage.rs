// SPDX-License-Identifier: Apache-2.0
//! The memory that an engine borrows, of the size that its program's tables need.
use crate::modes::ModeState;
use crate::state::Last;
use crate::time::Tag;

/// The memory that an engine borrows, without the sizes in its type.
pub trait EngineStorage: 'static {
    /// Returns empty storage.
    fn new() -> Self;

    /// Returns all of its parts.
    fn parts(&mut self) -> StorageParts<'_>;
}

/// The parts of the memory that an engine borrows.
#[derive(Debug)]
pub struct StorageParts<'s> {
    pub(crate) next: &'s mut [Tag],
    pub(crate) winners: &'s mut [u16],
    pub(crate) active: &'s mut [u32],
    pub(crate) ready: &'s mut [u32],
    pub(crate) ports: &'s mut [u32],
    pub(crate) tardy: &'s mut [u32],
    pub(crate) intended: &'s mut [Tag],
    pub(crate) last: &'s mut [Last],
    pub(crate) modes: &'s mut [ModeState],
    pub(crate) held: &'s mut [Tag],
}

/// The memory of an engine. [`storage_for!`](crate::storage_for) makes the type for a program's tables.
#[derive(Debug)]
pub struct Storage<
    const TRIGGERS: usize,
    const TRIGGER_WORDS: usize,
    const REACTION_WORDS: usize,
    const PORT_WORDS: usize,
    const TARDY_WORDS: usize = 0,
    const TARDY_INPUTS: usize = 0,
    const MODES: usize = 0,
    const HELD: usize = 0,
> {
    next: [Tag; TRIGGERS],
    winners: [u16; TRIGGERS],
    active: [u32; TRIGGER_WORDS],
    ready: [u32; REACTION_WORDS],
    ports: [u32; PORT_WORDS],
    tardy: [u32; TARDY_WORDS],
    intended: [Tag; TARDY_INPUTS],
    last: [Last; TARDY_INPUTS],
    modes: [ModeState; MODES],
    held: [Tag; HELD],
}

impl<
    const TRIGGERS: usize,
    const TRIGGER_WORDS: usize,
    const REACTION_WORDS: usize,
    const PORT_WORDS: usize,
    const TARDY_WORDS: usize,
    const TARDY_INPUTS: usize,
    const MODES: usize,
    const HELD: usize,
> EngineStorage
    for Storage<TRIGGERS, TRIGGER_WORDS, REACTION_WORDS, PORT_WORDS, TARDY_WORDS, TARDY_INPUTS, MODES, HELD>
{
    fn new() -> Self {
        const { assert!(TRIGGERS <= TRIGGER_WORDS * 32, "one bit per trigger: use storage_for!") };
        Self {
            next: [Tag::FOREVER; TRIGGERS],
            winners: [0; TRIGGERS],
            active: [0; TRIGGER_WORDS],
            ready: [0; REACTION_WORDS],
            ports: [0; PORT_WORDS],
            tardy: [0; TARDY_WORDS],
            intended: [Tag::NEVER; TARDY_INPUTS],
            last: [Last::NONE; TARDY_INPUTS],
            modes: [ModeState::NONE; MODES],
            held: [Tag::FOREVER; HELD],
        }
    }

    fn parts(&mut self) -> StorageParts<'_> {
        StorageParts {
            next: &mut self.next,
            winners: &mut self.winners,
            active: &mut self.active,
            ready: &mut self.ready,
            ports: &mut self.ports,
            tardy: &mut self.tardy,
            intended: &mut self.intended,
            last: &mut self.last,
            modes: &mut self.modes,
            held: &mut self.held,
        }
    }
}

/// Names the [`Storage`] type for a program: `pub type Storage = storage_for!(TABLES);`, where `TABLES` is a `const`.
#[macro_export]
macro_rules! storage_for {
    ($tables:expr) => {
        $crate::Storage<
            { $tables.triggers.len() },
            { $crate::words($tables.triggers.len()) },
            { $crate::words($tables.reactions.len()) },
            { $crate::words($tables.ports.len()) },
            { $crate::words($tables.tardy_reactions()) },
            { $tables.tardy_inputs() },
            { $tables.mode_count() },
            { $tables.held_triggers() },
        >
    };
}
