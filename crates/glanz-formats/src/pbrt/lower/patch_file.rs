//! Patches from files: lists in Newell's format, and RIB.

use glanz_scene::description::GeometryDescription;

use super::Lowering;
use crate::file_list::FileKind;
use crate::pbrt::parameters::{Parameter, ParameterList};
use crate::source::{MISSING_FILE, ParseResult};
use crate::{newell, rib};

impl Lowering {
    /// The surfaces of the file that a shape names: one for a list in Newell's format; for RIB one for the patches of each combination of degrees and one
    /// for each spline.
    pub(super) fn patch_file(&mut self, list: &mut ParameterList) -> ParseResult<Vec<GeometryDescription>> {
        let Some((p, name)) = list.text_parameter("filename", &mut self.reporter)? else {
            return Ok(Vec::new());
        };
        if list.has("P") {
            let message = format!("{}: give either \"filename\" or \"P\"", list.subject);
            return Err(self.reporter.error(&p.value_place, "parameter-count", message));
        }
        let (path, bytes) = match self.read_file(&name, FileKind::Mesh) {
            Ok(read) => read,
            Err(problem) => {
                let message = format!("{}: {problem}", list.subject);
                return Err(self.reporter.error(&p.value_place, MISSING_FILE, message));
            }
        };
        let source = format!("{}: {}", list.subject, path.display());
        if rib::is_rib(&bytes) {
            return self.rib_surfaces(list, &p, &source, &bytes);
        }
        match newell::read_with(&bytes, &self.finder.budget) {
            Ok(mesh) => Ok(vec![self.bicubic_patches(list, &mesh.positions, &mesh.patches)?]),
            Err(error) => Err(self.reporter.error(&p.value_place, "newell", format!("{source}:{error}"))),
        }
    }

    /// `source`: beginning of messages about the file.
    fn rib_surfaces(
        &mut self,
        list: &ParameterList,
        p: &Parameter,
        source: &str,
        bytes: &[u8],
    ) -> ParseResult<Vec<GeometryDescription>> {
        let file = match rib::read_with(bytes, &self.finder.budget) {
            Ok(file) => file,
            Err(error) => {
                let help = error.kind.help().map(str::to_owned);
                let message = format!("{source}:{error}");
                return Err(self.reporter.error_with_help(&p.value_place, "rib", message, help));
            }
        };
        for rib::SkippedRequest { name, line, column } in &file.skipped {
            let message = format!("{source}:{line}:{column}: request {name:?} is not read and skipped");
            self.reporter.warning(&p.value_place, "rib-request", message);
        }
        let patches = file.patches.into_iter().map(GeometryDescription::BezierPatches);
        let surfaces: Vec<_> =
            patches.chain(file.splines.into_iter().map(GeometryDescription::Nurbs)).collect();
        if surfaces.is_empty() {
            let message = format!("{source}: the file has no Patch, PatchMesh or NuPatch");
            return Err(self.reporter.error(&list.place, "rib", message));
        }
        Ok(surfaces)
    }
}
