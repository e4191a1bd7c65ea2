//! Messages between page and server; `docs/viewer.md` has the list.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::leaf_ranges::leaves;
use crate::model::PartMeasures;
use crate::query::{PickFilter, PickResult};
use crate::stream::{IntegratorName, ViewCamera};

/// Request of a page. The reply carries its `id`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub(crate) enum PageRequest {
    /// Render this view; end the one before.
    View {
        id: u32,
        camera: ViewCamera,
        /// Width and height, pixels.
        size: [u32; 2],
        /// Hidden leaves of the tree.
        #[serde(default, deserialize_with = "leaves")]
        hidden: BTreeSet<u32>,
        /// `None` for the server's default.
        integrator: Option<IntegratorName>,
        /// Whether noise is removed.
        #[serde(default)]
        denoise: bool,
    },
    /// End rendering.
    Stop { id: u32 },
    /// Render no more for now: the page is hidden.
    Pause { id: u32 },
    /// Continue a paused rendering.
    Resume { id: u32 },
    /// Return the hit of a ray.
    Pick {
        id: u32,
        /// World space, metres.
        origin: [f64; 3],
        /// Of any length above 0.
        direction: [f64; 3],
        #[serde(flatten)]
        filter: PickFilter,
    },
    /// Return area and volume of leaves.
    Measure {
        id: u32,
        #[serde(deserialize_with = "leaves")]
        leaves: BTreeSet<u32>,
    },
    /// Send the picture so far as OpenEXR.
    Save { id: u32 },
}

/// A malformed request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MalformedRequest {
    /// Its number; 0 if it cannot be read.
    pub(crate) id: u32,
    /// The fault.
    pub(crate) message: String,
}

impl PageRequest {
    /// Its number.
    pub(crate) fn id(&self) -> u32 {
        match *self {
            Self::View { id, .. }
            | Self::Stop { id }
            | Self::Pause { id }
            | Self::Resume { id }
            | Self::Pick { id, .. }
            | Self::Measure { id, .. }
            | Self::Save { id } => id,
        }
    }

    /// Whether it is a query, which concerns no view being rendered; requests about views must not wait behind many of these.
    pub(crate) fn is_query(&self) -> bool {
        matches!(self, Self::Pick { .. } | Self::Measure { .. } | Self::Save { .. })
    }

    /// Reads a message.
    ///
    /// # Errors
    /// [`MalformedRequest`] with a readable message.
    pub(crate) fn parse(text: &str) -> Result<Self, MalformedRequest> {
        serde_json::from_str(text).map_err(|error| {
            let value: Option<serde_json::Value> = serde_json::from_str(text).ok();
            let id = value.as_ref().and_then(|v| v.get("id")).and_then(serde_json::Value::as_u64);
            let id = id.and_then(|id| u32::try_from(id).ok()).unwrap_or(0);
            MalformedRequest { id, message: format!("the message is malformed: {error}") }
        })
    }
}

/// Text message of the server.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub(crate) enum ServerMessage {
    /// Draw this.
    Scene(SceneMessage),
    /// Progress of the image.
    Progress(ProgressMessage),
    /// Rendering waits for that of other pages.
    Waiting { id: u32 },
    /// Rendering has ended.
    Stopped { id: u32 },
    /// Hit of a ray.
    Hit { id: u32, hit: Option<Box<PickResult>> },
    /// Area and volume of leaves.
    Measures { id: u32, measures: PartMeasures },
    /// A request that cannot be served.
    Failed { id: u32, message: String },
}

/// The new scene of a page, or the error that prevents it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SceneMessage {
    /// Path of the model.
    pub(crate) model: Option<String>,
    pub(crate) name: String,
    /// What tells it from the other one of two designs; its name if there is none.
    pub(crate) label: String,
    /// The name under which the page uploads files.
    pub(crate) session: String,
    /// Default integrator.
    pub(crate) integrator: IntegratorName,
    /// State of the denoiser, if pages offer one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) denoiser: Option<DenoiserMessage>,
    /// Whether the page shows it beside the other one of two designs.
    pub(crate) compared: bool,
    /// Messages about a file that cannot be read.
    pub(crate) error: Option<String>,
    /// Whether the process of a scene that the page has opened has ended, which answers no more requests.
    pub(crate) lost: bool,
}

/// Whether the noise of views can be removed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct DenoiserMessage {
    /// The reason why it cannot; `None` if it can.
    pub(crate) error: Option<String>,
}

/// Progress of an image after a pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct ProgressMessage {
    pub(crate) id: u32,
    /// Per pixel.
    pub(crate) samples: u64,
    /// Root mean square of the standard errors of the pixels over the mean luminance; `None` while that is not known.
    pub(crate) noise: Option<f64>,
    /// Time spent rendering, without waiting.
    pub(crate) seconds: f64,
    pub(crate) done: bool,
}

impl ServerMessage {
    /// The text that is sent.
    pub(crate) fn to_text(&self) -> String {
        // Serialization fails only for maps whose keys are not strings.
        serde_json::to_string(self).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_the_contract_are_understood() {
        let camera = r#"{"kind":"perspective","position":[0,0,5],"right":[1,0,0],"up":[0,1,0],"forward":[0,0,-1],"fieldOfView":1,"height":1,"distance":5}"#;
        let view = format!(
            r#"{{"type":"view","id":7,"camera":{camera},"size":[4,3],"hidden":[4,[1,2]],"integrator":"guided"}}"#
        );
        let Ok(PageRequest::View { id: 7, size: [4, 3], hidden, integrator, .. }) = PageRequest::parse(&view)
        else {
            panic!("{:?}", PageRequest::parse(&view));
        };
        assert_eq!((hidden, integrator), (BTreeSet::from([1, 2, 4]), Some(IntegratorName::Guided)));
        assert_eq!(PageRequest::parse(r#"{"type":"stop","id":1}"#), Ok(PageRequest::Stop { id: 1 }));
        assert_eq!(PageRequest::parse(r#"{"type":"pause","id":1}"#), Ok(PageRequest::Pause { id: 1 }));
        assert_eq!(PageRequest::parse(r#"{"type":"resume","id":1}"#), Ok(PageRequest::Resume { id: 1 }));
        assert_eq!(PageRequest::parse(r#"{"type":"save","id":2}"#), Ok(PageRequest::Save { id: 2 }));
        assert_eq!(
            PageRequest::parse(r#"{"type":"measure","id":2,"leaves":[[3,5]]}"#),
            Ok(PageRequest::Measure { id: 2, leaves: BTreeSet::from([3, 4, 5]) })
        );
        let pick =
            r#"{"type":"pick","id":3,"origin":[0,0,0],"direction":[0,0,1],"hidden":[],"section":null}"#;
        assert!(
            matches!(PageRequest::parse(pick), Ok(PageRequest::Pick { id: 3, filter, .. }) if filter == PickFilter::default())
        );
        let through = r#"{"type":"pick","id":3,"origin":[0,0,0],"direction":[0,0,1],"hidden":[[1,2]],"seeThrough":true,"maps":true}"#;
        let Ok(PageRequest::Pick { filter, .. }) = PageRequest::parse(through) else {
            panic!("{:?}", PageRequest::parse(through));
        };
        let hidden = BTreeSet::from([1, 2]);
        assert_eq!(filter, PickFilter { hidden, section: None, see_through: true, maps: true });
    }

    #[test]
    fn queries_are_no_requests_about_views() {
        let kinds = [
            (PageRequest::Stop { id: 1 }, false),
            (PageRequest::Pause { id: 1 }, false),
            (PageRequest::Resume { id: 1 }, false),
            (PageRequest::Measure { id: 1, leaves: BTreeSet::new() }, true),
            (PageRequest::Save { id: 1 }, true),
        ];
        for (request, is_query) in kinds {
            assert_eq!(request.is_query(), is_query, "{request:?}");
        }
    }

    #[test]
    fn malformed_messages_are_answered_under_their_number() {
        for (text, id) in [
            ("", 0),
            ("[]", 0),
            ("{\"type\":\"dance\",\"id\":5}", 5),
            ("{\"type\":\"stop\",\"id\":-5}", 0),
            ("{\"type\":\"stop\",\"id\":5000000000}", 0),
            ("{\"type\":\"stop\"}", 0),
            ("{\"type\":\"view\",\"id\":9,\"size\":[1]}", 9),
            ("{\"type\":\"pick\",\"id\":4,\"origin\":[1e999,0,0],\"direction\":[0,0,1]}", 0),
            ("{\"type\":\"pick\",\"id\":4,\"origin\":[null,0,0],\"direction\":[0,0,1]}", 4),
        ] {
            assert_eq!(PageRequest::parse(text).map_err(|m| m.id), Err(id), "{text}");
        }
        // Nesting is bounded by the reader of JSON itself.
        assert!(PageRequest::parse(&"[".repeat(60_000)).is_err());
    }

    #[test]
    fn answers_are_those_of_the_contract() {
        let progress = ProgressMessage { id: 3, samples: 1, noise: None, seconds: 0.5, done: false };
        assert_eq!(
            ServerMessage::Progress(progress).to_text(),
            r#"{"type":"progress","id":3,"samples":1,"noise":null,"seconds":0.5,"done":false}"#
        );
        assert_eq!(ServerMessage::Stopped { id: 4 }.to_text(), r#"{"type":"stopped","id":4}"#);
        assert_eq!(ServerMessage::Hit { id: 5, hit: None }.to_text(), r#"{"type":"hit","id":5,"hit":null}"#);
    }
}
