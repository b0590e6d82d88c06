//! `spectrum` and `kind`: `E`, `D65`, `A`, `blackbody:K`, or a `nm:value` list.

use crate::collada::error::Fault;
use crate::color::Emission;

use super::index::table;
use super::strict::{Bounds, Strict};

/// The emission spectrum that an attribute names; `None` when it is absent.
pub fn read(strict: &mut Strict, attribute: &'static str) -> Result<Option<Emission>, Fault> {
    let Some(text) = strict.text(attribute) else { return Ok(None) };
    let emission = match text.trim() {
        "E" => Emission::E,
        "D65" => Emission::D65,
        "A" => Emission::A,
        other => match other.strip_prefix("blackbody:") {
            Some(kelvin) => {
                let fault = |message: String| strict.element.fault_at_value(attribute, message);
                let Ok(kelvin) = kelvin.trim().parse::<f32>() else {
                    return Err(fault(format!("`{kelvin}` is not a temperature")).hint("for example `blackbody:3200`"));
                };
                let bounds = Bounds::Within(500.0, 100_000.0);
                bounds.accept(kelvin).map_err(|message| fault(format!("the temperature is {kelvin} K; {message}")))?;
                Emission::Blackbody(kelvin)
            }
            None if other.contains(':') => {
                let table = table(strict, attribute, Bounds::AtLeast(0.0))?.unwrap_or_default();
                if table.iter().all(|&(_, power)| power == 0.0) {
                    return Err(strict.element.fault_at_value(attribute, "this spectrum is zero everywhere"));
                }
                Emission::Table(table)
            }
            None => {
                let fault = strict.element.fault_at_value(attribute, format!("unknown spectrum `{other}`"));
                return Err(fault.suggest(other, ["E", "D65", "A", "blackbody:K", "nm:value ..."]));
            }
        },
    };
    Ok(Some(emission))
}
