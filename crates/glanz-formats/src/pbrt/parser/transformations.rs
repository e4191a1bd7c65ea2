//! Directives that transform the following objects.

use glanz_math::{DMat4, DVec3};
use glanz_scene::description::look_at;

use super::Parser;
use crate::nearest::nearest;
use crate::pbrt::lexer::Token;
use crate::pbrt::parameters::shortened;
use crate::source::{ParseResult, Span};

impl Parser {
    pub(super) fn transformation(&mut self, word: &str, place: Span) -> ParseResult<()> {
        match word {
            "Identity" => self.state.replace(DMat4::IDENTITY),
            "Translate" => {
                let offset = self.numbers(&place)?;
                self.state.concatenate(DMat4::from_translation(DVec3::from_array(offset)));
            }
            "Scale" => {
                let factors = self.numbers(&place)?;
                self.state.concatenate(DMat4::from_scale(DVec3::from_array(factors)));
            }
            "Rotate" => {
                let [degrees, x, y, z] = self.numbers(&place)?;
                let Some(axis) = DVec3::new(x, y, z).try_normalize() else {
                    let message = "Rotate needs an axis that is not zero";
                    return Err(self.lowering.reporter.error(&place, "transformation", message));
                };
                self.state.concatenate(DMat4::from_axis_angle(axis, degrees.to_radians()));
            }
            "LookAt" => {
                let v: [f64; 9] = self.numbers(&place)?;
                let [eye, target, up] = [0, 3, 6].map(|i| DVec3::new(v[i], v[i + 1], v[i + 2]));
                let Some(to_world) = look_at(eye, target, up) else {
                    let message = "LookAt: the eye is the target, or up is parallel to the view";
                    return Err(self.lowering.reporter.error(&place, "transformation", message));
                };
                self.state.concatenate(to_world.inverse());
            }
            "Transform" => {
                let matrix = DMat4::from_cols_array(&self.numbers(&place)?);
                self.state.replace(matrix);
            }
            "ConcatTransform" => {
                let matrix = DMat4::from_cols_array(&self.numbers(&place)?);
                self.state.concatenate(matrix);
            }
            "CoordinateSystem" => {
                let (name, _) = self.name(word, &place)?;
                self.state.named_frames.insert(name, self.state.now.ctm);
            }
            "CoordSysTransform" => {
                let (name, name_place) = self.name(word, &place)?;
                let Some(matrix) = self.state.named_frames.get(&name).copied() else {
                    let message = format!("there is no coordinate system {:?}", shortened(&name));
                    let names = self.state.named_frames.keys().map(String::as_str);
                    let help = nearest(&name, names).map(|n| format!("did you mean {n:?}?"));
                    let r = &mut self.lowering.reporter;
                    return Err(r.error_with_help(&name_place, "missing-frame", message, help));
                };
                self.state.replace(matrix);
            }
            "ActiveTransform" => self.active_transform(place)?,
            _ => {
                let _: [f64; 2] = self.numbers(&place)?;
                self.animation(&place);
            }
        }
        Ok(())
    }

    fn active_transform(&mut self, place: Span) -> ParseResult<()> {
        let next = self.lexer(&place)?.next();
        let which = match &next {
            Ok(Some((Token::Word(which), _))) => which.as_str(),
            _ => "",
        };
        self.state.now.start_active = match which {
            "StartTime" | "All" => true,
            "EndTime" => {
                self.animation(&place);
                false
            }
            _ => {
                let message = "ActiveTransform needs StartTime, EndTime or All";
                return Err(self.lowering.reporter.error(&place, "syntax", message));
            }
        };
        Ok(())
    }

    fn animation(&mut self, place: &Span) {
        let message = "motion is not available yet; all objects have their positions at the start";
        self.lowering.reporter.stand_in(place, "stand-in-motion", message);
    }
}
