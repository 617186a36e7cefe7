//! Blocks: Module, PrmText, ExtUserPrmData, SlotDefinition, UnitDiagType, and the areas of the diagnosis.

use super::prm::{definition, field_type, part};
use super::{Reader, diag_bit};
use crate::gsd::MAX_MODULES;
use crate::gsd::diagnosis::{DiagArea, DiagType};
use crate::gsd::hint::{Place, ReadError};
use crate::gsd::module::{Module, Slot};
use crate::gsd::parameter::{Parameter, PrmPart};
use crate::gsd::statement::Statement;
use crate::gsd::text::trimmed;
use crate::profibus::dp::IoLengths;

/// The block that the lines are in.
pub(super) enum Block {
    Main,
    Module { module: Module, good: bool },
    Texts { place: Place, id: u32, texts: Vec<(i64, String)> },
    Parameter { place: Place, id: u32, name: String, parameter: Option<Parameter> },
    Slots { place: Place },
    DiagType { place: Place, block: DiagType },
}

impl Reader {
    /// First and last lines of blocks.
    pub(super) fn begins_or_ends_block(&mut self, line: &Statement<'_>) -> Result<bool, ReadError> {
        let place = line.place;
        match line.keyword.as_str() {
            "module" => {
                self.end_block(Some(place));
                self.begin_module(line)?;
            }
            "prmtext" => {
                self.end_block(Some(place));
                let id = self.id_of(line);
                self.block = Block::Texts { place, id, texts: Vec::new() };
            }
            "extuserprmdata" => {
                self.end_block(Some(place));
                let (id, name) = (self.id_of(line), line.text().unwrap_or_default());
                self.block = Block::Parameter { place, id, name: trimmed(name), parameter: None };
            }
            "slotdefinition" => {
                self.end_block(Some(place));
                self.block = Block::Slots { place };
            }
            "data_area_beg" => self.data_area = true,
            "data_area_end" => self.data_area = false,
            "unitdiagtype" => {
                self.end_block(Some(place));
                let number = line.first().and_then(|number| u8::try_from(number).ok()).unwrap_or_default();
                self.block = Block::DiagType {
                    place,
                    block: DiagType { number, bits: Vec::new(), areas: Vec::new() },
                };
            }
            "unit_diag_area" | "x_unit_diag_area" => {
                self.end_area();
                match line.span().map(|(first, last)| (u16::try_from(first), u16::try_from(last))) {
                    Some((Ok(first), Ok(last))) if first <= last => {
                        self.area = Some(DiagArea { first, last, values: Vec::new() });
                    }
                    Some(_) | None => {
                        self.warn(place, "expected FIRST-LAST bits of the area; the area is ignored".into());
                    }
                }
            }
            "unit_diag_area_end" | "x_unit_diag_area_end" => self.end_area(),
            "endmodule" | "endprmtext" | "endextuserprmdata" | "endslotdefinition" | "endunitdiagtype" => {
                self.end_block(None);
            }
            _other => return Ok(false),
        }
        Ok(true)
    }

    fn id_of(&mut self, line: &Statement<'_>) -> u32 {
        let id = line.first().and_then(|id| u32::try_from(id).ok());
        if id.is_none() {
            self.warn(line.place, format!("{} has no number; read as 0", line.spelled));
        }
        id.unwrap_or_default()
    }

    fn begin_module(&mut self, line: &Statement<'_>) -> Result<(), ReadError> {
        let place = line.place;
        if self.gsd.modules.len() >= MAX_MODULES {
            return Err(ReadError::TooManyModules { place });
        }
        let name = trimmed(line.text().unwrap_or_default());
        let identifiers = line.octets();
        let lengths = identifiers.as_deref().and_then(|octets| IoLengths::of(octets).ok());
        let good = lengths.is_some();
        if !good {
            self.warn(
                place,
                format!("the identifiers of module '{name}' are incomplete; the module is ignored"),
            );
            self.bad_module.get_or_insert((place, name.clone()));
        }
        let module = Module {
            place,
            name,
            identifiers: identifiers.unwrap_or_default(),
            lengths: lengths.unwrap_or_default(),
            reference: None,
            preset: false,
            prm: PrmPart::default(),
            info: String::new(),
            safety: false,
        };
        self.block = Block::Module { module, good };
        Ok(())
    }

    fn end_area(&mut self) {
        self.data_area = false;
        let Some(area) = self.area.take() else { return };
        match &mut self.block {
            Block::DiagType { block, .. } => block.areas.push(area),
            Block::Main
            | Block::Module { .. }
            | Block::Texts { .. }
            | Block::Parameter { .. }
            | Block::Slots { .. } => self.gsd.diag_areas.push(area),
        }
    }

    /// Takes over what the block held; `unclosed` where another one begins instead of its last line.
    pub(super) fn end_block(&mut self, unclosed: Option<Place>) {
        self.end_area();
        let begun = match core::mem::replace(&mut self.block, Block::Main) {
            Block::Main => return,
            Block::Module { module, good } => {
                let (place, name) = (module.place, module.name.clone());
                if module.safety {
                    let text = format!(
                        "module '{name}' has PROFIsafe parameters; its safety octets are not emulated"
                    );
                    self.warn(place, text);
                }
                if good {
                    self.gsd.modules.push(module);
                }
                place
            }
            Block::Texts { place, id, texts } => {
                if self.gsd.texts.insert(id, texts).is_some() {
                    self.warn(place, format!("PrmText {id} is there twice; the last one is used"));
                }
                place
            }
            Block::Parameter { place, id, name, parameter } => {
                match parameter {
                    Some(parameter) => {
                        if self.gsd.parameters.insert(id, parameter).is_some() {
                            self.warn(
                                place,
                                format!("ExtUserPrmData {id} is there twice; the last one is used"),
                            );
                        }
                    }
                    None => self.warn(place, format!("parameter '{name}' has no type; it is ignored")),
                }
                place
            }
            Block::Slots { place } => place,
            Block::DiagType { place, block } => {
                self.gsd.diag_types.push(block);
                place
            }
        };
        if unclosed.is_some() {
            self.warn(
                begun,
                "the block that begins here is not closed; it ends where the next one begins".into(),
            );
        }
    }

    pub(super) fn in_area(&mut self, line: &Statement<'_>) -> bool {
        let Some(area) = self.area.as_mut().filter(|_| matches!(line.keyword.as_str(), "value" | "x_value"))
        else {
            return false;
        };
        if let (Some(value), Some(text)) = (line.argument, line.text()) {
            area.values.push((value, trimmed(text)));
        }
        true
    }

    /// Lines that belong to the block at hand; the others belong to the main part, wherever they stand.
    pub(super) fn in_block(&mut self, line: &Statement<'_>) -> bool {
        let place = line.place;
        let mut hint = None;
        let known = match &mut self.block {
            Block::Main => false,
            Block::Module { module, .. } => match line.keyword.as_str() {
                "" => {
                    module.reference = line.first().and_then(|number| u32::try_from(number).ok());
                    true
                }
                "ext_module_prm_data_len" => {
                    module.prm.len = line.prm_len();
                    true
                }
                "ext_user_prm_data_const" | "ext_user_prm_data_ref" => {
                    hint = part(&mut module.prm, line, &mut self.references).err();
                    true
                }
                "preset" => {
                    module.preset = line.is_on();
                    true
                }
                "info_text" => {
                    module.info = trimmed(line.text().unwrap_or_default());
                    true
                }
                "f_ext_module_prm_data_len" | "f_paramdesccrc" => {
                    module.safety = true;
                    true
                }
                _main => false,
            },
            Block::Texts { texts, .. } => match (line.keyword.as_str(), line.argument, line.text()) {
                ("text", Some(value), Some(text)) => {
                    texts.push((value, trimmed(text)));
                    true
                }
                _main => false,
            },
            Block::Parameter { parameter, name, .. } => match (line.keyword.as_str(), parameter) {
                ("prm_text_ref", Some(parameter)) => {
                    parameter.text_ref = line.first().and_then(|number| u32::try_from(number).ok());
                    true
                }
                ("changeable", Some(parameter)) => {
                    parameter.changeable = line.is_on();
                    true
                }
                ("visible", Some(parameter)) => {
                    parameter.visible = line.is_on();
                    true
                }
                (_, parameter) => match field_type(line) {
                    Some(Ok(field)) => {
                        let (read, odd) = definition(name.clone(), field, line);
                        (*parameter, hint) = (Some(read), odd);
                        true
                    }
                    Some(Err(odd)) => {
                        hint = Some(odd);
                        true
                    }
                    None => false,
                },
            },
            Block::Slots { .. } => match (line.keyword.as_str(), line.argument.map(u16::try_from)) {
                ("slot", Some(Ok(number))) => {
                    let (default, references) = line.slot();
                    let name = trimmed(line.text().unwrap_or_default());
                    self.gsd.slots.push(Slot { number, name, default, references });
                    true
                }
                _main => false,
            },
            Block::DiagType { block, .. } => match diag_bit(line, "x_unit_diag_bit") {
                Some(bit) => {
                    block.bits.push(bit);
                    true
                }
                None => false,
            },
        };
        if let Some(hint) = hint {
            self.warn(place, hint);
        }
        known
    }
}
