//! HTTP and WebSocket: the page, its model, its conversation, its files.
//!
//! [`Server::bind`] opens the port and says the address, [`Server::run`] serves until it is told to stop. Requests come first to `access`
//! (who is admitted) and end in `headers`; `page` gives out the files of the page, `models` what it draws, `socket` speaks with it, `upload`
//! takes in files that are dropped on it, `watch` reads the scene again when it changes. Everything that visitors can make grow has one of
//! the [`Limits`].

mod access;
mod access_key;
mod address;
mod dress;
mod headers;
mod leaf_ranges;
mod message;
mod models;
mod page;
mod session;
mod settings;
mod shown;
mod socket;
mod state;
mod upload;
mod watch;

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{DefaultBodyLimit, Path as UrlPath, Request, State};
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

pub use self::dress::Dress;
pub use self::settings::{DEFAULT_PORT, Limits, ServerSettings};
pub use self::shown::Shown;

/// Errors of starting the server.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServerError {
    /// No port can be opened there.
    #[error("{address}: cannot be served from: {source}")]
    Address {
        /// Host and port.
        address: String,
        /// The reason.
        source: std::io::Error,
    },
    /// The system gives no threads or timers.
    #[error("the server cannot be started: {0}")]
    Start(#[from] std::io::Error),
    /// The system gives no random numbers.
    #[error("there are no random numbers for a token: {0}")]
    Random(#[from] getrandom::Error),
}

/// Result of reading a changed scene again.
#[derive(Clone, Debug)]
pub enum News {
    /// It was read again, and pages show it.
    Read(Arc<Shown>),
    /// It cannot be read; pages show the old one.
    Refused(Diagnostics),
}

/// Callback for changes of the scene's files.
pub type Listener = Box<dyn Fn(&News) + Send + Sync>;

/// A server with an open port.
pub struct Server {
    listener: TcpListener,
    app: Arc<AppState>,
    address: String,
    watched: Option<PathBuf>,
}

impl Server {
    /// Opens a port for pages that show `shown`, the scene of the file `scene`. `listener` is told when that is read again.
    ///
    /// # Errors
    /// [`ServerError`].
    pub fn bind(
        settings: &ServerSettings,
        scene: &Path,
        shown: Shown,
        listener: Listener,
    ) -> Result<Self, ServerError> {
        let (socket, port) = address::bind(settings.host.as_deref(), settings.port)?;
        let base = address::shown(&socket, settings.host.as_deref())?;
        let (access, address) = match &settings.host {
            None => (AccessControl::local(), base),
            Some(host) => {
                let key = AccessKey::random()?;
                (AccessControl::with_token(host, port, key), format!("{base}?token={key}"))
            }
        };
        let app = AppState::new(settings, access, shown, listener)?;
        let watched = settings.watch.then(|| scene.to_owned());
        Ok(Self { listener: socket, app: Arc::new(app), address, watched })
    }

    /// The address of the page, with its token if it needs one.
    #[must_use]
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Serves until `cancel` is raised, then sends all pages away.
    ///
    /// # Errors
    /// [`ServerError::Start`].
    pub fn run(self, cancel: &CancelFlag) -> Result<(), ServerError> {
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
        let Self { listener, app, watched, .. } = self;
        runtime.block_on(async {
            listener.set_nonblocking(true)?;
            let listener = tokio::net::TcpListener::from_std(listener)?;
            let serving = tokio::spawn(accept(listener, Arc::clone(&app)));
            let watching = watched.map(|scene| tokio::spawn(watch::watch(Arc::clone(&app), scene)));
            while !cancel.is_cancelled() {
                sleep(STOP_INTERVAL).await;
            }
            serving.abort();
            watching.inspect(tokio::task::JoinHandle::abort);
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
            // Mostly a lack of file descriptors, which passes.
            sleep(STOP_INTERVAL).await;
            continue;
        };
        // Pages wait for small messages. Where that cannot be set they come a little later.
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
            // Whatever goes wrong with a connection ends it, and nothing else.
            let _ = timeout(limits.connection_time, connection).await;
        });
    }
}

/// Bytes of the headers of a request, about.
const MAX_HEADERS: usize = 32 << 10;

/// Routes of the server.
fn router(app: Arc<AppState>) -> Router {
    // The multipart headers of the files need space, too.
    let upload = DefaultBodyLimit::max(app.limits.upload_bytes + (app.limits.upload_files << 10));
    Router::new()
        .route("/model/{key}", get(model))
        .route("/ws", get(socket))
        .route("/open", post(upload::open).layer(upload))
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
        Some(bytes) => ([(CONTENT_TYPE, "application/octet-stream")], bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such model any more").into_response(),
    }
}

async fn socket(State(app): State<Arc<AppState>>, upgrade: WebSocketUpgrade) -> Response {
    let Some(slot) = app.sessions.join(app.published()) else {
        return (StatusCode::SERVICE_UNAVAILABLE, "there are too many pages").into_response();
    };
    let bytes = app.limits.message_bytes;
    upgrade
        .max_message_size(bytes)
        .max_frame_size(bytes)
        .on_upgrade(move |socket| socket::serve_page(app, slot, socket))
}
