//! Words of Klartext: a block number, a keyword, addresses with signed numbers; comments after `;` or `*`.

use super::words::{FORWARDS, NcFault, NcWord, UNKNOWN, fault, leading_number, whole};
use crate::geometry::Vector;
use crate::io::source::quote_for_message;
use crate::machine::turned;

/// Reads one line.
pub(super) fn words(line: &str, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    let line = line.trim();
    if line.is_empty() {
        return Ok(());
    }
    let digits = line.find(|c: char| !c.is_ascii_digit()).unwrap_or(line.len());
    if digits == 0 {
        return fault("the block has no number", UNKNOWN);
    }
    let block = line.get(digits..).unwrap_or_default().trim_start();
    let (block, comment) = block.split_once(';').map_or((block, None), |(b, c)| (b.trim_end(), Some(c)));
    if let Some(comment) = comment {
        out.push(NcWord::Comment(comment.trim().to_owned()));
    }
    let mut tokens = block.split_whitespace();
    match tokens.next().unwrap_or_default() {
        "" => Ok(()),
        "*" | "BLK" => {
            out.push(NcWord::Nothing);
            Ok(())
        }
        "BEGIN" if block.ends_with("INCH") => fault("the program is in inches", "give a program in MM"),
        "BEGIN" => {
            // A straight block is absolute, and under feed per minute.
            out.extend([NcWord::Incremental(false), NcWord::InverseTime(false)]);
            if block.ends_with(" MM") {
                out.push(NcWord::Millimetres);
            }
            Ok(())
        }
        "END" => {
            out.push(NcWord::End);
            Ok(())
        }
        "CYCL" => cycle(&mut tokens, out),
        "TOOL" => tool(&mut tokens, out),
        "PLANE" => plane(&mut tokens, out),
        "FUNCTION" => function(block, out),
        "L" => motion(&mut tokens, out),
        "LN" => {
            out.push(NcWord::TipByVector);
            motion(&mut tokens, out)
        }
        first if first.starts_with('M') => {
            std::iter::once(first).chain(tokens).try_for_each(|token| m_word(token, out))
        }
        other => fault(format!("{} is not read", quote_for_message(other)), UNKNOWN),
    }
}

type Tokens<'a> = std::str::SplitWhitespace<'a>;

/// `CYCL DEF n`: 247 (preset) and 32 (tolerance) do not move anything.
fn cycle(tokens: &mut Tokens<'_>, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    let number = tokens.nth(1).unwrap_or_default();
    match number.split('.').next() {
        Some("32") => Ok(()),
        Some("247") => {
            let preset = tokens.find_map(|token| token.strip_prefix("Q339="));
            out.push(match preset {
                Some(preset) => NcWord::Preset(leading_number(preset, false)?.0),
                None => NcWord::Offset(None),
            });
            Ok(())
        }
        _ => fault(format!("CYCL DEF {} is not read", quote_for_message(number)), UNKNOWN),
    }
}

/// `TOOL CALL n Z Sn` changes the tool; `TOOL DEF n` only prepares it.
fn tool(tokens: &mut Tokens<'_>, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    match tokens.next() {
        Some("DEF") => Ok(()),
        Some("CALL") => {
            let (number, _) = leading_number(tokens.next().unwrap_or_default(), false)?;
            out.push(NcWord::Tool(whole(number)?));
            out.push(NcWord::Change);
            // The call brings length and radius of the tool along.
            out.push(NcWord::Length(true));
            for token in tokens {
                match token.strip_prefix('S') {
                    Some(speed) => out.push(NcWord::Speed(leading_number(speed, true)?.0)),
                    None if token == "Z" => {}
                    None => return fault(format!("{} is not read", quote_for_message(token)), UNKNOWN),
                }
            }
            Ok(())
        }
        _ => fault("TOOL without CALL or DEF", UNKNOWN),
    }
}

/// `PLANE SPATIAL SPAa SPBb SPCc …`: about Z by c, the new Y by b, the new X by a.
fn plane(tokens: &mut Tokens<'_>, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    match tokens.next() {
        Some("RESET") => {
            out.push(NcWord::PlaneOff);
            return Ok(());
        }
        Some("SPATIAL") => {}
        _ => return fault("only PLANE SPATIAL and PLANE RESET are read", UNKNOWN),
    }
    let mut angles = [None; 3];
    let mut turns = false;
    for token in tokens {
        turns |= token == "TURN" || token == "MOVE";
        for (name, angle) in ["SPA", "SPB", "SPC"].into_iter().zip(&mut angles) {
            if let Some(value) = token.strip_prefix(name) {
                *angle = Some(leading_number(value, true)?.0.to_radians());
            }
        }
    }
    let [Some(a), Some(b), Some(c)] = angles else {
        return fault("PLANE SPATIAL needs SPA, SPB and SPC", "give all three");
    };
    let turn = |v: Vector| {
        let v = turned(&Vector::x(), a, &v);
        let v = turned(&Vector::y(), b, &v);
        turned(&Vector::z(), c, &v)
    };
    out.push(NcWord::Plane([turn(Vector::x()), turn(Vector::y()), turn(Vector::z())]));
    if turns {
        out.push(NcWord::Swivel);
    }
    Ok(())
}

/// `FUNCTION TCPM …` and `FUNCTION RESET TCPM`.
fn function(block: &str, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    out.push(match block {
        text if text.starts_with("FUNCTION RESET TCPM") => NcWord::TipOff,
        text if text.starts_with("FUNCTION TCPM") => NcWord::TipByAngles,
        _ => return fault("only FUNCTION TCPM and FUNCTION RESET TCPM are read", UNKNOWN),
    });
    Ok(())
}

fn motion(tokens: &mut Tokens<'_>, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    // A straight block is under feed unless it says FMAX.
    out.push(NcWord::Feed);
    for token in tokens {
        let mut letters = token.chars();
        match (letters.next().unwrap_or(' '), token.get(1..).unwrap_or_default()) {
            ('R', "0") => {}
            ('F', "MAX") => out.push(NcWord::Rapid),
            ('F', rate) => out.push(NcWord::Rate(leading_number(rate, true)?.0)),
            ('M', _) => m_word(token, out)?,
            ('T', vector) if vector.starts_with(['X', 'Y', 'Z']) => {
                let index = match vector.chars().next() {
                    Some('X') => 0,
                    Some('Y') => 1,
                    _ => 2,
                };
                out.push(NcWord::Direction(index, leading_number(&vector[1..], true)?.0));
            }
            ('X', x) => out.push(NcWord::Linear(0, leading_number(x, true)?.0)),
            ('Y', x) => out.push(NcWord::Linear(1, leading_number(x, true)?.0)),
            ('Z', x) => out.push(NcWord::Linear(2, leading_number(x, true)?.0)),
            (letter @ ('A' | 'B' | 'C'), x) => out.push(NcWord::Rotary(letter, leading_number(x, true)?.0)),
            _ => return fault(format!("{} is not read", quote_for_message(token)), UNKNOWN),
        }
    }
    Ok(())
}

fn m_word(token: &str, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    let Some(number) = token.strip_prefix('M') else {
        // The feed rate of the compensating moves stands beside M128.
        return match token.strip_prefix('F') {
            Some(_) => Ok(()),
            None => fault(format!("{} is not read", quote_for_message(token)), UNKNOWN),
        };
    };
    out.push(match number {
        "3" | "13" => NcWord::Spindle(true),
        "4" | "14" => return fault("the spindle turns backwards", FORWARDS),
        "5" => NcWord::Spindle(false),
        "8" | "9" | "126" | "127" => NcWord::Nothing,
        // The program ends with END PGM.
        "2" | "30" => NcWord::IsMain,
        "91" => NcWord::Home,
        "128" => NcWord::TipByAngles,
        "129" => NcWord::TipOff,
        _ => return fault(format!("{} is not read", quote_for_message(token)), UNKNOWN),
    });
    Ok(())
}
