//! What the shapes of CAD and glTF files do not have.

use super::{EntityState, Lowering};
use crate::pbrt::parameters::{ParameterList, shortened};
use crate::source::ParseResult;

impl Lowering {
    /// Reports `alpha` and media, and refuses a receiver. `files`: the kind of files; `opacity`: what stands in for `alpha`.
    pub(super) fn without_surface_parameters(
        &mut self,
        list: &mut ParameterList,
        context: &EntityState,
        files: &str,
        opacity: &str,
    ) -> ParseResult<()> {
        let alpha_place = list.value_place("alpha");
        if self.alpha(list)?.is_some_and(|alpha| [alpha.opacity, alpha.shadow] != [1.0.into(), 1.0.into()]) {
            let message =
                format!("{}: \"alpha\" is not available for {files} files; {opacity}", list.subject);
            self.stand_in(&alpha_place, "stand-in-alpha", message);
        }
        let receiver = list.text_parameter("receiver", &mut self.reporter)?;
        list.ignore(&["cells", "receiverside", "zone"]);
        if let Some((p, name)) = receiver.filter(|(_, name)| !name.is_empty()) {
            let message = format!("{} cannot be receiver {:?}", list.subject, shortened(&name));
            let help = Some("place another shape of the material \"interface\" in front".to_owned());
            return Err(self.reporter.error_with_help(&p.value_place, "receiver-in-object", message, help));
        }
        if context.media.inside != context.media.outside {
            let message =
                format!("{}: media of shapes of such files are not available; none stands in", list.subject);
            self.stand_in(&list.place, "stand-in-medium", message);
        }
        Ok(())
    }
}
