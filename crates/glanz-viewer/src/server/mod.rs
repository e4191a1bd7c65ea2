//! HTTP and WebSocket: the page, its model, its messages, its files.
//!
//! [`Server::bind`] opens the port, [`Server::run`] serves until it is cancelled. Requests pass `access` (admission) first and `headers`
//! last; `page` serves the files of the page, `models` the models that it draws, `socket` exchanges messages with it, which `page_service`
//! answers, `watch` reads the scene again when it changes. `upload` receives files that are dropped on the page; their scene is read and rendered
//! by a process of its own (`opened_scene` starts it, `worker` is what it does), which has a `page_service`, too. Every resource that
//! clients can use up has one of the [`Limits`].

mod access;
mod access_key;
mod address;
mod headers;
mod label;
mod message;
mod models;
mod opened_scene;
mod overlay;
mod page;
mod page_service;
mod session;
mod settings;
mod socket;
mod state;
mod upload;
mod viewer_scene;
mod watch;
mod worker;

use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Path as UrlPath, RawQuery, Request, State};
use axum::http::StatusCode;
use axum::http::header::{CONTENT_TYPE, HeaderValue, SET_COOKIE};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use glanz_formats::Diagnostics;
use glanz_job::CancelFlag;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};

use self::access::{AccessControl, AccessDecision};
use self::access_key::AccessKey;
use self::state::AppState;

pub use self::overlay::SceneOverlay;
pub use self::settings::{ComparedDesign, DEFAULT_PORT, Limits, ServerSettings};
pub use self::viewer_scene::ViewerScene;
pub use self::worker::{WorkerCommand, WorkerError, WorkerSettings, run_worker, worker_folder};

/// Errors of starting the server.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServerError {
    /// No port can be opened there.
    #[error("{address}: the server cannot listen on this address: {source}")]
    Address {
        /// Host and port.
        address: String,
        /// The reason.
        source: std::io::Error,
    },
    /// The system provides no threads or timers.
    #[error("the server cannot be started: {0}")]
    Start(#[from] std::io::Error),
    /// The system provides no random numbers.
    #[error("the system provides no random numbers for a token: {0}")]
    Random(#[from] getrandom::Error),
}

/// Result of reading a changed scene again.
#[derive(Clone, Debug)]
pub enum SceneUpdate {
    /// It was read again, and pages show it.
    Reloaded(Arc<ViewerScene>),
    /// It cannot be read; pages keep the old one.
    Refused(Diagnostics),
}

/// Callback for changes of the files of a scene, which is at this path.
pub type UpdateListener = Box<dyn Fn(&Path, &SceneUpdate) + Send + Sync>;

/// A server with an open port.
pub struct Server {
    listener: TcpListener,
    app: Arc<AppState>,
    address: String,
    is_watched: bool,
}

impl Server {
    /// Opens a port for pages that show `viewer_scene`, the scene of the file `scene`. `listener` is called when the file of a design has been read again.
    ///
    /// # Errors
    /// [`ServerError`].
    pub fn bind(
        settings: &ServerSettings,
        scene: &Path,
        viewer_scene: ViewerScene,
        listener: UpdateListener,
    ) -> Result<Self, ServerError> {
        let (socket, port) = address::bind(settings.host.as_deref(), settings.port)?;
        let base = address::page_url(&socket, settings.host.as_deref())?;
        let (access, address) = match &settings.host {
            None => (AccessControl::local(), base),
            Some(host) => {
                let key = AccessKey::random()?;
                (AccessControl::with_token(host, port, key), format!("{base}?token={key}"))
            }
        };
        let app = AppState::new(settings, access, (scene, viewer_scene), listener)?;
        Ok(Self { listener: socket, app: Arc::new(app), address, is_watched: settings.watch })
    }

    /// The address of the page, with its token if it needs one.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Serves until `cancel` is raised, then closes the connections of all pages.
    ///
    /// # Errors
    /// [`ServerError::Start`].
    pub fn run(self, cancel: &CancelFlag) -> Result<(), ServerError> {
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
        let Self { listener, app, is_watched, .. } = self;
        runtime.block_on(async {
            listener.set_nonblocking(true)?;
            let listener = tokio::net::TcpListener::from_std(listener)?;
            let serving = tokio::spawn(accept(listener, Arc::clone(&app)));
            let designs = if is_watched { 0..app.designs.len() } else { 0..0 };
            let watching: Vec<_> =
                designs.map(|design| tokio::spawn(watch::watch(Arc::clone(&app), design))).collect();
            while !cancel.is_cancelled() {
                sleep(STOP_INTERVAL).await;
            }
            serving.abort();
            watching.iter().for_each(tokio::task::JoinHandle::abort);
            app.close().await;
            Ok::<_, std::io::Error>(())
        })?;
        // Unfinished builds are abandoned.
        runtime.shutdown_timeout(Duration::from_secs(1));
        Ok(())
    }
}

/// Interval between checks of the cancel flag.
pub(crate) const STOP_INTERVAL: Duration = Duration::from_millis(50);

/// Accepts connections until the task is aborted.
async fn accept(listener: tokio::net::TcpListener, app: Arc<AppState>) {
    let connections = Arc::new(Semaphore::new(app.limits.connections));
    let limits = app.limits;
    let app = router(app);
    loop {
        let Ok(permit) = Arc::clone(&connections).acquire_owned().await else { return };
        let Ok((stream, _)) = listener.accept().await else {
            // Mostly a temporary lack of file descriptors.
            sleep(STOP_INTERVAL).await;
            continue;
        };
        // Reduces the latency of small messages; a failure only delays them.
        let _ = stream.set_nodelay(true);
        let service = TowerToHyperService::new(app.clone());
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(limits.header_time)
            .max_buf_size(MAX_HEADERS)
            .serve_connection(TokioIo::new(stream), service)
            .with_upgrades();
        tokio::spawn(async move {
            let _permit = permit;
            // An error ends its connection only.
            let _ = timeout(limits.connection_time, connection).await;
        });
    }
}

/// Bytes of the headers of a request, about.
const MAX_HEADERS: usize = 32 << 10;

/// Routes of the server.
fn router(app: Arc<AppState>) -> Router {
    Router::new()
        .route("/model/{key}", get(model))
        .route("/ws", get(socket))
        .route("/open", post(upload::open))
        .fallback_service(get(page::serve))
        .layer(from_fn_with_state(Arc::clone(&app), check))
        .with_state(app)
}

/// Checks the access of a request and adds the security headers to the response.
async fn check(State(app): State<Arc<AppState>>, request: Request, next: Next) -> Response {
    let uri = request.uri();
    let mut response = match app.access.admit(uri.path(), uri.query(), request.headers()) {
        AccessDecision::Granted => next.run(request).await,
        AccessDecision::WithCookie(cookie) => {
            let mut response = next.run(request).await;
            if let Ok(cookie) = HeaderValue::from_str(&cookie) {
                response.headers_mut().insert(SET_COOKIE, cookie);
            }
            response
        }
        AccessDecision::Refused(status, reason) => (status, reason).into_response(),
    };
    headers::secure(response.headers_mut());
    response
}

async fn model(State(app): State<Arc<AppState>>, UrlPath(key): UrlPath<String>) -> Response {
    match AccessKey::parse(&key).and_then(|key| app.models.get(&key)) {
        Some(body) => ([(CONTENT_TYPE, "application/octet-stream")], body).into_response(),
        None => (StatusCode::NOT_FOUND, "the model is no longer available").into_response(),
    }
}

/// The value of a name in the query of an address.
fn query_value<'a>(query: Option<&'a str>, name: &str) -> Option<&'a str> {
    let pairs = query.into_iter().flat_map(|query| query.split('&'));
    pairs.filter_map(|pair| pair.split_once('=')).find_map(|(key, value)| (key == name).then_some(value))
}

async fn socket(
    State(app): State<Arc<AppState>>,
    RawQuery(query): RawQuery,
    upgrade: WebSocketUpgrade,
) -> Response {
    // A page without a design is one of the first.
    let design = match query_value(query.as_deref(), "design") {
        None | Some("a") => 0,
        Some("b") => 1,
        Some(_) => return (StatusCode::NOT_FOUND, "?design= must be a or b").into_response(),
    };
    let Some(published) = app.published(design) else {
        return (StatusCode::NOT_FOUND, "there is one design only").into_response();
    };
    let Some(slot) = app.sessions.join(design, published) else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open").into_response();
    };
    let bytes = app.limits.message_bytes;
    upgrade
        .max_message_size(bytes)
        .max_frame_size(bytes)
        .on_upgrade(move |socket| socket::serve_page(app, slot, socket))
}
