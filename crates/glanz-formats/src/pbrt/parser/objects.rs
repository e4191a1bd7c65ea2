//! Directives that create objects or select their kind.

use std::rc::Rc;
use std::sync::Arc;

use glanz_job::{LimitError, Resource};
use glanz_scene::description::SurfaceMedia;

use super::{OpenBlock, Parser};
use crate::file_list::FileKind;
use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::lower::EntityState;
use crate::pbrt::parameters::shortened;
use crate::source::{MISSING_FILE, ParseResult, Span};

/// Largest number of values of an attribute, which is copied to every object to which it applies.
const MAX_ATTRIBUTE_VALUES: usize = 64;
/// Largest number of attributes of one target.
const MAX_ATTRIBUTES: usize = 32;

impl Parser {
    pub(super) fn option(&mut self, word: &str, place: Span) -> ParseResult<()> {
        if word == "Option" {
            let mut list = self.parameters("Option".to_owned(), place)?;
            return self.lowering.option(&mut list);
        }
        let (kind, name_place) = self.name(word, &place)?;
        if word == "ColorSpace" {
            let Some(space) = ColorSpace::of_name(&kind) else {
                let message = format!("color space {:?} is unknown", shortened(&kind));
                let help = Some("color spaces are srgb, rec2020, dci-p3 and aces2065-1".to_owned());
                let r = &mut self.lowering.reporter;
                return Err(r.error_with_help(&name_place, "parameter-range", message, help));
            };
            self.state.now.color_space = space;
            return Ok(());
        }
        let subject = format!("{} {:?}", subject(word), shortened(&kind));
        let list = self.parameters(subject, place)?;
        if self.block != OpenBlock::Options
            && !matches!(word, "Accelerator" | "VolumeIntegrator" | "Renderer")
        {
            let message = format!("{word} has no effect after WorldBegin");
            self.lowering.reporter.warning(&place, "late-option", message);
            return Ok(());
        }
        match word {
            "Camera" => {
                let ctm = self.state.now.ctm;
                self.lowering.camera(&kind, list, ctm)?;
                self.lowering.description.camera_medium = self.state.now.media.outside;
                self.state.named_frames.insert("camera".to_owned(), ctm.inverse());
                Ok(())
            }
            "Film" => self.lowering.film(&kind, list),
            "Sampler" => self.lowering.sampler(&kind, list),
            "Integrator" | "SurfaceIntegrator" => self.lowering.integrator(&kind, list),
            "PixelFilter" => self.lowering.filter(&kind, list),
            // These have no effect on the picture, or only on its noise.
            _ => Ok(()),
        }
    }

    pub(super) fn include(&mut self, word: &str, place: Span) -> ParseResult<()> {
        let (name, name_place) = self.name(word, &place)?;
        let r = &mut self.lowering.reporter;
        let (resource, limit) = (Resource::Depth, r.budget.limits().depth);
        if self.files.len() as u64 > limit {
            let end = r.budget.fail(LimitError { resource, limit, needed: None });
            return Err(r.end(&name_place, end));
        }
        let asking = self.files.last().and_then(|f| f.path.as_deref());
        let path = match self.lowering.finder.find(&name, asking, FileKind::Scene) {
            Ok(path) => path,
            Err(fault) => {
                let message = format!("{word}: file {:?} {}", shortened(&name), fault.what());
                let help = Some(fault.help().to_owned());
                return Err(r.error_with_help(&name_place, MISSING_FILE, message, help));
            }
        };
        let real = std::fs::canonicalize(&path).ok();
        if real.is_some() && self.files.iter().any(|open| open.real == real) {
            let message = format!("{word}: file {:?} includes itself", shortened(&name));
            return Err(r.error(&name_place, "include", message));
        }
        let bytes: Arc<[u8]> = match self.lowering.finder.read(&path, FileKind::Scene) {
            Ok(bytes) => bytes.into(),
            Err(error) => {
                let message = format!("{word}: file {:?} cannot be read: {error}", shortened(&name));
                return Err(r.error(&name_place, MISSING_FILE, message));
            }
        };
        let import = (word == "Import").then(|| (self.state.now.clone(), self.state.levels.len()));
        let shown = self.lowering.finder.shown(&path).display().to_string();
        let pushed = self.push_file(&shown, Some(&path), bytes, import);
        pushed.map_err(|end| self.lowering.reporter.end(&name_place, end))
    }

    /// `Attribute "target" parameters`: defaults for the following objects.
    pub(super) fn attribute(&mut self, place: Span) -> ParseResult<()> {
        let (target, name_place) = self.name("Attribute", &place)?;
        let mut list = self.parameters(format!("Attribute {:?}", shortened(&target)), place)?;
        list.keep_memory();
        let Some(attributes) = self.state.now.attributes.of(&target) else {
            let message = format!("Attribute {:?} is unknown", shortened(&target));
            let help = Some("the targets are shape, light, material, medium and texture".to_owned());
            let r = &mut self.lowering.reporter;
            return Err(r.error_with_help(&name_place, "parameter-range", message, help));
        };
        let (mut all, long): (Vec<_>, Vec<_>) =
            list.into_items().into_iter().partition(|p| p.values.len() <= MAX_ATTRIBUTE_VALUES);
        for p in long {
            let message = format!(
                "Attribute: parameter {:?} has more than {MAX_ATTRIBUTE_VALUES} values and is left out",
                shortened(&p.name)
            );
            self.lowering.reporter.stand_in(&p.place, "long-attribute", message);
        }
        for old in attributes.iter() {
            if !all.iter().any(|p| p.name == old.name) {
                all.push(old.clone());
            }
        }
        if all.len() > MAX_ATTRIBUTES {
            let message = format!("more than {MAX_ATTRIBUTES} attributes");
            return Err(self.lowering.reporter.error(&place, "nesting", message));
        }
        *attributes = Rc::new(all);
        Ok(())
    }

    /// `MediumInterface "inside" "outside"`; a single name is that of both.
    pub(super) fn medium_interface(&mut self, place: Span) -> ParseResult<()> {
        let (inside, inside_place) = self.name("MediumInterface", &place)?;
        let second = self.lexer(&place)?.peek() == Some(b'"');
        let (outside, outside_place) = match second {
            true => self.name("MediumInterface", &place)?,
            false => (inside.clone(), inside_place),
        };
        self.state.now.media = SurfaceMedia {
            inside: self.lowering.use_medium(&inside, &inside_place),
            outside: self.lowering.use_medium(&outside, &outside_place),
        };
        Ok(())
    }

    pub(super) fn named_medium(&mut self, place: Span) -> ParseResult<()> {
        let (name, _) = self.name("MakeNamedMedium", &place)?;
        let mut list = self.parameters(format!("medium {:?}", shortened(&name)), place)?;
        list.keep_memory();
        list.inherit(&self.state.now.attributes.medium);
        let context = self.context();
        self.lowering.named_medium(&name, list, &context)
    }

    /// Media of version 1, which fill a box of their own, are read and left out.
    pub(super) fn volume(&mut self, place: Span) -> ParseResult<()> {
        let (kind, _) = self.name("Volume", &place)?;
        self.parameters(format!("volume {:?}", shortened(&kind)), place)?;
        let message = "Volume is not available yet; empty space stands in";
        self.lowering.reporter.stand_in(&place, "stand-in-medium", message);
        Ok(())
    }

    fn context(&self) -> EntityState {
        let now = &self.state.now;
        EntityState {
            ctm: now.ctm,
            reverse_orientation: now.reverse_orientation,
            material: now.material,
            media: now.media,
            emission: now.emission.clone(),
            color_space: now.color_space,
        }
    }

    /// Handles the directives that create objects or select a kind.
    pub(super) fn thing(&mut self, word: &str, place: Span) -> ParseResult<()> {
        let (name, name_place) = self.name(word, &place)?;
        match word {
            "NamedMaterial" => {
                self.state.now.material = Some(self.lowering.use_material(&name, &name_place));
                return Ok(());
            }
            "ObjectInstance" => {
                let context = self.context();
                return self.lowering.instance(&name, &name_place, &context);
            }
            "Texture" => return self.texture(&name, place),
            _ => {}
        }
        let subject = format!("{} {:?}", subject(word), shortened(&name));
        let mut list = self.parameters(subject, place)?;
        // The memory of shapes is counted with them.
        if word != "Shape" {
            list.keep_memory();
        }
        let attributes = &self.state.now.attributes;
        match word {
            "Shape" => list.inherit(&attributes.shape),
            "LightSource" | "AreaLightSource" => list.inherit(&attributes.light),
            "Observer" => {}
            _ => list.inherit(&attributes.material),
        }
        let context = self.context();
        match word {
            "Shape" => self.lowering.shape(&name, list, &context),
            "LightSource" => self.lowering.light(&name, list, &context),
            "Observer" => self.lowering.observer(&name, list, &context),
            "AreaLightSource" => {
                self.state.now.emission = Some(self.lowering.area_light(&name, list, &context)?);
                Ok(())
            }
            "Material" => {
                self.state.now.material = Some(self.lowering.material(&name, list, context.color_space)?);
                Ok(())
            }
            _ => self.lowering.named_material(&name, list, context.color_space),
        }
    }

    fn texture(&mut self, name: &str, place: Span) -> ParseResult<()> {
        let (value_type, _) = self.name("Texture", &place)?;
        let (kind, _) = self.name("Texture", &place)?;
        let mut list = self.parameters(format!("texture {:?}", shortened(&kind)), place)?;
        list.keep_memory();
        list.inherit(&self.state.now.attributes.texture);
        let context = self.context();
        self.lowering.texture(name, &value_type, &kind, list, &context)
    }
}

/// Name in messages of the object that a directive creates.
fn subject(directive: &str) -> &'static str {
    match directive {
        "Camera" => "camera",
        "Film" => "film",
        "Sampler" => "sampler",
        "PixelFilter" => "filter",
        "Shape" => "shape",
        "LightSource" => "light",
        "AreaLightSource" => "area light",
        "Observer" => "observer",
        "Material" | "MakeNamedMaterial" => "material",
        "Accelerator" => "accelerator",
        _ => "integrator",
    }
}
